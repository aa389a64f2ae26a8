/* One step of every run of a block: its length, its end, its mode.

   `Block` is all that a run keeps. What a step does is `begin_step`, then `end_step_y`, the search
   for the first switch (`search.h`), `end_step_x`, the extremes (`search.h`), and `go_on`. */

#ifndef FIVTUI_MOTION_H
#define FIVTUI_MOTION_H

#include <stddef.h>

#include "expansion.h"
#include "field.h"
#include "polynomial.h"

/* How a run ends: `fivtui.kernel.status.Status`; it goes on while that is RUNNING. */
enum { DONE, OVERFLOW, STALLED, STEP_LIMIT, NO_START, RUNNING, UNBOUNDED };

/* As in `fivtui.taylor.stepper` and `fivtui.model.slider_belt`. */
#define LONGEST_STEP 1e3
#define SHORTEST_FLIGHT 0x1p-30
#define MAX_STALLED 64.0
#define LEAST_SHARE 0x1p-30
#define EXP2_BIAS 0.043
#define BALANCED 0x1p-49
#define LEAST 1e-280
#define INFINITE __builtin_inf()

/* Extremes over a run, and of y after half the horizon. */
typedef struct {
    V x_low, x_high, y_low, y_high, vx_high, late_low, late_high;
} Extremes;

/* `field` governs the step; `side` is 1 off the belt and −1 in contact; `rest` is what t lacks of
   the exact time. x, vx, y and vy are at the end of the step of length h. */
typedef struct {
    Field field;
    V contact_b_x, contact_b_y, contact_d_x, contact_d_y, off_b_x, off_b_y;
    V coupling, preload, deflection, frequency, longest, separation;
    V t, rest, side, steps, stalled, lifts, landings, separated, separated_rest, first, last;
    Extremes seen;
    V h, x, vx, y, vy, x_off, y_off;
    V xs[ROWS + 2], ys[ROWS + 2];
} Block;

/* The rows of a block that a problem and where it stands consist of. */
#define KEPT_ROWS (offsetof(Block, h) / sizeof(V))

/* The lengths of the next steps: Jorba and Zou's rule, from the last two coefficients, for x and y
   each relative to a scale of its own. */
INLINE void set_length(Block *w, double tol, int groups)
{
    const V *x = w->xs, *y = w->ys;
    V own_x = greatest(absolute(x[1]), absolute(x[0]) * w->frequency);
    V own_y = greatest(absolute(y[1]), absolute(y[0]) * w->frequency);
    V both = greatest(greatest(own_x, own_y), w->deflection * w->frequency);
    V floor = both * LEAST_SHARE;
    V allowed_x = greatest(own_x, floor) * tol, allowed_y = greatest(own_y, floor) * tol;
    M some_x = allowed_x > 0.0, some_y = allowed_y > 0.0;
    const double none = 200.0 * 0x1p52;
    V shares[2];
    for (int last = 0; last < 2; last++) {
        int n = 4 * groups + 1 - last;
        V last_x = absolute(x[n]) * (double)n, last_y = absolute(y[n]) * (double)n;
        V share_x = bit_difference(allowed_x, last_x) * (1.0 / (n - 1));
        V share_y = bit_difference(allowed_y, last_y) * (1.0 / (n - 1));
        shares[last] = least(choose((last_x > 0.0) & some_x, share_x, splat(none)),
                             choose((last_y > 0.0) & some_y, share_y, splat(none)));
    }
    V exponent = least(shares[0], shares[1]);
    /* Where the coefficients overflow the end of the step is not finite either. */
    exponent = choose(exponent > -1000.0 * 0x1p52, exponent, splat(-1000.0 * 0x1p52));
    V h = from_bits_beyond_one(exponent, (1023LL << 52) - (int64_t)(EXP2_BIAS * 0x1p52));
    w->h = least(h, w->longest);
}

