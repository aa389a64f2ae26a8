/* Many runs: each lane has one problem, and starts the next one when that has ended.

   Each part of a step is done for all blocks before the next part, so that their chains of
   dependent operations overlap. First switches and extrema, which are rare, are collected from all
   lanes in a queue until there are LANES of them.

   A slot is a lane of one of the blocks; its number is block · LANES + lane, and sets of slots are
   bits. A source file defines FINITE_BELT as 1 for belts of finite speed, and as 0 for belts that
   are always faster. LANES is 8. */

#ifndef FIVTUI_LANES_H
#define FIVTUI_LANES_H

#include "belts.h"
#include "problem.h"
#include "search.h"

/* Enough blocks to keep the processor busy, few enough for its first-level cache. */
#define BLOCKS 6
#define SLOTS (BLOCKS * LANES)
#define SLOT_BIT(slot) (UINT64_C(1) << (slot))
#define ALL_SLOTS (SLOT_BIT(SLOTS) - 1)

/* Quantities whose extremes are searched. */
enum { OF_X, OF_Y, OF_VX };
/* Indices of guards of finite belts: of μ_s P + f BACKWARD_SLIP, of μ_s P − f FORWARD_SLIP. A
   slider that slides has only the guard ±v_r, also at FORWARD_SLIP. */
enum { FORWARD_SLIP, BACKWARD_SLIP, GUARDS };

/* Steps that wait for a search, one in each lane: their slots, and for a quantity or guard its
   polynomial, its value and slope at the end, and its ranges so far. In a search for extremes
   slopes are times h, in one for switches they are not. In `y_lanes` the value at the end is that
   of the block, not of the polynomial; in `x_lanes` the slope is. */
typedef struct {
    V h, side, end, end_slope, error, c[SERIES_LENGTH];
    Range full, second_half;
    int slot[LANES], quantity[LANES], count;
    unsigned full_lanes, second_half_lanes, x_lanes, y_lanes;
} Queue;

/* Memory of a batch: blocks, the occupied slots, numbers of begun and ended problems, and the
   problem (`member`) in each slot. */
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

/* Inputs of a batch. `cubic` says that all members have a cubic contact spring, `by_law` that all
   have a friction law. Requested extremes: those of y (`amplitude`), all (`peak`), and those of y
   in the second half (`steady`). */
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

/* The bits of a block's lanes among those of slots, and the reverse. */
INLINE unsigned lanes_of(uint64_t slots, int block)
{
    return (unsigned)(slots >> block * LANES) & ALL_LANES;
}
INLINE uint64_t slots_of(unsigned lanes, int block) { return (uint64_t)lanes << block * LANES; }

/* Move a problem to another slot. */
NOINLINE void move_problem(LaneWork *work, int source, int target)
{
    Block *from = block_at(work, source), *to = block_at(work, target);
    const V *from_rows = (const V *)from;
    V *to_rows = (V *)to;
    int source_lane = source % LANES, target_lane = target % LANES;
    /* Constants, counts and extremes of the run, and the coefficients of its mode. */
    for (size_t n = 0; n < PERSISTENT_ROWS; n++)
        set_lane(to_rows + n, target_lane, get_lane(from_rows + n, source_lane));
    /* The state: the first two coefficients of x and y. */
    for (int n = 0; n < 2; n++) {
        set_lane(to->xs + n, target_lane, get_lane(from->xs + n, source_lane));
        set_lane(to->ys + n, target_lane, get_lane(from->ys + n, source_lane));
    }
    work->member[target] = work->member[source];
    clear_lane(from, source_lane);
    work->belt[target] = work->belt[source];
    copy_lane_belt(belts_at(work, source), source_lane, belts_at(work, target), target_lane);
    copy_lane_belt(NULL, 0, belts_at(work, source), source_lane);
}

