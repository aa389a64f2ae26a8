/* First switches and extreme values of steps, exact to rounding.

   A switch is a root of y, or of another guard (`belt.h`). Bounds over a step (`Ends` in
   `polynomial.h`) decide most steps. Halley's and Newton's method are used where there is exactly
   one root or extremum; the few other steps are searched one by one by `roots.h`. `lanes` are bits:
   bit n stands for the run in lane n. */

#ifndef FIVTUI_SEARCH_H
#define FIVTUI_SEARCH_H

#include "motion.h"
#include "roots.h"

#define MAX_ITERATIONS 100
/* A step of Halley's method shorter than half of Newton's is rejected unless it changes the root by
   more than this, relative to the root. */
#define MIN_HALLEY_CHANGE 1e-6
/* Changes of a root below this fraction of the one before are taken to shrink cubically. */
#define CUBIC_CONVERGENCE 1e-3
/* Tolerance of the time of an extremum, relative to the step. */
#define EXTREMUM_TOLERANCE 4e-6

/* Set `scaled` to the coefficients of one lane in θ = t/h, filled up with zeros. */
INLINE void scale_polynomial(const V *c, int groups, int lane, double h, double *scaled)
{
    double power = 1.0;
    for (int n = 0; n < TERMS_OF(groups); n++) {
        scaled[n] = n < 4 * groups + 2 ? get_lane(c + n, lane) * power : 0.0;
        power *= h;
    }
}

/* Set the coefficients of ẋ from those of x. */
INLINE void set_velocity(const V *x, int groups, V *velocity)
{
    for (int n = 0; n <= 4 * groups; n++)
        velocity[n] = x[n + 1] * (n + 1.0);
}

/* The only root in (0, h] of y, or `from_zero` of y/t: Halley's method with a bracket. `side` is
   the sign before the root, `guess` is in θ = t/h. */
INLINE V refine_first_root(const V *y, int groups, V h, V side, M from_zero, V guess,
                           unsigned lanes)
{
    V left = splat(0.0), right = h, last_change = splat(0.0), t = guess * h;
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        Curve curve = curve_at(y, groups, t);
        M before_root = side * curve.value > 0.0;
        left = choose(before_root, t, left), right = choose(before_root, right, t);
        /* For y/t the value, slope and half the second derivative below are those of y/t times t,
           t² and t³; so `step` is the step over t. */
        V divided_slope = curve.slope * t - curve.value;
        V slope = choose(from_zero, divided_slope, curve.slope);
        V half_d2 = choose(from_zero, curve.half_d2 * (t * t) - divided_slope, curve.half_d2);
        V step = curve.value * slope / (slope * slope - curve.value * half_d2);
        V new = t - choose(from_zero, t, splat(1.0)) * step;
        V change = vabs(new - t);
        /* Halley's step vanishes with the slope at an extremum, too, where there is no root. So
           test that it is at least half of Newton's, value/slope. */
        M is_near = vabs(curve.value) <= vabs(step * slope) * 2.0;
        M is_inside = (new > left) & (new < right) & (is_near | (change > t * MIN_HALLEY_CHANGE));
        M converged = is_near & (change <= t * ROOT_TOLERANCE);
        /* Changes shrink cubically: the next one is about change (change/last)². */
        M negligible = change * change * change <= last_change * last_change * (t * ROOT_TOLERANCE);
        M is_root = converged | (is_near & is_inside & (change < last_change * CUBIC_CONVERGENCE)
                                 & negligible);
        V middle = (left + right) * 0.5;
        M is_halved = mask_not(is_inside | converged);
        M is_stuck = (curve.value == 0.0) | (is_halved & ((middle <= left) | (middle >= right)));
        V next_t = choose(is_root, vmin(vmax(new, left), right), choose(is_inside, new, middle));
        t = choose(mask_from_bits(lanes) & mask_not(is_stuck), next_t, t);
        last_change = choose(is_inside, change, splat(0.0));
        lanes &= ~mask_bits(is_root | is_stuck);
        if (!lanes)
            break;
    }
    return t;
}

