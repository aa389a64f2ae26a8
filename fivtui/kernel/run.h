/* The step of a single run, shared by `single.c` and `vary.c`, so that both have the same bits.
   LANES is 1: the block `w` has one run. */

#ifndef FIVTUI_RUN_H
#define FIVTUI_RUN_H

#include "problem.h"
#include "search.h"

/* `t_end` is the horizon, s, `tol` the local tolerance, `order` the order of expansion; `cubic`
   says whether the contact spring has a cubic term. */
typedef struct {
    Block w;
    double t_end, tol;
    int64_t order, cubic;
} Run;

INLINE void begin_run(Run *run, const double *parameters, int64_t separation, const double *start,
                      double t_end, double tol, int64_t order)
{
    memset(run, 0, sizeof *run);
    begin_problem(&run->w, 0, parameters, separation != 0, start);
    run->t_end = t_end, run->tol = tol;
    run->order = order, run->cubic = parameters[P_K_NL] > 0.0;
}

/* Expand a step; constant `cubic` gives two specialised copies of `expand`. */
NOINLINE void expand_block(Block *w, int order, int cubic)
{
    if (cubic)
        expand(w->xs, w->ys, &w->field, order, 1);
    else
        expand(w->xs, w->ys, &w->field, order, 0);
}

/* Shorten the step to its first switch; returns whether there is one. */
NOINLINE int cut_at_zero_height(Block *w, int groups)
{
    const unsigned lanes = 1;
    if (!find_first_switch(w->ys, groups, w->side, &w->h, w->y, w->vy, w->y_error, lanes))
        return 0;
    evaluate_end_y(w, groups);
    w->y = 0.0;
    return 1;
}

/* Extend the extremes of x, of y and of ẋ by the step. Kept out of line: most steps need none. */
NOINLINE void update_extremes_x(Block *w, int groups, ExtremaSearch search)
{
    find_extrema(w->xs, groups, &search);
    w->extremes.x_low = search.full.low, w->extremes.x_high = search.full.high;
}

NOINLINE void update_extremes_y(Block *w, int groups, ExtremaSearch search)
{
    find_extrema(w->ys, groups, &search);
    w->extremes.y_low = search.full.low, w->extremes.y_high = search.full.high;
    w->extremes.second_half_low = search.second_half.low;
    w->extremes.second_half_high = search.second_half.high;
}

NOINLINE void update_max_vx(Block *w, int groups)
{
    V velocity[SERIES_LENGTH] = {0.0};
    set_velocity(w->xs, groups, velocity);
    ExtremaSearch search = {.h = w->h, .ends = ends_of(velocity, groups, w->h),
                            .full = {-INFINITE, w->extremes.vx_high},
                            .second_half = UNLIMITED, .full_lanes = 1};
    find_extrema(velocity, groups, &search);
    w->extremes.vx_high = search.full.high;
}

/* Extend the extremes by the step. The second half of the run begins at `half_time`. The greatest ẋ
   of the step is at one of its ends, or at most `speed_limit`. */
INLINE void observe_extremes(Block *w, int groups, double half_time, double speed_limit)
{
    const unsigned lanes = 1;
    unsigned second_half_lanes = select_second_half(w, groups, half_time, lanes);
    ExtremaSearch search = search_in_y(w, lanes, second_half_lanes);
    if (search.full_lanes | search.second_half_lanes)
        update_extremes_y(w, groups, search);
    search = search_in_x(w, lanes);
    if (search.full_lanes)
        update_extremes_x(w, groups, search);
    if (may_exceed_max_vx(w, groups, speed_limit, lanes))
        update_max_vx(w, groups);
}

/* Compute a step and its extremes; set the time at its end, and whether it is `cut` at a switch.
   Returns whether the end is finite. */
INLINE int compute_step(Run *run, StepEnd *step_end, int *cut)
{
    Block *w = &run->w;
    const int order = (int)run->order, groups = order / GROUP_SIZE;
    expand_block(w, order, run->cubic != 0 && w->side < 0.0);
    balance_vertical_forces(w);
    set_step_length(w, run->tol, groups);
    evaluate_end_y(w, groups);
    *cut = may_reach_zero_height(w) && cut_at_zero_height(w, groups);
    if (mask_bits(clip_at_horizon(w, run->t_end, groups)))
        *cut = 0;
    evaluate_end_x(w, groups, 1);
    if (!is_finite_step(w))
        return 0;
    observe_extremes(w, groups, 0.5 * run->t_end, INFINITE);
    *step_end = find_step_end(w, run->t_end, *cut);
    return 1;
}

/* Accept the step; returns the status. */
INLINE int finish_step(Run *run, const StepEnd *step_end, int cut)
{
    StepFlags flags = accept_step(&run->w, step_end, cut, 1, INFINITE);
    if (flags.finished)
        return DONE;
    return flags.stalled ? STALLED : RUNNING;
}

#endif
