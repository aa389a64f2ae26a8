/* States at rest, by the operations of `static_start` in `fivtui.model.slider_belt`. */

#ifndef FIVTUI_REST_H
#define FIVTUI_REST_H

#include "problem.h"

/* The root of α y³ + β y + F: Newton's method from outside, until |y| no longer decreases. */
INLINE double resting_height(double alpha, double beta, double force)
{
    double y = -force / beta;
    if (alpha > 0.0) {
        double bound = maximum(1.0, __builtin_fabs(force) / alpha);
        y = minimum(maximum(y, -bound), bound);
    }
    for (;;) {
        double new = y - (alpha * y * y * y + beta * y + force) / (3.0 * alpha * y * y + beta);
        if (!(__builtin_fabs(new) < __builtin_fabs(y)))
            return y;
        y = new;
    }
}

/* The state at rest at the equilibrium for μ = 0 (Eq. 6); infinite without one. */
INLINE void resting_state(const double *p, int separation, double *start)
{
    const double load = load_of(p), stiffness = suspension_stiffness(p);
    const double y = !separation || load >= 0.0
                         ? resting_height(rest_cubic(p, 0.0), rest_linear(p, 0.0), load)
                     : stiffness > 0.0 ? -load / stiffness
                                  : INFINITE;
    start[0] = rest_position(p, y, 0.0), start[1] = 0.0;
    start[2] = y, start[3] = 0.0;
}

#endif
