/* One run on a belt of finite speed, or of which F, μ and the belt's speed follow tables. It has the
   steps of `single.c`, to the last bit where the belt is faster than the slider. */

#define LANES 1
#define FINITE 1
#include "driven.h"
#include "output.h"
#include "variant.h"

/* What a call gives back behind the columns of a result: how much is new, then the time of stick so
   far, s, and the numbers of changes by mode before · MODES + mode after. Columns of a change. */
enum { R_CHANGES = RESULTS, R_SEGMENTS, R_SAMPLES, R_STICK_TIME, R_KINDS };
#define CHANGE_COLUMNS 3

/* Columns of a leg between two rows of tables over time: its beginning, values and slopes, and the
   speed to which the belt comes at its end. */
enum {
    L_BEGIN, L_F, L_F_SLOPE, L_MU, L_MU_SLOPE, L_MU_S, L_MU_S_SLOPE, L_V, L_V_SLOPE, L_LAST_V, LEG
};

/* The slider sticks since `stuck_since`, if it does. With `legs`, which are the caller's, the run is
   on the course of one leg after another. */
typedef struct {
    Run run;
    Belt belt;
    int64_t sampled;
    double stick_time, stuck_since, kinds[MODES * MODES];
    const double *legs;
    int64_t leg_count;
    Course course;
} BeltRun;

/* The run in the caller's memory, from a line of the cache on: four coefficients seldom lie on two. */
#define LINE 64
INLINE BeltRun *run_in(void *room)
{
    return (BeltRun *)(((uintptr_t)room + (LINE - 1)) & ~(uintptr_t)(LINE - 1));
}

INLINE void begin_count(BeltRun *of)
{
    of->sampled = 0;
    of->stick_time = of->stuck_since = 0.0;
    memset(of->kinds, 0, sizeof of->kinds);
}

/* A step as far as its end, with its extremes; returns whether it is sound. */
INLINE int begin_belt_step(BeltRun *of, Ending *ending, Cut *cut, int64_t *then)
{
    Run *run = &of->run;
    Block *w = &run->w;
    const Belt *belt = &of->belt;
    const int order = (int)run->order, groups = order / 4;
    int stays = expand_step(belt, w, run->tol, order, run->cubic != 0);
    end_step_y(w, groups);
    *cut = find_end(belt, w, groups, stays, then);
    if (bits_of(end_at_horizon(w, run->t_end, groups))) {
        *cut = NOTHING_ENDS;
        end_step_x(w, groups, 1);
    }
    if (!is_sound(w))
        return 0;
    if (*cut == AT_SPEED || belt->mode == STICK)
        w->vx = belt->p[P_V_BELT];
    foresee(&of->belt, w);
    observe(w, groups, 0.5 * run->t_end, speed_limit(&of->belt, w->h));
    *ending = ending_of(w, run->t_end, *cut != NOTHING_ENDS);
    return 1;
}

INLINE Course course_of(const double *leg)
{
    return (Course){{leg[L_F], leg[L_F_SLOPE]}, {leg[L_MU], leg[L_MU_SLOPE]},
                    {leg[L_MU_S], leg[L_MU_S_SLOPE]}, {leg[L_V], leg[L_V_SLOPE]}, leg[L_BEGIN]};
}

INLINE double leg_end(const BeltRun *of)
{
    return of->leg_count > 1 ? of->legs[LEG + L_BEGIN] : INFINITE;
}

/* The same of a run over legs. */
INLINE int begin_driven_step(BeltRun *of, Ending *ending, Cut *cut, int64_t *then)
{
    Run *run = &of->run;
    Block *w = &run->w;
    const int order = (int)run->order, groups = order / 4;
    const double end = leg_end(of);
    expand_driven_step(&of->belt, w, run->tol, order, (end - w->t) - w->rest);
    end_step_y(w, groups);
    *cut = find_end(&of->belt, w, groups, 0, then);
    if (bits_of(end_at_horizon(w, run->t_end, groups))) {
        *cut = NOTHING_ENDS;
        end_step_x(w, groups, 1);
    }
    if (!is_sound(w))
        return 0;
    observe(w, groups, 0.5 * run->t_end, speed_limit(&of->belt, w->h));
    *ending = ending_of(w, run->t_end, *cut != NOTHING_ENDS);
    if (ending->t >= end)
        ending->t = end, ending->rest = 0.0;
    return 1;
}

