/* A slider on a belt of finite speed: its modes, their guards, and what follows on them, by the
   table of modes in `fivtui.model.modes`. LANES is 1. */

#ifndef FIVTUI_BELT_H
#define FIVTUI_BELT_H

#include "friction.h"
#include "run.h"

enum { SEPARATED, CONTACT, FORWARD, BACKWARD, STICK, MODES };
/* Columns behind those of `Parameters`; v_s is 0 where friction is constant. */
enum { P_V_BELT = PARAMETERS, P_MU_S, P_V_S, BELT_PARAMETERS };
/* As in `fivtui.taylor.belt`. */
#define SIMULTANEOUS 0x1p-40
/* Room for those of a polynomial, and zeros. */
#define COEFFICIENTS (ROWS + 2)

/* How fast F, μ, μ_s and the belt's speed change with time. */
typedef struct {
    double force, friction, grip, speed;
} Rates;

/* The belt and the slider on it: the field and the friction law of each mode; F, μ, μ_s and the
   belt's speed at the start of a step, and their rates; the mode; whether friction does not jump at
   v_r = 0; whether the belt is of finite speed. */
typedef struct {
    Field fields[MODES];
    Law laws[MODES];
    double m, a, h, k1, c1, c2, k2, k_nl, stiffness, preload, mu, mu_s, v_belt;
    Rates rates;
    int64_t mode, smooth, finite;
} Belt;

INLINE int is_sliding(int64_t mode) { return mode == FORWARD || mode == BACKWARD; }

/* The contact spring as if in contact, and what the belt exerts where it holds. */
INLINE double spring(const Belt *of, double y) { return -of->k2 * y - of->k_nl * y * y * y; }
INLINE double holding(const Belt *of, double x, double y)
{
    return (of->c1 * of->v_belt + of->m * of->rates.speed) + of->a * x - of->h * y;
}

/* Whether a function is negative now or soon: by its first derivative beyond rounding. */
INLINE int falls(const double *derivatives, const double *sizes)
{
    for (int n = 0; n < 3; n++)
        if (__builtin_fabs(derivatives[n]) > larger(BALANCED * sizes[n], LEAST))
            return derivatives[n] < 0.0;
    return 0;
}

/* A function times a line: both, and their first and second derivative. */
INLINE void times_line(double value, double slope, const double *of, double *result)
{
    result[0] = value * of[0];
    result[1] = slope * of[0] + value * of[1];
    result[2] = 2.0 * slope * of[1] + value * of[2];
}

/* The mode in contact: `_mode_on_belt` of `fivtui.model.slider_belt`. */
APART int64_t mode_on_belt(const Belt *of, const Block *w, double x, double vx, double y,
                           double vy)
{
    const double v = of->v_belt, a = of->a, h = of->h;
    const Rates *rates = &of->rates;
    if (!of->finite)
        return CONTACT;
    if (vx != v)
        return vx < v ? FORWARD : BACKWARD;
    double force = spring(of, y), kt = of->k2 + 3.0 * of->k_nl * y * y;
    double ay = (force - of->preload - of->c2 * vy + h * (x - y)) / of->m;
    double bend = 6.0 * of->k_nl * y * vy * vy, driven = of->c1 * rates->speed;
    const double held[3] = {holding(of, x, y), driven + a * v - h * vy, a * rates->speed - h * ay};
    const double forces[3] = {force, -kt * vy, -kt * ay - bend};
    /* What the preload gives is known to rounding, too. */
    const double load = __builtin_fabs(of->preload), rate = load / of->stiffness * w->frequency;
    const double of_forces[3] = {__builtin_fabs(force) + load, kt * (__builtin_fabs(vy) + rate),
                                 kt * (__builtin_fabs(ay) + load / of->m) + __builtin_fabs(bend)};
    const double of_held[3] = {
        of->c1 * v + __builtin_fabs(of->m * rates->speed) + __builtin_fabs(a * x)
            + __builtin_fabs(h * y),
        __builtin_fabs(driven) + a * v + __builtin_fabs(h * vy),
        __builtin_fabs(a * rates->speed) + __builtin_fabs(h * ay)};
    double grips[3], sizes[3], margin[3];
    times_line(of->mu_s, __builtin_fabs(rates->grip), of_forces, sizes);
    for (int n = 0; n < 3; n++)
        sizes[n] = of_held[n] + sizes[n];
    if (falls(forces, of_forces))
        return falls(held, sizes) ? BACKWARD : FORWARD;
    times_line(of->mu_s, rates->grip, forces, grips);
    for (int n = 0; n < 3; n++)
        margin[n] = grips[n] - held[n];
    if (falls(margin, sizes))
        return FORWARD;
    for (int n = 0; n < 3; n++)
        margin[n] = grips[n] + held[n];
    return falls(margin, sizes) ? BACKWARD : STICK;
}

/* A slider that begins to slide where friction balances the other forces has the acceleration of
   the belt: with another one by chance it would seem to stick at once. */
