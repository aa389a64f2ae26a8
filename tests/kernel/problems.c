/* Calls every function of the kernel with problems read from standard input, with buffers of
   exactly the required sizes; answers each problem by one byte. */

#include <stdio.h>
#include <stdlib.h>

#include "exports.h"

/* Columns before the coefficients of a segment (start, remainder, duration, end, mode), and before
   the derivatives of a crossing of y = 0 (time, x, ẋ, y, ẏ, mode). Number of extremes of a run. */
enum { SEGMENT_HEAD = 5, CROSSING_HEAD = 6, EXTREMES = 7 };
/* Columns of F, μ and v_s in a parameter set. The unknowns of an orbit are its start, its period and
   at most two varied parameters. */
enum { F_COLUMN = 6, MU_COLUMN = 8, V_S_COLUMN = 11, MAX_VARIED = 2, MAX_UNKNOWNS = 7 };
/* A seed gives a direction in which start and parameters change; here it is random numbers, which
   also serve as belts and tables. */
enum { SEED = STATE + PARAMETERS };
/* Orders of expansion: the highest one, and that with a friction law. */
enum { MAX_ORDER = 20, MAX_LAW_ORDER = 24 };
/* Runs of a problem that are also computed alone, calls per run, and rows of a table over time. */
enum { SINGLE_RUNS = 3, MAX_CALLS = 20, TABLE_ROWS = 2 };
/* Scale of the loads of tables, N. */
static const double GREATEST_LOAD = 1.0;

/* As `Problem` of `test_sanitized.py` packs it and describes its members. */
typedef struct {
    int64_t order, members, cubic, amplitude, peak, steady, budget, switches, times, segments, seeds,
        crossings;
    double t_end, tol, max_steps;
} Problem;

static void *allocate(int64_t count, size_t size)
{
    void *memory = malloc((size_t)count * size);
    if (!memory && count)
        exit(3);
    return memory;
}

static void *read_items(int64_t count, size_t size)
{
    void *memory = allocate(count, size);
    if (fread(memory, size, (size_t)count, stdin) != (size_t)count)
        exit(4);
    return memory;
}

static void run_alone(const Problem *p, const double *parameters, int64_t separation,
                      const double *start, const double *times)
{
    void *run = malloc((size_t)fivtui_run_size_baseline());
    double *switches = allocate(p->switches, sizeof(double));
    double *samples = allocate(p->times * STATE, sizeof(double));
    int8_t *modes = allocate(p->times, 1);
    /* x and y have order + 2 coefficients each. */
    int64_t columns = SEGMENT_HEAD + 2 * (p->order + 2);
    double *segments = p->segments < 0 ? NULL : allocate(p->segments * columns, sizeof(double));
    double *result = allocate(RESULTS + COUNTS, sizeof(double));
    fivtui_run_begin_baseline(run, parameters, separation, start, p->t_end, p->tol, p->order);
    int64_t status = RUNNING;
    for (int call = 0; call < MAX_CALLS && status == RUNNING; call++)
        status = fivtui_run_advance_baseline(run, switches, p->switches, times, p->times, samples,
                                             modes, segments, p->segments, p->budget, result);
    free(run), free(switches), free(samples), free(modes), free(segments), free(result);
}

/* The number within the range of a belt's parameters and of tables: 0 to the greatest value. */
static double clamp(double number)
{
    return number != number ? 0.0 : __builtin_fmin(__builtin_fabs(number), 1e9);
}

