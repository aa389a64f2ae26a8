/* What a run of its own gives out: samples and segments. LANES is 1. */

#ifndef FIVTUI_OUTPUT_H
#define FIVTUI_OUTPUT_H

#include "motion.h"

/* Columns of a segment: start, what it lacks of the exact start, duration, end, mode, and
   coefficients of x and of y in θ = time/duration. */
#define SEGMENT_HEAD 5

/* x, ẋ, y, ẏ at a time, in columns of `count`. */
APART void store_sample(const Block *w, int groups, double t, double *samples, int64_t count)
{
    double part = (t - w->t) - w->rest;
    Tangent x = tangent_at(w->xs, groups, part), y = tangent_at(w->ys, groups, part);
    samples[0] = x.value, samples[count] = x.slope;
    samples[2 * count] = y.value, samples[3 * count] = y.slope;
}

APART void store_segment(const Block *w, int groups, double end, int mode, double *row)
{
    int size = 4 * groups + 2;
    double power = 1.0;
    row[0] = w->t, row[1] = w->rest, row[2] = w->h, row[3] = end, row[4] = mode;
    for (int n = 0; n < size; n++) {
        row[SEGMENT_HEAD + n] = w->xs[n] * power;
        row[SEGMENT_HEAD + size + n] = w->ys[n] * power;
        power *= w->h;
    }
}

#endif
