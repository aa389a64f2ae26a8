/* First switches and extreme values of steps, exact to rounding.

   Bounds settle most steps, Halley's and Newton's method those that hold one root or extremum for
   certain, `roots.h` the few that are left, one at a time. */

#ifndef FIVTUI_SEARCH_H
#define FIVTUI_SEARCH_H

#include "motion.h"
#include "roots.h"

#define MAX_ITERATIONS 100
/* A change that is less than this part of a root, and that Newton's method would not make, is
   none. */
#define STILL 1e-6
/* A change of this part of the step at an extremum changes its value by the cube of it. */
#define CLOSE 4e-6

/* One run's polynomial in θ = t/h. */
INLINE void scaled_column(const V *c, int groups, int lane, double h, double *p)
{
    double power = 1.0;
    for (int n = 0; n < ROWS_OF(groups); n++) {
        p[n] = n < 4 * groups + 2 ? element(c + n, lane) * power : 0.0;
        power *= h;
    }
}

/* The root of y, or of y/t after a switch, by Halley's method, kept inside (0, h]. */
INLINE V refined_root(const V *y, int groups, V h, V side, M fresh, V guess, unsigned wanted)
{
    V left = splat(0.0), right = h, last = splat(0.0), t = guess * h;
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        Curve at = curve_at(y, groups, t);
        M inside = side * at.value > 0.0;
        left = choose(inside, t, left), right = choose(inside, right, t);
        V rise = at.slope * t - at.value;
        V slope = choose(fresh, rise, at.slope);
        V bend = choose(fresh, at.bend * (t * t) - rise, at.bend);
        V step = at.value * slope / (slope * slope - at.value * bend);
        V new = t - choose(fresh, t, splat(1.0)) * step;
        V change = absolute(new - t);
        /* Halley's method stands still at an extremum too: there Newton's would not. */
        M near = absolute(at.value) <= absolute(step * slope) * 2.0;
        M within = (new > left) & (new < right) & (near | (change > t * STILL));
        M close = near & (change <= t * PRECISE);
        /* Changes shrink cubically: the next is about change (change/last)². */
        M next_is_none = change * change * change <= last * last * (t * PRECISE);
        M accepted = close | (near & within & (change < last * 1e-3) & next_is_none);
        V middle = (left + right) * 0.5;
        M halved = negated(within | close);
        M stuck = (at.value == 0.0) | (halved & ((middle <= left) | (middle >= right)));
        V moved = choose(accepted, least(greatest(new, left), right), choose(within, new, middle));
        t = choose(mask_of(wanted) & negated(stuck), moved, t);
        last = choose(within, change, splat(0.0));
        wanted &= ~bits_of(accepted | stuck);
        if (!wanted)
            break;
    }
    return t;
}

/* The first switch of one run by isolation, negative if there is none. */
APART double isolated_switch(const V *y, int groups, int lane, double h, double side)
{
    double p[ROWS], found, final = 0.0;
    const int rows = ROWS_OF(groups);
    scaled_column(y, groups, lane, h, p);
    for (int n = 0; n < rows; n++)
        final += p[n];
    if (sign_roots(p, rows, 1, &found) > 0)
        return found * h;
    /* A root that rounded out of the step is at its end. */
    return side * final <= 0.0 ? h : -1.0;
}

/* Shorten the steps, of length h and with y and ẏ at their ends, to the first switch in them.
   Returns which of the wanted ones there is a switch in. */
INLINE unsigned first_switch(const V *y, int groups, V side, V *h, V final, V last_vy, V off,
                             unsigned wanted)
{
    V start_slope = y[1] * *h, end_slope = last_vy * *h;
    /* After a switch all this is about y/θ, for which the bounds of y are good enough. */
    M fresh = y[0] == 0.0;
    Ends p;
    p.first = choose(fresh, start_slope, y[0]);
    p.final = final;
    p.slope = choose(fresh, y[2] * (*h * *h), start_slope);
    p.last_slope = choose(fresh, end_slope - final, end_slope);
    p.off = off;
    p.slope_off = weighed(CUBIC_SLOPE_BOUND, y, groups, *h);
    V change = final - p.first;
    M above = side * p.first > 0.0;
    M crossing = above & (side * final < 0.0), returning = above & (side * final > 0.0);
    M simple = is_monotone(&p);
    Range range = hull(&p);
    M none = returning & (simple | (choose(side > 0.0, range.low, -range.high) > 0.0));
    unsigned one = wanted & bits_of(crossing & simple);
    unsigned left = wanted & ~one & ~bits_of(none);
    if (left) {
        M bent = is_bent(&p, y, groups, *h);
        /* Between the tangents at its ends lies all of a curve that bends one way. */
        V bound = p.first + p.slope * ((change - p.last_slope) / (p.slope - p.last_slope));
        M one_sided = (side * p.slope > 0.0) | (side * bound > 0.0)
                      | negated((p.slope > 0.0) ^ (p.last_slope > 0.0));
        one |= left & bits_of(crossing & bent);
        left &= ~one & ~bits_of(returning & bent & one_sided);
    }
    unsigned found = one;
    if (one) {
        V part = -p.first / change, rest = 1.0 - part;
        V inverse = rest / p.slope - part / p.last_slope;
        V guess = part * part * (3.0 - part * 2.0) + change * part * rest * inverse;
        guess = choose((guess > 0.0) & (guess < 1.0), guess, part);
        V root = refined_root(y, groups, *h, side, fresh, guess, one);
        *h = choose(mask_of(one), root, *h);
    }
    while (left) {
        int lane = __builtin_ctz(left);
        left &= left - 1;
        double root = isolated_switch(y, groups, lane, element(h, lane), element(&side, lane));
        if (root >= 0.0) {
            put(h, lane, root);
            found |= 1u << lane;
        }
    }
    return found;
}

