/* Many runs: each lane has a problem of its own, and takes the next one when it is done.

   The lanes are stepped block by block, each part of a step for all blocks before the next part:
   most of these are chains of operations that wait for each other, and those of several blocks
   overlap. First switches and extrema, which few of the steps have, wait in a queue, from whatever
   lanes they come, until there are LANES of them. A source file defines FINITE as 1 for belts of
   finite speed, 0 for such that are always faster. LANES is 8. */

#ifndef FIVTUI_LANES_H
#define FIVTUI_LANES_H

#include "belts.h"
#include "problem.h"
#include "search.h"

/* Enough blocks to fill the processor's queues, few enough for its first cache. */
#define BLOCKS 6
#define PLACES (BLOCKS * LANES)
#define ALL_PLACES ((UINT64_C(1) << PLACES) - 1)

enum { OF_X, OF_Y, OF_VX };
/* Guards of finite belts: μ_s P + f, and the others. */
enum { AHEAD, BEHIND, GUARDS };

/* Steps waiting for a search: where they come from, and their polynomials. */
typedef struct {
    V h, side, final, last_slope, off, c[ROWS + 2];
    Range whole, late;
    int place[LANES], quantity[LANES], count;
    unsigned in_whole, in_late, in_x, in_y;
} Queue;

typedef struct {
    Block blocks[BLOCKS];
    Queue queue;
    uint64_t occupied;
    int64_t begun, ended, member[PLACES];
    /* Where belts are of finite speed: when guards fall in the steps, and what follows on stick. */
    Belts belts[BLOCKS];
    Belt belt[PLACES];
    double falls[PLACES][GUARDS];
    int64_t then[PLACES];
} Work;

/* What is asked of a batch; `by_law` of belts of finite speed, all with a friction law. */
typedef struct {
    const double *parameters, *starts;
    const uint8_t *separation;
    double *results;
    int64_t count;
    double t_end, tol, max_steps;
    int order, cubic, amplitude, peak, steady, by_law;
} Request;

INLINE Block *block_of(Work *work, int place) { return work->blocks + place / LANES; }
INLINE Belts *belts_of(Work *work, int place) { return work->belts + place / LANES; }

/* Move a problem into another lane. */
APART void move(Work *work, int source, int target)
{
    V *from = (V *)block_of(work, source), *to = (V *)block_of(work, target);
    int one = source % LANES, other = target % LANES;
    for (size_t n = 0; n < KEPT_ROWS; n++)
        put(to + n, other, element(from + n, one));
    Block *w = block_of(work, source), *v = block_of(work, target);
    for (int n = 0; n < 2; n++) {
        put(v->xs + n, other, element(w->xs + n, one));
        put(v->ys + n, other, element(w->ys + n, one));
    }
    work->member[target] = work->member[source];
    clear(w, one);
    work->belt[target] = work->belt[source];
    copy_belt(belts_of(work, source), one, belts_of(work, target), other);
    copy_belt(NULL, 0, belts_of(work, source), one);
}

/* Begin the next problem in an empty place. */
INLINE void begin_next(Work *work, const Request *asked, int place)
{
    int64_t next = work->begun++;
    const double *p = asked->parameters + next * (FINITE ? BELT_PARAMETERS : PARAMETERS);
    Block *w = block_of(work, place);
    begin(w, place % LANES, p, asked->separation[next], asked->starts + next * 4);
    if (FINITE) {
        begin_belt(work->belt + place, w, place % LANES, p, 1);
        put_belt(belts_of(work, place), place % LANES, work->belt + place, p);
    }
    work->member[place] = next;
    work->occupied |= UINT64_C(1) << place;
}

/* Give problems to empty lanes, the first ones first; without any left, keep to as few blocks as
   can be. */
APART void refill(Work *work, const Request *asked)
{
    while (work->occupied != ALL_PLACES && work->begun < asked->count)
        begin_next(work, asked, __builtin_ctzll(~work->occupied));
    for (int place = PLACES - 1; place >= 0; place--) {
        if (!(work->occupied >> place & 1))
            continue;
        int hole = __builtin_ctzll(~work->occupied);
        if (hole / LANES >= place / LANES)
            break;
        move(work, place, hole);
        work->occupied ^= UINT64_C(1) << place | UINT64_C(1) << hole;
    }
}

