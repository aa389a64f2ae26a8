/* The slider-belt model: its motion in co-simulation, its equations in model exchange. */

#include <float.h>

#include "build.h"
#include "instance.h"
#include "stepping.h"
#include "rest.h"
#include "slider_belt_table.h"

/* An importer stops within this part of the extent of the motion of a switch, on either side. */
#define AT_SWITCH 1e-8
/* `local_tolerance` in `fivtui.taylor.stepper`. */
#define LOCAL_TOLERANCE 1e-3

enum { X, Y, VX, VY, STATES };
static const uint32_t STATE_REFERENCES[STATES] = {V_x, V_y, V_vx, V_vy};
static const uint32_t DERIVATIVE_REFERENCES[STATES] = {V_vx, V_vy, V_ax, V_ay};

/* In an instance's room for a motion: `side` is 1 off the belt and −1 in contact. */
typedef struct {
    double side, separations, reattachments, last_event;
    Motion motion;
} Content;

_Static_assert(sizeof(Content) <= sizeof(double) * MOTION_ROOM, "there is no room for the motion");
_Static_assert(VARIABLE_COUNT <= (int)MOST_VARIABLES, "there is no room for the values");

static Content *content_of(Instance *i) { return (Content *)i->s.motion; }
static const Content *content_in(const Instance *i) { return (const Content *)i->s.motion; }

static const Stepping *stepping_of(Instance *i)
{
    i->stepping = i->stepping ? i->stepping : stepping();
    return i->stepping;
}

static void parameters_of(const State *s, double *p)
{
    static const uint32_t REFERENCES[PARAMETERS] = {
        V_m, V_k1, V_k2, V_k3, V_c1, V_c2, V_F, V_k_nl, V_mu,
    };
    for (int n = 0; n < PARAMETERS; n++)
        p[n] = s->values[REFERENCES[n]];
}

static const char *begin_motion(Instance *i)
{
    State *s = &i->s;
    Content *at = content_of(i);
    const double *v = s->values;
    const int separation = v[V_separation] != 0.0;
    if (v[V_finite_belt] != 0.0)
        return because(i, "finite_belt = true: must be false in the native flavour");
    double p[PARAMETERS], state[4] = {v[V_x_start], v[V_vx_start], v[V_y_start], v[V_vy_start]};
    parameters_of(s, p);
    if (v[V_start_static] != 0.0)
        resting_state(p, separation, state);
    if (!finite_number(state[2]))
        return because(i, "no equilibrium: F = %g N lifts the slider and no spring holds it "
                          "vertically; use F >= 0, a larger k3, or ignore separation", p[P_F]);
    stepping_of(i)->begin(&at->motion, p, separation, 0, state, s->start_time,
                          s->tolerance * LOCAL_TOLERANCE);
    at->side = at->motion.w.side, at->last_event = s->start_time;
    at->separations = at->reattachments = 0.0;
    s->states[X] = state[0], s->states[VX] = state[1];
    s->states[Y] = state[2], s->states[VY] = state[3];
    return NULL;
}

static const char *move_on(Instance *i, double from, double *t, int *switched)
{
    const State *s = &i->s;
    Motion *m = &content_of(i)->motion;
    const Ramp force = {s->values[V_F], s->slopes[V_F]}, mu = {s->values[V_mu], s->slopes[V_mu]};
    switch (stepping_of(i)->move(m, from, t, switched, force, mu, (Ramp){0.0, 0.0})) {
    case OVERFLOW:
        return because(i, "the motion grows beyond the floating-point range at t = %g s; it is "
                          "unbounded: consider separation, use a cubic contact, or shorten the run",
                       m->failed_at);
    case STALLED:
        return because(i, "at t = %.17g s the motion changes faster than floating-point time "
                          "resolves; use a less stiff contact, more damping or a later start",
                       m->failed_at);
    case STEP_LIMIT:
        return because(i, "the step needs too much computation, it is given up at t = %g s; use a "
                          "shorter step", m->failed_at);
    default:
        return NULL;
    }
}

static double known_until(const Instance *i)
{
    const Motion *m = &content_in(i)->motion;
    /* After a ramp the inputs are held: another motion. */
    return is_driven(m) ? -INFINITE : m->end;
}

static double part_end(Instance *i)
{
    double t = i->s.t;
    /* What goes wrong is told by the step. */
    return move_on(i, t, &t, NULL) ? INFINITE : content_in(i)->motion.end;
}

