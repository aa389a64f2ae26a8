/* States at rest: operation by operation `fivtui.model.slider_belt.static_start`, without functions of
   a library. */

#ifndef FIVTUI_REST_H
#define FIVTUI_REST_H

#include "problem.h"

/* The root of α y³ + β y + F: Newton's method from beyond it, until it comes no nearer. */
INLINE double resting_height(double alpha, double beta, double force)
{
    double y = -force / beta;
    if (alpha > 0.0) {
        double bound = larger(1.0, __builtin_fabs(force) / alpha);
        y = smaller(larger(y, -bound), bound);
    }
    for (;;) {
        double new = y - (alpha * y * y * y + beta * y + force) / (3.0 * alpha * y * y + beta);
        if (!(__builtin_fabs(new) < __builtin_fabs(y)))
            return y;
        y = new;
    }
}

/* The state at rest at the equilibrium of μ = 0 (Eq. 6), infinite where there is none. */
INLINE void resting_state(const double *p, int separation, double *start)
{
    const double load = load_of(p), held = suspension_stiffness(p);
    const double y = !separation || load >= 0.0
                         ? resting_height(rest_cubic(p, 0.0), rest_linear(p, 0.0), load)
                     : held > 0.0 ? -load / held
                                  : INFINITE;
    start[0] = rest_position(p, y, 0.0), start[1] = 0.0;
    start[2] = y, start[3] = 0.0;
}

#endif
