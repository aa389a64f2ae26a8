/* How a problem comes into a lane of a block, and its result out of it. */

#ifndef FIVTUI_PROBLEM_H
#define FIVTUI_PROBLEM_H

#include <stddef.h>

#include "field.h"
#include "motion.h"

/* Columns of a result: `fivtui.kernel.native.RunColumns`. */
enum {
    R_X, R_VX, R_Y, R_VY, R_T, R_STATUS, R_STEPS, R_SEPARATIONS, R_REATTACHMENTS, R_SEPARATED,
    R_FIRST, R_LAST, R_X_MIN, R_Y_MIN, R_X_MAX, R_Y_MAX, R_VX_MAX, R_Y_LOW, R_Y_HIGH, RESULTS
};

/* The row of a block at a field of it, for one lane. */
#define OF(w, field, lane) (((double *)&(w)->field)[lane])

/* Empty a lane: what has no problem stands still. */
INLINE void clear(Block *w, int lane)
{
    V *rows = (V *)w;
    for (size_t n = 0; n < KEPT_ROWS; n++)
        put(rows + n, lane, 0.0);
    for (int n = 0; n < 2; n++)
        put(w->xs + n, lane, 0.0), put(w->ys + n, lane, 0.0);
    OF(w, longest, lane) = 1.0;
}

/* Put a problem into a lane: Eqs. 2 and 5 divided by the mass. */
INLINE void begin(Block *w, int lane, const double *p, int separation, const double *start)
{
    const double m = p[P_M], stiffness = total_stiffness(p);
    const Coefficients contact = contact_coefficients(p), off = separated_coefficients(p);
    clear(w, lane);
    OF(w, field.a_x, lane) = contact.xx;
    OF(w, field.a_y, lane) = contact.yx;
    OF(w, field.damping_x, lane) = contact.xvx;
    OF(w, field.damping_y, lane) = contact.yvy;
    OF(w, field.load, lane) = contact.load;
    OF(w, contact_b_x, lane) = contact.xy;
    OF(w, contact_b_y, lane) = contact.yy;
    OF(w, contact_d_x, lane) = contact.friction * contact.cubic;
    OF(w, contact_d_y, lane) = contact.cubic;
    OF(w, off_b_x, lane) = off.xy;
    OF(w, off_b_y, lane) = off.yy;
    OF(w, coupling, lane) = coupling_stiffness(p);
    OF(w, preload, lane) = load_of(p);
    OF(w, deflection, lane) = __builtin_fabs(load_of(p)) / stiffness;
    OF(w, frequency, lane) = 1.0 / __builtin_sqrt(m / stiffness);
    OF(w, longest, lane) = LONGEST_STEP / OF(w, frequency, lane);
    OF(w, separation, lane) = separation;
    OF(w, first, lane) = OF(w, last, lane) = __builtin_nan("");
    OF(w, seen.x_low, lane) = OF(w, seen.y_low, lane) = OF(w, seen.late_low, lane) = INFINITE;
    OF(w, seen.x_high, lane) = OF(w, seen.y_high, lane) = OF(w, seen.late_high, lane) = -INFINITE;
    OF(w, seen.vx_high, lane) = -INFINITE;
    put(w->xs, lane, start[0]), put(w->xs + 1, lane, start[1]);
    put(w->ys, lane, start[2]), put(w->ys + 1, lane, start[3]);
    V sides = side_after(w, w->xs[0], w->xs[1], w->ys[1]);
    double side = start[2] > 0.0 ? 1.0 : start[2] < 0.0 ? -1.0 : element(&sides, lane);
    OF(w, side, lane) = separation ? side : -1.0;
    set_field(w);
}

INLINE void write_result(const Block *w, int lane, int status, double *r)
{
    r[R_X] = element(w->xs, lane), r[R_VX] = element(w->xs + 1, lane);
    r[R_Y] = element(w->ys, lane), r[R_VY] = element(w->ys + 1, lane);
    r[R_T] = OF(w, t, lane), r[R_STATUS] = status, r[R_STEPS] = OF(w, steps, lane);
    r[R_SEPARATIONS] = OF(w, lifts, lane), r[R_REATTACHMENTS] = OF(w, landings, lane);
    r[R_SEPARATED] = OF(w, separated, lane);
    r[R_FIRST] = OF(w, first, lane), r[R_LAST] = OF(w, last, lane);
    r[R_X_MIN] = OF(w, seen.x_low, lane), r[R_X_MAX] = OF(w, seen.x_high, lane);
    r[R_Y_MIN] = OF(w, seen.y_low, lane), r[R_Y_MAX] = OF(w, seen.y_high, lane);
    r[R_VX_MAX] = OF(w, seen.vx_high, lane);
    r[R_Y_LOW] = OF(w, seen.late_low, lane), r[R_Y_HIGH] = OF(w, seen.late_high, lane);
}

#endif
