/* The native stepping as functions of a library, for tests that call it without an FMU around it. */

#include "../../fmu_src/native/stepping.c"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { MODE, LIFTS, LANDINGS, STICKS, SLIPS, REVERSALS, CHANGED_AT, END, SEEN };

EXPORT int64_t motion_size(void) { return sizeof(Motion); }

EXPORT void motion_begin(Motion *m, const double *p, int64_t separation, int64_t finite_belt,
                         const double *state, double t, double tol)
{
    stepping_baseline.begin(m, p, separation != 0, finite_belt != 0, state, t, tol);
}

/* `ramps` has value and slope of force, friction and speed; returns the status, and in `reached` the
   time and whether a switch ended the move. */
EXPORT int64_t motion_move(Motion *m, double from, double to, const double *ramps, int64_t to_switch,
                           double *reached)
{
    int switched = 0;
    int status = stepping_baseline.move(m, from, &to, to_switch ? &switched : NULL,
                                        (Ramp){ramps[0], ramps[1]}, (Ramp){ramps[2], ramps[3]},
                                        (Ramp){ramps[4], ramps[5]});
    reached[0] = to, reached[1] = switched;
    return status;
}

EXPORT void motion_state(const Motion *m, double t, double *state)
{
    stepping_baseline.state(m, t, state);
}

EXPORT void motion_look(const Motion *m, double *seen)
{
    seen[MODE] = mode_of_motion(m), seen[LIFTS] = m->w.lifts, seen[LANDINGS] = m->w.landings;
    seen[STICKS] = m->sticks, seen[SLIPS] = m->slips, seen[REVERSALS] = m->reversals;
    seen[CHANGED_AT] = m->changed_at, seen[END] = m->end;
}

/* Another motion from what of this one is to be saved. */
EXPORT int64_t motion_restore(const Motion *saved, Motion *m)
{
    const Block *w = &saved->w;
    const double state[4] = {w->xs[0], w->xs[1], w->ys[0], w->ys[1]};
    stepping_baseline.begin(m, saved->p, saved->separation != 0.0, (int)saved->belt.finite, state,
                            w->t, saved->tol);
    m->w.rest = w->rest, m->w.side = w->side, m->w.stalled = w->stalled;
    m->w.lifts = w->lifts, m->w.landings = w->landings, m->w.last = w->last;
    set_field(&m->w);
    m->belt.mode = saved->belt.mode, m->since = saved->since;
    m->force.slope = saved->force.slope, m->friction.slope = saved->friction.slope;
    m->speed.slope = saved->speed.slope;
    m->sticks = saved->sticks, m->slips = saved->slips, m->reversals = saved->reversals;
    m->changed_at = saved->changed_at;
    return stepping_baseline.again(m);
}