static void run_on_belt(const Problem *p, const double *parameters, int64_t separation,
                        const double *start, const double *times, const double *seeds)
{
    double belt[BELT_PARAMETERS], *rows = allocate(TABLE_ROWS * ROW_COLUMNS, sizeof(double));
    for (int i = 0; i < BELT_PARAMETERS; i++)
        belt[i] = i < PARAMETERS ? parameters[i] : clamp(seeds[i - PARAMETERS]);
    /* Values are in the odd columns of a row, slopes in the even ones; the first one is the
       time. */
    for (int i = 0; i < TABLE_ROWS * ROW_COLUMNS; i++) {
        double seed = seeds[i % SEED];
        rows[i] = i % ROW_COLUMNS % 2 ? clamp(seed) : 0.1 * seed;
    }
    /* After the first columns of a row come parameters, then two of results. */
    for (int row = 0; row < TABLE_ROWS; row++)
        for (int i = 0; i < PARAMETERS; i++)
            rows[row * ROW_COLUMNS + INPUT_COLUMNS + i] = belt[i];
    rows[0] = 0.0, rows[ROW_COLUMNS] = 0.5 * p->t_end;
    /* The higher order is only for friction that falls with the sliding speed, v_s > 0. */
    int64_t order = p->order == MAX_ORDER && belt[V_S_COLUMN] > 0.0 ? MAX_LAW_ORDER : p->order;
    /* 0: without a table; 1 and 2: with a table, on a belt that is always faster or of finite
       speed. */
    for (int driven = 0; driven < 3; driven++) {
        void *run = malloc((size_t)fivtui_belt_size_baseline());
        double *changes = allocate(p->switches * CHANGE_COLUMNS, sizeof(double));
        double *samples = allocate(p->times * STATE, sizeof(double));
        int8_t *modes = allocate(p->times, 1);
        int64_t columns = SEGMENT_HEAD + 2 * (order + 2);
        double *segments = p->segments < 0 ? NULL : allocate(p->segments * columns, sizeof(double));
        double *result = allocate(RESULTS + COUNTS + TALLY, sizeof(double));
        if (driven)
            fivtui_driven_begin_baseline(run, belt, separation, start, p->t_end, p->tol, order,
                                         driven - 1, rows, TABLE_ROWS, GREATEST_LOAD);
        else
            fivtui_belt_begin_baseline(run, belt, separation, start, p->t_end, p->tol, order);
        int64_t status = RUNNING;
        for (int call = 0; call < MAX_CALLS && status == RUNNING; call++)
            status = fivtui_belt_advance_baseline(run, changes, p->switches, times, p->times, samples,
                                                  modes, segments, p->segments, p->budget, result);
        free(run), free(changes), free(samples), free(modes), free(segments), free(result);
    }
    free(rows);
}

/* Compute a run with its derivatives by numbers that change start and parameters. */
static void run_varied(const Problem *p, const double *parameters, int64_t separation,
                       const double *start, const double *seeds)
{
    void *run = malloc((size_t)fivtui_vary_size_baseline());
    int64_t columns = CROSSING_HEAD + STATE * p->seeds;
    double *crossings = allocate(p->crossings * columns, sizeof(double));
    double *result = allocate(RESULTS + COUNTS, sizeof(double));
    double *deviations = allocate(p->seeds * STATE, sizeof(double));
    double *extremes = allocate(EXTREMES * (1 + p->seeds), sizeof(double));
    fivtui_vary_begin_baseline(run, parameters, separation, start, seeds, p->seeds, p->t_end, p->tol,
                               p->order);
    int64_t status = RUNNING;
    for (int call = 0; call < MAX_CALLS && status == RUNNING; call++)
        status = fivtui_vary_advance_baseline(run, crossings, p->crossings, p->budget, result,
                                              deviations, extremes);
    free(run), free(crossings), free(result), free(deviations), free(extremes);
}

/* As `OrbitRequest` in orbit.c: `scales` are the units of the unknowns; `low` and `high` bound the
   varied parameters, which have the indices `columns`. */
typedef struct {
    double parameters[PARAMETERS], scales[MAX_UNKNOWNS], low[MAX_VARIED], high[MAX_VARIED];
    double tol, max_period;
    int64_t columns[MAX_VARIED], varied_count, separation, order, budget;
} OrbitRequest;

/* Search for a periodic orbit in planes through a guess, which have random `normals`. The tangent of
   the curve of orbits points along the random `heading`. */
