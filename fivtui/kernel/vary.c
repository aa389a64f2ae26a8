/* One run with its derivatives by numbers that change start and parameters. A seed is the direction
   in which such a number changes them; a deviation is the derivative of the motion in that
   direction. */

#define LANES 1
#include "run.h"

#include "deviations.h"
#include "output.h"
#include "vary.h"

/* For each member of `Extremes`: the quantity, and the sign 1 for a maximum or −1 for a minimum. */
enum { OF_X, OF_VX, OF_Y };
#define EXTREMES ((int)(sizeof(Extremes) / sizeof(V)))
static const int QUANTITY[] = {OF_X, OF_X, OF_Y, OF_Y, OF_VX, OF_Y, OF_Y};
static const double SIGN[] = {-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0};
#define FIRST_OF_SECOND_HALF 5

/* The run and its `count` deviations in `vectors` of eight. `cubic` says whether the motion or a
   deviation depends on y³ in contact, `changes` has the derivatives of the field of each mode.
   `extreme_times` and `extreme_derivatives` are those of the extremes so far. */
typedef struct {
    Run run;
    int64_t count, vectors, cubic;
    FieldChange changes[MODES][MAX_VECTORS];
    Deviation deviations[MAX_VECTORS];
    double extreme_times[sizeof(Extremes) / sizeof(V)];
    Eight extreme_derivatives[sizeof(Extremes) / sizeof(V)][MAX_VECTORS];
    /* Ascending sample times, their number, rows to be written, and number of rows so far. */
    const double *sample_times;
    int64_t sample_count;
    double *samples;
    int64_t sampled;
} VariedRun;

/* Time in [first_time, h] at which `sign` times a polynomial is greatest. */
NOINLINE double extremum_time(const V *c, int groups, double first_time, double h, double sign)
{
    double scaled[MAX_TERMS], slope[MAX_TERMS] = {0.0}, candidates[MAX_TERMS];
    scale_polynomial(c, groups, 0, h, scaled);
    for (int n = 1; n < MAX_TERMS; n++)
        slope[n - 1] = n * scaled[n];
    int count = find_roots(slope, MAX_TERMS, MAX_TERMS - 1, candidates);
    candidates[count++] = 1.0;
    double start = first_time / h, theta = start,
        greatest_value = sign * polynomial_value(scaled, MAX_TERMS, start);
    for (int i = 0; i < count; i++) {
        double value = sign * polynomial_value(scaled, MAX_TERMS, candidates[i]);
        if (candidates[i] > start && value > greatest_value)
            theta = candidates[i], greatest_value = value;
    }
    return theta * h;
}

/* Bits of the extremes that the step has changed; sets their times since its start. */
static unsigned changed_extremes(const VariedRun *v, const Extremes *before, double *times)
{
    const Block *w = &v->run.w;
    const int groups = (int)v->run.order / GROUP_SIZE;
    const double *old_values = (const double *)before, *new_values = (const double *)&w->extremes;
    /* Time from the start of the step to the start of the second half. */
    double half_time = maximum((0.5 * v->run.t_end - w->t) - w->remainder, 0.0);
    unsigned changed = 0;
    for (int i = 0; i < EXTREMES; i++) {
        if (old_values[i] == new_values[i])
            continue;
        V velocity[SERIES_LENGTH] = {0.0};
        const V *c = QUANTITY[i] == OF_Y ? w->ys : w->xs;
        if (QUANTITY[i] == OF_VX) {
            set_velocity(w->xs, groups, velocity);
            c = velocity;
        }
        double first_time = i >= FIRST_OF_SECOND_HALF ? minimum(half_time, w->h) : 0.0;
        times[i] = extremum_time(c, groups, first_time, w->h, SIGN[i]);
        changed |= 1u << i;
    }
    return changed;
}

INLINE Eight deviation_of(const Deviation *d, int quantity)
{
    if (quantity == OF_X)
        return d->x;
    return quantity == OF_Y ? d->y : d->vx;
}