/* Begin the next problem in a free slot. */
INLINE void begin_next_problem(LaneWork *work, const Batch *batch, int slot)
{
    int64_t next = work->begun_count++;
    const double *p = batch->parameters + next * (FINITE_BELT ? BELT_PARAMETERS : PARAMETERS);
    Block *w = block_at(work, slot);
    begin_problem(w, slot % LANES, p, batch->separation[next], batch->starts + next * STATE);
    if (FINITE_BELT) {
        begin_belt(work->belt + slot, w, slot % LANES, p, 1);
        set_lane_belt(belts_at(work, slot), slot % LANES, work->belt + slot, p);
    }
    work->member[slot] = next;
    work->occupied |= SLOT_BIT(slot);
}

/* Begin problems in free slots. Without further problems, move the others into as few blocks as
   possible: from the last slot on, each to the first free slot if that is in an earlier block. */
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
        work->occupied ^= SLOT_BIT(slot) | SLOT_BIT(free_slot);
    }
}

/* Cut the queued steps at their first switches; returns the slots with a switch. */
NOINLINE uint64_t search_queued_switches(LaneWork *work, int groups)
{
    Queue *queue = &work->queue;
    uint64_t slots = 0;
    unsigned switching = find_first_switch(queue->c, groups, queue->side, &queue->h, queue->end,
                                           queue->end_slope, queue->error,
                                           (1u << queue->count) - 1);
    queue->count = 0;
    V vy = tangent_at(queue->c, groups, queue->h).slope,
        error = weighted_bound(CUBIC_BOUND, queue->c, groups, queue->h);
    for (; switching; switching &= switching - 1) {
        int item = __builtin_ctz(switching), slot = queue->slot[item], lane = slot % LANES;
        Block *w = block_at(work, slot);
        set_lane(&w->h, lane, get_lane(&queue->h, item));
        set_lane(&w->y, lane, 0.0);
        set_lane(&w->vy, lane, get_lane(&vy, item));
        set_lane(&w->y_error, lane, get_lane(&error, item));
        slots |= SLOT_BIT(slot);
    }
    return slots;
}

/* Slots whose steps end at a switch, among those that may have one. */
INLINE uint64_t find_switches(LaneWork *work, int groups, uint64_t candidates)
{
    Queue *queue = &work->queue;
    uint64_t cut = 0;
    queue->count = 0;
    for (; candidates; candidates &= candidates - 1) {
        int slot = __builtin_ctzll(candidates), lane = slot % LANES, item = queue->count++;
        const Block *w = block_at(work, slot);
        queue->slot[item] = slot;
        set_lane(&queue->h, item, get_lane(&w->h, lane));
        set_lane(&queue->side, item, get_lane(&w->side, lane));
        set_lane(&queue->end, item, get_lane(&w->y, lane));
        set_lane(&queue->end_slope, item, get_lane(&w->vy, lane));
        set_lane(&queue->error, item, get_lane(&w->y_error, lane));
        for (int n = 0; n < 4 * groups + 2; n++)
            set_lane(queue->c + n, item, get_lane(w->ys + n, lane));
        if (queue->count == LANES)
            cut |= search_queued_switches(work, groups);
    }
    return queue->count ? cut | search_queued_switches(work, groups) : cut;
}

/* Set the times at which the queued guards fall to zero, infinite if they do not. */
NOINLINE void search_queued_guards(LaneWork *work, int groups)
{
    Queue *queue = &work->queue;
    Tangent end = tangent_at(queue->c, groups, queue->h);
    V error = weighted_bound(CUBIC_BOUND, queue->c, groups, queue->h), h = queue->h;
    unsigned falling = find_first_switch(queue->c, groups, splat(1.0), &h, queue->end, end.slope,
                                         error, (1u << queue->count) - 1);
    for (int item = 0; item < queue->count; item++)
        work->fall_times[queue->slot[item]][queue->quantity[item]] =
            falling >> item & 1 ? get_lane(&h, item) : INFINITE;
    queue->count = 0;
}

