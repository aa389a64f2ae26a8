/* Many runs: each lane has a problem of its own, and takes the next one when it is done.

   The lanes are stepped block by block, each part of a step for all blocks before the next part:
   most of these are chains of operations that wait for each other, and those of several blocks
   overlap. First switches and extrema, which few of the steps have, wait in a queue, from whatever
   lanes they come, until there are LANES of them. */

#define LANES 8
#include "problem.h"
#include "rest.h"
#include "search.h"
#include "variant.h"

/* Enough blocks to fill the processor's queues, few enough for its first cache. */
#define BLOCKS 6
#define PLACES (BLOCKS * LANES)
#define ALL_PLACES ((UINT64_C(1) << PLACES) - 1)

enum { OF_X, OF_Y, OF_VX };

/* Steps waiting for a search: where they come from, and their polynomials. */
typedef struct {
    V h, side, final, last_slope, off, c[ROWS + 2];
    Range whole, late;
    int place[LANES], quantity[LANES], count;
    unsigned in_whole, in_late, in_y;
} Queue;

typedef struct {
    Block blocks[BLOCKS];
    Queue queue;
    uint64_t occupied;
    int64_t begun, ended, member[PLACES];
} Work;

/* What is asked of a batch. */
typedef struct {
    const double *parameters, *starts;
    const uint8_t *separation;
    double *results;
    int64_t count;
    double t_end, tol, max_steps;
    int order, cubic, amplitude, peak, steady;
} Request;

INLINE Block *block_of(Work *work, int place) { return work->blocks + place / LANES; }

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
}

/* Give problems to empty lanes, the first ones first; without any left, keep to as few blocks as
   can be. */
APART void refill(Work *work, const Request *asked)
{
    while (work->occupied != ALL_PLACES && work->begun < asked->count) {
        int place = __builtin_ctzll(~work->occupied);
        int64_t next = work->begun++;
        begin(block_of(work, place), place % LANES, asked->parameters + next * PARAMETERS,
              asked->separation[next], asked->starts + next * 4);
        work->member[place] = next;
        work->occupied |= UINT64_C(1) << place;
    }
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

APART void expand_block(Block *w, int order, int cubic)
{
    if (cubic)
        expand(w->xs, w->ys, &w->field, order, 1);
    else
        expand(w->xs, w->ys, &w->field, order, 0);
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

INLINE void empty(Queue *q) { q->count = 0, q->in_whole = q->in_late = q->in_y = 0; }

/* Take the waiting steps into the extremes of where they come from. */
APART void settle_extremes(Work *work, int groups)
{
    Queue *w = &work->queue;
    Quest q = {w->h, ends_of(w->c, groups, w->h), w->whole, w->late, w->in_whole, w->in_late};
    /* At a switch y is exactly zero. */
    q.ends.final = choose(mask_of(w->in_y), w->final, q.ends.final);
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
            in_vx |= (uint64_t)may_be_faster(w, groups, here) << first;
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

/* A step of all lanes. */
INLINE void step(Work *work, const Request *asked, int groups)
{
    int blocks = (__builtin_popcountll(work->occupied) + LANES - 1) / LANES;
    Block *w = work->blocks, *end = w + blocks;
    uint64_t near = 0, live = 0, done = 0, stalled = 0, halted = 0;
    for (Block *b = w; b < end; b++)
        expand_block(b, asked->order, asked->cubic);
    for (Block *b = w; b < end; b++) {
        settle_at_switch(b);
        set_length(b, asked->tol, groups);
    }
    for (Block *b = w; b < end; b++)
        end_step_y(b, groups);
    for (int i = 0; i < blocks; i++)
        near |= (uint64_t)bits_of(may_switch(w + i)) << i * LANES;
    uint64_t cut = find_switches(work, groups, near & work->occupied);
    for (int i = 0; i < blocks; i++)
        cut &= ~((uint64_t)bits_of(end_at_horizon(w + i, asked->t_end, groups)) << i * LANES);
    for (Block *b = w; b < end; b++)
        end_step_x(b, groups, asked->peak);
    for (int i = 0; i < blocks; i++)
        live |= (uint64_t)bits_of(is_sound(w + i)) << i * LANES;
    live &= work->occupied;
    if (asked->amplitude || asked->peak || asked->steady)
        observe(work, asked, groups, live);
    for (int i = 0; i < blocks; i++) {
        int first = i * LANES;
        M here = mask_of((unsigned)(live >> first) & ALL_LANES);
        M there = mask_of((unsigned)((cut & live) >> first) & ALL_LANES);
        Ending ending = ending_of(w + i, asked->t_end, there);
        Arrivals arrivals = go_on(w + i, &ending, there, here, asked->max_steps);
        done |= (uint64_t)arrivals.done << first;
        stalled |= (uint64_t)arrivals.stalled << first;
        halted |= (uint64_t)arrivals.halted << first;
    }
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
        work->ended++;
        work->occupied ^= bit;
    }
}

/* Bytes of the work; it has to be zero at first, and begin at a multiple of 64 bytes. */
EXPORT int64_t NAME(batch_size)(void) { return sizeof(Work); }

/* Go on with runs until all `count` are ended or `budget` steps of all lanes are made.

   The rows of `parameters` are parameter sets, all with k_nl > 0 (`cubic`) or all with k_nl = 0, those
   of `starts` states (x, ẋ, y, ẏ); `results` receives the rows of results. Wanted are extremes of
   y (`amplitude`), all extremes (`peak`), those of y after half the horizon (`steady`). Returns the
   runs ended, those under way counted by the part of the horizon behind them. */
EXPORT double NAME(batch_advance)(Work *work, const double *parameters, const uint8_t *separation,
                                  const double *starts, double *results, int64_t count,
                                  double t_end, double tol, double max_steps, int64_t order,
                                  int64_t cubic, int64_t amplitude, int64_t peak, int64_t steady,
                                  int64_t budget)
{
    const Request asked = {parameters, starts, separation, results, count, t_end, tol, max_steps,
                           (int)order, cubic != 0, amplitude != 0, peak != 0, steady != 0};
    while (budget-- > 0) {
        if (work->occupied != ALL_PLACES)
            refill(work, &asked);
        if (!work->occupied)
            break;
        step(work, &asked, (int)order / 4);
    }
    double behind = (double)work->ended;
    for (uint64_t left = work->occupied; left; left &= left - 1) {
        int place = __builtin_ctzll(left);
        behind += OF(block_of(work, place), t, place % LANES) / t_end;
    }
    return behind;
}

/* Whether all are ended. */
EXPORT int64_t NAME(batch_ended)(const Work *work) { return work->ended; }

/* The states at rest at the equilibria of μ = 0, infinite where there is none. */
EXPORT void NAME(static_starts)(const double *parameters, const uint8_t *separation,
                                double *starts, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        resting_state(parameters + i * PARAMETERS, separation[i], starts + 4 * i);
}
