/* Functions of `vary.c` for other sources, and the columns that they write. */

#ifndef FIVTUI_VARY_H
#define FIVTUI_VARY_H

#include "problem.h"
#include "variant.h"

/* Columns of a call after those of a result: number of crossings in the buffer, ẍ and ÿ. */
enum { R_CROSSINGS = RESULTS, R_AX, R_AY, VARY_RESULTS };

/* Columns of a crossing, which is a switch: time, state, mode after it, and the deviations
   there. */
enum { C_T, C_X, C_VX, C_Y, C_VY, C_MODE, CROSSING_HEAD };

/* Begin a run, as `run_begin`, with `count` derivatives, at most MAX_DEVIATIONS. A row of `seeds`
   has the derivatives of (x, ẋ, y, ẏ) at the start and of the parameters by one number. */
EXPORT void LIBRARY_NAME(vary_begin)(void *memory, const double *parameters, int64_t separation,
                                     const double *start, const double *seeds, int64_t count,
                                     double t_end, double tol, int64_t order);

/* Sample the run at `count` ascending times before its first step. A row of `samples` has (x, ẋ, y,
   ẏ) and their derivatives by each seed; rows of times after the last step are not written. */
EXPORT void LIBRARY_NAME(vary_sample)(void *memory, const double *times, int64_t count,
                                      double *samples);

/* Continue until the run has ended, `crossings` is full or after `budget` steps.

   A crossing is a row of CROSSING_HEAD columns and the deviations there. `result` receives
   VARY_RESULTS columns, `deviations` a row of derivatives of (x, ẋ, y, ẏ) for each seed, `extremes`
   the time of each extreme and its derivative by each seed. Returns the status. */
EXPORT int64_t LIBRARY_NAME(vary_advance)(void *memory, double *crossings, int64_t max_crossings,
                                          int64_t budget, double *result, double *deviations,
                                          double *extremes);

#endif