/* The value where the slope, of `sign` at first, vanishes, which it does once. */
INLINE V extreme_value(const V *c, int groups, V h, V guess, V sign, unsigned wanted)
{
    V left = splat(0.0), right = h, t = guess * h, result = splat(0.0);
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        Curve at = curve_at(c, groups, t);
        M before = at.slope * sign > 0.0;
        left = choose(before, t, left), right = choose(before, right, t);
        V change = -at.slope / (at.bend * 2.0), new = t + change;
        M within = (new > left) & (new < right);
        V middle = (left + right) * 0.5;
        M still = at.slope == 0.0;
        M stuck = negated(within) & ((middle <= left) | (middle >= right));
        M close = absolute(change) <= h * CLOSE;
        V best = choose(close & negated(still), at.value + at.slope * change * 0.5, at.value);
        result = choose(mask_of(wanted), best, result);
        t = choose(within, new, middle);
        wanted &= ~bits_of(still | close | stuck);
        if (!wanted)
            break;
    }
    return result;
}

/* Where the slope of the cubic vanishes, if slopes at its ends differ in sign; outside (0, 1) where
   rounding hides it. `square` and `cube` are its last coefficients. */
INLINE V crest_of(V slope, V square, V cube, V sign)
{
    /* The squares of numbers as small as these would be zero. */
    V size = greatest(absolute(slope), greatest(absolute(square), absolute(cube)));
    V scale = choose(size < 0x1p-400, splat(0x1p600), splat(1.0));
    slope = slope * scale, square = square * scale, cube = cube * scale;
    V root = root_of(greatest(square * square - cube * slope * 3.0, splat(0.0)));
    /* Two forms of the same, each of which cancels where the other does not. */
    M hollow = square * sign > 0.0;
    V above = choose(hollow, -(square + sign * root), absolute(slope));
    V below = choose(hollow, cube * 3.0, root - square * sign);
    return above / below;
}

/* A polynomial on [0, h], and which runs want its extreme values in the ranges seen over the whole
   run and over the second half; both hold its ends already. */
typedef struct {
    V h;
    Ends ends;
    Range whole, late;
    unsigned in_whole, in_late;
} Quest;

INLINE M reaches(Range range, Range seen) { return (range.low < seen.low) | (range.high > seen.high); }

INLINE void take(Range *seen, V low, V high, unsigned wanted)
{
    M here = mask_of(wanted);
    seen->low = choose(here, least(low, seen->low), seen->low);
    seen->high = choose(here, greatest(high, seen->high), seen->high);
}

/* Widen the ranges. */
INLINE void widen(const V *c, int groups, Quest *q)
{
    Ends *p = &q->ends;
    p->slope_off = weighed(CUBIC_SLOPE_BOUND, c, groups, q->h);
    unsigned open = ~bits_of(is_monotone(p));
    q->in_whole &= open, q->in_late &= open;
    if (!(q->in_whole | q->in_late))
        return;
    V change = p->final - p->first;
    V cube = p->slope + p->last_slope - change * 2.0;
    V square = change * 3.0 - p->slope * 2.0 - p->last_slope;
    M turning = (p->slope > 0.0) ^ (p->last_slope > 0.0);
    V sign = choose(p->slope > 0.0, splat(1.0), splat(-1.0));
    V crest = crest_of(p->slope, square, cube, sign);
    M known = turning & (crest > 0.0) & (crest < 1.0);
    crest = choose(known, crest, splat(0.5));
    V value = p->first + crest * (p->slope + crest * (square + crest * cube));
    Range there = {value - p->off, value + p->off};
    q->in_whole &= ~bits_of(known & negated(reaches(there, q->whole)));
    q->in_late &= ~bits_of(known & negated(reaches(there, q->late)));
    unsigned wanted = q->in_whole | q->in_late;
    if (!wanted)
        return;
    unsigned single = wanted & bits_of(turning & is_bent(p, c, groups, q->h));
    if (single) {
        value = extreme_value(c, groups, q->h, crest, sign, single);
        take(&q->whole, value, value, q->in_whole & single);
        take(&q->late, value, value, q->in_late & single);
    }
    for (unsigned left = wanted & ~single; left; left &= left - 1) {
        int lane = __builtin_ctz(left);
        double column[ROWS], low = INFINITE, high = -INFINITE;
        scaled_column(c, groups, lane, element(&q->h, lane), column);
        turning_values(column, ROWS_OF(groups), &low, &high);
        unsigned here = 1u << lane;
        take(&q->whole, splat(low), splat(high), q->in_whole & here);
        take(&q->late, splat(low), splat(high), q->in_late & here);
    }
}

