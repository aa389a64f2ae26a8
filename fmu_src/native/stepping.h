/* The motion, computed in Taylor steps, under inputs that may change at communication points.

   A Taylor step covers many communication steps. It is used until its end or a change of inputs. So
   the motion equals that of `fivtui.simulate` to the last bit, whatever the communication points.

   The kernel, in `fivtui/kernel`, computes the steps. Its `driven.h` has the motion under
   parameters that change linearly with time. */

#ifndef FIVTUI_FMU_STEPPING_H
#define FIVTUI_FMU_STEPPING_H

/* The kernel's functions for one run, also for belts of finite speed. */
#define LANES 1
#define FINITE_BELT 1
#include "driven.h"

/* Hidden: other libraries of the process may have functions of the same names. */
#pragma GCC visibility push(hidden)

/* A block of the kernel has one lane here, for one run. */
#define ONLY_LANE 0

/* Greatest |x| and |y|, m, greatest ẋ, m/s, range of the contact force, N, and time off the belt, s,
   over a part of the motion. */
typedef struct {
    double x_peak, y_peak, vx_max, P_min, P_max, separated_time;
} Totals;

/* Extend totals by those of another part of the motion. */
INLINE void extend_totals(Totals *totals, const Totals *part)
{
    totals->x_peak = maximum(totals->x_peak, part->x_peak);
    totals->y_peak = maximum(totals->y_peak, part->y_peak);
    totals->vx_max = maximum(totals->vx_max, part->vx_max);
    totals->P_min = minimum(totals->P_min, part->P_min);
    totals->P_max = maximum(totals->P_max, part->P_max);
    totals->separated_time += part->separated_time;
}

/* Parameters and inputs from a time on: values in the kernel's order, and slopes of the inputs. On a
   belt of finite speed P_MU_S is negative if static friction equals μ (else μ must not exceed it),
   and P_V_S is 0 if friction does not depend on the speed; on other belts P_V_BELT is constant. */
typedef struct {
    double p[BELT_PARAMETERS];
    Rates rates;
} Inputs;

/* The motion and its current Taylor step; a copy is a complete state. Flags and counts are doubles:
   a saved state consists of doubles.

   To restore a saved motion: call `begin` with `inputs` and the state at the start of the step,
   write back the saved numbers of `w`, `input_start`, `belt.mode`, counts and `past`, call
   `recompute`. */
typedef struct {
    /* The kernel's state of the run at the start of the step, and the polynomials of the step. */
    Block w;
    Belt belt;
    /* Whether `w` has the polynomials of the step and the state at its end. */
    double has_step;
    /* What ends the step, a `StepCut`: the zero of a guard, a function that is positive while a
       mode lasts, or none. The mode after the step, if it ends stick. */
    double cut, next_mode;
    /* Time at the end of the step, s: rounded, and exact time less rounded time. */
    double end, end_remainder;
    /* Tolerance of a step, order of its polynomials; whether k_nl and separation apply. */
    double tol, order, cubic, separation;
    /* Inputs from the time `input_start` on, s. */
    Inputs inputs;
    double input_start;
    /* Where the last advance failed: time, s, and largest coordinate of the state. */
    double failed_at, failed_size;
    /* On a belt of finite speed: numbers of switches to stick, from stick, and between forward and
       backward slip; number of all switches, and time of the last. Further counts are w.separations
       and w.reattachments: on other belts they are those of all switches. */
    double sticks, slips, reversals, belt_switches, last_belt_switch;
    /* Totals until the inputs last changed; `w` has the extremes since then. */
    Totals past;
} Motion;

/* The mode of the step, as in `fivtui.model.modes`: CONTACT or SEPARATED on a belt that is always
   faster than the slider, else FORWARD, BACKWARD, STICK or SEPARATED. */
INLINE int motion_mode(const Motion *m)
{
    return m->belt.finite ? (int)m->belt.mode : m->w.side < 0.0 ? CONTACT : SEPARATED;
}

/* Whether an input changes over the step; the motion must begin anew where the ramps end. */
INLINE int has_ramps(const Motion *m)
{
    const Rates *rates = &m->inputs.rates;
    return rates->F != 0.0 || rates->mu != 0.0 || rates->v_belt != 0.0;
}

/* The motion's functions, compiled for one instruction set. */
typedef struct {
    /* Begins the motion at t, on a belt of finite speed or one that is always faster. */
    void (*begin)(Motion *m, const Inputs *inputs, int separation, int finite_belt,
                  const double *state, double t, double tol);
    /* Advances to t under inputs that apply from `from` on; with `switched`, to the first switch up
       to t, and reports whether there is one. Returns RUNNING, or the status of a failure. */
    int (*advance)(Motion *m, double from, double *t, int *switched, const Inputs *inputs);
    /* Begins the motion anew at t under inputs and expands it there; returns a status as above. */
    int (*expand)(Motion *m, double t, const Inputs *inputs);
    /* Evaluates the state at a time within the step. */
    void (*state)(const Motion *m, double t, double *state);
    /* Computes the totals from the beginning of the motion to a time within the step. */
    void (*totals)(const Motion *m, double t, Totals *totals);
    /* Computes the step again from its start, because saved states contain no polynomials. */
    int (*recompute)(Motion *m);
} Stepping;

extern const Stepping stepping_baseline, stepping_avx2;

/* Returns the stepping for this processor. */
const Stepping *choose_stepping(void);

#pragma GCC visibility pop

#endif