/* End the waiting steps at their first switches, if there are any; returns where there are. */
APART uint64_t settle_switches(Work *work, int groups)
{
    Queue *q = &work->queue;
    uint64_t places = 0;
    unsigned found = first_switch(q->c, groups, q->side, &q->h, q->final, q->last_slope, q->off,
                                  (1u << q->count) - 1);
    q->count = 0;
    V vy = tangent_at(q->c, groups, q->h).slope, off = weighed(CUBIC_BOUND, q->c, groups, q->h);
    for (; found; found &= found - 1) {
        int slot = __builtin_ctz(found), place = q->place[slot], lane = place % LANES;
        Block *w = block_of(work, place);
        put(&w->h, lane, element(&q->h, slot));
        put(&w->y, lane, 0.0);
        put(&w->vy, lane, element(&vy, slot));
        put(&w->y_off, lane, element(&off, slot));
        places |= UINT64_C(1) << place;
    }
    return places;
}

/* The places whose steps end at a switch, out of those in which there may be one. */
INLINE uint64_t find_switches(Work *work, int groups, uint64_t near)
{
    Queue *q = &work->queue;
    uint64_t cut = 0;
    q->count = 0;
    for (; near; near &= near - 1) {
        int place = __builtin_ctzll(near), lane = place % LANES, slot = q->count++;
        const Block *w = block_of(work, place);
        q->place[slot] = place;
        put(&q->h, slot, element(&w->h, lane));
        put(&q->side, slot, element(&w->side, lane));
        put(&q->final, slot, element(&w->y, lane));
        put(&q->last_slope, slot, element(&w->vy, lane));
        put(&q->off, slot, element(&w->y_off, lane));
        for (int n = 0; n < 4 * groups + 2; n++)
            put(q->c + n, slot, element(w->ys + n, lane));
        if (q->count == LANES)
            cut |= settle_switches(work, groups);
    }
    return q->count ? cut | settle_switches(work, groups) : cut;
}

/* Say when the waiting guards fall to zero in their steps, infinite if they do not. */
APART void settle_guards(Work *work, int groups)
{
    Queue *q = &work->queue;
    Tangent end = tangent_at(q->c, groups, q->h);
    V off = weighed(CUBIC_BOUND, q->c, groups, q->h), h = q->h;
    unsigned found = first_switch(q->c, groups, splat(1.0), &h, q->final, end.slope, off,
                                  (1u << q->count) - 1);
    for (int slot = 0; slot < q->count; slot++)
        work->falls[q->place[slot]][q->quantity[slot]] =
            found >> slot & 1 ? element(&h, slot) : INFINITE;
    q->count = 0;
}

INLINE void queue_guard(Work *work, int groups, int place, int which, Guard *g)
{
    Queue *q = &work->queue;
    int slot = q->count++;
    double h = element(&block_of(work, place)->h, place % LANES);
    begin_guard(g, h);
    q->place[slot] = place, q->quantity[slot] = which;
    put(&q->h, slot, h), put(&q->final, slot, g->final);
    for (int n = 0; n < 4 * groups + 2; n++)
        put(q->c + n, slot, g->c[n]);
    if (q->count == LANES)
        settle_guards(work, groups);
}

