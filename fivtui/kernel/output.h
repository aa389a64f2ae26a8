/* Output of a single run: samples and segments. LANES is 1. `groups` is the order of expansion
   divided by 4 (`polynomial.h`). */

#ifndef FIVTUI_OUTPUT_H
#define FIVTUI_OUTPUT_H

#include "motion.h"

/* Columns of a segment, which is the motion over one step: start, its remainder (exact start less
   start), duration, end, mode, and coefficients of x and of y in θ = time/duration. */
enum { G_START, G_REMAINDER, G_DURATION, G_END, G_MODE, SEGMENT_HEAD };

/* Store the state (x, ẋ, y, ẏ) at a time t in the step, each in a column of `count` numbers. */
NOINLINE void store_sample(const Block *w, int groups, double t, double *samples, int64_t count)
{
    double elapsed = (t - w->t) - w->remainder;
    Tangent x = tangent_at(w->xs, groups, elapsed), y = tangent_at(w->ys, groups, elapsed);
    samples[S_X * count] = x.value, samples[S_VX * count] = x.slope;
    samples[S_Y * count] = y.value, samples[S_VY * count] = y.slope;
}

/* Store the segment of the step, which ends at the time `end`. */
NOINLINE void store_segment(const Block *w, int groups, double end, int mode, double *row)
{
    int size = 4 * groups + 2;
    double power = 1.0;
    row[G_START] = w->t, row[G_REMAINDER] = w->remainder, row[G_DURATION] = w->h;
    row[G_END] = end, row[G_MODE] = mode;
    for (int n = 0; n < size; n++) {
        row[SEGMENT_HEAD + n] = w->xs[n] * power;
        row[SEGMENT_HEAD + size + n] = w->ys[n] * power;
        power *= w->h;
    }
}

#endif
