/* A periodic orbit near a guess: Newton's method on the equations of shooting, with the multipliers
   and the direction of the curve of orbits that passes there. LANES is 1. */

#define LANES 1
#include "run.h"

#include "variant.h"

#define STATE 4
#define MOST_VARIED 2
#define MOST_UNKNOWNS (STATE + 1 + MOST_VARIED)
#define MOST_COUNT (STATE + MOST_VARIED)
#define MOST_ITERATIONS 8
#define ROOM 64
#define CROSSING_COLUMNS (6 + STATE * MOST_COUNT)
#define EXTREMES 7
/* A residual below the first is not improved; one above the second, relative to the state, is none. */
#define EXACT 2e-13
#define CONVERGED 1e-10
/* What a search returns. */
enum { NOT_FOUND, FOUND };

void NAME(vary_begin)(void *v, const double *parameters, int64_t separation, const double *start,
                      const double *seeds, int64_t count, double t_end, double tol, int64_t order);
int64_t NAME(vary_advance)(void *v, double *crossings, int64_t room, int64_t budget, double *result,
                           double *deviations, double *extremes);

/* What is asked: `varied` parameters at `places` of all, within bounds; the units of the unknowns,
   which are state, period and those parameters; and how runs are made. */
typedef struct {
    double parameters[PARAMETERS], scales[MOST_UNKNOWNS], low[MOST_VARIED], high[MOST_VARIED];
    double tol, longest;
    int64_t places[MOST_VARIED], varied, separation, order, budget;
} Asked;

/* One period, and its derivatives by state and parameters. */
typedef struct {
    double final[STATE], rate[STATE], by[MOST_COUNT * STATE], extremes[EXTREMES];
} Period;

/* What is found, behind each other as `fivtui.kernel.orbits` reads it. */
typedef struct {
    double unknowns[MOST_UNKNOWNS], tangent[MOST_UNKNOWNS], across[STATE], monodromy[9];
    double extremes[EXTREMES], determinant, iterations;
} Orbit;

typedef double System[MOST_UNKNOWNS][MOST_UNKNOWNS];

INLINE double size_of(double a) { return __builtin_fabs(a); }

/* Factorise a matrix in place, with row exchanges; returns its determinant, 0 where it is singular. */
static double factorise(System a, int count, int *rows)
{
    double determinant = 1.0;
    for (int i = 0; i < count; i++) {
        int best = i;
        for (int j = i + 1; j < count; j++)
            if (size_of(a[j][i]) > size_of(a[best][i]))
                best = j;
        rows[i] = best;
        if (!(size_of(a[best][i]) > 0.0))
            return 0.0;
        if (best != i) {
            determinant = -determinant;
            for (int j = 0; j < count; j++) {
                double kept = a[i][j];
                a[i][j] = a[best][j], a[best][j] = kept;
            }
        }
        determinant *= a[i][i];
        for (int j = i + 1; j < count; j++) {
            double factor = a[j][i] /= a[i][i];
            for (int n = i + 1; n < count; n++)
                a[j][n] -= factor * a[i][n];
        }
    }
    return determinant;
}

/* Solve with a factorised matrix. */
static void resolve(System a, int count, const int *rows, double *b)
{
    for (int i = 0; i < count; i++) {
        double kept = b[i];
        b[i] = b[rows[i]], b[rows[i]] = kept;
    }
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++)
            b[i] -= a[i][j] * b[j];
    for (int i = count - 1; i >= 0; i--) {
        for (int j = i + 1; j < count; j++)
            b[i] -= a[i][j] * b[j];
        b[i] /= a[i][i];
    }
}

