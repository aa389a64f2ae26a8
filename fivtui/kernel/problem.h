/* Starts a problem in a lane of a block, and reads its result. */

#ifndef FIVTUI_PROBLEM_H
#define FIVTUI_PROBLEM_H

#include <stddef.h>

#include "field.h"
#include "motion.h"

/* Columns of a result: `RunColumns` in `fivtui.kernel.runs`. */
enum {
    R_X, R_VX, R_Y, R_VY, R_T, R_STATUS, R_STEPS, R_SEPARATIONS, R_REATTACHMENTS, R_SEPARATED,
    R_FIRST, R_LAST, R_X_MIN, R_Y_MIN, R_X_MAX, R_Y_MAX, R_VX_MAX, R_Y_LOW, R_Y_HIGH, RESULTS
};

/* The number of one lane in a member of a block. */
#define LANE(w, field, lane) (((double *)&(w)->field)[lane])

/* Clear a lane; a lane without a problem stands still. */
INLINE void clear_lane(Block *w, int lane)
{
    V *rows = (V *)w;
    for (size_t n = 0; n < PERSISTENT_ROWS; n++)
        set_lane(rows + n, lane, 0.0);
    for (int n = 0; n < 2; n++)
        set_lane(w->xs + n, lane, 0.0), set_lane(w->ys + n, lane, 0.0);
    LANE(w, max_step, lane) = 1.0;
}

/* Start a problem in a lane: Eqs. 2 and 5 divided by the mass. */
INLINE void begin_problem(Block *w, int lane, const double *p, int separation, const double *start)
{
    const double m = p[P_M], stiffness = total_stiffness(p);
    const Coefficients contact = contact_coefficients(p), off = separated_coefficients(p);
    clear_lane(w, lane);
    LANE(w, field.a_x, lane) = contact.xx;
    LANE(w, field.a_y, lane) = contact.yx;
    LANE(w, field.damping_x, lane) = contact.xvx;
    LANE(w, field.damping_y, lane) = contact.yvy;
    LANE(w, field.load, lane) = contact.load;
    LANE(w, contact_b_x, lane) = contact.xy;
    LANE(w, contact_b_y, lane) = contact.yy;
    LANE(w, contact_d_x, lane) = contact.friction * contact.cubic;
    LANE(w, contact_d_y, lane) = contact.cubic;
    LANE(w, separated_b_x, lane) = off.xy;
    LANE(w, separated_b_y, lane) = off.yy;
    LANE(w, coupling, lane) = coupling_stiffness(p);
    LANE(w, preload, lane) = load_of(p);
    LANE(w, deflection, lane) = __builtin_fabs(load_of(p)) / stiffness;
    LANE(w, frequency, lane) = 1.0 / __builtin_sqrt(m / stiffness);
    LANE(w, max_step, lane) = LONGEST_STEP / LANE(w, frequency, lane);
    LANE(w, separation, lane) = separation;
    LANE(w, first_switch, lane) = LANE(w, last_switch, lane) = __builtin_nan("");
    LANE(w, extremes.x_low, lane) = LANE(w, extremes.y_low, lane) = LANE(w, extremes.late_low,
                                                                         lane) = INFINITE;
    LANE(w, extremes.x_high, lane) = LANE(w, extremes.y_high, lane) = LANE(w, extremes.late_high,
                                                                           lane) = -INFINITE;
    LANE(w, extremes.vx_high, lane) = -INFINITE;
    set_lane(w->xs, lane, start[0]), set_lane(w->xs + 1, lane, start[1]);
    set_lane(w->ys, lane, start[2]), set_lane(w->ys + 1, lane, start[3]);
    V sides = side_after(w, w->xs[0], w->xs[1], w->ys[1]);
    double side = start[2] > 0.0 ? 1.0 : start[2] < 0.0 ? -1.0 : get_lane(&sides, lane);
    LANE(w, side, lane) = separation ? side : -1.0;
    set_field(w);
}

INLINE void write_result(const Block *w, int lane, int status, double *r)
{
    r[R_X] = get_lane(w->xs, lane), r[R_VX] = get_lane(w->xs + 1, lane);
    r[R_Y] = get_lane(w->ys, lane), r[R_VY] = get_lane(w->ys + 1, lane);
    r[R_T] = LANE(w, t, lane), r[R_STATUS] = status, r[R_STEPS] = LANE(w, steps, lane);
    r[R_SEPARATIONS] = LANE(w, separations, lane),
        r[R_REATTACHMENTS] = LANE(w, reattachments, lane);
    r[R_SEPARATED] = LANE(w, separated_time, lane);
    r[R_FIRST] = LANE(w, first_switch, lane), r[R_LAST] = LANE(w, last_switch, lane);
    r[R_X_MIN] = LANE(w, extremes.x_low, lane), r[R_X_MAX] = LANE(w, extremes.x_high, lane);
    r[R_Y_MIN] = LANE(w, extremes.y_low, lane), r[R_Y_MAX] = LANE(w, extremes.y_high, lane);
    r[R_VX_MAX] = LANE(w, extremes.vx_high, lane);
    r[R_Y_LOW] = LANE(w, extremes.late_low, lane), r[R_Y_HIGH] = LANE(w, extremes.late_high, lane);
}

#endif