/* What is sought in a step of x (0), y (1) and ẋ (2); ranges that do not matter are endless. */
#define ENDLESS ((Range){splat(-INFINITE), splat(INFINITE)})

INLINE Quest quest_in_x(Block *w, unsigned live)
{
    Quest q = {w->h, {w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_off, w->x_off},
               {w->seen.x_low, w->seen.x_high}, ENDLESS, 0, 0};
    take(&q.whole, least(w->xs[0], w->x), greatest(w->xs[0], w->x), live);
    w->seen.x_low = q.whole.low, w->seen.x_high = q.whole.high;
    q.in_whole = live & bits_of(reaches(hull(&q.ends), q.whole));
    return q;
}

INLINE Quest quest_in_y(Block *w, unsigned whole, unsigned late)
{
    Quest q = {w->h, {w->ys[0], w->y, w->ys[1] * w->h, w->vy * w->h, w->y_off, w->y_off},
               {w->seen.y_low, w->seen.y_high}, {w->seen.late_low, w->seen.late_high}, 0, 0};
    V low = least(w->ys[0], w->y), high = greatest(w->ys[0], w->y);
    take(&q.whole, low, high, whole);
    take(&q.late, low, high, late);
    w->seen.y_low = q.whole.low, w->seen.y_high = q.whole.high;
    w->seen.late_low = q.late.low, w->seen.late_high = q.late.high;
    Range range = hull(&q.ends);
    q.in_whole = whole & bits_of(reaches(range, q.whole));
    q.in_late = late & bits_of(reaches(range, q.late));
    return q;
}

/* Which of the live runs may move faster in x than they did, between the ends of the step; there they
   do not go beyond `limit`. */
INLINE unsigned may_be_faster(Block *w, int groups, V limit, unsigned live)
{
    w->seen.vx_high = choose(mask_of(live), greatest(greatest(w->xs[1], w->vx), w->seen.vx_high),
                             w->seen.vx_high);
    live &= bits_of(w->seen.vx_high < limit);
    if (!live)
        return 0;
    Ends p = {w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_off, w->x_off};
    V fastest = greatest(greatest(p.slope, p.last_slope), middle_slope(&p));
    V off = weighed(CUBIC_SLOPE_BOUND, w->xs, groups, w->h);
    return live & bits_of(fastest + off > w->seen.vx_high * w->h);
}

/* A polynomial's ends, from its coefficients. */
INLINE Ends ends_of(const V *c, int groups, V h)
{
    Tangent end = tangent_at(c, groups, h);
    V off = weighed(CUBIC_BOUND, c, groups, h);
    return (Ends){c[0], end.value, c[1] * h, end.slope * h, off, off};
}

/* In the steps in which half the horizon lies, what is behind it belongs to the second half. */
APART void take_part_behind(Block *w, int groups, V middle, unsigned wanted)
{
    V y[ROWS + 2];
    memcpy(y, w->ys, sizeof y);
    for (int start = 0; start < 4 * groups + 1; start++)
        for (int n = 4 * groups; n >= start; n--)
            y[n] = fma_of(middle, y[n + 1], y[n]);
    V h = choose(mask_of(wanted), w->h - middle, splat(1.0));
    Quest q = {h, ends_of(y, groups, h), ENDLESS, {w->seen.late_low, w->seen.late_high}, 0, wanted};
    take(&q.late, least(q.ends.first, q.ends.final), greatest(q.ends.first, q.ends.final), wanted);
    q.in_late = wanted & bits_of(reaches(hull(&q.ends), q.late));
    widen(y, groups, &q);
    w->seen.late_low = q.late.low, w->seen.late_high = q.late.high;
}

/* Take the ends of the steps of the live runs into the second half; returns those within it. */
INLINE unsigned within_second_half(Block *w, int groups, double half, unsigned live)
{
    M before = w->t < half;
    M beyond = w->t + (w->h + w->rest) > half;
    unsigned crossing = live & bits_of(before & beyond);
    if (crossing)
        take_part_behind(w, groups, least((half - w->t) - w->rest, w->h), crossing);
    return live & ~bits_of(before);
}

#endif
