/* The motion while F, μ and the belt's speed change linearly with time, as in
   `fivtui.taylor.driven`: on a belt of finite speed, or one that is always faster. LANES is 1. */

#ifndef FIVTUI_DRIVEN_H
#define FIVTUI_DRIVEN_H

#include "belt.h"

/* A value from some time on, and its slope. */
typedef struct {
    double value, slope;
} Ramp;

/* F, μ, μ_s and the belt's speed from the time `since` on. */
typedef struct {
    Ramp force, friction, grip, speed;
    double since;
} Course;

INLINE double ramp_at(Ramp of, double late) { return of.value + of.slope * late; }

/* How late a time, with what it lacks of the exact one, is in a course. */
INLINE double lateness(const Course *course, double t, double rest) { return (t - course->since) + rest; }

/* The parameters at a time of a course, and their rates. */
INLINE void set_out(Belt *of, Block *w, const Course *course, double late)
{
    double *p = of->p;
    p[P_F] = ramp_at(course->force, late), p[P_MU] = ramp_at(course->friction, late);
    p[P_MU_S] = ramp_at(course->grip, late), p[P_V_BELT] = ramp_at(course->speed, late);
    w->preload = load_of(p);
    of->rates = (Rates){course->force.slope, course->friction.slope, course->grip.slope,
                        course->speed.slope};
    for (int mode = FORWARD; mode <= BACKWARD; mode++)
        of->laws[mode].mu = p[P_MU], of->laws[mode].fall = p[P_MU_S] - p[P_MU];
    of->smooth = p[P_MU_S] == p[P_MU] || of->laws[FORWARD].per_speed > 0.0;
}

/* How fast the slider slides in a mode; less than zero by rounding alone. */
INLINE double speed_by_law(const Belt *of, const Law *law, double vx)
{
    return larger(law->sign * (of->p[P_V_BELT] - vx), 0.0);
}

/* Continue the first two coefficients of x and y: Eqs. 2 and 5, without and with a friction law. */
APART void expand_driven(const Belt *of, V *x, V *y, int order)
{
    const Law *law = of->laws + of->mode;
    const Rates *rates = &of->rates;
    const double *p = of->p;
    const int touches = of->mode != SEPARATED, by_speed = law->per_speed > 0.0;
    const double sign = of->mode == BACKWARD ? -1.0 : 1.0, rate = law->sign * law->per_speed;
    const double force[2] = {load_of(p), rates->F}, mu[2] = {p[P_MU], rates->mu};
    /* μ(v) = μ + (μ_s − μ) e */
    const double fall[2] = {law->fall, rates->mu_static - rates->mu};
    double square[ROWS], contact[ROWS], e[ROWS], weight[ROWS], gap[ROWS];
    for (int n = 0; n < order; n++) {
        square[n] = product(y, y, n);
        contact[n] = touches ? -p[P_K2] * y[n] - p[P_K_NL] * product(y, square, n) : 0.0;
        double friction = mu[0] * contact[n] + (n > 0 ? mu[1] * contact[n - 1] : 0.0);
        if (by_speed) {
            e[n] = n > 0 ? rate * product(gap, e, n - 1) / n
                         : exponential(-speed_by_law(of, law, x[1]) * law->per_speed);
            weight[n] = (n < 2 ? mu[n] : 0.0) + fall[0] * e[n] + (n > 0 ? fall[1] * e[n - 1] : 0.0);
            friction = product(weight, contact, n);
        }
        double pull = coupling_stiffness(p) * (x[n] - y[n]), factor = p[P_M] * (n + 1.0) * (n + 2.0);
        double load = n < 2 ? force[n] : 0.0;
        x[n + 2] = (sign * friction - p[P_C1] * (n + 1.0) * x[n + 1] - p[P_K1] * x[n] - pull) / factor;
        if (of->mode == STICK)
            x[n + 2] = n == 0 ? 0.5 * rates->v_belt : 0.0;
        y[n + 2] = (contact[n] - load - p[P_C2] * (n + 1.0) * y[n + 1] + pull) / factor;
        /* Of ẍ less the belt's acceleration. */
        gap[n] = x[n + 2] * (n + 1.0) * (n + 2.0) - (n == 0 ? rates->v_belt : 0.0);
    }
}

