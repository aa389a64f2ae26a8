/* One run with its derivatives by numbers that change start and parameters. */

#define LANES 1
#include "run.h"

#include "deviations.h"
#include "variant.h"

/* For each member of `Extremes`: the quantity, and the sign 1 for a maximum or −1 for a minimum. */
enum { OF_X, OF_VX, OF_Y };
#define EXTREMES ((int)(sizeof(Extremes) / sizeof(V)))
static const int QUANTITY[] = {OF_X, OF_X, OF_Y, OF_Y, OF_VX, OF_Y, OF_Y};
static const double SIGN[] = {-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0};
#define FIRST_OF_SECOND_HALF 5

/* `cubic` says whether the motion or a deviation depends on y³ in contact. `extreme_times` and
   `extreme_derivatives` are those of the extremes so far. */
typedef struct {
    Run run;
    int64_t count, vectors, cubic;
    FieldChange changes[MODES][MAX_VECTORS];
    Deviation deviations[MAX_VECTORS];
    double extreme_times[sizeof(Extremes) / sizeof(V)];
    Eight extreme_derivatives[sizeof(Extremes) / sizeof(V)][MAX_VECTORS];
} VariedRun;

/* Columns of a call after those of a result: number of crossings in the buffer, ẍ and ÿ. */
enum { R_CROSSINGS = RESULTS, R_AX, R_AY };

/* Columns of a crossing before its deviations: time, x, ẋ, y, ẏ, and the mode after it. */
#define CROSSING_HEAD 6
#define STATE 4

/* Time in [first_time, h] at which `sign` times a polynomial is greatest. */
NOINLINE double extremum_time(const V *c, int groups, double first_time, double h, double sign)
{
    double p[ROWS], slope[ROWS] = {0.0}, candidates[ROWS];
    scale_polynomial(c, groups, 0, h, p);
    for (int n = 1; n < ROWS; n++)
        slope[n - 1] = n * p[n];
    int count = find_roots(slope, ROWS, ROWS - 1, candidates);
    candidates[count++] = 1.0;
    double start = first_time / h, theta = start,
        greatest_value = sign * polynomial_value(p, ROWS, start);
    for (int i = 0; i < count; i++) {
        double value = sign * polynomial_value(p, ROWS, candidates[i]);
        if (candidates[i] > start && value > greatest_value)
            theta = candidates[i], greatest_value = value;
    }
    return theta * h;
}

/* Bits of the extremes that the step has changed; sets their times since its start. */
static unsigned changed_extremes(const VariedRun *v, const Extremes *before, double *times)
{
    const Block *w = &v->run.w;
    const int groups = (int)v->run.order / 4;
    const double *old_values = (const double *)before, *new_values = (const double *)&w->extremes;
    double half_time = maximum((0.5 * v->run.t_end - w->t) - w->remainder, 0.0);
    unsigned changed = 0;
    for (int i = 0; i < EXTREMES; i++) {
        if (old_values[i] == new_values[i])
            continue;
        V rates[ROWS + 2] = {0.0};
        const V *c = QUANTITY[i] == OF_Y ? w->ys : w->xs;
        if (QUANTITY[i] == OF_VX) {
            for (int n = 0; n <= 4 * groups; n++)
                rates[n] = w->xs[n + 1] * (n + 1.0);
            c = rates;
        }
        double first_time = i >= FIRST_OF_SECOND_HALF ? minimum(half_time, w->h) : 0.0;
        times[i] = extremum_time(c, groups, first_time, w->h, SIGN[i]);
        changed |= 1u << i;
    }
    return changed;
}

/* Integrate the deviations over the step, and store them at the times of the `changed` extremes.
   Returns RUNNING on success. */
static int advance_deviations(VariedRun *v, unsigned changed, const double *times)
{
    const Block *w = &v->run.w;
    const int groups = (int)v->run.order / 4, vectors = (int)v->vectors;
    const int cubic = w->side < 0.0 && v->cubic;
    const FieldChange *change = v->changes[mode_in_lane(w, 0)];
    double covered = 0.0;
    for (int last = 0; !last;) {
        Motion m;
        Series s[MAX_VECTORS];
        Tangent x = tangent_at(w->xs, groups, covered), y = tangent_at(w->ys, groups, covered);
        m.x[0] = x.value, m.x[1] = x.slope;
        m.y[PADDED] = y.value, m.y[PADDED + 1] = y.slope;
        expand_motion(&m, &w->field, cubic);
        for (int g = 0; g < vectors; g++)
            expand_deviations(s + g, v->deviations + g, &m, &w->field, change + g, cubic);
        double remaining = w->h - covered, substep = substep_length(s, vectors, remaining);
        if (substep == 0.0)
            return is_finite_motion(&m) ? UNBOUNDED : OVERFLOW;
        last = substep == remaining;
        for (int i = 0; i < EXTREMES; i++) {
            if (!(changed >> i & 1) || !(last || times[i] <= covered + substep))
                continue;
            changed ^= 1u << i;
            v->extreme_times[i] = w->t + (w->remainder + times[i]);
            for (int g = 0; g < vectors; g++) {
                Deviation value = deviation_at(s + g, times[i] - covered);
                v->extreme_derivatives[i][g] = QUANTITY[i] == OF_X   ? value.x
                                               : QUANTITY[i] == OF_Y ? value.y
                                                                     : value.vx;
            }
        }
        for (int g = 0; g < vectors; g++)
            v->deviations[g] = deviation_at(s + g, substep);
        covered += substep;
    }
    return RUNNING;
}