/* Time of the first switch of one run by isolation of roots; negative without one. */
NOINLINE double isolate_switch(const V *y, int groups, int lane, double h, double side)
{
    double scaled[MAX_TERMS], root, final = 0.0;
    const int terms = TERMS_OF(groups);
    scale_polynomial(y, groups, lane, h, scaled);
    for (int n = 0; n < terms; n++)
        final += scaled[n];
    if (find_roots(scaled, terms, 1, &root) > 0)
        return root * h;
    /* Rounding moved the root out of the step: use the end of the step. */
    return side * final <= 0.0 ? h : -1.0;
}

/* Shorten the steps in `lanes` to their first switches. `end_y` and `end_vy` are y and ẏ at the
   ends of the steps of length h, `error` bounds the distance of y from its cubic. Returns the lanes
   with a switch. */
INLINE unsigned find_first_switch(const V *y, int groups, V side, V *h, V end_y, V end_vy, V error,
                                  unsigned lanes)
{
    V start_slope = y[1] * *h, end_slope = end_vy * *h;
    /* After a switch these are the ends of y/θ. The bounds of y suffice: the terms of y/θ have one
       degree less, and the bound of a term grows with its degree (`tables.h`). */
    M from_zero = y[0] == 0.0;
    Ends ends;
    ends.start = choose(from_zero, start_slope, y[0]);
    ends.end = end_y;
    ends.start_slope = choose(from_zero, y[2] * (*h * *h), start_slope);
    ends.end_slope = choose(from_zero, end_slope - end_y, end_slope);
    ends.error = error;
    ends.slope_error = weighted_bound(CUBIC_SLOPE_BOUND, y, groups, *h);
    V change = end_y - ends.start;
    M starts_on_side = side * ends.start > 0.0;
    M crosses = starts_on_side & (side * end_y < 0.0),
        returns = starts_on_side & (side * end_y > 0.0);
    M monotone = is_monotone(&ends);
    Range range = value_range(&ends);
    M has_no_root = returns & (monotone | (choose(side > 0.0, range.low, -range.high) > 0.0));
    unsigned single_root = lanes & mask_bits(crosses & monotone);
    unsigned undecided = lanes & ~single_root & ~mask_bits(has_no_root);
    if (undecided) {
        /* A convex or concave curve lies between its chord and the tangents at its ends. It stays
           on its side if it moves away from zero at first, if these tangents meet on that side, or
           if its slope keeps its sign. */
        M is_convex_or_concave = has_monotone_slope(&ends, y, groups, *h);
        V tangents_meet = ends.start + ends.start_slope
            * ((change - ends.end_slope) / (ends.start_slope - ends.end_slope));
        M stays_on_side = (side * ends.start_slope > 0.0) | (side * tangents_meet > 0.0)
                          | mask_not((ends.start_slope > 0.0) ^ (ends.end_slope > 0.0));
        single_root |= undecided & mask_bits(crosses & is_convex_or_concave);
        undecided &= ~single_root & ~mask_bits(returns & is_convex_or_concave & stays_on_side);
    }
    unsigned switching = single_root;
    if (single_root) {
        /* Guess by Hermite interpolation of θ as a function of y; the chord's root if it fails. */
        V chord_root = -ends.start / change, remainder = 1.0 - chord_root;
        V slopes = remainder / ends.start_slope - chord_root / ends.end_slope;
        V guess = chord_root * chord_root * (3.0 - chord_root * 2.0)
            + change * chord_root * remainder * slopes;
        guess = choose((guess > 0.0) & (guess < 1.0), guess, chord_root);
        V root = refine_first_root(y, groups, *h, side, from_zero, guess, single_root);
        *h = choose(mask_from_bits(single_root), root, *h);
    }
    while (undecided) {
        int lane = __builtin_ctz(undecided);
        undecided &= undecided - 1;
        double root = isolate_switch(y, groups, lane, get_lane(h, lane), get_lane(&side, lane));
        if (root >= 0.0) {
            set_lane(h, lane, root);
            switching |= 1u << lane;
        }
    }
    return switching;
}

