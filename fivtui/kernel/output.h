/* Output of a single run: samples and segments. LANES is 1. */

#ifndef FIVTUI_OUTPUT_H
#define FIVTUI_OUTPUT_H

#include "motion.h"

/* Columns of a segment: start, its remainder (exact start less start), duration, end, mode, and
   coefficients of x and of y in θ = time/duration. */
#define SEGMENT_HEAD 5

/* Store x, ẋ, y, ẏ at a time in columns of `count`. */
NOINLINE void store_sample(const Block *w, int groups, double t, double *samples, int64_t count)
{
    double elapsed = (t - w->t) - w->remainder;
    Tangent x = tangent_at(w->xs, groups, elapsed), y = tangent_at(w->ys, groups, elapsed);
    samples[0] = x.value, samples[count] = x.slope;
    samples[2 * count] = y.value, samples[3 * count] = y.slope;
}

NOINLINE void store_segment(const Block *w, int groups, double end, int mode, double *row)
{
    int size = 4 * groups + 2;
    double power = 1.0;
    row[0] = w->t, row[1] = w->remainder, row[2] = w->h, row[3] = end, row[4] = mode;
    for (int n = 0; n < size; n++) {
        row[SEGMENT_HEAD + n] = w->xs[n] * power;
        row[SEGMENT_HEAD + size + n] = w->ys[n] * power;
        power *= w->h;
    }
}

#endif