/* End the steps in which guards fall first, some having been `cut` at switches; returns which. */
APART uint64_t find_falls(Work *work, int groups, int blocks, uint64_t cut)
{
    uint64_t sliding = 0, sticking = 0, fallen = 0;
    for (int i = 0; i < blocks; i++) {
        sliding |= (uint64_t)may_stop_sliding(work->blocks + i, work->belts + i, groups) << i * LANES;
        sticking |= (uint64_t)may_slip(work->blocks + i, work->belts + i) << i * LANES;
    }
    sliding &= work->occupied, sticking &= work->occupied;
    work->queue.count = 0;
    for (uint64_t left = sliding | sticking; left; left &= left - 1) {
        int place = __builtin_ctzll(left), lane = place % LANES;
        const Belt *of = work->belt + place;
        const Block *w = block_of(work, place);
        Guard ahead, behind;
        if (sliding >> place & 1) {
            guard_of_speed(of, w, lane, groups, of->mode == FORWARD ? 1.0 : -1.0, &ahead);
            queue_guard(work, groups, place, AHEAD, &ahead);
        } else {
            guards_of_hold(of, w, lane, groups, &ahead, &behind);
            queue_guard(work, groups, place, AHEAD, &ahead);
            queue_guard(work, groups, place, BEHIND, &behind);
        }
    }
    if (work->queue.count)
        settle_guards(work, groups);
    for (uint64_t left = sliding | sticking; left; left &= left - 1) {
        int place = __builtin_ctzll(left);
        V *h = &block_of(work, place)->h;
        const double *falls = work->falls[place];
        double fall = sliding >> place & 1
                          ? falls[AHEAD]
                          : first_release(falls[AHEAD], falls[BEHIND], work->then + place);
        Cut by = cut >> place & 1 ? AT_SWITCH : NOTHING_ENDS;
        if (!comes_first(fall, element(h, place % LANES), by))
            continue;
        put(h, place % LANES, fall);
        fallen |= UINT64_C(1) << place;
    }
    for (int i = 0; i < blocks; i++) {
        unsigned here = (unsigned)(fallen >> i * LANES) & ALL_LANES;
        if (here)
            end_shortened(work->blocks + i, mask_of(here), groups);
    }
    return fallen;
}

/* Count falls of guards that follow on each other at once, and steps that creep, as `go_on_belt`
   does. */
INLINE unsigned stall(Block *w, V before, M fell, M creeps, unsigned stalled)
{
    M brief = (fell & (w->h < w->longest * (SHORTEST_FLIGHT / LONGEST_STEP))) | creeps;
    w->stalled = choose(brief, before + 1.0, w->stalled);
    unsigned here = bits_of(brief);
    return (stalled & ~here) | (bits_of(w->stalled > MAX_STALLED) & here);
}

/* Take the modes that follow on the ends of steps. */
INLINE void change_modes(Work *work, uint64_t ended, uint64_t fallen)
{
    for (; ended; ended &= ended - 1) {
        int place = __builtin_ctzll(ended), lane = place % LANES;
        const Block *w = block_of(work, place);
        Belt *of = work->belt + place;
        if (of->mode == STICK && fallen >> place & 1)
            of->mode = work->then[place];
        else if (element(&w->side, lane) > 0.0)
            of->mode = SEPARATED;
        else
            of->mode = mode_on_belt(of, element(&w->x, lane), element(&w->vx, lane),
                                    element(&w->y, lane), element(&w->vy, lane));
        put_mode(belts_of(work, place), lane, of->mode);
    }
}

INLINE void empty(Queue *q) { q->count = 0, q->in_whole = q->in_late = q->in_x = q->in_y = 0; }

/* Take the waiting steps into the extremes of where they come from. */
APART void settle_extremes(Work *work, int groups)
{
    Queue *w = &work->queue;
    Quest q = {w->h, ends_of(w->c, groups, w->h), w->whole, w->late, w->in_whole, w->in_late};
    /* At a switch y is exactly zero. */
    q.ends.final = choose(mask_of(w->in_y), w->final, q.ends.final);
    /* Where the slider comes to the speed of the belt it has exactly that. */
    if (FINITE)
        q.ends.last_slope = choose(mask_of(w->in_x), w->last_slope, q.ends.last_slope);
    widen(w->c, groups, &q);
    for (int slot = 0; slot < w->count; slot++) {
        Extremes *seen = &block_of(work, w->place[slot])->seen;
        int lane = w->place[slot] % LANES;
        double low = element(&q.whole.low, slot), high = element(&q.whole.high, slot);
        if (w->quantity[slot] == OF_VX) {
            put(&seen->vx_high, lane, high);
        } else if (w->quantity[slot] == OF_X) {
            put(&seen->x_low, lane, low), put(&seen->x_high, lane, high);
        } else {
            put(&seen->y_low, lane, low), put(&seen->y_high, lane, high);
            put(&seen->late_low, lane, element(&q.late.low, slot));
            put(&seen->late_high, lane, element(&q.late.high, slot));
        }
    }
    empty(w);
}