/* One period from scaled unknowns; whether there is one. */
static int follow(void *memory, const Asked *asked, const double *unknowns, Period *period)
{
    double parameters[PARAMETERS], start[STATE], result[RESULTS + 3];
    double seeds[MOST_COUNT * (STATE + PARAMETERS)] = {0.0}, crossings[ROOM * CROSSING_COLUMNS];
    double extremes[EXTREMES * (1 + MOST_COUNT)];
    const int64_t count = STATE + asked->varied;
    const double t_end = unknowns[STATE] * asked->scales[STATE];
    memcpy(parameters, asked->parameters, sizeof parameters);
    for (int i = 0; i < STATE; i++) {
        start[i] = unknowns[i] * asked->scales[i];
        if (!finite_number(start[i]))
            return 0;
        /* As `Request` does it. */
        if (size_of(start[i]) < 1e-150)
            start[i] = 0.0;
        seeds[i * (STATE + PARAMETERS) + i] = 1.0;
    }
    if (!(t_end > 0.0 && t_end <= asked->longest))
        return 0;
    for (int i = 0; i < asked->varied; i++) {
        double value = unknowns[STATE + 1 + i] * asked->scales[STATE + 1 + i];
        if (!(value >= asked->low[i] && value <= asked->high[i]))
            return 0;
        parameters[asked->places[i]] = value;
        seeds[(STATE + i) * (STATE + PARAMETERS) + STATE + asked->places[i]] = 1.0;
    }
    NAME(vary_begin)(memory, parameters, asked->separation, start, seeds, count, t_end, asked->tol,
                     asked->order);
    int64_t left = asked->budget, status = RUNNING;
    while (status == RUNNING && left > 0) {
        status = NAME(vary_advance)(memory, crossings, ROOM, left, result, period->by, extremes);
        left = asked->budget - (int64_t)result[R_STEPS];
    }
    if (status != DONE)
        return 0;
    memcpy(period->final, result, sizeof period->final);
    period->rate[0] = result[R_VX], period->rate[1] = result[RESULTS + 1];
    period->rate[2] = result[R_VY], period->rate[3] = result[RESULTS + 2];
    const double *seen = result + R_X_MIN;
    const int order[EXTREMES] = {0, 2, 1, 3, 4, 5, 6};
    for (int i = 0; i < EXTREMES; i++)
        period->extremes[i] = seen[order[i]];
    return 1;
}

/* The rows of the return in the system of equations: how its miss changes with the unknowns. */
static void fill(System a, const Asked *asked, const Period *period)
{
    const double *scales = asked->scales;
    for (int i = 0; i < STATE; i++) {
        for (int j = 0; j < STATE; j++)
            a[i][j] = period->by[j * STATE + i] * scales[j] / scales[i] - (i == j);
        a[i][STATE] = period->rate[i] * scales[STATE] / scales[i];
        for (int n = 0; n < asked->varied; n++) {
            int column = STATE + 1 + n;
            a[i][column] = period->by[(STATE + n) * STATE + i] * scales[column] / scales[i];
        }
    }
}

/* The derivative of the return across the motion: on an orthonormal basis of the plane `across`, by
   a reflection. */
static void reduce(const System a, const double *across, double *monodromy)
{
    double h[STATE][STATE], turned[STATE][STATE], v[STATE];
    memcpy(v, across, sizeof v);
    v[0] += across[0] < 0.0 ? -1.0 : 1.0;
    double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3];
    for (int i = 0; i < STATE; i++)
        for (int j = 0; j < STATE; j++)
            h[i][j] = (i == j) - 2.0 * v[i] * v[j] / square;
    for (int i = 0; i < STATE; i++)
        for (int j = 0; j < STATE; j++) {
            turned[i][j] = 0.0;
            for (int n = 0; n < STATE; n++)
                turned[i][j] += (a[i][n] + (i == n)) * h[n][j];
        }
    for (int i = 1; i < STATE; i++)
        for (int j = 1; j < STATE; j++) {
            double sum = 0.0;
            for (int n = 0; n < STATE; n++)
                sum += h[n][i] * turned[n][j];
            monodromy[3 * (i - 1) + j - 1] = sum;
        }
}

