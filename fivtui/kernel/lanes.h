/* Many runs: each lane has one problem, and starts the next one when that has ended.

   Each part of a step is done for all blocks before the next part, so that their chains of
   dependent operations overlap. First switches and extrema, which are rare, are collected from all
   lanes in a queue until there are LANES of them. A slot is a lane of one of the blocks. A source
   file defines FINITE as 1 for belts of finite speed, and as 0 for belts that are always faster.
   LANES is 8. */

#ifndef FIVTUI_LANES_H
#define FIVTUI_LANES_H

#include "belts.h"
#include "problem.h"
#include "search.h"

/* Enough blocks to keep the processor busy, few enough for its first-level cache. */
#define BLOCKS 6
#define SLOTS (BLOCKS * LANES)
#define ALL_SLOTS ((UINT64_C(1) << SLOTS) - 1)

enum { OF_X, OF_Y, OF_VX };
/* Guards of finite belts: μ_s P + f is BACKWARD_SLIP, the others are FORWARD_SLIP. */
enum { FORWARD_SLIP, BACKWARD_SLIP, GUARDS };

/* Steps that wait for a search: their slots and polynomials. */
typedef struct {
    V h, side, end, end_slope, error, c[ROWS + 2];
    Range full, late;
    int slot[LANES], quantity[LANES], count;
    unsigned full_lanes, late_lanes, x_lanes, y_lanes;
} Queue;

typedef struct {
    Block blocks[BLOCKS];
    Queue queue;
    uint64_t occupied;
    int64_t begun_count, ended_count, member[SLOTS];
    /* For belts of finite speed: times at which guards fall to zero, and next modes after stick. */
    BeltLanes belts[BLOCKS];
    Belt belt[SLOTS];
    double fall_times[SLOTS][GUARDS];
    int64_t next_modes[SLOTS];
} LaneWork;

/* Inputs of a batch; `by_law` says that all members have a friction law. */
typedef struct {
    const double *parameters, *starts;
    const uint8_t *separation;
    double *results;
    int64_t count;
    double t_end, tol, max_steps;
    int order, cubic, amplitude, peak, steady, by_law;
} Batch;

INLINE Block *block_at(LaneWork *work, int slot) { return work->blocks + slot / LANES; }
INLINE BeltLanes *belts_at(LaneWork *work, int slot) { return work->belts + slot / LANES; }

/* Move a problem to another slot. */
NOINLINE void move_problem(LaneWork *work, int source, int target)
{
    V *from = (V *)block_at(work, source), *to = (V *)block_at(work, target);
    int source_lane = source % LANES, target_lane = target % LANES;
    for (size_t n = 0; n < PERSISTENT_ROWS; n++)
        set_lane(to + n, target_lane, get_lane(from + n, source_lane));
    Block *w = block_at(work, source), *v = block_at(work, target);
    for (int n = 0; n < 2; n++) {
        set_lane(v->xs + n, target_lane, get_lane(w->xs + n, source_lane));
        set_lane(v->ys + n, target_lane, get_lane(w->ys + n, source_lane));
    }
    work->member[target] = work->member[source];
    clear_lane(w, source_lane);
    work->belt[target] = work->belt[source];
    copy_lane_belt(belts_at(work, source), source_lane, belts_at(work, target), target_lane);
    copy_lane_belt(NULL, 0, belts_at(work, source), source_lane);
}

/* Begin the next problem in a free slot. */
INLINE void begin_next_problem(LaneWork *work, const Batch *batch, int slot)
{
    int64_t next = work->begun_count++;
    const double *p = batch->parameters + next * (FINITE ? BELT_PARAMETERS : PARAMETERS);
    Block *w = block_at(work, slot);
    begin_problem(w, slot % LANES, p, batch->separation[next], batch->starts + next * 4);
    if (FINITE) {
        begin_belt(work->belt + slot, w, slot % LANES, p, 1);
        set_lane_belt(belts_at(work, slot), slot % LANES, work->belt + slot, p);
    }
    work->member[slot] = next;
    work->occupied |= UINT64_C(1) << slot;
}

