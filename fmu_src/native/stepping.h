/* The motion under inputs that may change at communication points, a Taylor step at a time.

   A Taylor step covers many communication steps. It is kept until it is used up or an input
   changes, so the motion has the bits of `fivtui.simulate`, whatever the communication points. */

#ifndef FIVTUI_FMU_STEPPING_H
#define FIVTUI_FMU_STEPPING_H

#define LANES 1
#include "problem.h"

/* Not to be taken for functions of the same name elsewhere in the process. */
#pragma GCC visibility push(hidden)

/* An input over a communication step: value at its beginning, and slope. */
typedef struct {
    double value, slope;
} Ramp;

/* `w` is at the start of the step that ends at `end` (which lacks `end_rest` of the exact time),
   with the state at its end and its polynomials, if there is one (`stepped`). The ramps begin at
   `since`; a move that failed came as far as `failed_at`. Numbers alone: a copy is a state. */
typedef struct {
    Block w;
    double stepped, cut, end, end_rest;
    double tol, order, cubic, separation, since, failed_at;
    Ramp force, friction;
    double p[PARAMETERS];
} Motion;

/* The motion's functions, compiled for one instruction set. */
typedef struct {
    void (*begin)(Motion *m, const double *p, int separation, const double *state, double t,
                  double tol);
    /* Moves on to t under inputs that are given from the last t on; with `switched`, to the first
       switch not after t, and says whether there is one. Returns the status, RUNNING if well. */
    int (*move)(Motion *m, double from, double *t, int *switched, Ramp force, Ramp friction);
    void (*state)(const Motion *m, double t, double *state);
    /* Computes the step again from where it starts: its polynomials are not saved. */
    int (*again)(Motion *m);
} Stepping;

extern const Stepping stepping_baseline, stepping_avx2;

/* The stepping for this processor. */
const Stepping *stepping(void);

#pragma GCC visibility pop

#endif
