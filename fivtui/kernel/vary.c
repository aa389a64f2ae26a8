/* One run with its derivatives: by start, by parameters, by whatever both depend on. */

#define LANES 1
#include "run.h"

#include "deviations.h"
#include "variant.h"

/* The numbers of `Extremes`, in its order: of what each is an extreme, and which. */
enum { OF_X, OF_VX, OF_Y };
#define EXTREMES ((int)(sizeof(Extremes) / sizeof(V)))
static const int QUANTITY[] = {OF_X, OF_X, OF_Y, OF_Y, OF_VX, OF_Y, OF_Y};
static const double SIGN[] = {-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0};
#define FIRST_LATE 5

/* `cubic` is whether y³ plays a part in contact; `now` are the deviations, `moments` the times of the
   extremes so far, and `by` their derivatives. */
typedef struct {
    Run run;
    int64_t count, eights, cubic;
    Change changes[MODES][EIGHTS];
    Deviation now[EIGHTS];
    double moments[sizeof(Extremes) / sizeof(V)];
    Eight by[sizeof(Extremes) / sizeof(V)][EIGHTS];
} Varied;

/* What a call gives back behind the columns of a result: crossings in the buffer, ẍ and ÿ. */
enum { R_CROSSINGS = RESULTS, R_AX, R_AY };

/* A crossing before its deviations: time, x, ẋ, y, ẏ, and the mode after it. */
#define CROSSING_HEAD 6
#define STATE 4

/* Where on [from, h] a polynomial is greatest, or with the sign −1 least. */
APART double place_of_extreme(const V *c, int groups, double from, double h, double sign)
{
    double p[ROWS], slope[ROWS] = {0.0}, places[ROWS];
    scaled_column(c, groups, 0, h, p);
    for (int n = 1; n < ROWS; n++)
        slope[n - 1] = n * p[n];
    int count = sign_roots(slope, ROWS, ROWS - 1, places);
    places[count++] = 1.0;
    double begin = from / h, best = begin, highest = sign * value_of(p, ROWS, begin);
    for (int i = 0; i < count; i++) {
        double value = sign * value_of(p, ROWS, places[i]);
        if (places[i] > begin && value > highest)
            best = places[i], highest = value;
    }
    return best * h;
}

/* The extremes that the step has changed, and where on it they are. */
static unsigned changed_extremes(const Varied *v, const Extremes *before, double *places)
{
    const Block *w = &v->run.w;
    const int groups = (int)v->run.order / 4;
    const double *old = (const double *)before, *new = (const double *)&w->seen;
    double late = larger((0.5 * v->run.t_end - w->t) - w->rest, 0.0);
    unsigned changed = 0;
    for (int i = 0; i < EXTREMES; i++) {
        if (old[i] == new[i])
            continue;
        V rates[ROWS + 2] = {0.0};
        const V *c = QUANTITY[i] == OF_Y ? w->ys : w->xs;
        if (QUANTITY[i] == OF_VX) {
            for (int n = 0; n <= 4 * groups; n++)
                rates[n] = w->xs[n + 1] * (n + 1.0);
            c = rates;
        }
        double from = i >= FIRST_LATE ? smaller(late, w->h) : 0.0;
        places[i] = place_of_extreme(c, groups, from, w->h, SIGN[i]);
        changed |= 1u << i;
    }
    return changed;
}

/* Carry the deviations over the step, and note them at the `wanted` places. Returns RUNNING if that
   can be done. */
static int carry(Varied *v, unsigned wanted, const double *places)
{
    const Block *w = &v->run.w;
    const int groups = (int)v->run.order / 4, eights = (int)v->eights;
    const int cubic = w->side < 0.0 && v->cubic;
    const Change *change = v->changes[mode_in_lane(w, 0)];
    double done = 0.0;
    for (int last = 0; !last;) {
        Motion m;
        Series s[EIGHTS];
        Tangent x = tangent_at(w->xs, groups, done), y = tangent_at(w->ys, groups, done);
        m.x[0] = x.value, m.x[1] = x.slope;
        m.y[PADDED] = y.value, m.y[PADDED + 1] = y.slope;
        expand_motion(&m, &w->field, cubic);
        for (int g = 0; g < eights; g++)
            expand_deviations(s + g, v->now + g, &m, &w->field, change + g, cubic);
        double left = w->h - done, piece = piece_length(s, eights, left);
        if (piece == 0.0)
            return is_finite(&m) ? UNBOUNDED : OVERFLOW;
        last = piece == left;
        for (int i = 0; i < EXTREMES; i++) {
            if (!(wanted >> i & 1) || !(last || places[i] <= done + piece))
                continue;
            wanted ^= 1u << i;
            v->moments[i] = w->t + (w->rest + places[i]);
            for (int g = 0; g < eights; g++) {
                Deviation at = deviation_at(s + g, places[i] - done);
                v->by[i][g] = QUANTITY[i] == OF_X ? at.x : QUANTITY[i] == OF_Y ? at.y : at.vx;
            }
        }
        for (int g = 0; g < eights; g++)
            v->now[g] = deviation_at(s + g, piece);
        done += piece;
    }
    return RUNNING;
}