/* Begin problems in free slots. Without further problems, move the others into as few blocks as
   possible. */
NOINLINE void refill(LaneWork *work, const Batch *batch)
{
    while (work->occupied != ALL_SLOTS && work->begun_count < batch->count)
        begin_next_problem(work, batch, __builtin_ctzll(~work->occupied));
    for (int slot = SLOTS - 1; slot >= 0; slot--) {
        if (!(work->occupied >> slot & 1))
            continue;
        int free_slot = __builtin_ctzll(~work->occupied);
        if (free_slot / LANES >= slot / LANES)
            break;
        move_problem(work, slot, free_slot);
        work->occupied ^= UINT64_C(1) << slot | UINT64_C(1) << free_slot;
    }
}

/* Cut the queued steps at their first switches; returns the slots with a switch. */
NOINLINE uint64_t search_queued_switches(LaneWork *work, int groups)
{
    Queue *q = &work->queue;
    uint64_t slots = 0;
    unsigned found = find_first_switch(q->c, groups, q->side, &q->h, q->end, q->end_slope, q->error,
                                       (1u << q->count) - 1);
    q->count = 0;
    V vy = tangent_at(q->c, groups, q->h).slope,
        error = weighted_bound(CUBIC_BOUND, q->c, groups, q->h);
    for (; found; found &= found - 1) {
        int item = __builtin_ctz(found), slot = q->slot[item], lane = slot % LANES;
        Block *w = block_at(work, slot);
        set_lane(&w->h, lane, get_lane(&q->h, item));
        set_lane(&w->y, lane, 0.0);
        set_lane(&w->vy, lane, get_lane(&vy, item));
        set_lane(&w->y_error, lane, get_lane(&error, item));
        slots |= UINT64_C(1) << slot;
    }
    return slots;
}

/* Slots whose steps end at a switch, among those that may have one. */
INLINE uint64_t find_switches(LaneWork *work, int groups, uint64_t candidates)
{
    Queue *q = &work->queue;
    uint64_t cut = 0;
    q->count = 0;
    for (; candidates; candidates &= candidates - 1) {
        int slot = __builtin_ctzll(candidates), lane = slot % LANES, item = q->count++;
        const Block *w = block_at(work, slot);
        q->slot[item] = slot;
        set_lane(&q->h, item, get_lane(&w->h, lane));
        set_lane(&q->side, item, get_lane(&w->side, lane));
        set_lane(&q->end, item, get_lane(&w->y, lane));
        set_lane(&q->end_slope, item, get_lane(&w->vy, lane));
        set_lane(&q->error, item, get_lane(&w->y_error, lane));
        for (int n = 0; n < 4 * groups + 2; n++)
            set_lane(q->c + n, item, get_lane(w->ys + n, lane));
        if (q->count == LANES)
            cut |= search_queued_switches(work, groups);
    }
    return q->count ? cut | search_queued_switches(work, groups) : cut;
}

/* Set the times at which the queued guards fall to zero, infinite if they do not. */
NOINLINE void search_queued_guards(LaneWork *work, int groups)
{
    Queue *q = &work->queue;
    Tangent end = tangent_at(q->c, groups, q->h);
    V error = weighted_bound(CUBIC_BOUND, q->c, groups, q->h), h = q->h;
    unsigned found = find_first_switch(q->c, groups, splat(1.0), &h, q->end, end.slope, error,
                                       (1u << q->count) - 1);
    for (int item = 0; item < q->count; item++)
        work->fall_times[q->slot[item]][q->quantity[item]] =
            found >> item & 1 ? get_lane(&h, item) : INFINITE;
    q->count = 0;
}