/* The value at the only zero of the slope, whose sign is `sign` before it: Newton's method with a
   bracket. `guess` is in θ = t/h. */
INLINE V extremum_value(const V *c, int groups, V h, V guess, V sign, unsigned lanes)
{
    V left = splat(0.0), right = h, t = guess * h, result = splat(0.0);
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        Curve curve = curve_at(c, groups, t);
        M before_extremum = curve.slope * sign > 0.0;
        left = choose(before_extremum, t, left), right = choose(before_extremum, right, t);
        V change = -curve.slope / (curve.half_d2 * 2.0), new = t + change;
        M is_inside = (new > left) & (new < right);
        V middle = (left + right) * 0.5;
        M is_flat = curve.slope == 0.0;
        M is_stuck = mask_not(is_inside) & ((middle <= left) | (middle >= right));
        M converged = vabs(change) <= h * EXTREMUM_TOLERANCE;
        V value = choose(converged & mask_not(is_flat), curve.value + curve.slope * change * 0.5,
                         curve.value);
        result = choose(mask_from_bits(lanes), value, result);
        t = choose(is_inside, new, middle);
        lanes &= ~mask_bits(is_flat | converged | is_stuck);
        if (!lanes)
            break;
    }
    return result;
}

/* Zero in θ of the slope of the cubic value + slope θ + square θ² + cube θ³, whose slopes at both
   ends differ in sign; outside (0, 1) if rounding hides it. `sign` is that of the slope at θ =
   0. */
INLINE V cubic_extremum(V slope, V square, V cube, V sign)
{
    /* Scale small numbers up: their squares would underflow. */
    V size = vmax(vabs(slope), vmax(vabs(square), vabs(cube)));
    V scale = choose(size < 0x1p-400, splat(0x1p600), splat(1.0));
    slope = slope * scale, square = square * scale, cube = cube * scale;
    V root = vsqrt(vmax(square * square - cube * slope * 3.0, splat(0.0)));
    /* θ = −(square + sign root)/(3 cube) = sign slope/(root − sign square), where sign slope is
       |slope|. Use the form that adds numbers of equal sign: no digits cancel. */
    M adds_in_first = square * sign > 0.0;
    V numerator = choose(adds_in_first, -(square + sign * root), vabs(slope));
    V denominator = choose(adds_in_first, cube * 3.0, root - square * sign);
    return numerator / denominator;
}

/* A search for extreme values of polynomials on [0, h]: the ranges of values so far over the full
   run and over its second half, and the lanes in which the inside of the step may extend each. */
typedef struct {
    V h;
    Ends ends;
    Range full, second_half;
    unsigned full_lanes, second_half_lanes;
} ExtremaSearch;

INLINE M exceeds(Range a, Range b) { return (a.low < b.low) | (a.high > b.high); }

/* Extend the ranges of some lanes by two values. */
INLINE void widen_range(Range *range, V low, V high, unsigned lanes)
{
    M mask = mask_from_bits(lanes);
    range->low = choose(mask, vmin(low, range->low), range->low);
    range->high = choose(mask, vmax(high, range->high), range->high);
}