/* Queue a guard, FORWARD_SLIP or BACKWARD_SLIP, of a slot; search a full queue. */
INLINE void queue_guard(LaneWork *work, int groups, int slot, int kind, Guard *guard)
{
    Queue *queue = &work->queue;
    int item = queue->count++;
    double h = get_lane(&block_at(work, slot)->h, slot % LANES);
    normalize_guard(guard, h);
    queue->slot[item] = slot, queue->quantity[item] = kind;
    set_lane(&queue->h, item, h), set_lane(&queue->end, item, guard->end);
    for (int n = 0; n < 4 * groups + 2; n++)
        set_lane(queue->c + n, item, guard->c[n]);
    if (queue->count == LANES)
        search_queued_guards(work, groups);
}

/* Cut the steps in which a guard falls to zero first; `cut` has the slots that y = 0 has cut
   already. Returns the slots. */
NOINLINE uint64_t find_falls(LaneWork *work, int groups, int blocks, uint64_t cut)
{
    uint64_t sliding = 0, sticking = 0, by_guard = 0;
    for (int i = 0; i < blocks; i++) {
        const Block *w = work->blocks + i;
        sliding |= slots_of(may_stop_sliding(w, work->belts + i, groups), i);
        sticking |= slots_of(may_slip(w, work->belts + i), i);
    }
    sliding &= work->occupied, sticking &= work->occupied;
    work->queue.count = 0;
    for (uint64_t remaining = sliding | sticking; remaining; remaining &= remaining - 1) {
        int slot = __builtin_ctzll(remaining), lane = slot % LANES;
        const Belt *belt = work->belt + slot;
        const Block *w = block_at(work, slot);
        Guard forward_guard, backward_guard;
        if (sliding >> slot & 1) {
            set_speed_guard(belt, w, lane, groups, friction_sign(belt->mode), &forward_guard);
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
        double fall_time = sliding >> slot & 1
            ? fall_times[FORWARD_SLIP]
            : first_release_time(fall_times[FORWARD_SLIP], fall_times[BACKWARD_SLIP],
                                 work->next_modes + slot);
        StepCut cause = cut >> slot & 1 ? CUT_AT_ZERO_HEIGHT : NOT_CUT;
        if (!ends_step(fall_time, get_lane(h, slot % LANES), cause))
            continue;
        set_lane(h, slot % LANES, fall_time);
        by_guard |= SLOT_BIT(slot);
    }
    for (int i = 0; i < blocks; i++) {
        unsigned lanes = lanes_of(by_guard, i);
        if (lanes)
            reevaluate_ends(work->blocks + i, mask_from_bits(lanes), groups);
    }
    return by_guard;
}

/* Count short steps to the zero of a guard, and creeping steps, as `accept_belt_step` does.
   `before` are the counts before the step; `stalled` are bits of lanes; those of the lanes with
   such steps are returned by the new counts, the others as they are. */
INLINE unsigned count_stalled(Block *w, V before, M guard_lanes, M is_creeping, unsigned stalled)
{
    M is_short = (guard_lanes & (w->h < w->max_step * SHORTEST_CUT_RATIO))
        | is_creeping;
    w->stalled = choose(is_short, before + 1.0, w->stalled);
    unsigned lanes = mask_bits(is_short);
    return (stalled & ~lanes) | (mask_bits(w->stalled > MAX_STALLED) & lanes);
}

/* Set the next modes of the slots whose steps ended a mode; those in `by_guard` did so at the zero
   of a guard. */
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

INLINE void empty_queue(Queue *queue)
{
    queue->count = 0;
    queue->full_lanes = queue->second_half_lanes = queue->x_lanes = queue->y_lanes = 0;
}

/* Extend the extremes of the slots of the queued steps. */
NOINLINE void search_queued_extremes(LaneWork *work, int groups)
{
    Queue *queue = &work->queue;
    ExtremaSearch search = {queue->h, ends_of(queue->c, groups, queue->h), queue->full,
                            queue->second_half, queue->full_lanes, queue->second_half_lanes};
    /* At a switch y is exactly zero. */
    search.ends.end = choose(mask_from_bits(queue->y_lanes), queue->end, search.ends.end);
    /* A slider that reaches the speed of the belt has exactly that speed. */
    if (FINITE_BELT)
        search.ends.end_slope =
            choose(mask_from_bits(queue->x_lanes), queue->end_slope, search.ends.end_slope);
    find_extrema(queue->c, groups, &search);
    for (int item = 0; item < queue->count; item++) {
        Extremes *extremes = &block_at(work, queue->slot[item])->extremes;
        int lane = queue->slot[item] % LANES;
        double low = get_lane(&search.full.low, item), high = get_lane(&search.full.high, item);
        if (queue->quantity[item] == OF_VX) {
            set_lane(&extremes->vx_high, lane, high);
        } else if (queue->quantity[item] == OF_X) {
            set_lane(&extremes->x_low, lane, low), set_lane(&extremes->x_high, lane, high);
        } else {
            set_lane(&extremes->y_low, lane, low), set_lane(&extremes->y_high, lane, high);
            set_lane(&extremes->second_half_low, lane, get_lane(&search.second_half.low, item));
            set_lane(&extremes->second_half_high, lane, get_lane(&search.second_half.high, item));
        }
    }
    empty_queue(queue);
}

/* Queue the search of a slot's step for extremes of x, y or ẋ, over the full run or its second
   half; search a full queue. */
INLINE void queue_extreme(LaneWork *work, int groups, int slot, int quantity, int in_full,
                          int in_second_half)
{
    Queue *queue = &work->queue;
    const Block *w = block_at(work, slot);
    const Extremes *extremes = &w->extremes;
    int lane = slot % LANES, item = queue->count++;
    double infinity = INFINITE;
    queue->slot[item] = slot, queue->quantity[item] = quantity;
    queue->full_lanes |= (unsigned)in_full << item;
    queue->second_half_lanes |= (unsigned)in_second_half << item;
    set_lane(&queue->h, item, get_lane(&w->h, lane));
    /* Ranges that no value extends; those to be searched are replaced below. */
    set_lane(&queue->full.low, item, -infinity), set_lane(&queue->full.high, item, infinity);
    set_lane(&queue->second_half.low, item, -infinity);
    set_lane(&queue->second_half.high, item, infinity);
    if (quantity == OF_VX) {
        set_lane(&queue->full.high, item, get_lane(&extremes->vx_high, lane));
        /* Coefficients of ẋ from those of x. */
        for (int n = 0; n <= 4 * groups; n++)
            set_lane(queue->c + n, item, get_lane(w->xs + n + 1, lane) * (n + 1.0));
        set_lane(queue->c + 4 * groups + 1, item, 0.0);
    } else {
        const V *series = quantity == OF_X ? w->xs : w->ys;
        const V *low = quantity == OF_X ? &extremes->x_low : &extremes->y_low;
        const V *high = quantity == OF_X ? &extremes->x_high : &extremes->y_high;
        set_lane(&queue->full.low, item, get_lane(low, lane));
        set_lane(&queue->full.high, item, get_lane(high, lane));
        if (FINITE_BELT && quantity == OF_X) {
            queue->x_lanes |= 1u << item;
            set_lane(&queue->end_slope, item, get_lane(&w->vx, lane) * get_lane(&w->h, lane));
        }
        if (quantity == OF_Y) {
            queue->y_lanes |= 1u << item;
            set_lane(&queue->end, item, get_lane(&w->y, lane));
            set_lane(&queue->second_half.low, item, get_lane(&extremes->second_half_low, lane));
            set_lane(&queue->second_half.high, item, get_lane(&extremes->second_half_high, lane));
        }
        for (int n = 0; n < 4 * groups + 2; n++)
            set_lane(queue->c + n, item, get_lane(series + n, lane));
    }
    if (queue->count == LANES)
        search_queued_extremes(work, groups);
}

/* Extend the requested extremes by the steps of some slots. */
INLINE void observe_extremes(LaneWork *work, const Batch *batch, int groups, uint64_t slots)
{
    uint64_t x_slots = 0, full_slots = 0, second_half_slots = 0, vx_slots = 0;
    for (int block = 0; block < BLOCKS; block++) {
        unsigned lanes = lanes_of(slots, block), second_half_lanes = 0;
        Block *w = work->blocks + block;
        if (!lanes)
            continue;
        if (batch->steady)
            second_half_lanes = select_second_half(w, groups, 0.5 * batch->t_end, lanes);
        unsigned full_lanes = batch->amplitude || batch->peak ? lanes : 0;
        ExtremaSearch search = search_in_y(w, full_lanes, second_half_lanes);
        full_slots |= slots_of(search.full_lanes, block);
        second_half_slots |= slots_of(search.second_half_lanes, block);
        if (batch->peak) {
            x_slots |= slots_of(search_in_x(w, lanes).full_lanes, block);
            V limit = FINITE_BELT ? speed_limits(work->belts + block) : splat(INFINITE);
            vx_slots |= slots_of(may_exceed_max_vx(w, groups, limit, lanes), block);
        }
    }
    empty_queue(&work->queue);
    for (; x_slots; x_slots &= x_slots - 1)
        queue_extreme(work, groups, __builtin_ctzll(x_slots), OF_X, 1, 0);
    uint64_t y_slots = full_slots | second_half_slots;
    for (; y_slots; y_slots &= y_slots - 1) {
        int slot = __builtin_ctzll(y_slots);
        queue_extreme(work, groups, slot, OF_Y, full_slots >> slot & 1,
                      second_half_slots >> slot & 1);
    }
    for (; vx_slots; vx_slots &= vx_slots - 1)
        queue_extreme(work, groups, __builtin_ctzll(vx_slots), OF_VX, 1, 0);
    if (work->queue.count)
        search_queued_extremes(work, groups);
}

/* Expand the steps of all lanes, and set their lengths. */
INLINE void expand_all(LaneWork *work, const Batch *batch, int groups, int blocks)
{
    Block *first = work->blocks, *end = first + blocks;
    if (FINITE_BELT) {
        for (int i = 0; i < blocks; i++)
            expand_on_belts(first + i, work->belts + i, batch->order, batch->cubic, batch->by_law);
        for (int i = 0; i < blocks; i++)
            set_length_on_belts(first + i, work->belts + i, work->belt + i * LANES, batch->tol,
                                groups);
        return;
    }
    for (Block *w = first; w < end; w++)
        expand_field(w, &w->field, batch->order, batch->cubic);
    for (Block *w = first; w < end; w++) {
        balance_vertical_forces(w);
        set_step_length(w, batch->tol, groups);
    }
}

/* Write the result of the problem in a slot, and free the slot. */
INLINE void end_problem(LaneWork *work, const Batch *batch, int slot, int status)
{
    Block *w = block_at(work, slot);
    write_result(w, slot % LANES, status, batch->results + work->member[slot] * RESULTS);
    clear_lane(w, slot % LANES);
    copy_lane_belt(NULL, 0, belts_at(work, slot), slot % LANES);
    work->ended_count++;
    work->occupied ^= SLOT_BIT(slot);
}

/* Take a step in all lanes. Sets of slots: `cut` steps end at y = 0, those in `by_guard` at the
   zero of another guard, `finite` ones have a finite end. */
INLINE void step_lanes(LaneWork *work, const Batch *batch, int groups)
{
    int blocks = (__builtin_popcountll(work->occupied) + LANES - 1) / LANES;
    Block *w = work->blocks, *end = w + blocks;
    uint64_t candidates = 0, finite = 0, by_guard = 0, clipped = 0;
    uint64_t done = 0, stalled = 0, over_limit = 0;
    expand_all(work, batch, groups, blocks);
    for (Block *b = w; b < end; b++)
        evaluate_end_y(b, groups);
    for (int i = 0; i < blocks; i++)
        candidates |= slots_of(mask_bits(may_reach_zero_height(w + i)), i);
    uint64_t cut = find_switches(work, groups, candidates & work->occupied);
    if (FINITE_BELT) {
        for (Block *b = w; b < end; b++)
            evaluate_end_x(b, groups, 1);
        by_guard = find_falls(work, groups, blocks, cut);
        cut &= ~by_guard;
    }
    for (int i = 0; i < blocks; i++)
        clipped |= slots_of(mask_bits(clip_at_horizon(w + i, batch->t_end, groups)), i);
    cut &= ~clipped, by_guard &= ~clipped;
    for (Block *b = w; b < end; b++)
        evaluate_end_x(b, groups, FINITE_BELT || batch->peak);
    for (int i = 0; i < blocks; i++)
        finite |= slots_of(mask_bits(is_finite_step(w + i)), i);
    finite &= work->occupied;
    if (FINITE_BELT)
        for (int i = 0; i < blocks; i++) {
            /* Where a guard ends slip or stick, and while it sticks, the slider has exactly the
               speed of the belt. */
            M has_belt_speed = mask_from_bits(lanes_of(by_guard, i));
            has_belt_speed |= work->belts[i].stick > 0.0;
            w[i].vx = choose(has_belt_speed, work->belts[i].v_belt, w[i].vx);
        }
    if (batch->amplitude || batch->peak || batch->steady)
        observe_extremes(work, batch, groups, finite);
    for (int i = 0; i < blocks; i++) {
        M finite_lanes = mask_from_bits(lanes_of(finite, i));
        M cut_lanes = mask_from_bits(lanes_of(cut & finite, i));
        unsigned falling = lanes_of(by_guard & finite, i);
        M guard_lanes = mask_from_bits(falling), ended_lanes = cut_lanes | guard_lanes;
        V stalled_before = w[i].stalled;
        M is_creeping = mask_from_bits(0);
        if (FINITE_BELT)
            is_creeping = finite_lanes & (work->belts[i].law.per_speed > 0.0)
                & (w[i].h < w[i].t * UNRESOLVED);
        StepEnd step_end = find_step_end(w + i, batch->t_end, ended_lanes);
        StepFlags flags = accept_step(w + i, &step_end, cut_lanes, finite_lanes, batch->max_steps);
        if (FINITE_BELT && (falling || mask_bits(is_creeping)))
            flags.stalled =
                count_stalled(w + i, stalled_before, guard_lanes, is_creeping, flags.stalled);
        done |= slots_of(flags.finished, i);
        stalled |= slots_of(flags.stalled, i);
        over_limit |= slots_of(flags.over_limit, i);
    }
    if (FINITE_BELT)
        change_modes(work, (cut | by_guard) & finite, by_guard);
    uint64_t leaving = work->occupied & (~finite | done | stalled | over_limit);
    for (; leaving; leaving &= leaving - 1) {
        int slot = __builtin_ctzll(leaving), status = OVERFLOW;
        /* Several may apply: the first of these counts. */
        if (done & SLOT_BIT(slot))
            status = DONE;
        else if (stalled & SLOT_BIT(slot))
            status = STALLED;
        else if (over_limit & SLOT_BIT(slot))
            status = STEP_LIMIT;
        end_problem(work, batch, slot, status);
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
        step_lanes(work, batch, batch->order / GROUP_SIZE);
    }
    double progress = (double)work->ended_count;
    for (uint64_t remaining = work->occupied; remaining; remaining &= remaining - 1) {
        int slot = __builtin_ctzll(remaining);
        progress += get_lane(&block_at(work, slot)->t, slot % LANES) / batch->t_end;
    }
    return progress;
}

#endif