INLINE void queue_guard(LaneWork *work, int groups, int slot, int guard, Guard *g)
{
    Queue *q = &work->queue;
    int item = q->count++;
    double h = get_lane(&block_at(work, slot)->h, slot % LANES);
    normalize_guard(g, h);
    q->slot[item] = slot, q->quantity[item] = guard;
    set_lane(&q->h, item, h), set_lane(&q->end, item, g->end);
    for (int n = 0; n < 4 * groups + 2; n++)
        set_lane(q->c + n, item, g->c[n]);
    if (q->count == LANES)
        search_queued_guards(work, groups);
}

/* Cut the steps in which a guard falls to zero before y = 0, which `cut` has; returns the slots. */
NOINLINE uint64_t find_falls(LaneWork *work, int groups, int blocks, uint64_t cut)
{
    uint64_t sliding = 0, sticking = 0, by_guard = 0;
    for (int i = 0; i < blocks; i++) {
        const Block *w = work->blocks + i;
        sliding |= (uint64_t)may_stop_sliding(w, work->belts + i, groups) << i * LANES;
        sticking |= (uint64_t)may_slip(w, work->belts + i) << i * LANES;
    }
    sliding &= work->occupied, sticking &= work->occupied;
    work->queue.count = 0;
    for (uint64_t remaining = sliding | sticking; remaining; remaining &= remaining - 1) {
        int slot = __builtin_ctzll(remaining), lane = slot % LANES;
        const Belt *belt = work->belt + slot;
        const Block *w = block_at(work, slot);
        Guard forward_guard, backward_guard;
        if (sliding >> slot & 1) {
            set_speed_guard(belt, w, lane, groups, belt->mode == FORWARD ? 1.0 : -1.0,
                            &forward_guard);
            queue_guard(work, groups, slot, FORWARD_SLIP, &forward_guard);
        } else {
            set_hold_guards(belt, w, lane, groups, &forward_guard, &backward_guard);
            queue_guard(work, groups, slot, FORWARD_SLIP, &forward_guard);
            queue_guard(work, groups, slot, BACKWARD_SLIP, &backward_guard);
        }
    }
    if (work->queue.count)
        search_queued_guards(work, groups);
    for (uint64_t remaining = sliding | sticking; remaining; remaining &= remaining - 1) {
        int slot = __builtin_ctzll(remaining);
        V *h = &block_at(work, slot)->h;
        const double *fall_times = work->fall_times[slot];
        double fall = sliding >> slot & 1
                          ? fall_times[FORWARD_SLIP]
                          : first_release_time(fall_times[FORWARD_SLIP], fall_times[BACKWARD_SLIP],
                                               work->next_modes + slot);
        StepCut cause = cut >> slot & 1 ? CUT_AT_SWITCH : NOT_CUT;
        if (!ends_step(fall, get_lane(h, slot % LANES), cause))
            continue;
        set_lane(h, slot % LANES, fall);
        by_guard |= UINT64_C(1) << slot;
    }
    for (int i = 0; i < blocks; i++) {
        unsigned lanes = (unsigned)(by_guard >> i * LANES) & ALL_LANES;
        if (lanes)
            reevaluate_ends(work->blocks + i, mask_from_bits(lanes), groups);
    }
    return by_guard;
}

/* Count short steps to the zero of a guard, and creeping steps, as `accept_belt_step` does. */
INLINE unsigned count_stalled(Block *w, V before, M guard_lanes, M is_creeping, unsigned stalled)
{
    M is_short = (guard_lanes & (w->h < w->max_step * (SHORTEST_FLIGHT / LONGEST_STEP)))
        | is_creeping;
    w->stalled = choose(is_short, before + 1.0, w->stalled);
    unsigned lanes = mask_bits(is_short);
    return (stalled & ~lanes) | (mask_bits(w->stalled > MAX_STALLED) & lanes);
}