/* Where the motion is at the switch and the forces balance to rounding, the acceleration is that of
   the damper: with a sign by chance the motion would seem to cross at once, again and again. */
INLINE V lifting_force(V coupling, V preload, V x)
{
    V held = coupling * x, force = held - preload;
    V rounding = (absolute(held) + absolute(preload)) * BALANCED;
    return choose(absolute(force) > greatest(rounding, splat(LEAST)), force, splat(0.0));
}

INLINE void settle_at_switch(Block *w)
{
    V *y = w->ys;
    M at_switch = (y[0] == 0.0) & (w->separation > 0.0);
    if (!bits_of(at_switch))
        return;
    M balanced = at_switch & (lifting_force(w->coupling, w->preload, w->xs[0]) == 0.0);
    if (!bits_of(balanced))
        return;
    const Field *f = &w->field;
    V half = f->damping_y * y[1] * 0.5;
    V jerk = f->a_y * w->xs[1] + f->b_y * y[1] + f->damping_y * half * 2.0;
    y[2] = choose(balanced, half, y[2]);
    y[3] = choose(balanced, jerk * (1.0 / 6.0), y[3]);
}

/* y and ẏ at the end of the step, and how far y leaves its cubic. */
INLINE void end_step_y(Block *w, int groups)
{
    Tangent end = tangent_at(w->ys, groups, w->h);
    w->y = end.value, w->vy = end.slope;
    w->y_off = weighed(CUBIC_BOUND, w->ys, groups, w->h);
}

/* End the steps that go beyond the horizon there, and say which: a switch that was found in one of
   them is beyond it. What is found up to the horizon does not depend on it, to the last bit. */
INLINE M end_at_horizon(Block *w, double t_end, int groups)
{
    V left = (t_end - w->t) - w->rest;
    M beyond = w->h > left;
    if (bits_of(beyond)) {
        w->h = choose(beyond, left, w->h);
        Tangent end = tangent_at(w->ys, groups, w->h);
        V off = weighed(CUBIC_BOUND, w->ys, groups, w->h);
        w->y = choose(beyond, end.value, w->y), w->vy = choose(beyond, end.slope, w->vy);
        w->y_off = choose(beyond, off, w->y_off);
    }
    return beyond;
}

INLINE void end_step_x(Block *w, int groups, int bounded)
{
    Tangent end = tangent_at(w->xs, groups, w->h);
    w->x = end.value, w->vx = end.slope;
    if (bounded)
        w->x_off = weighed(CUBIC_BOUND, w->xs, groups, w->h);
}

/* The runs in whose step there may be a switch. */
INLINE M may_switch(const Block *w)
{
    V slope = w->ys[1] * w->h, last_slope = w->vy * w->h;
    Ends ends = {w->ys[0], w->y, slope, last_slope, w->y_off, w->y_off};
    Range y = hull(&ends);
    M off = w->side > 0.0;
    /* After a switch y starts from zero: then all this is about y/θ. */
    V middle = w->y * 1.5 - last_slope * 0.5;
    V bottom = least(least(slope, w->y), middle), top = greatest(greatest(slope, w->y), middle);
    V beyond = w->y_off * SHARING;
    M away = choose(off, bottom, -top) > beyond;
    M far = choose(off, y.low, -y.high) > 0.0;
    M fresh = w->ys[0] == 0.0;
    return (w->separation > 0.0) & negated((fresh & away) | (negated(fresh) & far));
}

/* The runs in which the end of the step is finite. */
INLINE M is_sound(const Block *w)
{
    V total = (w->x + w->y) + (w->vx + w->vy);
    return (total - total == 0.0) & (w->h > 0.0);
}

/* 1 if the motion goes on off the belt from y = 0, −1 if in contact: the sign of the first
   derivative of y that is not zero (Eqs. 3 and 4). */