/* Expand a step, `longest` at most, on a belt that has set out. */
INLINE void expand_driven_step(const Belt *of, Block *w, double tol, int order, double longest)
{
    const Law *law = of->laws + of->mode;
    w->field = of->fields[of->mode];
    if (!LAW_IS_TUNED && law->per_speed > 0.0)
        expand_slipping(of, w->xs, w->ys, order);
    else
        expand_driven(of, w->xs, w->ys, order);
    settle_at_switch(w);
    if (w->ys[0] == 0.0 && w->separation > 0.0
        && lifting_force(w->coupling, w->preload, w->xs[0]) == 0.0)
        w->ys[3] -= of->rates.F / (6.0 * of->p[P_M]);
    if (w->xs[1] == of->p[P_V_BELT] && is_sliding(of->mode))
        w->xs[2] = settled_start(of, w->xs[0], w->ys[0], w->xs[2]);
    set_length(w, tol, order / 4);
    if (law->per_speed > 0.0) {
        /* v_r changes by what the belt's speed does, too. */
        const double bend = w->xs[2];
        M stays;
        w->xs[2] -= 0.5 * of->rates.v_belt;
        w->h = limited(w->h, w->xs, law, speed_by_law(of, law, w->xs[1]), order / 4, &stays);
        w->xs[2] = bend;
    }
    w->h = smaller(w->h, longest);
}

/* 1 if the motion goes on off the belt, −1 if in contact: as `_is_off` of
   `fivtui.model.slider_belt`. */
INLINE double driven_side(const Belt *of, const Block *w)
{
    if (!(w->separation > 0.0))
        return -1.0;
    if (w->y != 0.0)
        return w->y > 0.0 ? 1.0 : -1.0;
    double force = lifting_force(w->coupling, w->preload, w->x);
    double push = w->coupling * w->vx - of->rates.F;
    double third = __builtin_fabs(push) > LEAST ? push : -(w->coupling * w->x);
    double direction = w->vy != 0.0 ? w->vy : force != 0.0 ? force : third;
    return direction > 0.0 ? 1.0 : -1.0;
}

/* Take the mode that follows on the end of a step at the time `end`, where the belt has set out. */
INLINE void take_mode(Belt *of, Block *w, double end, Cut cut, int64_t then)
{
    take_side(w, end, driven_side(of, w));
    of->mode = cut == AT_HOLD     ? then
               : w->side > 0.0    ? SEPARATED
                                  : mode_on_belt(of, w->x, w->vx, w->y, w->vy);
}

/* Begin on a course with a block and a belt that have begun. */
INLINE void begin_driven(Belt *of, Block *w, const Course *course)
{
    w->x = w->xs[0], w->vx = w->xs[1], w->y = w->ys[0], w->vy = w->ys[1];
    set_out(of, w, course, lateness(course, w->t, w->rest));
    w->side = driven_side(of, w);
    set_field(w);
    of->mode = w->side > 0.0 ? SEPARATED : mode_on_belt(of, w->x, w->vx, w->y, w->vy);
}

/* Go on from the end of a step, up to which the belt came to a speed, and from which on it follows
   `course`. Where that is another one (`bends`), the mode is another one, perhaps, without a cut. */
INLINE Arrivals go_on_driven(Belt *of, Block *w, const Ending *ending, Cut cut, int64_t then,
                             double speed, const Course *course, int bends)
{
    double stalled = w->stalled, shortest = w->longest * (SHORTEST_FLIGHT / LONGEST_STEP);
    if (cut == AT_SPEED || of->mode == STICK)
        w->vx = speed;
    Arrivals arrivals = go_on(w, ending, 0, 1, INFINITE);
    if (cut != NOTHING_ENDS && w->h < shortest) {
        w->stalled = stalled + 1.0;
        arrivals.stalled = w->stalled > MAX_STALLED;
    }
    set_out(of, w, course, lateness(course, ending->t, ending->rest));
    if (cut != NOTHING_ENDS || bends)
        take_mode(of, w, ending->t, cut, then);
    return arrivals;
}

/* The belt's speed at the end of a step over a course. */
INLINE double last_speed(const Course *course, const Ending *ending)
{
    return ramp_at(course->speed, lateness(course, ending->t, ending->rest));
}

#endif
