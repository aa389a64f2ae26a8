/* Calls every function of the kernel with problems read from standard input, in buffers of exactly the
   size that each needs; answers each problem by one byte. */

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
int64_t fivtui_vary_advance_baseline(void *, double *, int64_t, int64_t, double *, double *, double *);
int64_t fivtui_orbit_request_size_baseline(void);
int64_t fivtui_orbit_found_size_baseline(void);
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

enum { PARAMETERS = 9, STATE = 4, RESULTS = 19, MORE = 3, EXTREMES = 7, RUNNING = 5, CALLS = 20 };
enum { SEGMENT_HEAD = 5, CROSSING_HEAD = 6, SINGLE_RUNS = 3, OF_BELT = 3, CHANGE = 3, LEG = 10 };
/* Behind the others in results on belts: time of stick, changes by kind. */
enum { TALLY = 26 };

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

static void *taken(int64_t count, size_t size)
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
    double *result = allocate(RESULTS + MORE, sizeof(double));
    fivtui_run_begin_baseline(run, parameters, separation, start, p->t_end, p->tol, p->order);
    int64_t status = RUNNING;
    for (int call = 0; call < CALLS && status == RUNNING; call++)
        status = fivtui_run_advance_baseline(run, switches, p->switches, times, p->times, samples,
                                             modes, segments, p->segments, p->budget, result);
    free(run), free(switches), free(samples), free(modes), free(segments), free(result);
}

/* What a belt and its tables may be: from 0 to the most that is taken. */
static double allowed(double number)
{
    return number != number ? 0.0 : __builtin_fmin(__builtin_fabs(number), 1e9);
}

static void run_on_belt(const Problem *p, const double *parameters, int64_t separation,
                        const double *start, const double *times, const double *seeds)
{
    double belt[PARAMETERS + OF_BELT], *legs = allocate(2 * LEG, sizeof(double));
    for (int i = 0; i < PARAMETERS + OF_BELT; i++)
        belt[i] = i < PARAMETERS ? parameters[i] : allowed(seeds[i - PARAMETERS]);
    for (int i = 0; i < 2 * LEG; i++)
        legs[i] = i % LEG % 2 ? allowed(seeds[i % 13]) : 0.1 * seeds[i % 13];
    legs[0] = 0.0, legs[LEG] = 0.5 * p->t_end;
    /* The highest order is for friction laws alone. */
    int64_t order = p->order == 20 && belt[PARAMETERS + OF_BELT - 1] > 0.0 ? 24 : p->order;
    for (int driven = 0; driven < 3; driven++) {
        void *run = malloc((size_t)fivtui_belt_size_baseline());
        double *changes = allocate(p->switches * CHANGE, sizeof(double));
        double *samples = allocate(p->times * STATE, sizeof(double));
        int8_t *modes = allocate(p->times, 1);
        int64_t columns = SEGMENT_HEAD + 2 * (order + 2);
        double *segments = p->segments < 0 ? NULL : allocate(p->segments * columns, sizeof(double));
        double *result = allocate(RESULTS + MORE + TALLY, sizeof(double));
        if (driven)
            fivtui_driven_begin_baseline(run, belt, separation, start, p->t_end, p->tol, order,
                                         driven - 1, legs, 2, 1.0);
        else
            fivtui_belt_begin_baseline(run, belt, separation, start, p->t_end, p->tol, order);
        int64_t status = RUNNING;
        for (int call = 0; call < CALLS && status == RUNNING; call++)
            status = fivtui_belt_advance_baseline(run, changes, p->switches, times, p->times, samples,
                                                  modes, segments, p->segments, p->budget, result);
        free(run), free(changes), free(samples), free(modes), free(segments), free(result);
    }
    free(legs);
}

static void run_varied(const Problem *p, const double *parameters, int64_t separation,
                       const double *start, const double *seeds)
{
    void *run = malloc((size_t)fivtui_vary_size_baseline());
    int64_t columns = CROSSING_HEAD + STATE * p->seeds;
    double *crossings = allocate(p->crossings * columns, sizeof(double));
    double *result = allocate(RESULTS + MORE, sizeof(double));
    double *deviations = allocate(p->seeds * STATE, sizeof(double));
    double *extremes = allocate(EXTREMES * (1 + p->seeds), sizeof(double));
    fivtui_vary_begin_baseline(run, parameters, separation, start, seeds, p->seeds, p->t_end, p->tol,
                               p->order);
    int64_t status = RUNNING;
    for (int call = 0; call < CALLS && status == RUNNING; call++)
        status = fivtui_vary_advance_baseline(run, crossings, p->crossings, p->budget, result,
                                              deviations, extremes);
    free(run), free(crossings), free(result), free(deviations), free(extremes);
}