INLINE V side_after(const Block *w, V x, V vx, V vy)
{
    V force = lifting_force(w->coupling, w->preload, x);
    V push = w->coupling * vx;
    V third = choose(absolute(push) > LEAST, push, -(w->coupling * x));
    V direction = choose(vy != 0.0, vy, choose(force != 0.0, force, third));
    return choose(direction > 0.0, splat(1.0), splat(-1.0));
}

/* The mode of a run on a belt that is always faster. */
INLINE int mode_in_lane(const Block *w, int lane)
{
    return element(&w->side, lane) < 0.0 ? CONTACT : SEPARATED;
}

INLINE void set_field(Block *w)
{
    M off = w->side > 0.0;
    w->field.b_x = choose(off, w->off_b_x, w->contact_b_x);
    w->field.b_y = choose(off, w->off_b_y, w->contact_b_y);
    w->field.d_x = choose(off, splat(0.0), w->contact_d_x);
    w->field.d_y = choose(off, splat(0.0), w->contact_d_y);
}

/* Go on on these sides from the time `end`. */
INLINE void take_side(Block *w, V end, V side)
{
    M lifted = (side > 0.0) & (w->side < 0.0), landed = (side < 0.0) & (w->side > 0.0);
    M switched = lifted | landed;
    M none_yet = switched & (w->lifts + w->landings == 0.0);
    w->first = choose(none_yet, end, w->first);
    w->last = choose(switched, end, w->last);
    w->lifts = w->lifts + choose(lifted, splat(1.0), splat(0.0));
    w->landings = w->landings + choose(landed, splat(1.0), splat(0.0));
    w->side = side;
    set_field(w);
}

/* Change the mode of the runs that are `cut` at a switch at the time `end`. */
INLINE void change_mode(Block *w, V end, M cut)
{
    take_side(w, end, choose(cut, side_after(w, w->x, w->vx, w->vy), w->side));
}

/* Where the steps end, and whether that is the horizon. */
typedef struct {
    V t, rest;
    M last;
} Ending;

/* Of steps that are `cut` at a switch, and others. Two-sum, so that the rounding of t does not grow
   with the number of steps. */
INLINE Ending ending_of(const Block *w, double t_end, M cut)
{
    M reached = negated(cut) & negated(w->h < (t_end - w->t) - w->rest);
    V increment = w->h + w->rest, t = w->t + increment, lost = t - w->t;
    V rest = (w->t - (t - lost)) + (increment - lost);
    M last = reached | (t >= t_end);
    return (Ending){choose(last, splat(t_end), t), rest, last};
}

/* What the end of a step has brought. */
typedef struct {
    unsigned done, stalled, halted;
} Arrivals;

/* End the steps of the runs that are `live`, those `cut` at a switch. */
INLINE Arrivals go_on(Block *w, const Ending *ending, M cut, M live, double max_steps)
{
    M short_flight = cut & (w->h < w->longest * (SHORTEST_FLIGHT / LONGEST_STEP));
    V part = choose((w->side > 0.0) & live, w->h, splat(0.0)) + w->separated_rest;
    V longer = w->separated + part;
    w->separated_rest = part - (longer - w->separated);
    w->separated = longer;
    if (bits_of(cut))
        change_mode(w, ending->t, cut);
    M still = short_flight | (ending->t == w->t);
    w->stalled = choose(still, w->stalled + 1.0, splat(0.0));
    w->steps = w->steps + choose(live, splat(1.0), splat(0.0));
    w->t = choose(live, ending->t, w->t);
    w->rest = ending->rest;
    w->xs[0] = choose(live, w->x, w->xs[0]), w->xs[1] = choose(live, w->vx, w->xs[1]);
    w->ys[0] = choose(live, w->y, w->ys[0]), w->ys[1] = choose(live, w->vy, w->ys[1]);
    return (Arrivals){bits_of(ending->last & live), bits_of((w->stalled > MAX_STALLED) & live),
                      bits_of((w->steps >= max_steps) & live)};
}

#endif