INLINE void settle_start(const Belt *of, Block *w)
{
    double x = w->xs[0], y = w->ys[0], grip = of->mu_s * spring(of, y), held = holding(of, x, y);
    double size = of->c1 * of->v_belt + __builtin_fabs(of->m * of->rates.speed)
                  + __builtin_fabs(of->a * x) + __builtin_fabs(of->h * y) + __builtin_fabs(grip);
    double with_belt = 0.5 * of->rates.speed;
    int forward = of->mode == FORWARD;
    double margin = forward ? grip - held : grip + held;
    int balanced = of->smooth && __builtin_fabs(margin) <= BALANCED * size;
    if (balanced || (forward ? w->xs[2] > with_belt : w->xs[2] < with_belt))
        w->xs[2] = with_belt;
}

/* Where in the step, of length 1, a guard falls to zero; 2 if it does not. `final` is its end. */
APART double first_fall(double *c, int groups, double final)
{
    double found;
    if (c[0] <= 0.0)
        /* At the start of a mode its guard is zero, and rises but for rounding: it is c/θ that
           counts, or c/θ². */
        c[0] = 0.0, c[1] = larger(c[1], 0.0);
    for (int shift = 0; shift < 2 && c[0] == 0.0; shift++)
        memmove(c, c + 1, (COEFFICIENTS - 1) * sizeof *c);
    Ends p = ends_of(c, groups, 1.0);
    if (final > 0.0 && hull(&p).low > 0.0)
        return 2.0;
    p.slope_off = weighed(CUBIC_SLOPE_BOUND, c, groups, 1.0);
    if (c[0] > 0.0 && is_monotone(&p)) {
        if (final > 0.0)
            return 2.0;
        return p.final < 0.0 ? refined(c, 0.0, 1.0, 0) : 1.0;
    }
    if (sign_roots(c, 1, &found) > 0)
        return found;
    /* A root that rounded out of the step is at its end. */
    return final <= 0.0 ? 1.0 : 2.0;
}

/* The first fall of v_r, of `sign`. */
APART double fall_of_speed(const Belt *of, const Block *w, int groups, double sign)
{
    const double v = of->v_belt, change = of->rates.speed * w->h, last_v = v + change;
    double c[COEFFICIENTS] = {0.0}, power = w->h, speed = sign * (last_v - w->vx);
    Ends p = {w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_off, w->x_off};
    double middle = middle_slope(&p), off = weighed(CUBIC_SLOPE_BOUND, w->xs, groups, w->h);
    double fastest = larger(larger(sign * p.slope, sign * p.last_slope), sign * middle);
    if (smaller(sign * v, sign * last_v) * w->h > fastest + off)
        return 2.0;
    for (int n = 0; n <= 4 * groups; n++, power *= w->h)
        c[n] = -sign * (n + 1) * w->xs[n + 1] * power;
    c[0] = sign * (v - w->xs[1]) * w->h;
    c[1] += sign * change * w->h;
    return first_fall(c, groups, speed * w->h);
}

/* The first fall of μ_s P ∓ f; `mode` follows on it. */
APART double fall_of_hold(const Belt *of, const Block *w, int groups, int64_t *mode)
{
    const int size = 4 * groups + 2;
    const double more = of->rates.grip * w->h, driven = of->c1 * of->rates.speed * w->h;
    double grip[COEFFICIENTS] = {0.0}, held[COEFFICIENTS] = {0.0}, power = 1.0, first = 2.0;
    double force;
    Series y = {{0.0}}, square = {{0.0}};
    for (int n = 0; n < size; n++, power *= w->h) {
        put_term(&y, n, w->ys[n] * power);
        held[n] = (n < 3 ? of->a * w->xs[n] * power : 0.0) - of->h * y.c[n];
    }
    for (int n = 0; n < size; n++) {
        force = -of->k2 * y.c[n];
        if (of->k_nl > 0.0) {
            put_term(&square, n, product_of(&y, &y, n));
            force -= of->k_nl * product_of(&y, &square, n);
        }
        grip[n] += of->mu_s * force;
        if (more != 0.0 && n + 1 < size)
            grip[n + 1] = more * force;
    }
    grip[0] = of->mu_s * spring(of, w->ys[0]), held[0] = holding(of, w->xs[0], w->ys[0]);
    held[1] += driven;
    double last_grip = (of->mu_s + more) * spring(of, w->y);
    double last_held = holding(of, w->x, w->y) + driven;
    for (int backward = 0; backward < 2; backward++) {
        double c[COEFFICIENTS], sign = backward ? 1.0 : -1.0;
        for (int n = 0; n < COEFFICIENTS; n++)
            c[n] = grip[n] + sign * held[n];
        double found = first_fall(c, groups, last_grip + sign * last_held);
        if (found < first * (1.0 - SIMULTANEOUS))
            first = found, *mode = backward ? BACKWARD : FORWARD;
    }
    return first;
}