/* Extend the ranges by the extreme values inside the step. */
INLINE void find_extrema(const V *c, int groups, ExtremaSearch *search)
{
    Ends *ends = &search->ends;
    ends->slope_error = weighted_bound(CUBIC_SLOPE_BOUND, c, groups, search->h);
    unsigned not_monotone = ~mask_bits(is_monotone(ends));
    search->full_lanes &= not_monotone, search->second_half_lanes &= not_monotone;
    if (!(search->full_lanes | search->second_half_lanes))
        return;
    V change = ends->end - ends->start;
    V cube = ends->start_slope + ends->end_slope - change * 2.0;
    V square = change * 3.0 - ends->start_slope * 2.0 - ends->end_slope;
    M changes_sign = (ends->start_slope > 0.0) ^ (ends->end_slope > 0.0);
    V sign = choose(ends->start_slope > 0.0, splat(1.0), splat(-1.0));
    V theta = cubic_extremum(ends->start_slope, square, cube, sign);
    M has_cubic_extremum = changes_sign & (theta > 0.0) & (theta < 1.0);
    theta = choose(has_cubic_extremum, theta, splat(0.5));
    V value = ends->start + theta * (ends->start_slope + theta * (square + theta * cube));
    /* The extremum of the polynomial is that of the cubic within the error. */
    Range bounds = {value - ends->error, value + ends->error};
    search->full_lanes &= ~mask_bits(has_cubic_extremum & mask_not(exceeds(bounds, search->full)));
    search->second_half_lanes &=
        ~mask_bits(has_cubic_extremum & mask_not(exceeds(bounds, search->second_half)));
    unsigned lanes = search->full_lanes | search->second_half_lanes;
    if (!lanes)
        return;
    unsigned single_extremum = lanes
        & mask_bits(changes_sign & has_monotone_slope(ends, c, groups, search->h));
    if (single_extremum) {
        value = extremum_value(c, groups, search->h, theta, sign, single_extremum);
        widen_range(&search->full, value, value, search->full_lanes & single_extremum);
        widen_range(&search->second_half, value, value,
                    search->second_half_lanes & single_extremum);
    }
    for (unsigned remaining = lanes & ~single_extremum; remaining; remaining &= remaining - 1) {
        int lane = __builtin_ctz(remaining);
        double scaled[MAX_TERMS], low = INFINITE, high = -INFINITE;
        scale_polynomial(c, groups, lane, get_lane(&search->h, lane), scaled);
        include_extrema(scaled, TERMS_OF(groups), &low, &high);
        unsigned lane_bit = 1u << lane;
        widen_range(&search->full, splat(low), splat(high), search->full_lanes & lane_bit);
        widen_range(&search->second_half, splat(low), splat(high),
                    search->second_half_lanes & lane_bit);
    }
}

/* The range that no value exceeds: that of a search that is not needed. */
#define UNLIMITED ((Range){splat(-INFINITE), splat(INFINITE)})

/* Bounds of x and of y over the step of a block. The last number is a placeholder: `find_extrema`
   sets `slope_error` before it is used. */
INLINE Ends ends_of_x(const Block *w)
{
    return (Ends){w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_error, w->x_error};
}
INLINE Ends ends_of_y(const Block *w)
{
    return (Ends){w->ys[0], w->y, w->ys[1] * w->h, w->vy * w->h, w->y_error, w->y_error};
}

/* Extend the extremes of `lanes` by the ends of the step; returns the search for those inside
   it. */
INLINE ExtremaSearch search_in_x(Block *w, unsigned lanes)
{
    ExtremaSearch search = {.h = w->h, .ends = ends_of_x(w),
                            .full = {w->extremes.x_low, w->extremes.x_high},
                            .second_half = UNLIMITED};
    widen_range(&search.full, vmin(w->xs[0], w->x), vmax(w->xs[0], w->x), lanes);
    w->extremes.x_low = search.full.low, w->extremes.x_high = search.full.high;
    search.full_lanes = lanes & mask_bits(exceeds(value_range(&search.ends), search.full));
    return search;
}