/* Direction, multipliers and determinant at the orbit; whether they are there. */
static int complete(const Asked *asked, const Period *period, const double *planes,
                    const double *along, int64_t turning, Orbit *found)
{
    const int count = STATE + 1 + (int)asked->varied;
    System system = {{0.0}}, factors;
    int rows[MOST_UNKNOWNS];
    double speed = 0.0, length = 0.0;
    fill(system, asked, period);
    for (int i = 0; i < STATE; i++) {
        found->across[i] = period->rate[i] / asked->scales[i];
        speed += found->across[i] * found->across[i];
    }
    speed = __builtin_sqrt(speed);
    for (int i = 0; i < STATE; i++)
        found->across[i] /= speed;
    for (int n = 0; n < count - STATE; n++)
        memcpy(system[STATE + n], planes + n * count, count * sizeof *planes);
    if (turning) {
        memset(system[STATE], 0, sizeof system[STATE]);
        memcpy(system[STATE], found->across, sizeof found->across);
    }
    memcpy(system[count - 1], along, count * sizeof *along);
    memcpy(factors, system, sizeof factors);
    if (factorise(factors, count, rows) == 0.0)
        return 0;
    memset(found->tangent, 0, sizeof found->tangent);
    found->tangent[count - 1] = 1.0;
    resolve(factors, count, rows, found->tangent);
    for (int i = 0; i < count; i++)
        length += found->tangent[i] * found->tangent[i];
    length = __builtin_sqrt(length);
    for (int i = 0; i < count; i++)
        found->tangent[i] /= length;
    reduce(system, found->across, found->monodromy);
    memcpy(system[count - 1], found->tangent, count * sizeof *along);
    found->determinant = factorise(system, count, rows);
    memcpy(found->extremes, period->extremes, sizeof found->extremes);
    return finite_number(length);
}

/* Bytes of what is asked, of what is found. */
EXPORT int64_t NAME(orbit_asked_size)(void) { return sizeof(Asked); }
EXPORT int64_t NAME(orbit_found_size)(void) { return sizeof(Orbit); }

/* Find the periodic orbit near a guess. `planes` are normals of planes through the guess, as many as
   varied parameters and one more; the curve passes through the last, and has the tangent that goes
   the way of `along`. If `turning`, the first is across the orbit that is found when the direction
   is. `memory` is that of a run with derivatives. */
EXPORT int64_t NAME(orbit_solve)(void *memory, const Asked *asked, const double *guess,
                                 const double *planes, const double *along, int64_t turning,
                                 Orbit *found)
{
    const int count = STATE + 1 + (int)asked->varied;
    double unknowns[MOST_UNKNOWNS] = {0.0}, least = INFINITE, size = 0.0;
    Period period, best;
    memcpy(unknowns, guess, count * sizeof *guess);
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
        System system = {{0.0}};
        int rows[MOST_UNKNOWNS];
        double missed[MOST_UNKNOWNS] = {0.0}, residual = 0.0, here = 0.0;
        if (!follow(memory, asked, unknowns, &period))
            break;
        fill(system, asked, &period);
        for (int i = 0; i < STATE; i++) {
            missed[i] = period.final[i] / asked->scales[i] - unknowns[i];
            here = larger(here, size_of(unknowns[i]));
        }
        for (int n = STATE; n < count; n++) {
            memcpy(system[n], planes + (n - STATE) * count, count * sizeof *planes);
            for (int i = 0; i < count; i++)
                missed[n] += system[n][i] * (unknowns[i] - guess[i]);
        }
        for (int i = 0; i < count; i++)
            residual = larger(residual, size_of(missed[i]));
        if (residual < least) {
            least = residual, best = period, size = here;
            memcpy(found->unknowns, unknowns, sizeof unknowns);
            found->iterations = iteration;
        } else if (least < CONVERGED * size)
            break;
        if (residual < EXACT * here || factorise(system, count, rows) == 0.0)
            break;
        resolve(system, count, rows, missed);
        for (int i = 0; i < count; i++)
            unknowns[i] -= missed[i];
    }
    if (!(least < CONVERGED * size))
        return NOT_FOUND;
    return complete(asked, &best, planes, along, turning, found) ? FOUND : NOT_FOUND;
}
