/* A slider on a belt of finite speed: its modes, their guards, and what follows on them, by the
   table of modes in `fivtui.model.modes`. `belts.h` has blocks of them side by side; where LANES is
   1 a run of its own takes its steps by this. */

#ifndef FIVTUI_BELT_H
#define FIVTUI_BELT_H

#include "friction.h"
#include "problem.h"
#include "recurrence.h"
#include "search.h"
#if LANES == 1
#include "run.h"
#endif

/* As in `fivtui.taylor.belt`. */
#define SIMULTANEOUS 0x1p-40
#define UNRESOLVED 0x1p-50
/* Room for those of a polynomial, and zeros. */
#define COEFFICIENTS (ROWS + 2)

/* The belt and the slider on it: the field and the friction law of each mode; the parameters at the
   start of a step, v_s being 0 where friction is constant, and their rates; the mode; whether friction
   does not jump at v_r = 0; whether the belt is of finite speed, and friction by a law; e where the
   next step starts, if that is known. Margins of the hold within `nearness` are zero. */
typedef struct {
#if LANES == 1
    Field fields[MODES];
    Law laws[MODES];
    Start next;
#endif
    double p[BELT_PARAMETERS], frequency;
    Rates rates;
    double nearness;
    int64_t mode, smooth, finite, by_speed;
} Belt;

INLINE int is_sliding(int64_t mode) { return mode == FORWARD || mode == BACKWARD; }

/* Whether a function is negative now or soon: by its first derivative beyond rounding, itself not
   being zero by `nearness` of its size. */
