/* One run: Taylor steps, switches, exact extremes, samples and polynomials. */

#define LANES 1
#include "problem.h"
#include "search.h"
#include "variant.h"

typedef struct {
    Block w;
    double t_end, tol;
    int64_t order, cubic, sampled;
} Run;

/* What a call gives back behind the columns of a result. */
enum { R_SWITCHES = RESULTS, R_SEGMENTS, R_SAMPLES };

/* Columns of a sample: x, ẋ, y, ẏ, mode. Columns of a segment: start, what it lacks of the exact
   start, duration, end, mode, and coefficients of x and of y in θ = time/duration. */
#define SAMPLE_COLUMNS 5
#define SEGMENT_HEAD 5

APART void expand_in_contact(Block *w, int order, int cubic)
{
    if (cubic)
        expand(w->xs, w->ys, &w->field, order, 1);
    else
        expand(w->xs, w->ys, &w->field, order, 0);
}

/* Whether the step ends at a switch now. */
APART int find_switch(Block *w, int groups)
{
    if (!first_switch(w->ys, groups, w->side, &w->h, w->y, w->vy, w->y_off, 1))
        return 0;
    end_step_y(w, groups);
    w->y = 0.0;
    return 1;
}

APART void find_extremes_x(Block *w, int groups, Quest q)
{
    widen(w->xs, groups, &q);
    w->seen.x_low = q.whole.low, w->seen.x_high = q.whole.high;
}

APART void find_extremes_y(Block *w, int groups, Quest q)
{
    widen(w->ys, groups, &q);
    w->seen.y_low = q.whole.low, w->seen.y_high = q.whole.high;
    w->seen.late_low = q.late.low, w->seen.late_high = q.late.high;
}

APART void find_fastest(Block *w, int groups)
{
    V rates[ROWS + 2] = {0.0};
    for (int n = 0; n <= 4 * groups; n++)
        rates[n] = w->xs[n + 1] * (n + 1.0);
    Quest q = {w->h, ends_of(rates, groups, w->h), {-INFINITE, w->seen.vx_high}, ENDLESS, 1, 0};
    widen(rates, groups, &q);
    w->seen.vx_high = q.whole.high;
}

INLINE void observe(Block *w, int groups, double half)
{
    unsigned late = within_second_half(w, groups, half, 1);
    Quest q = quest_in_y(w, 1, late);
    if (q.in_whole | q.in_late)
        find_extremes_y(w, groups, q);
    q = quest_in_x(w, 1);
    if (q.in_whole)
        find_extremes_x(w, groups, q);
    if (may_be_faster(w, groups, 1))
        find_fastest(w, groups);
}

APART void store_sample(const Block *w, int groups, double t, double *row)
{
    double part = (t - w->t) - w->rest;
    Tangent x = tangent_at(w->xs, groups, part), y = tangent_at(w->ys, groups, part);
    row[0] = x.value, row[1] = x.slope, row[2] = y.value, row[3] = y.slope;
    row[4] = w->side < 0.0;
}

APART void store_segment(const Block *w, int groups, double end, double *row)
{
    int size = 4 * groups + 2;
    double power = 1.0;
    row[0] = w->t, row[1] = w->rest, row[2] = w->h, row[3] = end, row[4] = w->side < 0.0;
    for (int n = 0; n < size; n++) {
        row[SEGMENT_HEAD + n] = w->xs[n] * power;
        row[SEGMENT_HEAD + size + n] = w->ys[n] * power;
        power *= w->h;
    }
}

/* Bytes of a run. */
EXPORT int64_t NAME(run_size)(void) { return sizeof(Run); }

/* Begin a run: parameters, whether separation is considered, and (x, ẋ, y, ẏ). */
EXPORT void NAME(run_begin)(Run *run, const double *parameters, int64_t separation,
                            const double *start, double t_end, double tol, int64_t order)
{
    memset(run, 0, sizeof *run);
    begin(&run->w, 0, parameters, separation != 0, start);
    run->t_end = t_end, run->tol = tol;
    run->order = order, run->cubic = parameters[P_KNL] > 0.0;
}

/* Go on until the run is ended, `switches` or `segments` is full, or `budget` steps are made.

   `times` are ascending sample times, `samples` receives the states there; `segments` may be NULL.
   `result` receives the columns of a result and how many switches, segments and samples are in the
   buffers. Returns the status. */
EXPORT int64_t NAME(run_advance)(Run *run, double *switches, int64_t switch_room,
                                 const double *times, double *samples, int64_t time_count,
                                 double *segments, int64_t segment_room, int64_t budget,
                                 double *result)
{
    Block *w = &run->w;
    const double t_end = run->t_end, half = 0.5 * t_end;
    const int order = (int)run->order, groups = order / 4, cubic = run->cubic != 0;
    const int64_t columns = SEGMENT_HEAD + 2 * (order + 2);
    int64_t switched = 0, stored = 0, sampled = run->sampled;
    int status = RUNNING;
    while (status == RUNNING && budget-- > 0) {
        if (switched == switch_room || (segments && stored == segment_room))
            break;
        expand_in_contact(w, order, cubic && w->side < 0.0);
        settle_at_switch(w);
        set_length(w, t_end, run->tol, groups);
        end_step_y(w, groups);
        int cut = may_switch(w) && find_switch(w, groups);
        end_step_x(w, groups, 1);
        if (!is_sound(w)) {
            status = OVERFLOW;
            break;
        }
        observe(w, groups, half);
        Ending ending = ending_of(w, t_end, cut);
        for (; sampled < time_count && (times[sampled] < ending.t || ending.last); sampled++)
            store_sample(w, groups, times[sampled], samples + sampled * SAMPLE_COLUMNS);
        if (segments)
            store_segment(w, groups, ending.t, segments + stored++ * columns);
        double switches_before = w->lifts + w->landings;
        Arrivals arrivals = go_on(w, &ending, cut, 1, INFINITE);
        if (w->lifts + w->landings != switches_before)
            switches[switched++] = w->last;
        status = arrivals.done ? DONE : arrivals.stalled ? STALLED : RUNNING;
    }
    run->sampled = sampled;
    write_result(w, 0, status, result);
    result[R_SWITCHES] = (double)switched;
    result[R_SEGMENTS] = (double)stored;
    result[R_SAMPLES] = (double)sampled;
    return status;
}