INLINE Arrivals end_driven_step(BeltRun *of, const Ending *ending, Cut cut, int64_t then)
{
    const int bends = ending->t == leg_end(of);
    double speed = bends ? of->legs[L_LAST_V] : last_speed(&of->course, ending);
    if (bends) {
        of->legs += LEG, of->leg_count--;
        of->course = course_of(of->legs);
    }
    return go_on_driven(&of->belt, &of->run.w, ending, cut, then, speed, &of->course, bends);
}

/* Bytes of the room of a run, wherever it is. */
EXPORT int64_t NAME(belt_size)(void) { return sizeof(BeltRun) + LINE; }

/* Begin a run: parameters with those of the belt, whether separation is considered, and the start.*/
EXPORT void NAME(belt_begin)(void *room, const double *p, int64_t separation, const double *start,
                             double t_end, double tol, int64_t order)
{
    BeltRun *of = run_in(room);
    begin_run(&of->run, p, separation, start, t_end, tol, order);
    begin_belt(&of->belt, &of->run.w, 0, p, 1);
    begin_count(of);
    of->legs = NULL, of->leg_count = 0;
}

/* Begin a run over legs, on a belt that is `finite` or always faster; the greatest preload of all
   legs is the scale of displacements. */
EXPORT void NAME(driven_begin)(void *room, const double *p, int64_t separation,
                               const double *start, double t_end, double tol, int64_t order,
                               int64_t finite, const double *legs, int64_t leg_count,
                               double greatest_load)
{
    BeltRun *of = run_in(room);
    begin_run(&of->run, p, separation, start, t_end, tol, order);
    Block *w = &of->run.w;
    begin_belt(&of->belt, w, 0, p, finite != 0);
    w->deflection = greatest_load / total_stiffness(of->belt.p);
    begin_count(of);
    of->legs = legs, of->leg_count = leg_count;
    of->course = course_of(legs);
    begin_driven(&of->belt, w, &of->course);
}

/* Go on until the run is ended, `changes` or `segments` is full, or `budget` steps are made: as
   `run_advance`, but `changes` receives time, mode before and mode after of every switch. */
EXPORT int64_t NAME(belt_advance)(void *room, double *changes, int64_t change_room,
                                  const double *times, int64_t time_count, double *samples,
                                  int8_t *modes, double *segments, int64_t segment_room,
                                  int64_t budget, double *result)
{
    BeltRun *of = run_in(room);
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
        if (!(of->legs ? begin_driven_step(of, &ending, &cut, &then)
                       : begin_belt_step(of, &ending, &cut, &then))) {
            status = OVERFLOW;
            break;
        }
        for (; sampled < time_count && (times[sampled] < ending.t || ending.last); sampled++) {
            store_sample(w, groups, times[sampled], samples + sampled, time_count);
            modes[sampled] = (int8_t)mode;
        }
        if (segments)
            store_segment(w, groups, ending.t, (int)mode, segments + stored++ * columns);
        Arrivals arrivals = of->legs ? end_driven_step(of, &ending, cut, then)
                                     : go_on_belt(&of->belt, w, &ending, cut, then);
        status = arrivals.done ? DONE : arrivals.stalled ? STALLED : RUNNING;
        if (of->belt.mode != mode) {
            double *change = changes + CHANGE_COLUMNS * changed++;
            change[0] = ending.t, change[1] = (double)mode, change[2] = (double)of->belt.mode;
            of->kinds[mode * MODES + of->belt.mode] += 1.0;
            if (mode == STICK)
                of->stick_time += ending.t - of->stuck_since;
            of->stuck_since = ending.t;
        }
    }
    of->sampled = sampled;
    write_result(w, 0, status, result);
    result[R_CHANGES] = (double)changed;
    result[R_SEGMENTS] = (double)stored;
    result[R_SAMPLES] = (double)sampled;
    result[R_STICK_TIME] = of->stick_time + (of->belt.mode == STICK ? w->t - of->stuck_since : 0.0);
    memcpy(result + R_KINDS, of->kinds, sizeof of->kinds);
    return status;
}