INLINE void queue_extreme(Work *work, int groups, int place, int quantity, int whole, int late)
{
    Queue *q = &work->queue;
    const Block *w = block_of(work, place);
    int lane = place % LANES, slot = q->count++;
    double endless = INFINITE;
    q->place[slot] = place, q->quantity[slot] = quantity;
    q->in_whole |= (unsigned)whole << slot, q->in_late |= (unsigned)late << slot;
    put(&q->h, slot, element(&w->h, lane));
    put(&q->whole.low, slot, -endless), put(&q->whole.high, slot, endless);
    put(&q->late.low, slot, -endless), put(&q->late.high, slot, endless);
    if (quantity == OF_VX) {
        put(&q->whole.high, slot, element(&w->seen.vx_high, lane));
        for (int n = 0; n <= 4 * groups; n++)
            put(q->c + n, slot, element(w->xs + n + 1, lane) * (n + 1.0));
        put(q->c + 4 * groups + 1, slot, 0.0);
    } else {
        const V *series = quantity == OF_X ? w->xs : w->ys;
        const V *low = quantity == OF_X ? &w->seen.x_low : &w->seen.y_low;
        const V *high = quantity == OF_X ? &w->seen.x_high : &w->seen.y_high;
        put(&q->whole.low, slot, element(low, lane));
        put(&q->whole.high, slot, element(high, lane));
        if (FINITE && quantity == OF_X) {
            q->in_x |= 1u << slot;
            put(&q->last_slope, slot, element(&w->vx, lane) * element(&w->h, lane));
        }
        if (quantity == OF_Y) {
            q->in_y |= 1u << slot;
            put(&q->final, slot, element(&w->y, lane));
            put(&q->late.low, slot, element(&w->seen.late_low, lane));
            put(&q->late.high, slot, element(&w->seen.late_high, lane));
        }
        for (int n = 0; n < 4 * groups + 2; n++)
            put(q->c + n, slot, element(series + n, lane));
    }
    if (q->count == LANES)
        settle_extremes(work, groups);
}

/* Take the steps of the lanes that are live into what is wanted of the extremes. */
INLINE void observe(Work *work, const Request *asked, int groups, uint64_t live)
{
    uint64_t in_x = 0, in_whole = 0, in_late = 0, in_vx = 0;
    for (int block = 0; block < BLOCKS; block++) {
        unsigned here = (unsigned)(live >> block * LANES) & ALL_LANES, late = 0;
        int first = block * LANES;
        Block *w = work->blocks + block;
        if (!here)
            continue;
        if (asked->steady)
            late = within_second_half(w, groups, 0.5 * asked->t_end, here);
        Quest q = quest_in_y(w, asked->amplitude || asked->peak ? here : 0, late);
        in_whole |= (uint64_t)q.in_whole << first;
        in_late |= (uint64_t)q.in_late << first;
        if (asked->peak) {
            in_x |= (uint64_t)quest_in_x(w, here).in_whole << first;
            V limit = FINITE ? speed_limits(work->belts + block) : splat(INFINITE);
            in_vx |= (uint64_t)may_be_faster(w, groups, limit, here) << first;
        }
    }
    empty(&work->queue);
    for (; in_x; in_x &= in_x - 1)
        queue_extreme(work, groups, __builtin_ctzll(in_x), OF_X, 1, 0);
    for (uint64_t left = in_whole | in_late; left; left &= left - 1) {
        int place = __builtin_ctzll(left);
        queue_extreme(work, groups, place, OF_Y, in_whole >> place & 1, in_late >> place & 1);
    }
    for (; in_vx; in_vx &= in_vx - 1)
        queue_extreme(work, groups, __builtin_ctzll(in_vx), OF_VX, 1, 0);
    if (work->queue.count)
        settle_extremes(work, groups);
}

/* Expand the steps of all lanes, and choose their lengths. */
INLINE void expand_all(Work *work, const Request *asked, int groups, int blocks)
{
    Block *w = work->blocks, *end = w + blocks;
    if (FINITE) {
        for (int i = 0; i < blocks; i++)
            expand_on_belts(w + i, work->belts + i, asked->order, asked->cubic, asked->by_law);
        for (int i = 0; i < blocks; i++)
            set_length_on_belts(w + i, work->belts + i, work->belt + i * LANES, asked->tol, groups);
        return;
    }
    for (Block *b = w; b < end; b++)
        expand_field(b, &b->field, asked->order, asked->cubic);
    for (Block *b = w; b < end; b++) {
        settle_at_switch(b);
        set_length(b, asked->tol, groups);
    }
}