/* Accept a step, and apply the switch if it is `cut`; the guard is y, without parameters. */
static int finish_varied_step(VariedRun *v, const StepEnd *step_end, int cut)
{
    Block *w = &v->run.w;
    const double gradient[STATE] = {0.0, 0.0, 1.0, 0.0};
    const Eight none = {0.0};
    Field before = w->field;
    int status = finish_step(&v->run, step_end, cut);
    if (cut) {
        double x = w->xs[0], vx = w->xs[1], y = w->ys[0], vy = w->ys[1];
        Pair jump = accelerations(&w->field, x, vx, y, vy) - accelerations(&before, x, vx, y, vy);
        const double jumps[STATE] = {0.0, PAIR_X(jump), 0.0, PAIR_Y(jump)};
        for (int g = 0; g < v->vectors; g++)
            apply_saltation(v->deviations + g, jumps, gradient, none, vy);
    }
    return status;
}

static void write_deviations(const VariedRun *v, double *rows)
{
    for (int64_t i = 0; i < v->count; i++) {
        const Deviation *d = v->deviations + i / 8;
        double *row = rows + i * STATE;
        row[0] = d->x[i % 8], row[1] = d->vx[i % 8], row[2] = d->y[i % 8], row[3] = d->vy[i % 8];
    }
}

/* Bytes of a run with derivatives. */
EXPORT int64_t NAME(vary_size)(void) { return sizeof(VariedRun); }

/* Begin a run, as `run_begin`, with `count` derivatives, at most 16. A row of `seeds` has the
   derivatives of (x, ẋ, y, ẏ) at the start and of the parameters by one number. */
EXPORT void NAME(vary_begin)(VariedRun *v, const double *parameters, int64_t separation,
                             const double *start, const double *seeds, int64_t count, double t_end,
                             double tol, int64_t order)
{
    memset(v, 0, sizeof *v);
    begin_run(&v->run, parameters, separation, start, t_end, tol, order);
    v->count = count, v->vectors = (count + 7) / 8, v->cubic = v->run.cubic;
    for (int64_t i = 0; i < count; i++) {
        const double *seed = seeds + i * (STATE + PARAMETERS);
        Deviation *d = v->deviations + i / 8;
        v->cubic |= seed[STATE + P_K_NL] != 0.0;
        d->x[i % 8] = seed[0], d->vx[i % 8] = seed[1];
        d->y[i % 8] = seed[2], d->vy[i % 8] = seed[3];
        for (int mode = 0; mode < MODES; mode++)
            set_field_change(v->changes[mode] + i / 8, i % 8, parameters, seed + STATE, mode);
    }
}

/* Continue until the run has ended, `crossings` is full or after `budget` steps.

   A crossing is a row of CROSSING_HEAD columns and the deviations there. `result` receives the
   columns of a result, the number of crossings, ẍ and ÿ; `derivatives` a row of derivatives of (x,
   ẋ, y, ẏ) for each seed; `extremes` the time of each extreme and its derivative by each seed.
   Returns the status. */
EXPORT int64_t NAME(vary_advance)(VariedRun *v, double *crossings, int64_t max_crossings,
                                  int64_t budget,
                                  double *result, double *deviations, double *extremes)
{
    Block *w = &v->run.w;
    const int64_t columns = CROSSING_HEAD + STATE * v->count;
    int64_t crossing_count = 0;
    int status = RUNNING, cut;
    while (status == RUNNING && crossing_count < max_crossings && budget-- > 0) {
        StepEnd step_end;
        Extremes before = w->extremes;
        double times[sizeof(Extremes) / sizeof(V)];
        if (!compute_step(&v->run, &step_end, &cut)) {
            status = OVERFLOW;
            break;
        }
        if ((status = advance_deviations(v, changed_extremes(v, &before, times), times)) != RUNNING)
            break;
        double switches = w->separations + w->reattachments;
        status = finish_varied_step(v, &step_end, cut);
        if (w->separations + w->reattachments != switches) {
            double *row = crossings + crossing_count++ * columns;
            row[0] = w->last_switch, row[1] = w->xs[0], row[2] = w->xs[1], row[3] = w->ys[0];
            row[4] = w->ys[1], row[5] = mode_in_lane(w, 0);
            write_deviations(v, row + CROSSING_HEAD);
        }
    }
    write_result(w, 0, status, result);
    Pair rate = accelerations(&w->field, w->xs[0], w->xs[1], w->ys[0], w->ys[1]);
    result[R_CROSSINGS] = (double)crossing_count;
    result[R_AX] = PAIR_X(rate), result[R_AY] = PAIR_Y(rate);
    write_deviations(v, deviations);
    for (int i = 0; i < EXTREMES; i++) {
        double *row = extremes + i * (1 + v->count);
        row[0] = v->extreme_times[i];
        for (int64_t n = 0; n < v->count; n++)
            row[1 + n] = v->extreme_derivatives[i][n / 8][n % 8];
    }
    return status;
}