INLINE ExtremaSearch search_in_y(Block *w, unsigned full_lanes, unsigned second_half_lanes)
{
    ExtremaSearch search = {.h = w->h, .ends = ends_of_y(w),
                            .full = {w->extremes.y_low, w->extremes.y_high},
                            .second_half = {w->extremes.second_half_low,
                                            w->extremes.second_half_high}};
    V low = vmin(w->ys[0], w->y), high = vmax(w->ys[0], w->y);
    widen_range(&search.full, low, high, full_lanes);
    widen_range(&search.second_half, low, high, second_half_lanes);
    w->extremes.y_low = search.full.low, w->extremes.y_high = search.full.high;
    w->extremes.second_half_low = search.second_half.low;
    w->extremes.second_half_high = search.second_half.high;
    Range range = value_range(&search.ends);
    search.full_lanes = full_lanes & mask_bits(exceeds(range, search.full));
    search.second_half_lanes = second_half_lanes & mask_bits(exceeds(range, search.second_half));
    return search;
}

/* Lanes whose ẋ may exceed its greatest value so far within the step. The greatest ẋ of the step is
   at one of its ends, or at most `limit`. */
INLINE unsigned may_exceed_max_vx(Block *w, int groups, V limit, unsigned lanes)
{
    w->extremes.vx_high = choose(mask_from_bits(lanes),
                                 vmax(vmax(w->xs[1], w->vx), w->extremes.vx_high),
                                 w->extremes.vx_high);
    lanes &= mask_bits(w->extremes.vx_high < limit);
    if (!lanes)
        return 0;
    Ends ends = ends_of_x(w);
    V max_slope = vmax(vmax(ends.start_slope, ends.end_slope), middle_slope(&ends));
    V error = weighted_bound(CUBIC_SLOPE_BOUND, w->xs, groups, w->h);
    return lanes & mask_bits(max_slope + error > w->extremes.vx_high * w->h);
}

/* Values, slopes and error bounds of a polynomial on [0, h]. */
INLINE Ends ends_of(const V *c, int groups, V h)
{
    Tangent end = tangent_at(c, groups, h);
    V error = weighted_bound(CUBIC_BOUND, c, groups, h);
    return (Ends){c[0], end.value, c[1] * h, end.slope * h, error, error};
}

/* In steps that contain the start of the second half, search the part from there on for extremes of
   y. `split` is the time from the start of the step to the start of the second half. */
NOINLINE void observe_split_step(Block *w, int groups, V split, unsigned lanes)
{
    V y[SERIES_LENGTH];
    memcpy(y, w->ys, sizeof y);
    /* Taylor shift: coefficients in the time since `split`. */
    for (int start = 0; start < 4 * groups + 1; start++)
        for (int n = 4 * groups; n >= start; n--)
            y[n] = vfma(split, y[n + 1], y[n]);
    V h = choose(mask_from_bits(lanes), w->h - split, splat(1.0));
    ExtremaSearch search = {.h = h, .ends = ends_of(y, groups, h), .full = UNLIMITED,
                            .second_half = {w->extremes.second_half_low,
                                            w->extremes.second_half_high}};
    V start_y = search.ends.start, end_y = search.ends.end;
    widen_range(&search.second_half, vmin(start_y, end_y), vmax(start_y, end_y), lanes);
    search.second_half_lanes =
        lanes & mask_bits(exceeds(value_range(&search.ends), search.second_half));
    find_extrema(y, groups, &search);
    w->extremes.second_half_low = search.second_half.low;
    w->extremes.second_half_high = search.second_half.high;
}

/* Lanes whose steps start in the second half of the run, which begins at `half_time`. Steps that
   contain its start are searched here. */
INLINE unsigned select_second_half(Block *w, int groups, double half_time, unsigned lanes)
{
    M starts_before = w->t < half_time;
    M ends_after = w->t + (w->h + w->remainder) > half_time;
    unsigned split_lanes = lanes & mask_bits(starts_before & ends_after);
    if (split_lanes)
        observe_split_step(w, groups, vmin((half_time - w->t) - w->remainder, w->h), split_lanes);
    return lanes & ~mask_bits(starts_before);
}

#endif
