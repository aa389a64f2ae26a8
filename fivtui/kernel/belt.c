/* One run on a belt of finite speed. It has the steps of `single.c`, to the last bit where the belt
   is faster than the slider. */

#define LANES 1
#include "belt.h"
#include "output.h"
#include "variant.h"

/* What a call gives back behind the columns of a result; columns of a change of the mode. */
enum { R_CHANGES = RESULTS, R_SEGMENTS, R_SAMPLES };
#define CHANGE_COLUMNS 3

typedef struct {
    Run run;
    Belt belt;
    int64_t sampled;
} BeltRun;

/* A step as far as its end, with its extremes; returns whether it is sound. */
INLINE int begin_belt_step(BeltRun *of, Ending *ending, Cut *cut, int64_t *then)
{
    Run *run = &of->run;
    Block *w = &run->w;
    const Belt *belt = &of->belt;
    const int order = (int)run->order, groups = order / 4;
    expand_step(belt, w, run->tol, order, run->cubic != 0);
    end_step_y(w, groups);
    *cut = find_end(belt, w, groups, then);
    if (bits_of(end_at_horizon(w, run->t_end, groups))) {
        *cut = NOTHING_ENDS;
        end_step_x(w, groups, 1);
    }
    if (!is_sound(w))
        return 0;
    if (*cut == AT_SPEED || belt->mode == STICK)
        w->vx = belt->v_belt;
    observe(w, groups, 0.5 * run->t_end);
    *ending = ending_of(w, run->t_end, *cut != NOTHING_ENDS);
    return 1;
}

/* Bytes of a run. */
EXPORT int64_t NAME(belt_size)(void) { return sizeof(BeltRun); }

/* Begin a run: parameters with those of the belt, whether separation is considered, and the start.*/
EXPORT void NAME(belt_begin)(BeltRun *of, const double *p, int64_t separation, const double *start,
                             double t_end, double tol, int64_t order)
{
    begin_run(&of->run, p, separation, start, t_end, tol, order);
    begin_belt(&of->belt, &of->run.w, p);
    of->sampled = 0;
}

/* Go on until the run is ended, `changes` or `segments` is full, or `budget` steps are made: as
   `run_advance`, but `changes` receives time, mode before and mode after of every switch. */
EXPORT int64_t NAME(belt_advance)(BeltRun *of, double *changes, int64_t change_room,
                                  const double *times, int64_t time_count, double *samples,
                                  int8_t *modes, double *segments, int64_t segment_room,
                                  int64_t budget, double *result)
{
    Run *run = &of->run;
    Block *w = &run->w;
    const int groups = (int)run->order / 4;
    const int64_t columns = SEGMENT_HEAD + 2 * (run->order + 2);
    int64_t changed = 0, stored = 0, sampled = of->sampled;
    int status = RUNNING;
    while (status == RUNNING && budget-- > 0) {
        Ending ending;
        Cut cut;
        int64_t mode = of->belt.mode, then = STICK;
        if (changed == change_room || (segments && stored == segment_room))
            break;
        if (!begin_belt_step(of, &ending, &cut, &then)) {
            status = OVERFLOW;
            break;
        }
        for (; sampled < time_count && (times[sampled] < ending.t || ending.last); sampled++) {
            store_sample(w, groups, times[sampled], samples + sampled, time_count);
            modes[sampled] = (int8_t)mode;
        }
        if (segments)
            store_segment(w, groups, ending.t, (int)mode, segments + stored++ * columns);
        Arrivals arrivals = go_on_belt(&of->belt, w, &ending, cut, then);
        status = arrivals.done ? DONE : arrivals.stalled ? STALLED : RUNNING;
        if (of->belt.mode != mode) {
            double *change = changes + CHANGE_COLUMNS * changed++;
            change[0] = ending.t, change[1] = (double)mode, change[2] = (double)of->belt.mode;
        }
    }
    of->sampled = sampled;
    write_result(w, 0, status, result);
    result[R_CHANGES] = (double)changed;
    result[R_SEGMENTS] = (double)stored;
    result[R_SAMPLES] = (double)sampled;
    return status;
}