/* As `OrbitRequest` in orbit.c. */
typedef struct {
    double parameters[PARAMETERS], scales[7], low[2], high[2], tol, longest;
    int64_t places[2], varied, separation, order, budget;
} OrbitRequest;

static void solve_orbit(const Problem *p, const double *parameters, int64_t separation,
                        const double *start, const double *seeds)
{
    int64_t varied = 1 + p->seeds % 2, count = STATE + 1 + varied;
    OrbitRequest *request = allocate(1, (size_t)fivtui_orbit_request_size_baseline());
    *request = (OrbitRequest){.low = {0.0}, .tol = p->tol, .longest = 5.0, .places = {8, 6}};
    request->varied = varied, request->separation = separation;
    request->order = p->order, request->budget = p->budget;
    for (int i = 0; i < PARAMETERS; i++)
        request->parameters[i] = parameters[i];
    for (int i = 0; i < 2; i++)
        request->high[i] = 1e9;
    double *guess = allocate(count, sizeof(double)), *along = allocate(count, sizeof(double));
    double *planes = allocate((1 + varied) * count, sizeof(double));
    for (int64_t i = 0; i < count; i++) {
        request->scales[i] = 1.0 + (double)i;
        guess[i] = i < STATE ? start[i] : i == STATE ? p->t_end : parameters[8];
        along[i] = seeds[i];
        for (int64_t n = 0; n <= varied; n++)
            planes[n * count + i] = seeds[(i + 3 * n) % (STATE + PARAMETERS)];
    }
    void *run = malloc((size_t)fivtui_vary_size_baseline());
    void *orbit = malloc((size_t)fivtui_orbit_found_size_baseline());
    fivtui_orbit_solve_baseline(run, request, guess, planes, along, p->cubic, orbit);
    free(request), free(guess), free(along), free(planes), free(run), free(orbit);
}

static void run_batch(const Problem *p, const double *parameters, const uint8_t *separation,
                      const double *starts, const double *seeds)
{
    double *belts = allocate(p->members * (PARAMETERS + OF_BELT), sizeof(double));
    for (int64_t i = 0; i < p->members; i++)
        for (int n = 0; n < PARAMETERS + OF_BELT; n++)
            belts[i * (PARAMETERS + OF_BELT) + n] =
                n < PARAMETERS ? parameters[i * PARAMETERS + n] : allowed(seeds[n - PARAMETERS]);
    double *results = allocate(p->members * RESULTS, sizeof(double));
    for (int finite = 0; finite < 2; finite++) {
        size_t size = (size_t)(finite ? fivtui_belts_size_baseline : fivtui_batch_size_baseline)();
        void *work = aligned_alloc(64, size);
        for (size_t n = 0; n < size; n++)
            ((char *)work)[n] = 0;
        for (int call = 0; call < CALLS; call++) {
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
        double *parameters = taken(p.members * PARAMETERS, sizeof(double));
        double *starts = taken(p.members * STATE, sizeof(double));
        uint8_t *separation = taken(p.members, 1);
        double *times = taken(p.times, sizeof(double));
        double *seeds = taken(p.seeds * (STATE + PARAMETERS), sizeof(double));
        for (int64_t i = 0; i < p.members && i < SINGLE_RUNS; i++) {
            const double *one = parameters + i * PARAMETERS, *start = starts + i * STATE;
            run_alone(&p, one, separation[i], start, times);
            run_on_belt(&p, one, separation[i], start, times, seeds);
            /* A step that no tolerance bounds holds millions of the pieces that deviations take. */
            if (p.tol > 0.0 && p.tol < 0.1 && !(p.t_end > 100.0)) {
                run_varied(&p, one, separation[i], start, seeds);
                solve_orbit(&p, one, separation[i], start, seeds);
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
