/* Calls every function of the kernel with problems read from standard input, with buffers of
   exactly the required sizes; answers each problem by one byte. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int64_t fivtui_run_size_baseline(void);
void fivtui_run_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                               int64_t);
int64_t fivtui_run_advance_baseline(void *, double *, int64_t, const double *, int64_t, double *,
                                    int8_t *, double *, int64_t, int64_t, double *);
int64_t fivtui_belt_size_baseline(void);
void fivtui_belt_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                                int64_t);
void fivtui_driven_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                                  int64_t, int64_t, const double *, int64_t, double);
int64_t fivtui_belt_advance_baseline(void *, double *, int64_t, const double *, int64_t, double *,
                                     int8_t *, double *, int64_t, int64_t, double *);
int64_t fivtui_vary_size_baseline(void);
void fivtui_vary_begin_baseline(void *, const double *, int64_t, const double *, const double *,
                                int64_t, double, double, int64_t);
int64_t fivtui_vary_advance_baseline(void *, double *, int64_t, int64_t, double *, double *,
                                     double *);
int64_t fivtui_orbit_request_size_baseline(void);
int64_t fivtui_orbit_size_baseline(void);
int64_t fivtui_orbit_solve_baseline(void *, const void *, const double *, const double *,
                                    const double *, int64_t, void *);
int64_t fivtui_batch_size_baseline(void);
double fivtui_batch_advance_baseline(void *, const double *, const uint8_t *, const double *,
                                     double *, int64_t, double, double, double, int64_t, int64_t,
                                     int64_t, int64_t, int64_t, int64_t);
double fivtui_belts_advance_baseline(void *, const double *, const uint8_t *, const double *,
                                              double *, int64_t, double, double, double, int64_t,
                                              int64_t, int64_t, int64_t, int64_t, int64_t);
int64_t fivtui_batch_ended_baseline(const void *);
int64_t fivtui_belts_size_baseline(void);
int64_t fivtui_belts_ended_baseline(const void *);
void fivtui_static_starts_baseline(const double *, const uint8_t *, double *, int64_t);

/* Numbers of columns and the status of a run, as in the kernel. After RESULTS a call adds COUNTS,
   and on belts the stick time and counts of changes (TALLY). */
enum { PARAMETERS = 9, BELT_PARAMETERS = 12, STATE = 4, RESULTS = 19, COUNTS = 3, TALLY = 26 };
enum { SEGMENT_HEAD = 5, CROSSING_HEAD = 6, CHANGE_COLUMNS = 3, ROW_COLUMNS = 10, EXTREMES = 7 };
enum { RUNNING = 5, CACHE_LINE = 64 };
/* Columns of F and μ, and limits of the unknowns of an orbit. */
enum { F_COLUMN = 6, MU_COLUMN = 8, V_S_COLUMN = 11, MAX_VARIED = 2, MAX_UNKNOWNS = 7 };
/* Runs of a problem that are also computed alone, calls per run, and rows of a table over time. */
enum { SINGLE_RUNS = 3, MAX_CALLS = 20, TABLE_ROWS = 2 };

/* As `Problem` of `test_sanitized.py` packs it. */
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
        double seed = seeds[i % (STATE + PARAMETERS)];
        rows[i] = i % ROW_COLUMNS % 2 ? clamp(seed) : 0.1 * seed;
    }
    rows[0] = 0.0, rows[ROW_COLUMNS] = 0.5 * p->t_end;
    /* The highest order is for friction laws alone. */
    int64_t order = p->order == 20 && belt[V_S_COLUMN] > 0.0 ? 24 : p->order;
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
                                         driven - 1, rows, TABLE_ROWS, 1.0);
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

/* As `OrbitRequest` in orbit.c. */
typedef struct {
    double parameters[PARAMETERS], scales[MAX_UNKNOWNS], low[MAX_VARIED], high[MAX_VARIED];
    double tol, max_period;
    int64_t columns[MAX_VARIED], varied_count, separation, order, budget;
} OrbitRequest;

static void solve_orbit(const Problem *p, const double *parameters, int64_t separation,
                        const double *start, const double *seeds)
{
    int64_t varied = 1 + p->seeds % 2, count = STATE + 1 + varied;
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
            normals[n * count + i] = seeds[(i + 3 * n) % (STATE + PARAMETERS)];
    }
    void *run = malloc((size_t)fivtui_vary_size_baseline());
    void *orbit = malloc((size_t)fivtui_orbit_size_baseline());
    fivtui_orbit_solve_baseline(run, request, guess, normals, heading, p->cubic, orbit);
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
        double *seeds = read_items(p.seeds * (STATE + PARAMETERS), sizeof(double));
        for (int64_t i = 0; i < p.members && i < SINGLE_RUNS; i++) {
            const double *member = parameters + i * PARAMETERS, *start = starts + i * STATE;
            run_alone(&p, member, separation[i], start, times);
            run_on_belt(&p, member, separation[i], start, times, seeds);
            /* Without a limit by the tolerance a step would have millions of substeps of
               deviations. */
            if (p.tol > 0.0 && p.tol < 0.1 && !(p.t_end > 100.0)) {
                run_varied(&p, member, separation[i], start, seeds);
                solve_orbit(&p, member, separation[i], start, seeds);
            }
        }
        run_batch(&p, parameters, separation, starts, seeds);
        fivtui_static_starts_baseline(parameters, separation, starts, p.members);
        run_batch(&p, parameters, separation, starts, seeds);
        free(parameters), free(starts), free(separation), free(times), free(seeds);
        putchar('.');
        fflush(stdout);
    }
    return 0;
}