/* End a step that is `cut` where y = 0: there the guard is y, and no parameter is in it. */
static int pass(Varied *v, const Ending *ending, int cut)
{
    Block *w = &v->run.w;
    const double gradient[STATE] = {0.0, 0.0, 1.0, 0.0};
    const Eight none = {0.0};
    Field before = w->field;
    int status = end_step(&v->run, ending, cut);
    if (cut) {
        double x = w->xs[0], vx = w->xs[1], y = w->ys[0], vy = w->ys[1];
        Pair jump = acceleration_of(&w->field, x, vx, y, vy) - acceleration_of(&before, x, vx, y, vy);
        const double jumps[STATE] = {0.0, X_OF(jump), 0.0, Y_OF(jump)};
        for (int g = 0; g < v->eights; g++)
            pass_switch(v->now + g, jumps, gradient, none, vy);
    }
    return status;
}

static void write_deviations(const Varied *v, double *rows)
{
    for (int64_t i = 0; i < v->count; i++) {
        const Deviation *d = v->now + i / 8;
        double *row = rows + i * STATE;
        row[0] = d->x[i % 8], row[1] = d->vx[i % 8], row[2] = d->y[i % 8], row[3] = d->vy[i % 8];
    }
}

/* Bytes of a run with derivatives. */
EXPORT int64_t NAME(vary_size)(void) { return sizeof(Varied); }

/* Begin a run, as `run_begin`, with `count` derivatives, sixteen at most. Each row of `seeds` says
   how (x, ẋ, y, ẏ) at the start and the parameters change. */
EXPORT void NAME(vary_begin)(Varied *v, const double *parameters, int64_t separation,
                             const double *start, const double *seeds, int64_t count, double t_end,
                             double tol, int64_t order)
{
    memset(v, 0, sizeof *v);
    begin_run(&v->run, parameters, separation, start, t_end, tol, order);
    v->count = count, v->eights = (count + 7) / 8, v->cubic = v->run.cubic;
    for (int64_t i = 0; i < count; i++) {
        const double *seed = seeds + i * (STATE + PARAMETERS);
        Deviation *d = v->now + i / 8;
        v->cubic |= seed[STATE + P_K_NL] != 0.0;
        d->x[i % 8] = seed[0], d->vx[i % 8] = seed[1];
        d->y[i % 8] = seed[2], d->vy[i % 8] = seed[3];
        for (int mode = 0; mode < MODES; mode++)
            put_change(v->changes[mode] + i / 8, i % 8, parameters, seed + STATE, mode);
    }
}

/* Go on until the run is ended, `crossings` is full or `budget` steps are made.

   A crossing is a row of CROSSING_HEAD numbers and the deviations there. `result` receives the
   columns of a result, how many crossings are in the buffer, ẍ and ÿ; `deviations` a row of
   derivatives of (x, ẋ, y, ẏ) for each seed; `extremes`, for each of `Extremes`, its time and its
   derivative by each seed. Returns the status. */
EXPORT int64_t NAME(vary_advance)(Varied *v, double *crossings, int64_t room, int64_t budget,
                                  double *result, double *deviations, double *extremes)
{
    Block *w = &v->run.w;
    const int64_t columns = CROSSING_HEAD + STATE * v->count;
    int64_t crossed = 0;
    int status = RUNNING, cut;
    while (status == RUNNING && crossed < room && budget-- > 0) {
        Ending ending;
        Extremes before = w->seen;
        double places[sizeof(Extremes) / sizeof(V)];
        if (!begin_step(&v->run, &ending, &cut)) {
            status = OVERFLOW;
            break;
        }
        if ((status = carry(v, changed_extremes(v, &before, places), places)) != RUNNING)
            break;
        double switches = w->lifts + w->landings;
        status = pass(v, &ending, cut);
        if (w->lifts + w->landings != switches) {
            double *row = crossings + crossed++ * columns;
            row[0] = w->last, row[1] = w->xs[0], row[2] = w->xs[1], row[3] = w->ys[0];
            row[4] = w->ys[1], row[5] = mode_in_lane(w, 0);
            write_deviations(v, row + CROSSING_HEAD);
        }
    }
    write_result(w, 0, status, result);
    Pair rate = acceleration_of(&w->field, w->xs[0], w->xs[1], w->ys[0], w->ys[1]);
    result[R_CROSSINGS] = (double)crossed;
    result[R_AX] = X_OF(rate), result[R_AY] = Y_OF(rate);
    write_deviations(v, deviations);
    for (int i = 0; i < EXTREMES; i++) {
        double *row = extremes + i * (1 + v->count);
        row[0] = v->moments[i];
        for (int64_t n = 0; n < v->count; n++)
            row[1 + n] = v->by[i][n / 8][n % 8];
    }
    return status;
}