INLINE int falls(double nearness, const double *derivatives, const double *sizes)
{
    for (int n = 0; n < 3; n++) {
        double zero = (n == 0 ? nearness : BALANCED) * sizes[n];
        if (__builtin_fabs(derivatives[n]) > larger(zero, LEAST))
            return derivatives[n] < 0.0;
    }
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
APART int64_t mode_on_belt(const Belt *of, double x, double vx, double y, double vy)
{
    const double *p = of->p, v = p[P_V_BELT], a = horizontal_stiffness(p), h = coupling_stiffness(p);
    const Rates *rates = &of->rates;
    if (!of->finite)
        return CONTACT;
    if (vx != v)
        return vx < v ? FORWARD : BACKWARD;
    double force = spring_force(p, y), kt = tangent_stiffness(p, y);
    double ay = vertical_acceleration(p, x, y, vy, force - load_of(p));
    double bend = tangent_slope(p, y) * vy * vy, driven = p[P_C1] * rates->v_belt;
    const double held[3] = {holding_force(p, x, y, rates->v_belt),
                            holding_force_rate(p, rates->v_belt, v, vy),
                            holding_force_rate(p, 0.0, rates->v_belt, ay)};
    const double forces[3] = {force, -kt * vy, -kt * ay - bend};
    /* What the preload gives is known to rounding, too. */
    const double load = __builtin_fabs(load_of(p)), rate = load / total_stiffness(p) * of->frequency;
    const double of_forces[3] = {__builtin_fabs(force) + load, kt * (__builtin_fabs(vy) + rate),
                                 kt * (__builtin_fabs(ay) + load / p[P_M]) + __builtin_fabs(bend)};
    const double of_held[3] = {
        p[P_C1] * v + __builtin_fabs(p[P_M] * rates->v_belt) + __builtin_fabs(a * x)
            + __builtin_fabs(h * y),
        __builtin_fabs(driven) + a * v + __builtin_fabs(h * vy),
        __builtin_fabs(a * rates->v_belt) + __builtin_fabs(h * ay)};
    double grips[3], sizes[3], margin[3];
    times_line(of->p[P_MU_S], __builtin_fabs(rates->mu_static), of_forces, sizes);
    for (int n = 0; n < 3; n++)
        sizes[n] = of_held[n] + sizes[n];
    if (falls(of->nearness, forces, of_forces))
        return falls(of->nearness, held, sizes) ? BACKWARD : FORWARD;
    times_line(of->p[P_MU_S], rates->mu_static, forces, grips);
    for (int n = 0; n < 3; n++)
        margin[n] = grips[n] - held[n];
    if (falls(of->nearness, margin, sizes))
        return FORWARD;
    for (int n = 0; n < 3; n++)
        margin[n] = grips[n] + held[n];
    return falls(of->nearness, margin, sizes) ? BACKWARD : STICK;
}

/* Half the acceleration of a slider that begins to slide, which the expansion takes for `half`.
   Where friction balances the other forces it is that of the belt: with another one by chance the
   slider would seem to stick at once. */
INLINE double settled_start(const Belt *of, double x, double y, double half)
{
    const double *p = of->p;
    double grip = p[P_MU_S] * spring_force(p, y), held = holding_force(p, x, y, of->rates.v_belt);
    double size = p[P_C1] * p[P_V_BELT] + __builtin_fabs(p[P_M] * of->rates.v_belt)
                  + __builtin_fabs(horizontal_stiffness(p) * x)
                  + __builtin_fabs(coupling_stiffness(p) * y) + __builtin_fabs(grip);
    double with_belt = 0.5 * of->rates.v_belt;
    int forward = of->mode == FORWARD;
    double margin = forward ? grip - held : grip + held;
    int balanced = of->smooth && __builtin_fabs(margin) <= BALANCED * size;
    return balanced || (forward ? half > with_belt : half < with_belt) ? with_belt : half;
}

/* A guard over a step, as a polynomial of the time since its start, and its value at the end. */
typedef struct {
    double c[COEFFICIENTS], final;
} Guard;

/* At the start of a mode its guard is zero, and rises but for rounding; where it does not rise it is
   the guard over time that counts. */
INLINE void begin_guard(Guard *g, double h)
{
    if (g->c[0] > 0.0)
        return;
    g->c[0] = 0.0, g->c[1] = larger(g->c[1], 0.0);
    if (g->c[1] == 0.0) {
        memmove(g->c, g->c + 1, (COEFFICIENTS - 1) * sizeof *g->c);
        g->final /= h;
    }
}

/* v_r, of `sign`, in one lane of a block. */
INLINE void guard_of_speed(const Belt *of, const Block *w, int lane, int groups, double sign, Guard *g)
{
    double rate = of->rates.v_belt;
    for (int n = 0; n <= 4 * groups; n++)
        g->c[n] = -sign * (n + 1) * element(w->xs + n + 1, lane);
    g->c[0] = sign * (of->p[P_V_BELT] - element(w->xs + 1, lane)), g->c[1] += sign * rate;
    memset(g->c + 4 * groups + 1, 0, (COEFFICIENTS - 1 - 4 * groups) * sizeof *g->c);
    g->final = sign * (of->p[P_V_BELT] + rate * element(&w->h, lane) - element(&w->vx, lane));
}

/* Whether v_r, of `sign`, stays positive for certain while the belt's speed goes from v to last_v. */
INLINE M keeps_sliding(const Block *w, int groups, V sign, V v, V last_v)
{
    Ends p = {w->xs[0], w->x, w->xs[1] * w->h, w->vx * w->h, w->x_off, w->x_off};
    V off = weighed(CUBIC_SLOPE_BOUND, w->xs, groups, w->h);
    V fastest = greatest(greatest(sign * p.slope, sign * p.last_slope), sign * middle_slope(&p));
    return least(sign * v, sign * last_v) * w->h > fastest + off;
}

/* μ_s P − f and μ_s P + f in one lane of a block, f being what the belt exerts. Eq. 5 gives P from
   the expansion of y. */
INLINE void guards_of_hold(const Belt *of, const Block *w, int lane, int groups, Guard *ahead,
                           Guard *behind)
{
    const Rates *rates = &of->rates;
    const double *p = of->p, a = horizontal_stiffness(p), h = coupling_stiffness(p), m = p[P_M];
    const double span = element(&w->h, lane), more = rates->mu_static * span;
    double force[COEFFICIENTS], grip[COEFFICIENTS], held[COEFFICIENTS];
    for (int n = 0; n < 4 * groups; n++) {
        double y = element(w->ys + n, lane);
        double moved = of->p[P_C2] * element(w->ys + n + 1, lane) + m * (n + 2) * element(w->ys + n + 2, lane);
        force[n] = (n + 1) * moved + h * y, grip[n] = of->p[P_MU_S] * force[n], held[n] = -h * y;
    }
    /* Where the slider sticks x is of the second degree. */
    force[0] = spring_force(of->p, element(w->ys, lane)), force[1] += rates->F;
    for (int n = 1; n < 3; n++) {
        double x = element(w->xs + n, lane);
        force[n] -= h * x, grip[n] = of->p[P_MU_S] * force[n], held[n] += a * x;
    }
    grip[0] = of->p[P_MU_S] * force[0], held[0] = holding_force(of->p, element(w->xs, lane), element(w->ys, lane), of->rates.v_belt);
    held[1] += of->p[P_C1] * rates->v_belt;
    if (more != 0.0)
        for (int n = 1; n < 4 * groups; n++)
            grip[n] += rates->mu_static * force[n - 1];
    memset(ahead, 0, sizeof *ahead);
    memset(behind, 0, sizeof *behind);
    for (int n = 0; n < 4 * groups; n++)
        ahead->c[n] = grip[n] - held[n], behind->c[n] = grip[n] + held[n];
    double y = element(&w->y, lane), last_grip = (of->p[P_MU_S] + more) * spring_force(of->p, y);
    double last_held = holding_force(of->p, element(&w->x, lane), y, of->rates.v_belt) + of->p[P_C1] * rates->v_belt * span;
    ahead->final = last_grip - last_held, behind->final = last_grip + last_held;
}

/* What holds the slider: least μ_s, stiffnesses, what the belt exerts at y = 0 at both ends, and how
   far between them it leaves its chord. */
typedef struct {
    V grip, k2, k_nl, h, first, last, bulge;
} Hold;

/* Whether the belt holds the slider for certain, against what pushes it forward and backward. */
typedef struct {
    M forward, backward;
} Held;

INLINE Held keeps_holding(const Block *w, const Hold *of)
{
    Ends p = {w->ys[0], w->y, w->ys[1] * w->h, w->vy * w->h, w->y_off, w->y_off};
    Range y = hull(&p);
    V force = -of->k2 * y.high - of->k_nl * y.high * y.high * y.high;
    /* A stiff contact loses more with y than its coupling gives. */
    V pushing = choose(of->grip * of->k2 >= of->h, y.high, y.low);
    V grip = of->grip * force - of->bulge;
    return (Held){grip > greatest(of->first, of->last) - of->h * pushing,
                  grip > of->h * y.high - least(of->first, of->last)};
}

/* What ends a step: nothing, y = 0, v_r = 0, or the hold of the belt. */
typedef enum { NOTHING_ENDS, AT_SWITCH, AT_SPEED, AT_HOLD } Cut;

/* When the belt's hold ends, by the falls of μ_s P ∓ f; `mode` follows on it. */
INLINE double first_release(double ahead, double behind, int64_t *mode)
{
    int backward = behind < ahead * (1.0 - SIMULTANEOUS);
    *mode = backward ? BACKWARD : FORWARD;
    return backward ? behind : ahead;
}

/* Whether the fall of a guard ends a step of length h that is `cut` at a switch, or is not. */
INLINE int comes_first(double fall, double h, Cut cut)
{
    return fall <= h && !(cut == AT_SWITCH && fall >= h * (1.0 - SIMULTANEOUS));
}

#if LANES == 1

/* When a guard falls to zero in the step, infinite if it does not. */
INLINE double fall_of(Guard *g, double h, int groups)
{
    begin_guard(g, h);
    Tangent end = tangent_at(g->c, groups, h);
    double off = weighed(CUBIC_BOUND, g->c, groups, h);
    return first_switch(g->c, groups, 1.0, &h, g->final, end.slope, off, 1) ? h : INFINITE;
}

/* The first fall of v_r. */
APART double fall_of_speed(const Belt *of, const Block *w, int groups, double sign)
{
    Guard g;
    guard_of_speed(of, w, 0, groups, sign, &g);
    return fall_of(&g, w->h, groups);
}

/* The first fall of μ_s P ∓ f, those apart that do not fall for certain; `mode` follows on it. */
APART double fall_of_hold(const Belt *of, const Block *w, int groups, const Held *held,
                          int64_t *mode)
{
    Guard ahead, behind;
    guards_of_hold(of, w, 0, groups, &ahead, &behind);
    double forward = held->forward ? INFINITE : fall_of(&ahead, w->h, groups);
    double backward = held->backward ? INFINITE : fall_of(&behind, w->h, groups);
    return first_release(forward, backward, mode);
}

/* A speed that the slider reaches in a step of length h at its ends alone, if at all. */
INLINE double speed_limit(const Belt *of, double h)
{
    if (of->mode == STICK)
        return -INFINITE;
    return of->mode == FORWARD ? larger(of->p[P_V_BELT], of->p[P_V_BELT] + of->rates.v_belt * h) : INFINITE;
}

/* The first fall of a guard of the present mode, infinite if there is none; a slider that `stays` in
   motion over the belt for certain does not reach its speed. */
INLINE double first_fall(const Belt *of, const Block *w, int groups, int stays, int64_t *then)
{
    if (is_sliding(of->mode)) {
        if (stays)
            return INFINITE;
        double sign = of->mode == FORWARD ? 1.0 : -1.0, v = of->p[P_V_BELT];
        return keeps_sliding(w, groups, sign, v, v + of->rates.v_belt * w->h)
                   ? INFINITE
                   : fall_of_speed(of, w, groups, sign);
    }
    if (of->mode != STICK)
        return INFINITE;
    const double *p = of->p, speed = of->rates.v_belt;
    const Hold hold = {smaller(p[P_MU_S], p[P_MU_S] + of->rates.mu_static * w->h), p[P_K2], p[P_K_NL],
                       coupling_stiffness(p), holding_force(p, w->xs[0], 0.0, speed),
                       holding_force(p, w->x, 0.0, speed) + p[P_C1] * speed * w->h,
                       0.125 * horizontal_stiffness(p) * __builtin_fabs(speed) * (w->h * w->h)};
    const Held held = keeps_holding(w, &hold);
    return held.forward && held.backward ? INFINITE : fall_of_hold(of, w, groups, &held, then);
}

/* Shorten the step to the first fall of a guard in it; `then` follows on the hold. */
INLINE Cut find_end(const Belt *of, Block *w, int groups, int stays, int64_t *then)
{
    Cut cut = may_switch(w) && find_switch(w, groups) ? AT_SWITCH : NOTHING_ENDS;
    end_step_x(w, groups, 1);
    double fall = first_fall(of, w, groups, stays, then);
    if (!comes_first(fall, w->h, cut))
        return cut;
    w->h = fall;
    end_step_y(w, groups);
    end_step_x(w, groups, 1);
    return of->mode == STICK ? AT_HOLD : AT_SPEED;
}

/* Continue the first two coefficients by a friction law of which there is no tuned recurrence. */
INLINE void expand_slipping(const Belt *of, V *x, V *y, int order)
{
#if !LAW_IS_TUNED
    if (of->mode == FORWARD)
        expand_forward(of->p, &of->rates, x, y, order);
    else
        expand_backward(of->p, &of->rates, x, y, order);
#endif
}

/* Returns whether a slider stays in motion over the belt for certain. */
INLINE int expand_step(const Belt *of, Block *w, double tol, int order, int cubic)
{
    const Law *law = of->laws + of->mode;
    w->field = of->fields[of->mode];
    if (!LAW_IS_TUNED && law->per_speed > 0.0)
        expand_slipping(of, w->xs, w->ys, order);
    else if (of->by_speed && of->mode == STICK)
        expand_holding(w->xs, w->ys, &w->field, law, order, cubic);
    else if (of->by_speed)
        expand_by_law(w->xs, w->ys, &w->field, law, of->p[P_V_BELT], &of->next, order, cubic);
    else
        expand_in_contact(w, order, cubic && of->mode != SEPARATED);
    settle_at_switch(w);
    if (w->xs[1] == of->p[P_V_BELT] && is_sliding(of->mode))
        w->xs[2] = settled_start(of, w->xs[0], w->ys[0], w->xs[2]);
    set_length(w, tol, order / 4);
    M stays = 0;
    if (law->per_speed > 0.0)
        w->h = limited(w->h, w->xs, law, law->sign * (of->p[P_V_BELT] - w->xs[1]), order / 4, &stays);
    return stays;
}

/* Find e at the end of a step, where the next one starts, while the processor has other work. */
INLINE void foresee(Belt *of, const Block *w)
{
    const Law *law = of->laws + of->mode;
    if (law->per_speed > 0.0) {
        double exponent = exponent_of(law, of->p[P_V_BELT], w->vx);
        of->next = (Start){exponent, exponential(-exponent)};
    }
}

/* Go on from the end of the step, in the mode that follows. */
INLINE Arrivals go_on_belt(Belt *of, Block *w, const Ending *ending, Cut cut, int64_t then)
{
    double stalled = w->stalled, shortest = w->longest * (SHORTEST_FLIGHT / LONGEST_STEP);
    const int creeps = of->laws[of->mode].per_speed > 0.0 && w->h < w->t * UNRESOLVED;
    Arrivals arrivals = go_on(w, ending, cut == AT_SWITCH, 1, INFINITE);
    if (((cut == AT_SPEED || cut == AT_HOLD) && w->h < shortest) || creeps) {
        w->stalled = stalled + 1.0;
        arrivals.stalled = w->stalled > MAX_STALLED;
    }
    if (cut == AT_HOLD)
        of->mode = then;
    else if (cut != NOTHING_ENDS)
        of->mode = w->side > 0.0 ? SEPARATED : mode_on_belt(of, w->x, w->vx, w->y, w->vy);
    return arrivals;
}

#endif

#if LANES == 1
INLINE void set_belt_field(Field *f, const Coefficients *c)
{
    f->a_x = c->xx, f->a_y = c->yx, f->b_x = c->xy, f->b_y = c->yy;
    f->damping_x = c->xvx, f->damping_y = c->yvy;
    f->d_x = c->friction * c->cubic, f->d_y = c->cubic, f->load = c->load;
}
#endif

/* Begin with the parameters `p` in a lane of a block that has begun; those of the belt, behind the
   others, are not read where it is not of finite speed. */
INLINE void begin_belt(Belt *of, const Block *w, int lane, const double *p, int finite)
{
    memset(of, 0, sizeof *of);
    of->finite = finite, of->nearness = BALANCED;
    memcpy(of->p, p, sizeof(double) * (size_t)(finite ? BELT_PARAMETERS : PARAMETERS));
    if (!finite)
        of->p[P_MU_S] = p[P_MU];
    of->frequency = element(&w->frequency, lane);
    of->by_speed = of->p[P_V_S] > 0.0;
#if LANES == 1
    of->next = (Start){0.0, 1.0};
    for (int mode = 0; mode < MODES; mode++) {
        const Coefficients c = coefficients_in(mode, p);
        set_belt_field(of->fields + mode, &c);
        if (!of->by_speed)
            continue;
        double sign = mode == FORWARD ? 1.0 : mode == BACKWARD ? -1.0 : 0.0;
        of->laws[mode] = (Law){sign, p[P_MU], of->p[P_MU_S] - p[P_MU],
                               sign != 0.0 ? 1.0 / p[P_V_S] : 0.0,
                               mode == SEPARATED ? 0.0 : p[P_K2] / p[P_M]};
        of->fields[mode].b_x = mode == STICK ? 0.0 : separated_coefficients(p).xy;
    }
#endif
    of->smooth = of->p[P_MU_S] == p[P_MU] || of->by_speed;
    of->mode = element(&w->side, lane) > 0.0
                   ? SEPARATED
                   : mode_on_belt(of, element(w->xs, lane), element(w->xs + 1, lane),
                                  element(w->ys, lane), element(w->ys + 1, lane));
}

#endif