/* What ends a step: nothing, y = 0, v_r = 0, or the hold of the belt. */
typedef enum { NOTHING_ENDS, AT_SWITCH, AT_SPEED, AT_HOLD } Cut;

/* Shorten the step to the first fall of a guard in it; `then` follows on the hold. */
INLINE Cut find_end(const Belt *of, Block *w, int groups, int64_t *then)
{
    Cut cut = may_switch(w) && find_switch(w, groups) ? AT_SWITCH : NOTHING_ENDS;
    end_step_x(w, groups, 1);
    if (of->mode == SEPARATED || of->mode == CONTACT)
        return cut;
    double part = of->mode == STICK ? fall_of_hold(of, w, groups, then)
                                    : fall_of_speed(of, w, groups, of->mode == FORWARD ? 1.0 : -1.0);
    if (!(part <= 1.0) || (cut == AT_SWITCH && part >= 1.0 - SIMULTANEOUS))
        return cut;
    w->h *= part;
    end_step_y(w, groups);
    end_step_x(w, groups, 1);
    return of->mode == STICK ? AT_HOLD : AT_SPEED;
}

INLINE void expand_step(const Belt *of, Block *w, double tol, int order, int cubic)
{
    const Law *law = of->laws + of->mode;
    w->field = of->fields[of->mode];
    double speed = law->sign * (of->v_belt - w->xs[1]);
    if (law->per_speed > 0.0 && !(speed * law->per_speed > FAR))
        expand_by_law(w->xs, w->ys, &w->field, law, of->k2 / of->m, of->v_belt, order, cubic);
    else
        expand_in_contact(w, order, cubic && of->mode != SEPARATED);
    settle_at_switch(w);
    if (w->xs[1] == of->v_belt && is_sliding(of->mode))
        settle_start(of, w);
    set_length(w, tol, order / 4);
    if (law->per_speed > 0.0)
        w->h = limited(w->h, w->xs, law, speed, order / 4);
}

/* Go on from the end of the step, in the mode that follows. */
INLINE Arrivals go_on_belt(Belt *of, Block *w, const Ending *ending, Cut cut, int64_t then)
{
    double stalled = w->stalled, shortest = w->longest * (SHORTEST_FLIGHT / LONGEST_STEP);
    Arrivals arrivals = go_on(w, ending, cut == AT_SWITCH, 1, INFINITE);
    if ((cut == AT_SPEED || cut == AT_HOLD) && w->h < shortest) {
        w->stalled = stalled + 1.0;
        arrivals.stalled = w->stalled > MAX_STALLED;
    }
    if (cut == AT_HOLD)
        of->mode = then;
    else if (cut != NOTHING_ENDS)
        of->mode = w->side > 0.0 ? SEPARATED : mode_on_belt(of, w, w->x, w->vx, w->y, w->vy);
    return arrivals;
}

/* Begin with the parameters `p` on a block that has begun; those of the belt, behind the others,
   are not read where it is not of finite speed. */
INLINE void begin_belt(Belt *of, const Block *w, const double *p, int finite)
{
    memset(of, 0, sizeof *of);
    of->finite = finite;
    double m = p[P_M], h = 0.5 * p[P_K3], mu = p[P_MU];
    of->m = m, of->a = p[P_K1] + h, of->h = h, of->c1 = p[P_C1], of->c2 = p[P_C2];
    of->k1 = p[P_K1], of->k2 = p[P_K2], of->k_nl = p[P_KNL], of->preload = p[P_F], of->mu = mu;
    of->stiffness = p[P_K1] + p[P_K2] + p[P_K3];
    of->mu_s = finite ? p[P_MU_S] : mu, of->v_belt = finite ? p[P_V_BELT] : 0.0;
    Field contact = w->field, off = w->field;
    contact.b_x = w->contact_b_x, contact.b_y = w->contact_b_y;
    contact.d_x = w->contact_d_x, contact.d_y = w->contact_d_y;
    off.b_x = w->off_b_x, off.b_y = w->off_b_y, off.d_x = 0.0, off.d_y = 0.0;
    of->fields[SEPARATED] = off;
    of->fields[CONTACT] = of->fields[FORWARD] = of->fields[BACKWARD] = of->fields[STICK] = contact;
    of->fields[BACKWARD].b_x = (h + mu * p[P_K2]) / m;
    of->fields[BACKWARD].d_x = -contact.d_x;
    Field *held = of->fields + STICK;
    held->a_x = held->b_x = held->damping_x = held->d_x = 0.0;
    const int by_speed = finite && p[P_V_S] > 0.0;
    if (by_speed)
        for (int mode = FORWARD; mode <= BACKWARD; mode++)
            of->laws[mode] = (Law){mode == FORWARD ? 1.0 : -1.0, mu, of->mu_s - mu, 1.0 / p[P_V_S]};
    of->smooth = of->mu_s == mu || by_speed;
    of->mode = w->side > 0.0 ? SEPARATED
                             : mode_on_belt(of, w, w->xs[0], w->xs[1], w->ys[0], w->ys[1]);
}

#endif