/* The state at the time reached; its mode and the switches so far, unless one is still pending. */
static void look(Instance *i)
{
    State *s = &i->s;
    Content *at = content_of(i);
    const Block *w = &at->motion.w;
    double state[4];
    stepping_of(i)->state(&at->motion, s->t, state);
    s->states[X] = state[0], s->states[VX] = state[1];
    s->states[Y] = state[2], s->states[VY] = state[3];
    if (s->is_pending)
        return;
    at->side = w->side, at->last_event = w->last;
    at->separations = w->lifts, at->reattachments = w->landings;
}

static void publish(Instance *i)
{
    if (i->type == fmi2CoSimulation)
        look(i);
    const Content *at = content_in(i);
    const double *states = i->s.states;
    double *v = i->s.values, x = states[X], y = states[Y], vx = states[VX], vy = states[VY];
    const double force = at->side < 0.0 ? -v[V_k2] * y - v[V_k_nl] * y * y * y + 0.0 : 0.0;
    const double coupling = 0.5 * v[V_k3] * (x - y);
    v[V_x] = x, v[V_vx] = vx, v[V_y] = v[V_switching] = y, v[V_vy] = vy;
    v[V_P] = force;
    v[V_friction_slider] = v[V_mu] * force, v[V_friction_belt] = -(v[V_mu] * force);
    v[V_ax] = (v[V_mu] * force - v[V_c1] * vx - v[V_k1] * x - coupling) / v[V_m];
    v[V_ay] = (force - v[V_F] - v[V_c2] * vy + coupling) / v[V_m];
    v[V_mode] = v[V_mode_integer] = v[V_mode_enumeration] = at->side < 0.0;
    v[V_separations] = at->separations, v[V_reattachments] = at->reattachments;
    v[V_switches] = at->separations + at->reattachments;
    v[V_last_event] = at->last_event;
}

/* y, and where that is zero the side on which the motion goes on. */
static void indicate(const Instance *i, double *indicators)
{
    const double y = i->s.states[Y];
    indicators[0] = y != 0.0 ? y : content_in(i)->side * DBL_MIN;
}

static double largest(double a, double b) { return a > b ? a : b; }

static int settle(Instance *i)
{
    State *s = &i->s;
    Content *at = content_of(i);
    double p[PARAMETERS], state[4] = {s->states[X], s->states[VX], s->states[Y], s->states[VY]};
    Block w;
    parameters_of(s, p);
    begin(&w, 0, p, s->values[V_separation] != 0.0, state);
    const double speed = largest(absolute(state[1]), absolute(state[3])) / w.frequency;
    const double place = largest(absolute(state[0]), absolute(state[2]));
    const int near = absolute(state[2]) <= AT_SWITCH * largest(w.deflection, largest(place, speed));
    if (near) {
        /* The sign of y is rounding; the direction of the motion decides. */
        state[2] = 0.0;
        begin(&w, 0, p, s->values[V_separation] != 0.0, state);
    }
    if (w.side == at->side)
        return 0;
    at->side = w.side, at->last_event = s->t, s->states[Y] = state[2];
    *(w.side > 0.0 ? &at->separations : &at->reattachments) += 1.0;
    return 1;
}

static void differentiate(const Instance *i, double *d)
{
    const double *v = i->s.values, y = v[V_y];
    double force = 0.0;
    if (content_in(i)->side < 0.0)
        force = -(v[V_k2] + 3.0 * v[V_k_nl] * y * y) * d[V_y] - d[V_k2] * y
                - d[V_k_nl] * y * y * y;
    const double friction = v[V_mu] * force + d[V_mu] * v[V_P];
    const double coupling =
        0.5 * (v[V_k3] * (d[V_x] - d[V_y]) + d[V_k3] * (v[V_x] - y));
    const double push_x = friction - v[V_c1] * d[V_vx] - d[V_c1] * v[V_vx] - v[V_k1] * d[V_x]
                          - d[V_k1] * v[V_x] - coupling;
    const double push_y = force - d[V_F] - v[V_c2] * d[V_vy] - d[V_c2] * v[V_vy] + coupling;
    d[V_P] = force, d[V_switching] = d[V_y];
    d[V_friction_slider] = friction, d[V_friction_belt] = -friction;
    d[V_ax] = (push_x - v[V_ax] * d[V_m]) / v[V_m];
    d[V_ay] = (push_y - v[V_ay] * d[V_m]) / v[V_m];
}