/* Set the next modes at the ends of steps. */
INLINE void change_modes(LaneWork *work, uint64_t ended_slots, uint64_t by_guard)
{
    for (; ended_slots; ended_slots &= ended_slots - 1) {
        int slot = __builtin_ctzll(ended_slots), lane = slot % LANES;
        const Block *w = block_at(work, slot);
        Belt *belt = work->belt + slot;
        if (belt->mode == STICK && by_guard >> slot & 1)
            belt->mode = work->next_modes[slot];
        else if (get_lane(&w->side, lane) > 0.0)
            belt->mode = SEPARATED;
        else
            belt->mode = mode_on_belt(belt, get_lane(&w->x, lane), get_lane(&w->vx, lane),
                                          get_lane(&w->y, lane), get_lane(&w->vy, lane));
        set_lane_mode(belts_at(work, slot), lane, belt->mode);
    }
}

INLINE void empty_queue(Queue *q)
{
    q->count = 0, q->full_lanes = q->late_lanes = q->x_lanes = q->y_lanes = 0;
}

/* Extend the extremes of the slots of the queued steps. */
NOINLINE void search_queued_extremes(LaneWork *work, int groups)
{
    Queue *w = &work->queue;
    ExtremaSearch q = {w->h, ends_of(w->c, groups, w->h), w->full, w->late, w->full_lanes,
                       w->late_lanes};
    /* At a switch y is exactly zero. */
    q.ends.end = choose(mask_from_bits(w->y_lanes), w->end, q.ends.end);
    /* A slider that reaches the speed of the belt has exactly that speed. */
    if (FINITE)
        q.ends.end_slope = choose(mask_from_bits(w->x_lanes), w->end_slope, q.ends.end_slope);
    find_extrema(w->c, groups, &q);
    for (int item = 0; item < w->count; item++) {
        Extremes *extremes = &block_at(work, w->slot[item])->extremes;
        int lane = w->slot[item] % LANES;
        double low = get_lane(&q.full.low, item), high = get_lane(&q.full.high, item);
        if (w->quantity[item] == OF_VX) {
            set_lane(&extremes->vx_high, lane, high);
        } else if (w->quantity[item] == OF_X) {
            set_lane(&extremes->x_low, lane, low), set_lane(&extremes->x_high, lane, high);
        } else {
            set_lane(&extremes->y_low, lane, low), set_lane(&extremes->y_high, lane, high);
            set_lane(&extremes->late_low, lane, get_lane(&q.late.low, item));
            set_lane(&extremes->late_high, lane, get_lane(&q.late.high, item));
        }
    }
    empty_queue(w);
}

INLINE void queue_extreme(LaneWork *work, int groups, int slot, int quantity, int in_full,
                          int in_late)
{
    Queue *q = &work->queue;
    const Block *w = block_at(work, slot);
    int lane = slot % LANES, item = q->count++;
    double infinity = INFINITE;
    q->slot[item] = slot, q->quantity[item] = quantity;
    q->full_lanes |= (unsigned)in_full << item, q->late_lanes |= (unsigned)in_late << item;
    set_lane(&q->h, item, get_lane(&w->h, lane));
    set_lane(&q->full.low, item, -infinity), set_lane(&q->full.high, item, infinity);
    set_lane(&q->late.low, item, -infinity), set_lane(&q->late.high, item, infinity);
    if (quantity == OF_VX) {
        set_lane(&q->full.high, item, get_lane(&w->extremes.vx_high, lane));
        for (int n = 0; n <= 4 * groups; n++)
            set_lane(q->c + n, item, get_lane(w->xs + n + 1, lane) * (n + 1.0));
        set_lane(q->c + 4 * groups + 1, item, 0.0);
    } else {
        const V *series = quantity == OF_X ? w->xs : w->ys;
        const V *low = quantity == OF_X ? &w->extremes.x_low : &w->extremes.y_low;
        const V *high = quantity == OF_X ? &w->extremes.x_high : &w->extremes.y_high;
        set_lane(&q->full.low, item, get_lane(low, lane));
        set_lane(&q->full.high, item, get_lane(high, lane));
        if (FINITE && quantity == OF_X) {
            q->x_lanes |= 1u << item;
            set_lane(&q->end_slope, item, get_lane(&w->vx, lane) * get_lane(&w->h, lane));
        }
        if (quantity == OF_Y) {
            q->y_lanes |= 1u << item;
            set_lane(&q->end, item, get_lane(&w->y, lane));
            set_lane(&q->late.low, item, get_lane(&w->extremes.late_low, lane));
            set_lane(&q->late.high, item, get_lane(&w->extremes.late_high, lane));
        }
        for (int n = 0; n < 4 * groups + 2; n++)
            set_lane(q->c + n, item, get_lane(series + n, lane));
    }
    if (q->count == LANES)
        search_queued_extremes(work, groups);
}

