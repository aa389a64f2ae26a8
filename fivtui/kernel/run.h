/* The step of a single run, with which `single.c` and `vary.c` have the same bits. LANES is 1. */

#ifndef FIVTUI_RUN_H
#define FIVTUI_RUN_H

#include "problem.h"
#include "search.h"

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

NOINLINE void expand_block(Block *w, int order, int cubic)
{
    if (cubic)
        expand(w->xs, w->ys, &w->field, order, 1);
    else
        expand(w->xs, w->ys, &w->field, order, 0);
}

/* Shorten the step to its first switch; returns whether there is one. */
NOINLINE int cut_at_switch(Block *w, int groups)
{
    if (!find_first_switch(w->ys, groups, w->side, &w->h, w->y, w->vy, w->y_error, 1))
        return 0;
    evaluate_end_y(w, groups);
    w->y = 0.0;
    return 1;
}

NOINLINE void update_extremes_x(Block *w, int groups, ExtremaSearch q)
{
    find_extrema(w->xs, groups, &q);
    w->extremes.x_low = q.full.low, w->extremes.x_high = q.full.high;
}

NOINLINE void update_extremes_y(Block *w, int groups, ExtremaSearch q)
{
    find_extrema(w->ys, groups, &q);
    w->extremes.y_low = q.full.low, w->extremes.y_high = q.full.high;
    w->extremes.late_low = q.late.low, w->extremes.late_high = q.late.high;
}

NOINLINE void update_max_vx(Block *w, int groups)
{
    V rates[ROWS + 2] = {0.0};
    for (int n = 0; n <= 4 * groups; n++)
        rates[n] = w->xs[n + 1] * (n + 1.0);
    ExtremaSearch q = {w->h, ends_of(rates, groups, w->h), {-INFINITE, w->extremes.vx_high},
                       UNLIMITED, 1, 0};
    find_extrema(rates, groups, &q);
    w->extremes.vx_high = q.full.high;
}

INLINE void observe_extremes(Block *w, int groups, double half, double speed_limit)
{
    unsigned late = select_second_half(w, groups, half, 1);
    ExtremaSearch q = search_in_y(w, 1, late);
    if (q.full_lanes | q.late_lanes)
        update_extremes_y(w, groups, q);
    q = search_in_x(w, 1);
    if (q.full_lanes)
        update_extremes_x(w, groups, q);
    if (may_exceed_max_vx(w, groups, speed_limit, 1))
        update_max_vx(w, groups);
}

/* Compute a step and its extremes, the time at its end, and whether it is `cut` at a switch.
   Returns whether its end is finite. */
INLINE int compute_step(Run *run, StepEnd *step_end, int *cut)
{
    Block *w = &run->w;
    const int order = (int)run->order, groups = order / 4;
    expand_block(w, order, run->cubic != 0 && w->side < 0.0);
    balance_at_switch(w);
    set_step_length(w, run->tol, groups);
    evaluate_end_y(w, groups);
    *cut = may_switch(w) && cut_at_switch(w, groups);
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
    return flags.finished ? DONE : flags.stalled ? STALLED : RUNNING;
}

#endif
