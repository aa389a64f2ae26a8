/* States at rest, by the operations of `static_start` in `fivtui.model.slider_belt`. */

#ifndef FIVTUI_REST_H
#define FIVTUI_REST_H

#include "problem.h"

/* The root y, m, of α y³ + β y + F with α, β ≥ 0: Newton's method from beyond the root, until |y|
   no longer decreases. Each term alone bounds |y|: |F|/β, and for α > 0 the cube root of |F|/α,
   which is at most max(1, |F|/α). */
INLINE double resting_height(double alpha, double beta, double force)
{
    double y = -force / beta;
    if (alpha > 0.0) {
        double bound = maximum(1.0, __builtin_fabs(force) / alpha);
        y = minimum(maximum(y, -bound), bound);
    }
    for (;;) {
        double next_y = y - (alpha * y * y * y + beta * y + force) / (3.0 * alpha * y * y + beta);
        if (!(__builtin_fabs(next_y) < __builtin_fabs(y)))
            return y;
        y = next_y;
    }
}

/* The state at rest at the equilibrium for μ = 0 (Eq. 6 of the paper). It is infinite if F < 0
   lifts the slider off the belt and no spring holds it. */
INLINE void resting_state(const double *p, int separation, double *state)
{
    const double load = load_of(p), stiffness = suspension_stiffness(p);
    double y = INFINITE;
    if (!separation || load >= 0.0)
        y = resting_height(rest_cubic(p, 0.0), rest_linear(p, 0.0), load);
    else if (stiffness > 0.0)
        y = -load / stiffness;
    state[S_X] = rest_position(p, y, 0.0), state[S_VX] = 0.0;
    state[S_Y] = y, state[S_VY] = 0.0;
}

#endif