/* Extend the requested extremes by the steps of the live slots. */
INLINE void observe_extremes(LaneWork *work, const Batch *batch, int groups, uint64_t live)
{
    uint64_t in_x = 0, full_lanes = 0, late_lanes = 0, in_vx = 0;
    for (int block = 0; block < BLOCKS; block++) {
        unsigned lanes = (unsigned)(live >> block * LANES) & ALL_LANES, late = 0;
        int first = block * LANES;
        Block *w = work->blocks + block;
        if (!lanes)
            continue;
        if (batch->steady)
            late = select_second_half(w, groups, 0.5 * batch->t_end, lanes);
        ExtremaSearch q = search_in_y(w, batch->amplitude || batch->peak ? lanes : 0, late);
        full_lanes |= (uint64_t)q.full_lanes << first;
        late_lanes |= (uint64_t)q.late_lanes << first;
        if (batch->peak) {
            in_x |= (uint64_t)search_in_x(w, lanes).full_lanes << first;
            V limit = FINITE ? speed_limits(work->belts + block) : splat(INFINITE);
            in_vx |= (uint64_t)may_exceed_max_vx(w, groups, limit, lanes) << first;
        }
    }
    empty_queue(&work->queue);
    for (; in_x; in_x &= in_x - 1)
        queue_extreme(work, groups, __builtin_ctzll(in_x), OF_X, 1, 0);
    for (uint64_t remaining = full_lanes | late_lanes; remaining; remaining &= remaining - 1) {
        int slot = __builtin_ctzll(remaining);
        queue_extreme(work, groups, slot, OF_Y, full_lanes >> slot & 1, late_lanes >> slot & 1);
    }
    for (; in_vx; in_vx &= in_vx - 1)
        queue_extreme(work, groups, __builtin_ctzll(in_vx), OF_VX, 1, 0);
    if (work->queue.count)
        search_queued_extremes(work, groups);
}

/* Expand the steps of all lanes, and set their lengths. */
INLINE void expand_all(LaneWork *work, const Batch *batch, int groups, int blocks)
{
    Block *w = work->blocks, *end = w + blocks;
    if (FINITE) {
        for (int i = 0; i < blocks; i++)
            expand_on_belts(w + i, work->belts + i, batch->order, batch->cubic, batch->by_law);
        for (int i = 0; i < blocks; i++)
            set_length_on_belts(w + i, work->belts + i, work->belt + i * LANES, batch->tol, groups);
        return;
    }
    for (Block *b = w; b < end; b++)
        expand_field(b, &b->field, batch->order, batch->cubic);
    for (Block *b = w; b < end; b++) {
        balance_at_switch(b);
        set_step_length(b, batch->tol, groups);
    }
}

