/* Starts a problem in a lane of a block, and reads its result. A problem is a parameter set with a
   start; a block has LANES of them (`Block` in `motion.h`, here `w`). */

#ifndef FIVTUI_PROBLEM_H
#define FIVTUI_PROBLEM_H

#include <stddef.h>

#include "field.h"
#include "motion.h"

/* Columns of a result: `RunColumns` in `fivtui.kernel.runs`. R_SECOND_HALF_MIN and
   R_SECOND_HALF_MAX are extremes of y in the second half of the run. */
enum {
    R_X, R_VX, R_Y, R_VY, R_T, R_STATUS, R_STEPS, R_SEPARATIONS, R_REATTACHMENTS,
    R_SEPARATED_TIME, R_FIRST_SWITCH, R_LAST_SWITCH, R_X_MIN, R_Y_MIN, R_X_MAX, R_Y_MAX, R_VX_MAX,
    R_SECOND_HALF_MIN, R_SECOND_HALF_MAX, RESULTS
};

/* The number of one lane in a member of a block, to be assigned. */
#define MEMBER(w, member, lane) (((double *)&(w)->member)[lane])

/* Clear a lane; without a problem it computes steps in which nothing moves. */
INLINE void clear_lane(Block *w, int lane)
{
    V *rows = (V *)w;
    for (size_t n = 0; n < PERSISTENT_ROWS; n++)
        set_lane(rows + n, lane, 0.0);
    for (int n = 0; n < 2; n++)
        set_lane(w->xs + n, lane, 0.0), set_lane(w->ys + n, lane, 0.0);
    MEMBER(w, max_step, lane) = 1.0;
}

/* Set the constants of a lane that follow from its parameters. `contact` and `separated` have the
   coefficients of Eqs. 2 and 5 of the paper, divided by the mass: `cubic` is k_nl/m, `load` F/m. */
INLINE void set_constants(Block *w, int lane, const double *p)
{
    const double m = p[P_M], stiffness = total_stiffness(p);
    const Coefficients contact = contact_coefficients(p), separated = separated_coefficients(p);
    MEMBER(w, field.a_x, lane) = contact.xx;
    MEMBER(w, field.a_y, lane) = contact.yx;
    MEMBER(w, field.damping_x, lane) = contact.xvx;
    MEMBER(w, field.damping_y, lane) = contact.yvy;
    MEMBER(w, field.load, lane) = contact.load;
    MEMBER(w, contact_b_x, lane) = contact.xy;
    MEMBER(w, contact_b_y, lane) = contact.yy;
    /* Friction is μ times the contact force, and so is its cubic term. */
    MEMBER(w, contact_d_x, lane) = contact.friction * contact.cubic;
    MEMBER(w, contact_d_y, lane) = contact.cubic;
    MEMBER(w, separated_b_x, lane) = separated.xy;
    MEMBER(w, separated_b_y, lane) = separated.yy;
    MEMBER(w, coupling, lane) = coupling_stiffness(p);
    MEMBER(w, preload, lane) = load_of(p);
    MEMBER(w, deflection, lane) = __builtin_fabs(load_of(p)) / stiffness;
    MEMBER(w, frequency, lane) = 1.0 / __builtin_sqrt(m / stiffness);
    MEMBER(w, max_step, lane) = LONGEST_STEP / MEMBER(w, frequency, lane);
}

/* Start a problem in a lane. */
INLINE void begin_problem(Block *w, int lane, const double *p, int separation, const double *start)
{
    clear_lane(w, lane);
    set_constants(w, lane, p);
    MEMBER(w, separation, lane) = separation;
    MEMBER(w, first_switch, lane) = MEMBER(w, last_switch, lane) = __builtin_nan("");
    MEMBER(w, extremes.x_low, lane) = MEMBER(w, extremes.y_low, lane) = INFINITE;
    MEMBER(w, extremes.x_high, lane) = MEMBER(w, extremes.y_high, lane) = -INFINITE;
    MEMBER(w, extremes.vx_high, lane) = -INFINITE;
    MEMBER(w, extremes.second_half_low, lane) = INFINITE;
    MEMBER(w, extremes.second_half_high, lane) = -INFINITE;
    set_lane(w->xs, lane, start[S_X]), set_lane(w->xs + 1, lane, start[S_VX]);
    set_lane(w->ys, lane, start[S_Y]), set_lane(w->ys + 1, lane, start[S_VY]);
    V sides_from_zero = side_after(w, w->xs[0], w->xs[1], w->ys[1]);
    double side = get_lane(&sides_from_zero, lane);
    if (start[S_Y] != 0.0)
        side = start[S_Y] > 0.0 ? 1.0 : -1.0;
    MEMBER(w, side, lane) = separation ? side : -1.0;
    set_field(w);
}

/* Write the result of a lane up to its current time; `result` has RESULTS columns. */
INLINE void write_result(const Block *w, int lane, int status, double *result)
{
    const Extremes *extremes = &w->extremes;
    result[R_X] = get_lane(w->xs, lane), result[R_VX] = get_lane(w->xs + 1, lane);
    result[R_Y] = get_lane(w->ys, lane), result[R_VY] = get_lane(w->ys + 1, lane);
    result[R_T] = get_lane(&w->t, lane), result[R_STATUS] = status;
    result[R_STEPS] = get_lane(&w->steps, lane);
    result[R_SEPARATIONS] = get_lane(&w->separations, lane);
    result[R_REATTACHMENTS] = get_lane(&w->reattachments, lane);
    result[R_SEPARATED_TIME] = get_lane(&w->separated_time, lane);
    result[R_FIRST_SWITCH] = get_lane(&w->first_switch, lane);
    result[R_LAST_SWITCH] = get_lane(&w->last_switch, lane);
    result[R_X_MIN] = get_lane(&extremes->x_low, lane);
    result[R_X_MAX] = get_lane(&extremes->x_high, lane);
    result[R_Y_MIN] = get_lane(&extremes->y_low, lane);
    result[R_Y_MAX] = get_lane(&extremes->y_high, lane);
    result[R_VX_MAX] = get_lane(&extremes->vx_high, lane);
    result[R_SECOND_HALF_MIN] = get_lane(&extremes->second_half_low, lane);
    result[R_SECOND_HALF_MAX] = get_lane(&extremes->second_half_high, lane);
}

#endif
