/* The motion under inputs that may change at communication points, a Taylor step at a time.

   A Taylor step covers many communication steps. It is kept until it is used up or an input
   changes, so the motion has the bits of `fivtui.simulate`, whatever the communication points. */

#ifndef FIVTUI_FMU_STEPPING_H
#define FIVTUI_FMU_STEPPING_H

#define LANES 1
#define FINITE 1
#include "driven.h"

/* Not to be taken for functions of the same name elsewhere in the process. */
#pragma GCC visibility push(hidden)

/* `w` is at the start of the step that ends at `end` (which lacks `end_rest` of the exact time),
   with the state at its end and its polynomials, if there is one (`stepped`); it is `cut` by a guard,
   and at the end of its hold mode `then` follows. The inputs are ramps that begin at `since`; a move
   that failed came as far as `failed_at`, where no coordinate of its state exceeds `failed_size`.
   Numbers alone: a copy is a state.

   A saved motion is `begin` with the `p` and the state at the start of the step, with what of `w`,
   the ramps' slopes, `since`, `belt.mode` and the counts are written back, then `again`. */
typedef struct {
    Block w;
    Belt belt;
    double stepped, cut, then, end, end_rest;
    double tol, order, cubic, separation, since, failed_at, failed_size;
    /* On a belt of finite speed: how often the slider began to stick, ceased to stick, and changed
       between forward and backward slip; changes of its mode in all, and the last one's time. Beside
       w.separations, w.reattachments. */
    double sticks, slips, reversals, changes, changed_at;
    Ramp force, friction, speed;
    double p[BELT_PARAMETERS];
} Motion;

/* The mode of the step, as in `fivtui.model.modes`: 0 or 1 on a belt that is always faster, else
   0, 2, 3 or 4. */
INLINE int mode_of_motion(const Motion *m)
{
    return m->belt.finite ? (int)m->belt.mode : m->w.side < 0.0 ? CONTACT : SEPARATED;
}

/* Whether an input changes over the step: then the motion is another one where the ramps end. */
INLINE int is_driven(const Motion *m)
{
    return m->force.slope != 0.0 || m->friction.slope != 0.0 || m->speed.slope != 0.0;
}

/* The motion's functions, compiled for one instruction set. */
typedef struct {
    /* Begins at t. On a belt of finite speed (`finite_belt`) p has BELT_PARAMETERS columns, with a
       negative P_MU_S where static friction follows μ (else μ must not exceed it) and P_V_S 0 where
       friction does not depend on the speed; else PARAMETERS columns. */
    void (*begin)(Motion *m, const double *p, int separation, int finite_belt, const double *state,
                  double t, double tol);
    /* Moves on to t under inputs that are given from the last t on; with `switched`, to the first
       switch not after t, and says whether there is one. Where the belt is always faster `speed` is
       not read. Returns the status, RUNNING if well. */
    int (*move)(Motion *m, double from, double *t, int *switched, Ramp force, Ramp friction,
                Ramp speed);
    void (*state)(const Motion *m, double t, double *state);
    /* Computes the step again from where it starts: its polynomials are not saved. */
    int (*again)(Motion *m);
} Stepping;

extern const Stepping stepping_baseline, stepping_avx2;

/* The stepping for this processor. */
const Stepping *stepping(void);

#pragma GCC visibility pop

#endif
