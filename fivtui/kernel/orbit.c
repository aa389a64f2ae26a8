/* A periodic orbit near a guess by shooting and Newton's method, with its monodromy matrix and the
   tangent of the curve of orbits. Runs are computed one at a time: LANES is 1. LIBRARY_NAME gives
   exported functions their prefix and suffix, see variant.h.

   The unknowns are the state at the start, the period and one or two varied parameters, each in its
   own unit (`scales`). A period is computed by `vary.c`, with its derivatives by state and varied
   parameters. The orbit is closed if the state after a period is that at the start. */

#define LANES 1
#include "run.h"

#include "vary.h"

#define MAX_VARIED 2
/* Index of the period among the unknowns; varied parameters follow it. */
#define U_PERIOD STATE
#define MAX_UNKNOWNS (STATE + 1 + MAX_VARIED)
/* A seed is a direction of derivatives: a component of the start, or a varied parameter. */
#define MAX_SEEDS (STATE + MAX_VARIED)
/* Dimension of a plane that the orbit crosses. */
#define PLANE (STATE - 1)
#define MAX_NEWTON_ITERATIONS 8
/* Rows and columns of the buffer into which `vary.c` writes separations and reattachments; a search
   does not read it. CROSSING_HEAD is the number of columns before the derivatives of the state. */
#define MAX_CROSSINGS 64
#define CROSSING_COLUMNS (CROSSING_HEAD + STATE * MAX_SEEDS)
#define EXTREMES 7
/* Smaller components of a start are set to zero, because their products would underflow: equal to
   START_THRESHOLD of `fivtui.transient`. */
#define MIN_START 1e-150
/* Relative residuals: Newton's method stops below the first, and fails above the second. */
#define EXACT_RESIDUAL 2e-13
#define MAX_RESIDUAL 1e-10
/* Results of a search. */
enum { NOT_FOUND, FOUND };

/* Inputs of a search. `scales` are the units of the unknowns. `varied_count` parameters vary
   between `low` and `high`; `columns` are their indices in `parameters`. Periods are at most
   `max_period`, s. `separation` is 0 if the slider cannot leave the belt. A run has the tolerance
   `tol`, Taylor series of this `order`, and at most `budget` steps. */
typedef struct {
    double parameters[PARAMETERS], scales[MAX_UNKNOWNS], low[MAX_VARIED], high[MAX_VARIED];
    double tol, max_period;
    int64_t columns[MAX_VARIED], varied_count, separation, order, budget;
} OrbitRequest;

/* End of one period: state, its rate, derivatives by start and varied parameters, and extremes. */
typedef struct {
    double final[STATE], rate[STATE], derivatives[MAX_SEEDS * STATE], extremes[EXTREMES];
} Period;

/* Layout that `fivtui.kernel.orbits` reads. `determinant` is that of the linearised equations with
   the tangent as last row: it is zero where another curve of orbits crosses. */
typedef struct {
    double unknowns[MAX_UNKNOWNS], tangent[MAX_UNKNOWNS], flow_direction[STATE];
    double monodromy[PLANE * PLANE];
    double extremes[EXTREMES], determinant, iterations;
} Orbit;

typedef double System[MAX_UNKNOWNS][MAX_UNKNOWNS];

INLINE double magnitude(double a) { return __builtin_fabs(a); }

INLINE double vector_length(const double *a, int count)
{
    double square = 0.0;
    for (int i = 0; i < count; i++)
        square += a[i] * a[i];
    return __builtin_sqrt(square);
}

/* Factorise a matrix in place, with row exchanges that `rows` receives. Returns its determinant, 0
   if it is singular. */