/* Write a row (δx, δẋ, δy, δẏ) for each deviation. */
static void write_deviations(const VariedRun *v, const Deviation *deviations, double *rows)
{
    for (int64_t i = 0; i < v->count; i++) {
        const Deviation *d = deviations + i / VECTOR_SIZE;
        const int64_t item = i % VECTOR_SIZE;
        double *row = rows + i * STATE;
        row[S_X] = d->x[item], row[S_VX] = d->vx[item];
        row[S_Y] = d->y[item], row[S_VY] = d->vy[item];
    }
}

/* Write the samples of a substep: state and deviations at sample times up to `end`, a time since
   the start of the step. The deviations are expanded at `start`. */
static void write_samples(VariedRun *v, const Series *series, double start, double end)
{
    const Block *w = &v->run.w;
    for (; v->sampled < v->sample_count; v->sampled++) {
        double t = v->sample_times[v->sampled], elapsed = (t - w->t) - w->remainder;
        if (elapsed > end)
            return;
        double *row = v->samples + v->sampled * STATE * (1 + v->count);
        store_sample(w, (int)v->run.order / GROUP_SIZE, t, row, 1);
        Deviation deviations[MAX_VECTORS];
        for (int i = 0; i < v->vectors; i++)
            deviations[i] = deviation_at(series + i, elapsed - start);
        write_deviations(v, deviations, row + STATE);
    }
}

/* Integrate the deviations over the step, and store them at the times of the `changed` extremes
   and at sample times. Returns RUNNING on success. */
static int advance_deviations(VariedRun *v, unsigned changed, const double *times)
{
    const Block *w = &v->run.w;
    const int groups = (int)v->run.order / GROUP_SIZE, vectors = (int)v->vectors;
    const int cubic = w->side < 0.0 && v->cubic;
    const FieldChange *change = v->changes[mode_in_lane(w, 0)];
    double covered = 0.0;
    for (int is_last = 0; !is_last;) {
        Motion motion;
        Series series[MAX_VECTORS];
        Tangent x = tangent_at(w->xs, groups, covered), y = tangent_at(w->ys, groups, covered);
        /* Deviations need short substeps, each with the motion expanded about its own start;
           `Motion` has zeros before y. */
        motion.x[0] = x.value, motion.x[1] = x.slope;
        motion.y[PADDED_TERMS] = y.value, motion.y[PADDED_TERMS + 1] = y.slope;
        expand_motion(&motion, &w->field, cubic);
        for (int i = 0; i < vectors; i++)
            expand_deviations(series + i, v->deviations + i, &motion, &w->field, change + i, cubic);
        double remaining = w->h - covered, substep = substep_length(series, vectors, remaining);
        if (substep == 0.0)
            return is_finite_motion(&motion) ? UNBOUNDED : OVERFLOW;
        is_last = substep == remaining;
        for (int i = 0; i < EXTREMES; i++) {
            if (!(changed >> i & 1) || !(is_last || times[i] <= covered + substep))
                continue;
            changed ^= 1u << i;
            v->extreme_times[i] = w->t + (w->remainder + times[i]);
            for (int j = 0; j < vectors; j++) {
                Deviation value = deviation_at(series + j, times[i] - covered);
                v->extreme_derivatives[i][j] = deviation_of(&value, QUANTITY[i]);
            }
        }
        write_samples(v, series, covered, covered + substep);
        for (int i = 0; i < vectors; i++)
            v->deviations[i] = deviation_at(series + i, substep);
        covered += substep;
    }
    return RUNNING;
}

/* Accept a step, and apply the switch to the deviations if the step is `cut` at y = 0. The guard is
   y: its gradient in the state is that of y, and no parameter changes it. */