/* A step of all lanes. */
INLINE void step(Work *work, const Request *asked, int groups)
{
    int blocks = (__builtin_popcountll(work->occupied) + LANES - 1) / LANES;
    Block *w = work->blocks, *end = w + blocks;
    uint64_t near = 0, live = 0, done = 0, stalled = 0, halted = 0, fallen = 0, beyond = 0;
    expand_all(work, asked, groups, blocks);
    for (Block *b = w; b < end; b++)
        end_step_y(b, groups);
    for (int i = 0; i < blocks; i++)
        near |= (uint64_t)bits_of(may_switch(w + i)) << i * LANES;
    uint64_t cut = find_switches(work, groups, near & work->occupied);
    if (FINITE) {
        for (Block *b = w; b < end; b++)
            end_step_x(b, groups, 1);
        fallen = find_falls(work, groups, blocks, cut);
        cut &= ~fallen;
    }
    for (int i = 0; i < blocks; i++)
        beyond |= (uint64_t)bits_of(end_at_horizon(w + i, asked->t_end, groups)) << i * LANES;
    cut &= ~beyond, fallen &= ~beyond;
    for (Block *b = w; b < end; b++)
        end_step_x(b, groups, FINITE || asked->peak);
    for (int i = 0; i < blocks; i++)
        live |= (uint64_t)bits_of(is_sound(w + i)) << i * LANES;
    live &= work->occupied;
    if (FINITE)
        for (int i = 0; i < blocks; i++) {
            M on_belt = mask_of((unsigned)(fallen >> i * LANES) & ALL_LANES);
            on_belt |= work->belts[i].stick > 0.0;
            w[i].vx = choose(on_belt, work->belts[i].v_belt, w[i].vx);
        }
    if (asked->amplitude || asked->peak || asked->steady)
        observe(work, asked, groups, live);
    for (int i = 0; i < blocks; i++) {
        int first = i * LANES;
        M here = mask_of((unsigned)(live >> first) & ALL_LANES);
        M there = mask_of((unsigned)((cut & live) >> first) & ALL_LANES);
        unsigned falling = (unsigned)((fallen & live) >> first) & ALL_LANES;
        M fell = mask_of(falling), ended = there | fell;
        V before = w[i].stalled;
        M creeps = mask_of(0);
        if (FINITE)
            creeps = here & (work->belts[i].law.per_speed > 0.0) & (w[i].h < w[i].t * UNRESOLVED);
        Ending ending = ending_of(w + i, asked->t_end, ended);
        Arrivals arrivals = go_on(w + i, &ending, there, here, asked->max_steps);
        if (FINITE && (falling || bits_of(creeps)))
            arrivals.stalled = stall(w + i, before, fell, creeps, arrivals.stalled);
        done |= (uint64_t)arrivals.done << first;
        stalled |= (uint64_t)arrivals.stalled << first;
        halted |= (uint64_t)arrivals.halted << first;
    }
    if (FINITE)
        change_modes(work, (cut | fallen) & live, fallen);
    uint64_t leaving = work->occupied & (~live | done | stalled | halted);
    for (; leaving; leaving &= leaving - 1) {
        int place = __builtin_ctzll(leaving);
        uint64_t bit = UINT64_C(1) << place;
        int status = done & bit      ? DONE
                     : stalled & bit ? STALLED
                     : halted & bit  ? STEP_LIMIT
                                     : OVERFLOW;
        Block *b = block_of(work, place);
        write_result(b, place % LANES, status, asked->results + work->member[place] * RESULTS);
        clear(b, place % LANES);
        copy_belt(NULL, 0, belts_of(work, place), place % LANES);
        work->ended++;
        work->occupied ^= bit;
    }
}

/* Go on until all are ended or `budget` steps of all lanes are made; returns the runs ended, those
   under way counted by the part of the horizon behind them. */
INLINE double advance(Work *work, const Request *asked, int64_t budget)
{
    while (budget-- > 0) {
        if (work->occupied != ALL_PLACES)
            refill(work, asked);
        if (!work->occupied)
            break;
        step(work, asked, asked->order / 4);
    }
    double behind = (double)work->ended;
    for (uint64_t left = work->occupied; left; left &= left - 1) {
        int place = __builtin_ctzll(left);
        behind += OF(block_of(work, place), t, place % LANES) / asked->t_end;
    }
    return behind;
}

#endif