static double factorise(System a, int count, int *rows)
{
    double determinant = 1.0;
    for (int i = 0; i < count; i++) {
        int pivot = i;
        for (int j = i + 1; j < count; j++)
            if (magnitude(a[j][i]) > magnitude(a[pivot][i]))
                pivot = j;
        rows[i] = pivot;
        if (!(magnitude(a[pivot][i]) > 0.0))
            return 0.0;
        if (pivot != i) {
            determinant = -determinant;
            for (int j = 0; j < count; j++) {
                double swapped = a[i][j];
                a[i][j] = a[pivot][j], a[pivot][j] = swapped;
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

/* Solve a system with a factorised matrix; the solution replaces the right-hand side b. */
static void solve_factorised(System a, int count, const int *rows, double *b)
{
    for (int i = 0; i < count; i++) {
        double swapped = b[i];
        b[i] = b[rows[i]], b[rows[i]] = swapped;
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

/* Compute one period from scaled unknowns; returns 0 if it cannot be computed. */
static int compute_period(void *memory, const OrbitRequest *request, const double *unknowns,
                          Period *period)
{
    double parameters[PARAMETERS], start[STATE], result[VARY_RESULTS];
    double seeds[MAX_SEEDS][STATE + PARAMETERS] = {{0.0}};
    double crossings[MAX_CROSSINGS * CROSSING_COLUMNS], extremes[EXTREMES * (1 + MAX_SEEDS)];
    const int64_t seed_count = STATE + request->varied_count;
    const double t_end = unknowns[U_PERIOD] * request->scales[U_PERIOD];
    memcpy(parameters, request->parameters, sizeof parameters);
    for (int i = 0; i < STATE; i++) {
        start[i] = unknowns[i] * request->scales[i];
        if (!is_finite_number(start[i]))
            return 0;
        if (magnitude(start[i]) < MIN_START)
            start[i] = 0.0;
        seeds[i][i] = 1.0;
    }
    if (!(t_end > 0.0 && t_end <= request->max_period))
        return 0;
    for (int i = 0; i < request->varied_count; i++) {
        double value = unknowns[U_PERIOD + 1 + i] * request->scales[U_PERIOD + 1 + i];
        if (!(value >= request->low[i] && value <= request->high[i]))
            return 0;
        parameters[request->columns[i]] = value;
        seeds[STATE + i][STATE + request->columns[i]] = 1.0;
    }
    LIBRARY_NAME(vary_begin)(memory, parameters, request->separation, start, seeds[0], seed_count,
                             t_end, request->tol, request->order);
    int64_t remaining = request->budget, status = RUNNING;
    /* `vary_advance` also returns when `crossings` is full: call it again to continue. */
    while (status == RUNNING && remaining > 0) {
        status = LIBRARY_NAME(vary_advance)(memory, crossings, MAX_CROSSINGS, remaining, result,
                                            period->derivatives, extremes);
        remaining = request->budget - (int64_t)result[R_STEPS];
    }
    if (status != DONE)
        return 0;
    memcpy(period->final, result + R_X, sizeof period->final);
    period->rate[S_X] = result[R_VX], period->rate[S_VX] = result[R_AX];
    period->rate[S_Y] = result[R_VY], period->rate[S_VY] = result[R_AY];
    /* Columns of `result`, in the order of `FoundOrbit.extremes` in `fivtui.kernel.orbits`. The
       last two are the extremes of y in the second half of the run. */
    static const int COLUMNS[EXTREMES] = {R_X_MIN, R_X_MAX, R_Y_MIN, R_Y_MAX, R_VX_MAX,
                                          R_SECOND_HALF_MIN, R_SECOND_HALF_MAX};
    for (int i = 0; i < EXTREMES; i++)
        period->extremes[i] = result[COLUMNS[i]];
    return 1;
}

/* Set the rows of the closure equations: derivatives of the final less the initial state. */
static void set_closure_rows(System system, const OrbitRequest *request, const Period *period)
{
    const double *scales = request->scales;
    for (int i = 0; i < STATE; i++) {
        for (int j = 0; j < STATE; j++)
            system[i][j] = period->derivatives[j * STATE + i] * scales[j] / scales[i] - (i == j);
        system[i][U_PERIOD] = period->rate[i] * scales[U_PERIOD] / scales[i];
        for (int n = 0; n < request->varied_count; n++) {
            int column = U_PERIOD + 1 + n;
            system[i][column] = period->derivatives[(STATE + n) * STATE + i]
                * scales[column] / scales[i];
        }
    }
}

/* Set the monodromy matrix on the plane normal to the flow. The columns of a Householder reflection
   that maps the flow to the first axis are an orthonormal basis: the flow, then the plane. */
static void set_monodromy(const System closure, const double *flow_direction, double *monodromy)
{
    double reflection[STATE][STATE], product[STATE][STATE], v[STATE];
    memcpy(v, flow_direction, sizeof v);
    v[0] += flow_direction[0] < 0.0 ? -1.0 : 1.0;
    double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3];
    for (int i = 0; i < STATE; i++)
        for (int j = 0; j < STATE; j++)
            reflection[i][j] = (i == j) - 2.0 * v[i] * v[j] / square;
    for (int i = 0; i < STATE; i++)
        for (int j = 0; j < STATE; j++) {
            product[i][j] = 0.0;
            /* The closure rows are the derivatives of the final state less the identity. */
            for (int n = 0; n < STATE; n++)
                product[i][j] += (closure[i][n] + (i == n)) * reflection[n][j];
        }
    for (int i = 0; i < PLANE; i++)
        for (int j = 0; j < PLANE; j++) {
            double sum = 0.0;
            for (int n = 0; n < STATE; n++)
                sum += reflection[n][i + 1] * product[n][j + 1];
            monodromy[PLANE * i + j] = sum;
        }
}

/* Set tangent, monodromy matrix and determinant of an orbit; returns 0 if it is singular. Arguments
   as of `orbit_solve`. */
static int complete_orbit(const OrbitRequest *request, const Period *period, const double *normals,
                          const double *heading, int64_t is_normal_to_flow, Orbit *orbit)
{
    const int count = STATE + 1 + (int)request->varied_count;
    System system = {{0.0}}, factors;
    double flow_normal[MAX_UNKNOWNS] = {0.0};
    int rows[MAX_UNKNOWNS];
    set_closure_rows(system, request, period);
    for (int i = 0; i < STATE; i++)
        orbit->flow_direction[i] = period->rate[i] / request->scales[i];
    const double speed = vector_length(orbit->flow_direction, STATE);
    for (int i = 0; i < STATE; i++)
        flow_normal[i] = orbit->flow_direction[i] /= speed;
    /* Rows: the equations of closure, `normals` without the last one, and the heading. The flow may
       replace the first normal. The product with the tangent is 1 for the heading, 0 for others. */
    for (int n = 0; n < request->varied_count; n++)
        memcpy(system[STATE + n], n == 0 && is_normal_to_flow ? flow_normal : normals + n * count,
               count * sizeof *normals);
    memcpy(system[count - 1], heading, count * sizeof *heading);
    memcpy(factors, system, sizeof factors);
    if (factorise(factors, count, rows) == 0.0)
        return 0;
    memset(orbit->tangent, 0, sizeof orbit->tangent);
    orbit->tangent[count - 1] = 1.0;
    solve_factorised(factors, count, rows, orbit->tangent);
    const double length = vector_length(orbit->tangent, count);
    for (int i = 0; i < count; i++)
        orbit->tangent[i] /= length;
    set_monodromy(system, orbit->flow_direction, orbit->monodromy);
    /* With the tangent as last row the determinant is zero only where curves of orbits cross. */
    memcpy(system[count - 1], orbit->tangent, count * sizeof *heading);
    orbit->determinant = factorise(system, count, rows);
    memcpy(orbit->extremes, period->extremes, sizeof orbit->extremes);
    return is_finite_number(length);
}

/* Bytes of the structs `OrbitRequest` and `Orbit`. */
EXPORT int64_t LIBRARY_NAME(orbit_request_size)(void) { return sizeof(OrbitRequest); }
EXPORT int64_t LIBRARY_NAME(orbit_size)(void) { return sizeof(Orbit); }

/* Find the periodic orbit near a guess of the unknowns.

   There are as many equations as unknowns: STATE equations close the orbit, the others keep it in
   planes through the guess. `normals` are those of the planes, varied_count + 1 rows of an element
   per unknown. The tangent of the curve of orbits has a positive component in the direction
   `heading`. The tangent is normal to the flow if `is_normal_to_flow`, else to the first of
   `normals`; it is also normal to the further ones, except the last. `memory` is a buffer of
   `vary_size` bytes that a run with derivatives overwrites. Returns FOUND or NOT_FOUND. */
EXPORT int64_t LIBRARY_NAME(orbit_solve)(void *memory, const OrbitRequest *request,
                                         const double *guess, const double *normals,
                                         const double *heading, int64_t is_normal_to_flow,
                                         Orbit *orbit)
{
    const int count = STATE + 1 + (int)request->varied_count;
    double unknowns[MAX_UNKNOWNS] = {0.0}, min_residual = INFINITE, best_scale = 0.0;
    Period period, best_period;
    memcpy(unknowns, guess, count * sizeof *guess);
    for (int iteration = 0; iteration < MAX_NEWTON_ITERATIONS; iteration++) {
        System system = {{0.0}};
        int rows[MAX_UNKNOWNS];
        double residuals[MAX_UNKNOWNS] = {0.0}, residual = 0.0, scale = 0.0;
        if (!compute_period(memory, request, unknowns, &period))
            break;
        set_closure_rows(system, request, &period);
        /* Residuals: the closure of the state, and the distances from the planes. */
        for (int i = 0; i < STATE; i++) {
            residuals[i] = period.final[i] / request->scales[i] - unknowns[i];
            scale = maximum(scale, magnitude(unknowns[i]));
        }
        for (int n = STATE; n < count; n++) {
            memcpy(system[n], normals + (n - STATE) * count, count * sizeof *normals);
            for (int i = 0; i < count; i++)
                residuals[n] += system[n][i] * (unknowns[i] - guess[i]);
        }
        for (int i = 0; i < count; i++)
            residual = maximum(residual, magnitude(residuals[i]));
        if (residual < min_residual) {
            min_residual = residual, best_period = period, best_scale = scale;
            memcpy(orbit->unknowns, unknowns, sizeof unknowns);
            orbit->iterations = iteration;
        } else if (min_residual < MAX_RESIDUAL * best_scale) {
            /* Converged: the residual is small and no longer falls. */
            break;
        }
        if (residual < EXACT_RESIDUAL * scale || factorise(system, count, rows) == 0.0)
            break;
        solve_factorised(system, count, rows, residuals);
        for (int i = 0; i < count; i++)
            unknowns[i] -= residuals[i];
    }
    if (!(min_residual < MAX_RESIDUAL * best_scale))
        return NOT_FOUND;
    return complete_orbit(request, &best_period, normals, heading, is_normal_to_flow, orbit)
        ? FOUND : NOT_FOUND;
}