static int finish_varied_step(VariedRun *v, const StepEnd *step_end, int cut)
{
    Block *w = &v->run.w;
    const double gradient[STATE] = {[S_Y] = 1.0};
    const Eight no_change = {0.0};
    Field before = w->field;
    int status = finish_step(&v->run, step_end, cut);
    if (cut) {
        double x = w->xs[0], vx = w->xs[1], y = w->ys[0], vy = w->ys[1];
        Pair jump = accelerations(&w->field, x, vx, y, vy) - accelerations(&before, x, vx, y, vy);
        const double jumps[STATE] = {[S_VX] = PAIR_X(jump), [S_VY] = PAIR_Y(jump)};
        for (int i = 0; i < v->vectors; i++)
            apply_saltation(v->deviations + i, jumps, gradient, no_change, vy);
    }
    return status;
}

/* Bytes of a run with derivatives. */
EXPORT int64_t LIBRARY_NAME(vary_size)(void) { return sizeof(VariedRun); }

EXPORT void LIBRARY_NAME(vary_begin)(void *memory, const double *parameters, int64_t separation,
                                     const double *start, const double *seeds, int64_t count,
                                     double t_end, double tol, int64_t order)
{
    VariedRun *v = memory;
    memset(v, 0, sizeof *v);
    begin_run(&v->run, parameters, separation, start, t_end, tol, order);
    v->count = count, v->vectors = (count + VECTOR_SIZE - 1) / VECTOR_SIZE;
    v->cubic = v->run.cubic;
    for (int64_t i = 0; i < count; i++) {
        const double *seed = seeds + i * (STATE + PARAMETERS), *parameter_seed = seed + STATE;
        const int64_t vector = i / VECTOR_SIZE, item = i % VECTOR_SIZE;
        Deviation *d = v->deviations + vector;
        v->cubic |= parameter_seed[P_K_NL] != 0.0;
        d->x[item] = seed[S_X], d->vx[item] = seed[S_VX];
        d->y[item] = seed[S_Y], d->vy[item] = seed[S_VY];
        for (int mode = 0; mode < MODES; mode++)
            set_field_change(v->changes[mode] + vector, (int)item, parameters, parameter_seed,
                             mode);
    }
}

EXPORT void LIBRARY_NAME(vary_sample)(void *memory, const double *times, int64_t count,
                                      double *samples)
{
    VariedRun *v = memory;
    v->sample_times = times, v->sample_count = count, v->samples = samples;
}

EXPORT int64_t LIBRARY_NAME(vary_advance)(void *memory, double *crossings, int64_t max_crossings,
                                          int64_t budget, double *result, double *deviations,
                                          double *extremes)
{
    VariedRun *v = memory;
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
        status = advance_deviations(v, changed_extremes(v, &before, times), times);
        if (status != RUNNING)
            break;
        double switches = w->separations + w->reattachments;
        status = finish_varied_step(v, &step_end, cut);
        if (w->separations + w->reattachments != switches) {
            double *row = crossings + crossing_count++ * columns;
            row[C_T] = w->last_switch, row[C_X] = w->xs[0], row[C_VX] = w->xs[1];
            row[C_Y] = w->ys[0], row[C_VY] = w->ys[1], row[C_MODE] = mode_in_lane(w, 0);
            write_deviations(v, v->deviations, row + CROSSING_HEAD);
        }
    }
    write_result(w, 0, status, result);
    Pair rate = accelerations(&w->field, w->xs[0], w->xs[1], w->ys[0], w->ys[1]);
    result[R_CROSSINGS] = (double)crossing_count;
    result[R_AX] = PAIR_X(rate), result[R_AY] = PAIR_Y(rate);
    write_deviations(v, v->deviations, deviations);
    for (int i = 0; i < EXTREMES; i++) {
        double *row = extremes + i * (1 + v->count);
        row[0] = v->extreme_times[i];
        for (int64_t n = 0; n < v->count; n++)
            row[1 + n] = v->extreme_derivatives[i][n / VECTOR_SIZE][n % VECTOR_SIZE];
    }
    return status;
}
