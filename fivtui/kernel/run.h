/* A run of its own, step by step: what the runs of `single.c` and `vary.c` have in common, so that
   they have the same bits. LANES is 1. */

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
    begin(&run->w, 0, parameters, separation != 0, start);
    run->t_end = t_end, run->tol = tol;
    run->order = order, run->cubic = parameters[P_K_NL] > 0.0;
}

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

INLINE void observe(Block *w, int groups, double half, double speed_limit)
{
    unsigned late = within_second_half(w, groups, half, 1);
    Quest q = quest_in_y(w, 1, late);
    if (q.in_whole | q.in_late)
        find_extremes_y(w, groups, q);
    q = quest_in_x(w, 1);
    if (q.in_whole)
        find_extremes_x(w, groups, q);
    if (may_be_faster(w, groups, speed_limit, 1))
        find_fastest(w, groups);
}

/* A step as far as its end, with its extremes; where that is, and whether it is `cut` at a switch.
   Returns whether it is sound. */
INLINE int begin_step(Run *run, Ending *ending, int *cut)
{
    Block *w = &run->w;
    const int order = (int)run->order, groups = order / 4;
    expand_in_contact(w, order, run->cubic != 0 && w->side < 0.0);
    settle_at_switch(w);
    set_length(w, run->tol, groups);
    end_step_y(w, groups);
    *cut = may_switch(w) && find_switch(w, groups);
    if (bits_of(end_at_horizon(w, run->t_end, groups)))
        *cut = 0;
    end_step_x(w, groups, 1);
    if (!is_sound(w))
        return 0;
    observe(w, groups, 0.5 * run->t_end, INFINITE);
    *ending = ending_of(w, run->t_end, *cut);
    return 1;
}

/* Go on from the end of the step; returns the status. */
INLINE int end_step(Run *run, const Ending *ending, int cut)
{
    Arrivals arrivals = go_on(&run->w, ending, cut, 1, INFINITE);
    return arrivals.done ? DONE : arrivals.stalled ? STALLED : RUNNING;
}

#endif
