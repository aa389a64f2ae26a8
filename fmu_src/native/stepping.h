/* The motion, computed in Taylor steps, under inputs that may change at communication points.

   A Taylor step covers many communication steps. It is used until its end or a change of inputs, so
   the motion has the bits of `fivtui.simulate`, whatever the communication points. */

#ifndef FIVTUI_FMU_STEPPING_H
#define FIVTUI_FMU_STEPPING_H

#define LANES 1
#define FINITE 1
#include "driven.h"

/* Hidden: other libraries of the process may have functions of the same names. */
#pragma GCC visibility push(hidden)

/* `w` is at the start of the step that ends at `end`, whose rounding error is `end_remainder`.
   `has_step`: `w` has the polynomials of the step and the state at its end. `cut` says which guard
   ends the step; after a hold the mode is `next_mode`. Input ramps begin at `ramp_start`. A failed
   move stopped at `failed_at`, with the largest coordinate `failed_size`. A copy is a full state.

   To restore a saved motion: call `begin` with `p` and the state at the start of the step, write
   back the saved numbers of `w`, slopes, `ramp_start`, `belt.mode` and counts, call `recompute`. */
typedef struct {
    Block w;
    Belt belt;
    double has_step, cut, next_mode, end, end_remainder;
    double tol, order, cubic, separation, ramp_start, failed_at, failed_size;
    /* On a belt of finite speed: numbers of changes to stick, from stick, and between forward and
       backward slip; number of all changes of the mode, and time of the last. Further counts are
       w.separations and w.reattachments. */
    double sticks, slips, reversals, changes, last_change;
    Ramp force, friction, speed;
    double p[BELT_PARAMETERS];
} Motion;

/* The mode of the step, as in `fivtui.model.modes`: 0 or 1 on a belt that is always faster, else
   0, 2, 3 or 4. */
INLINE int motion_mode(const Motion *m)
{
    return m->belt.finite ? (int)m->belt.mode : m->w.side < 0.0 ? CONTACT : SEPARATED;
}

/* Whether an input changes over the step; the motion must begin anew where the ramps end. */
INLINE int has_ramps(const Motion *m)
{
    return m->force.slope != 0.0 || m->friction.slope != 0.0 || m->speed.slope != 0.0;
}

/* The motion's functions, compiled for one instruction set. */
typedef struct {
    /* Begins the motion at t. On a belt of finite speed (`finite_belt`) p has BELT_PARAMETERS
       columns: P_MU_S is negative if static friction equals μ (else μ must not exceed it), P_V_S is
       0 if friction does not depend on the speed. On other belts p has PARAMETERS columns. */
    void (*begin)(Motion *m, const double *p, int separation, int finite_belt, const double *state,
                  double t, double tol);
    /* Advances to t under inputs that apply from `from` on; with `switched`, to the first switch up
       to t, and reports whether there is one. `speed` is ignored on a belt that is always faster.
       Returns RUNNING, or the status of a failure. */
    int (*move)(Motion *m, double from, double *t, int *switched, Ramp force, Ramp friction,
                Ramp speed);
    void (*state)(const Motion *m, double t, double *state);
    /* Computes the step again from its start, because saved states contain no polynomials. */
    int (*recompute)(Motion *m);
} Stepping;

extern const Stepping stepping_baseline, stepping_avx2;

/* Returns the stepping for this processor. */
const Stepping *choose_stepping(void);

#pragma GCC visibility pop

#endif