static void solve_orbit(const Problem *p, const double *parameters, int64_t separation,
                        const double *start, const double *seeds)
{
    /* Drawn numbers serve as the count of varied parameters, 1 or 2, and as a flag. */
    const int64_t varied = 1 + p->seeds % 2, is_normal_to_flow = p->cubic;
    const int64_t count = STATE + 1 + varied;
    OrbitRequest *request = allocate(1, (size_t)fivtui_orbit_request_size_baseline());
    *request = (OrbitRequest){.tol = p->tol, .max_period = 5.0, .columns = {MU_COLUMN, F_COLUMN}};
    request->varied_count = varied, request->separation = separation;
    request->order = p->order, request->budget = p->budget;
    for (int i = 0; i < PARAMETERS; i++)
        request->parameters[i] = parameters[i];
    for (int i = 0; i < MAX_VARIED; i++)
        request->high[i] = 1e9;
    double *guess = allocate(count, sizeof(double)), *heading = allocate(count, sizeof(double));
    double *normals = allocate((1 + varied) * count, sizeof(double));
    for (int64_t i = 0; i < count; i++) {
        request->scales[i] = 1.0 + (double)i;
        guess[i] = i < STATE ? start[i] : parameters[MU_COLUMN];
        if (i == STATE)
            guess[i] = p->t_end;
        heading[i] = seeds[i];
        for (int64_t n = 0; n <= varied; n++)
            normals[n * count + i] = seeds[(i + 3 * n) % SEED];
    }
    void *run = malloc((size_t)fivtui_vary_size_baseline());
    void *orbit = malloc((size_t)fivtui_orbit_size_baseline());
    fivtui_orbit_solve_baseline(run, request, guess, normals, heading, is_normal_to_flow, orbit);
    free(request), free(guess), free(heading), free(normals), free(run), free(orbit);
}

static void run_batch(const Problem *p, const double *parameters, const uint8_t *separation,
                      const double *starts, const double *seeds)
{
    double *belts = allocate(p->members * BELT_PARAMETERS, sizeof(double));
    for (int64_t i = 0; i < p->members; i++)
        for (int n = 0; n < BELT_PARAMETERS; n++)
            belts[i * BELT_PARAMETERS + n] =
                n < PARAMETERS ? parameters[i * PARAMETERS + n] : clamp(seeds[n - PARAMETERS]);
    double *results = allocate(p->members * RESULTS, sizeof(double));
    for (int finite = 0; finite < 2; finite++) {
        size_t size = (size_t)(finite ? fivtui_belts_size_baseline : fivtui_batch_size_baseline)();
        void *work = aligned_alloc(CACHE_LINE, size);
        for (size_t n = 0; n < size; n++)
            ((char *)work)[n] = 0;
        for (int call = 0; call < MAX_CALLS; call++) {
            if ((finite ? fivtui_belts_ended_baseline : fivtui_batch_ended_baseline)(work)
                >= p->members)
                break;
            (finite ? fivtui_belts_advance_baseline : fivtui_batch_advance_baseline)(
                work, finite ? belts : parameters, separation, starts, results, p->members, p->t_end,
                p->tol, p->max_steps, p->order, p->cubic, p->amplitude, p->peak, p->steady,
                p->budget);
        }
        free(work);
    }
    free(results), free(belts);
}

int main(void)
{
    Problem p;
    while (fread(&p, sizeof p, 1, stdin) == 1) {
        double *parameters = read_items(p.members * PARAMETERS, sizeof(double));
        double *starts = read_items(p.members * STATE, sizeof(double));
        uint8_t *separation = read_items(p.members, 1);
        double *times = read_items(p.times, sizeof(double));
        double *seeds = read_items(p.seeds * SEED, sizeof(double));
        for (int64_t i = 0; i < p.members && i < SINGLE_RUNS; i++) {
            const double *member = parameters + i * PARAMETERS, *start = starts + i * STATE;
            run_alone(&p, member, separation[i], start, times);
            run_on_belt(&p, member, separation[i], start, times, seeds);
            /* A step is divided into substeps for the deviations. Steps that no usual tolerance or
               horizon limits would need millions. */
            if (p.tol > 0.0 && p.tol < 0.1 && !(p.t_end > 100.0)) {
                run_varied(&p, member, separation[i], start, seeds);
                solve_orbit(&p, member, separation[i], start, seeds);
            }
        }
        run_batch(&p, parameters, separation, starts, seeds);
        /* Again from rest: the states of equilibrium replace the starts. */
        fivtui_static_starts_baseline(parameters, separation, starts, p.members);
        run_batch(&p, parameters, separation, starts, seeds);
        free(parameters), free(starts), free(separation), free(times), free(seeds);
        putchar('.');
        fflush(stdout);
    }
    return 0;
}