/* Take a step in all lanes. */
INLINE void step_lanes(LaneWork *work, const Batch *batch, int groups)
{
    int blocks = (__builtin_popcountll(work->occupied) + LANES - 1) / LANES;
    Block *w = work->blocks, *end = w + blocks;
    uint64_t candidates = 0, live = 0, done = 0, stalled = 0, halted = 0, by_guard = 0, clipped = 0;
    expand_all(work, batch, groups, blocks);
    for (Block *b = w; b < end; b++)
        evaluate_end_y(b, groups);
    for (int i = 0; i < blocks; i++)
        candidates |= (uint64_t)mask_bits(may_switch(w + i)) << i * LANES;
    uint64_t cut = find_switches(work, groups, candidates & work->occupied);
    if (FINITE) {
        for (Block *b = w; b < end; b++)
            evaluate_end_x(b, groups, 1);
        by_guard = find_falls(work, groups, blocks, cut);
        cut &= ~by_guard;
    }
    for (int i = 0; i < blocks; i++)
        clipped |= (uint64_t)mask_bits(clip_at_horizon(w + i, batch->t_end, groups)) << i * LANES;
    cut &= ~clipped, by_guard &= ~clipped;
    for (Block *b = w; b < end; b++)
        evaluate_end_x(b, groups, FINITE || batch->peak);
    for (int i = 0; i < blocks; i++)
        live |= (uint64_t)mask_bits(is_finite_step(w + i)) << i * LANES;
    live &= work->occupied;
    if (FINITE)
        for (int i = 0; i < blocks; i++) {
            M on_belt = mask_from_bits((unsigned)(by_guard >> i * LANES) & ALL_LANES);
            on_belt |= work->belts[i].stick > 0.0;
            w[i].vx = choose(on_belt, work->belts[i].v_belt, w[i].vx);
        }
    if (batch->amplitude || batch->peak || batch->steady)
        observe_extremes(work, batch, groups, live);
    for (int i = 0; i < blocks; i++) {
        int first = i * LANES;
        M live_lanes = mask_from_bits((unsigned)(live >> first) & ALL_LANES);
        M cut_lanes = mask_from_bits((unsigned)((cut & live) >> first) & ALL_LANES);
        unsigned falling = (unsigned)((by_guard & live) >> first) & ALL_LANES;
        M guard_lanes = mask_from_bits(falling), ended_lanes = cut_lanes | guard_lanes;
        V before = w[i].stalled;
        M is_creeping = mask_from_bits(0);
        if (FINITE)
            is_creeping = live_lanes & (work->belts[i].law.per_speed > 0.0)
                & (w[i].h < w[i].t * UNRESOLVED);
        StepEnd step_end = find_step_end(w + i, batch->t_end, ended_lanes);
        StepFlags flags = accept_step(w + i, &step_end, cut_lanes, live_lanes, batch->max_steps);
        if (FINITE && (falling || mask_bits(is_creeping)))
            flags.stalled = count_stalled(w + i, before, guard_lanes, is_creeping, flags.stalled);
        done |= (uint64_t)flags.finished << first;
        stalled |= (uint64_t)flags.stalled << first;
        halted |= (uint64_t)flags.over_limit << first;
    }
    if (FINITE)
        change_modes(work, (cut | by_guard) & live, by_guard);
    uint64_t leaving = work->occupied & (~live | done | stalled | halted);
    for (; leaving; leaving &= leaving - 1) {
        int slot = __builtin_ctzll(leaving);
        uint64_t bit = UINT64_C(1) << slot;
        int status = done & bit      ? DONE
                     : stalled & bit ? STALLED
                     : halted & bit  ? STEP_LIMIT
                                     : OVERFLOW;
        Block *b = block_at(work, slot);
        write_result(b, slot % LANES, status, batch->results + work->member[slot] * RESULTS);
        clear_lane(b, slot % LANES);
        copy_lane_belt(NULL, 0, belts_at(work, slot), slot % LANES);
        work->ended_count++;
        work->occupied ^= bit;
    }
}

/* Continue until all runs have ended or after `budget` steps of all lanes; returns the number of
   ended runs plus the computed fractions of the others. */
INLINE double advance_batch(LaneWork *work, const Batch *batch, int64_t budget)
{
    while (budget-- > 0) {
        if (work->occupied != ALL_SLOTS)
            refill(work, batch);
        if (!work->occupied)
            break;
        step_lanes(work, batch, batch->order / 4);
    }
    double progress = (double)work->ended_count;
    for (uint64_t remaining = work->occupied; remaining; remaining &= remaining - 1) {
        int slot = __builtin_ctzll(remaining);
        progress += LANE(block_at(work, slot), t, slot % LANES) / batch->t_end;
    }
    return progress;
}

#endif