/* As `static_start_change` in `fivtui.model.slider_belt`. */
static void differentiate_start(const Instance *i, double *d)
{
    const double *v = i->s.values;
    d[V_x] = d[V_x_start], d[V_vx] = d[V_vx_start];
    d[V_y] = d[V_y_start], d[V_vy] = d[V_vy_start];
    if (v[V_start_static] == 0.0)
        return;
    const double y = v[V_y], h = 0.5 * v[V_k3], dh = 0.5 * d[V_k3], a = v[V_k1] + h;
    const int off = v[V_separation] != 0.0 && v[V_F] < 0.0;
    const double k2 = off ? 0.0 : v[V_k2], dk2 = off ? 0.0 : d[V_k2];
    const double k_nl = off ? 0.0 : v[V_k_nl], dk_nl = off ? 0.0 : d[V_k_nl];
    const double push = d[V_F] + dk2 * y + dk_nl * y * y * y
                        + y * (dh * v[V_k1] * v[V_k1] + d[V_k1] * h * h) / (a * a);
    d[V_y] = -push / (3.0 * k_nl * y * y + k2 + h * v[V_k1] / a);
    d[V_x] = h * d[V_y] / a + y * (dh * v[V_k1] - d[V_k1] * h) / (a * a);
    d[V_vx] = d[V_vy] = 0.0;
}

enum {
    N_SIDE, N_SEPARATIONS, N_REATTACHMENTS, N_LAST_EVENT,
    N_T, N_REST, N_STEP_SIDE, N_STALLED, N_LIFTS, N_LANDINGS, N_LAST, N_X, N_VX, N_Y, N_VY,
    N_STEPPED, N_SINCE, N_F, N_F_SLOPE, N_MU, N_MU_SLOPE, NUMBERS
};
_Static_assert(NUMBERS <= MOTION_NUMBERS, "there is no room for the numbers");

static void pack(const Instance *i, double *n)
{
    const Content *at = content_in(i);
    const Motion *m = &at->motion;
    const Block *w = &m->w;
    n[N_SIDE] = at->side, n[N_SEPARATIONS] = at->separations;
    n[N_REATTACHMENTS] = at->reattachments, n[N_LAST_EVENT] = at->last_event;
    n[N_T] = w->t, n[N_REST] = w->rest, n[N_STEP_SIDE] = w->side, n[N_STALLED] = w->stalled;
    n[N_LIFTS] = w->lifts, n[N_LANDINGS] = w->landings, n[N_LAST] = w->last;
    n[N_X] = w->xs[0], n[N_VX] = w->xs[1], n[N_Y] = w->ys[0], n[N_VY] = w->ys[1];
    n[N_STEPPED] = m->stepped, n[N_SINCE] = m->since;
    n[N_F] = m->force.value, n[N_F_SLOPE] = m->force.slope;
    n[N_MU] = m->friction.value, n[N_MU_SLOPE] = m->friction.slope;
}

static int is_side(double side, int separation)
{
    return side == -1.0 || (side == 1.0 && separation);
}

static int unpack(Instance *i, const double *n)
{
    State *s = &i->s;
    Content *at = content_of(i);
    Motion *m = &at->motion;
    Block *w = &m->w;
    const Stepping *stepping = stepping_of(i);
    const int separation = s->values[V_separation] != 0.0;
    const double state[4] = {n[N_X], n[N_VX], n[N_Y], n[N_VY]};
    double p[PARAMETERS];
    parameters_of(s, p);
    p[P_F] = n[N_F], p[P_MU] = n[N_MU];
    at->side = n[N_SIDE], at->separations = n[N_SEPARATIONS];
    at->reattachments = n[N_REATTACHMENTS], at->last_event = n[N_LAST_EVENT];
    stepping->begin(m, p, separation, 0, state, n[N_T], s->tolerance * LOCAL_TOLERANCE);
    if (!is_side(n[N_SIDE], separation) || !is_side(n[N_STEP_SIDE], separation))
        return 0;
    w->rest = n[N_REST], w->side = n[N_STEP_SIDE], w->stalled = n[N_STALLED];
    w->lifts = n[N_LIFTS], w->landings = n[N_LANDINGS], w->last = n[N_LAST];
    set_field(w);
    m->since = n[N_SINCE], m->force.slope = n[N_F_SLOPE], m->friction.slope = n[N_MU_SLOPE];
    if (i->type == fmi2ModelExchange || n[N_STEPPED] == 0.0)
        return i->type == fmi2ModelExchange || s->t == w->t;
    return stepping->again(m) == RUNNING && s->t >= w->t && s->t < m->end;
}

const Component COMPONENT = {
    .guid = SLIDER_BELT_GUID,
    .variables = TABLE,
    .variable_count = VARIABLE_COUNT,
    .states = STATE_REFERENCES,
    .derivatives = DERIVATIVE_REFERENCES,
    .state_count = STATES,
    .indicator_count = 1,
    .begin = begin_motion,
    .move = move_on,
    .known_until = known_until,
    .part_end = part_end,
    .publish = publish,
    .indicate = indicate,
    .settle = settle,
    .differentiate = differentiate,
    .differentiate_start = differentiate_start,
    .pack = pack,
    .unpack = unpack,
};
