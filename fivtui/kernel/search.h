/* First switches and extreme values of steps, exact to rounding.

   Bounds decide most steps. Halley's and Newton's method are used where there is exactly one root
   or extremum; the few other steps are searched one by one by `roots.h`. */

#ifndef FIVTUI_SEARCH_H
#define FIVTUI_SEARCH_H

#include "motion.h"
#include "roots.h"

#define MAX_ITERATIONS 100
/* Relative change of a root below which a step that Newton's method would not make is rejected. */
#define MIN_HALLEY_CHANGE 1e-6
/* Tolerance of the time of an extremum, relative to the step. */
#define EXTREMUM_TOLERANCE 4e-6

/* Coefficients of one lane in θ = t/h. */
INLINE void scale_polynomial(const V *c, int groups, int lane, double h, double *p)
{
    double power = 1.0;
    for (int n = 0; n < ROWS_OF(groups); n++) {
        p[n] = n < 4 * groups + 2 ? get_lane(c + n, lane) * power : 0.0;
        power *= h;
    }
}

/* The only root of y, or of y/t after a switch, in (0, h]: Halley's method with a bracket. */
INLINE V refine_first_root(const V *y, int groups, V h, V side, M from_zero, V guess,
                           unsigned lanes)
{
    V left = splat(0.0), right = h, last_change = splat(0.0), t = guess * h;
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        Curve curve = curve_at(y, groups, t);
        M before_root = side * curve.value > 0.0;
        left = choose(before_root, t, left), right = choose(before_root, right, t);
        V divided_slope = curve.slope * t - curve.value;
        V slope = choose(from_zero, divided_slope, curve.slope);
        V half_d2 = choose(from_zero, curve.half_d2 * (t * t) - divided_slope, curve.half_d2);
        V step = curve.value * slope / (slope * slope - curve.value * half_d2);
        V new = t - choose(from_zero, t, splat(1.0)) * step;
        V change = vabs(new - t);
        /* Halley's method also stops at an extremum, where Newton's method would not. */
        M is_near = vabs(curve.value) <= vabs(step * slope) * 2.0;
        M is_inside = (new > left) & (new < right) & (is_near | (change > t * MIN_HALLEY_CHANGE));
        M converged = is_near & (change <= t * ROOT_TOLERANCE);
        /* Changes shrink cubically: the next one is about change (change/last)². */
        M negligible = change * change * change <= last_change * last_change * (t * ROOT_TOLERANCE);
        M is_root = converged | (is_near & is_inside & (change < last_change * 1e-3) & negligible);
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

/* The first switch of one run by isolation of roots; negative without one. */
NOINLINE double isolate_switch(const V *y, int groups, int lane, double h, double side)
{
    double p[ROWS], root, final = 0.0;
    const int rows = ROWS_OF(groups);
    scale_polynomial(y, groups, lane, h, p);
    for (int n = 0; n < rows; n++)
        final += p[n];
    if (find_roots(p, rows, 1, &root) > 0)
        return root * h;
    /* Rounding moved the root out of the step: use the end of the step. */
    return side * final <= 0.0 ? h : -1.0;
}

/* Shorten the steps in `lanes` to their first switches. `final` and `last_vy` are y and ẏ at the
   ends of the steps of length h, `error` bounds the distance of y from its cubic. Returns the lanes
   with a switch. */
INLINE unsigned find_first_switch(const V *y, int groups, V side, V *h, V final, V last_vy, V error,
                                  unsigned lanes)
{
    V start_slope = y[1] * *h, end_slope = last_vy * *h;
    /* After a switch these are the ends of y/θ, for which the bounds of y suffice. */
    M from_zero = y[0] == 0.0;
    Ends p;
    p.start = choose(from_zero, start_slope, y[0]);
    p.end = final;
    p.start_slope = choose(from_zero, y[2] * (*h * *h), start_slope);
    p.end_slope = choose(from_zero, end_slope - final, end_slope);
    p.error = error;
    p.slope_error = weighted_bound(CUBIC_SLOPE_BOUND, y, groups, *h);
    V change = final - p.start;
    M starts_inside = side * p.start > 0.0;
    M crossing = starts_inside & (side * final < 0.0),
        returning = starts_inside & (side * final > 0.0);
    M monotone = is_monotone(&p);
    Range range = value_range(&p);
    M has_none = returning & (monotone | (choose(side > 0.0, range.low, -range.high) > 0.0));
    unsigned one_root = lanes & mask_bits(crossing & monotone);
    unsigned open = lanes & ~one_root & ~mask_bits(has_none);
    if (open) {
        M has_one_bend = has_monotone_slope(&p, y, groups, *h);
        /* A convex or concave curve lies between its chord and the tangents at its ends. */
        V bound = p.start + p.start_slope
            * ((change - p.end_slope) / (p.start_slope - p.end_slope));
        M one_sided = (side * p.start_slope > 0.0) | (side * bound > 0.0)
                      | mask_not((p.start_slope > 0.0) ^ (p.end_slope > 0.0));
        one_root |= open & mask_bits(crossing & has_one_bend);
        open &= ~one_root & ~mask_bits(returning & has_one_bend & one_sided);
    }
    unsigned switching = one_root;
    if (one_root) {
        V part = -p.start / change, rest = 1.0 - part;
        V inverse = rest / p.start_slope - part / p.end_slope;
        V guess = part * part * (3.0 - part * 2.0) + change * part * rest * inverse;
        guess = choose((guess > 0.0) & (guess < 1.0), guess, part);
        V root = refine_first_root(y, groups, *h, side, from_zero, guess, one_root);
        *h = choose(mask_from_bits(one_root), root, *h);
    }
    while (open) {
        int lane = __builtin_ctz(open);
        open &= open - 1;
        double root = isolate_switch(y, groups, lane, get_lane(h, lane), get_lane(&side, lane));
        if (root >= 0.0) {
            set_lane(h, lane, root);
            switching |= 1u << lane;
        }
    }
    return switching;
}

/* The value at the only zero of the slope, whose sign is `sign` before it. */
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

/* Zero of the slope of the cubic whose slopes at both ends differ in sign; outside (0, 1) if
   rounding hides it. `square` and `cube` are the last coefficients of the cubic. */
INLINE V cubic_extremum(V slope, V square, V cube, V sign)
{
    /* Scale small numbers up: their squares would underflow. */
    V size = vmax(vabs(slope), vmax(vabs(square), vabs(cube)));
    V scale = choose(size < 0x1p-400, splat(0x1p600), splat(1.0));
    slope = slope * scale, square = square * scale, cube = cube * scale;
    V root = vsqrt(vmax(square * square - cube * slope * 3.0, splat(0.0)));
    /* Of two equal forms, use the one without cancellation. */
    M is_minimum = square * sign > 0.0;
    V numerator = choose(is_minimum, -(square + sign * root), vabs(slope));
    V denominator = choose(is_minimum, cube * 3.0, root - square * sign);
    return numerator / denominator;
}

/* A search for extreme values of polynomials on [0, h]: the ranges so far over the full run and its
   second half, which include both ends, and the lanes that may extend them. */
typedef struct {
    V h;
    Ends ends;
    Range full, late;
    unsigned full_lanes, late_lanes;
} ExtremaSearch;

INLINE M exceeds(Range a, Range b) { return (a.low < b.low) | (a.high > b.high); }

INLINE void widen_range(Range *range, V low, V high, unsigned lanes)
{
    M mask = mask_from_bits(lanes);
    range->low = choose(mask, vmin(low, range->low), range->low);
    range->high = choose(mask, vmax(high, range->high), range->high);
}

/* Extend the ranges by the extreme values. */
INLINE void find_extrema(const V *c, int groups, ExtremaSearch *q)
{
    Ends *p = &q->ends;
    p->slope_error = weighted_bound(CUBIC_SLOPE_BOUND, c, groups, q->h);
    unsigned open_lanes = ~mask_bits(is_monotone(p));
    q->full_lanes &= open_lanes, q->late_lanes &= open_lanes;
    if (!(q->full_lanes | q->late_lanes))
        return;
    V change = p->end - p->start;
    V cube = p->start_slope + p->end_slope - change * 2.0;
    V square = change * 3.0 - p->start_slope * 2.0 - p->end_slope;
    M changes_sign = (p->start_slope > 0.0) ^ (p->end_slope > 0.0);
    V sign = choose(p->start_slope > 0.0, splat(1.0), splat(-1.0));
    V theta = cubic_extremum(p->start_slope, square, cube, sign);
    M is_known = changes_sign & (theta > 0.0) & (theta < 1.0);
    theta = choose(is_known, theta, splat(0.5));
    V value = p->start + theta * (p->start_slope + theta * (square + theta * cube));
    Range crest_range = {value - p->error, value + p->error};
    q->full_lanes &= ~mask_bits(is_known & mask_not(exceeds(crest_range, q->full)));
    q->late_lanes &= ~mask_bits(is_known & mask_not(exceeds(crest_range, q->late)));
    unsigned lanes = q->full_lanes | q->late_lanes;
    if (!lanes)
        return;
    unsigned one_extremum = lanes
        & mask_bits(changes_sign & has_monotone_slope(p, c, groups, q->h));
    if (one_extremum) {
        value = extremum_value(c, groups, q->h, theta, sign, one_extremum);
        widen_range(&q->full, value, value, q->full_lanes & one_extremum);
        widen_range(&q->late, value, value, q->late_lanes & one_extremum);
    }
    for (unsigned remaining = lanes & ~one_extremum; remaining; remaining &= remaining - 1) {
        int lane = __builtin_ctz(remaining);
        double column[ROWS], low = INFINITE, high = -INFINITE;
        scale_polynomial(c, groups, lane, get_lane(&q->h, lane), column);
        include_extrema(column, ROWS_OF(groups), &low, &high);
        unsigned bit = 1u << lane;
        widen_range(&q->full, splat(low), splat(high), q->full_lanes & bit);
        widen_range(&q->late, splat(low), splat(high), q->late_lanes & bit);
    }
}

/* Searches for the extremes of a step of x and y. An unused range is unlimited. */
#define UNLIMITED ((Range){splat(-INFINITE), splat(INFINITE)})

INLINE ExtremaSearch search_in_x(Block *w, unsigned live)
{
    ExtremaSearch q = {w->h, {w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_error,
                              w->x_error},
                       {w->extremes.x_low, w->extremes.x_high}, UNLIMITED, 0, 0};
    widen_range(&q.full, vmin(w->xs[0], w->x), vmax(w->xs[0], w->x), live);
    w->extremes.x_low = q.full.low, w->extremes.x_high = q.full.high;
    q.full_lanes = live & mask_bits(exceeds(value_range(&q.ends), q.full));
    return q;
}

INLINE ExtremaSearch search_in_y(Block *w, unsigned whole, unsigned late)
{
    ExtremaSearch q = {w->h, {w->ys[0], w->y, w->ys[1] * w->h, w->vy * w->h, w->y_error,
                              w->y_error},
                       {w->extremes.y_low, w->extremes.y_high},
                       {w->extremes.late_low, w->extremes.late_high}, 0, 0};
    V low = vmin(w->ys[0], w->y), high = vmax(w->ys[0], w->y);
    widen_range(&q.full, low, high, whole);
    widen_range(&q.late, low, high, late);
    w->extremes.y_low = q.full.low, w->extremes.y_high = q.full.high;
    w->extremes.late_low = q.late.low, w->extremes.late_high = q.late.high;
    Range range = value_range(&q.ends);
    q.full_lanes = whole & mask_bits(exceeds(range, q.full));
    q.late_lanes = late & mask_bits(exceeds(range, q.late));
    return q;
}

/* Runs whose ẋ may exceed its greatest value so far within the step; ẋ never exceeds `limit`. */
INLINE unsigned may_exceed_max_vx(Block *w, int groups, V limit, unsigned live)
{
    w->extremes.vx_high = choose(mask_from_bits(live),
                                 vmax(vmax(w->xs[1], w->vx), w->extremes.vx_high),
                                 w->extremes.vx_high);
    live &= mask_bits(w->extremes.vx_high < limit);
    if (!live)
        return 0;
    Ends p = {w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_error, w->x_error};
    V fastest = vmax(vmax(p.start_slope, p.end_slope), middle_slope(&p));
    V error = weighted_bound(CUBIC_SLOPE_BOUND, w->xs, groups, w->h);
    return live & mask_bits(fastest + error > w->extremes.vx_high * w->h);
}

/* Values and bounds at both ends of a polynomial. */
INLINE Ends ends_of(const V *c, int groups, V h)
{
    Tangent end = tangent_at(c, groups, h);
    V error = weighted_bound(CUBIC_BOUND, c, groups, h);
    return (Ends){c[0], end.value, c[1] * h, end.slope * h, error, error};
}

/* In steps that contain half the horizon, search the later part for extremes of y. */
NOINLINE void observe_second_half(Block *w, int groups, V middle, unsigned lanes)
{
    V y[ROWS + 2];
    memcpy(y, w->ys, sizeof y);
    for (int start = 0; start < 4 * groups + 1; start++)
        for (int n = 4 * groups; n >= start; n--)
            y[n] = vfma(middle, y[n + 1], y[n]);
    V h = choose(mask_from_bits(lanes), w->h - middle, splat(1.0));
    ExtremaSearch q = {h, ends_of(y, groups, h), UNLIMITED,
                       {w->extremes.late_low, w->extremes.late_high}, 0, lanes};
    widen_range(&q.late, vmin(q.ends.start, q.ends.end), vmax(q.ends.start, q.ends.end), lanes);
    q.late_lanes = lanes & mask_bits(exceeds(value_range(&q.ends), q.late));
    find_extrema(y, groups, &q);
    w->extremes.late_low = q.late.low, w->extremes.late_high = q.late.high;
}

/* Runs whose steps start in the second half. Steps that contain its start are searched here. */
INLINE unsigned select_second_half(Block *w, int groups, double half, unsigned live)
{
    M starts_before = w->t < half;
    M ends_after = w->t + (w->h + w->remainder) > half;
    unsigned crossing = live & mask_bits(starts_before & ends_after);
    if (crossing)
        observe_second_half(w, groups, vmin((half - w->t) - w->remainder, w->h), crossing);
    return live & ~mask_bits(starts_before);
}

#endif
