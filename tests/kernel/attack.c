/* Calls the kernel with everything that a number can be, and buffers of size zero. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int64_t fivtui_run_size_baseline(void);
void fivtui_run_begin_baseline(void *, const double *, int64_t, const double *, double, double,
                               int64_t);
int64_t fivtui_run_advance_baseline(void *, double *, int64_t, const double *, double *, int64_t,
                                    double *, int64_t, int64_t, double *);
int64_t fivtui_vary_size_baseline(void);
void fivtui_vary_begin_baseline(void *, const double *, int64_t, const double *, const double *,
                                int64_t, double, double, int64_t);
int64_t fivtui_vary_advance_baseline(void *, double *, int64_t, int64_t, double *, double *, double *);
int64_t fivtui_batch_size_baseline(void);
double fivtui_batch_advance_baseline(void *, const double *, const uint8_t *, const double *,
                                     double *, int64_t, double, double, double, int64_t, int64_t,
                                     int64_t, int64_t, int64_t, int64_t);
int64_t fivtui_batch_ended_baseline(const void *);
void fivtui_static_starts_baseline(const double *, const uint8_t *, double *, int64_t);

#define MEMBERS 61

static const double BASE[9] = {5.0, 100.0, 50.0, 60.0, 0.32, 0.32, 80.0, 100.0, 0.7};
static uint64_t state = 88172645463325252u;

static double chance(void)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

static double odd_number(void)
{
    const double odd[] = {0.0, -0.0, 1e-320, -1e-300, 1e300, -1e308, INFINITY, -INFINITY, NAN, 1e15};
    return odd[(int)(chance() * 10.0)];
}

int main(void)
{
    double switches[3], times[4] = {0.0, 0.1, 0.1, 2.0}, samples[4 * 5], result[22];
    void *run = malloc((size_t)fivtui_run_size_baseline());
    void *varied = malloc((size_t)fivtui_vary_size_baseline());
    double *seeds = malloc(16 * 13 * sizeof(double)), *derived = malloc(16 * 4 * sizeof(double));
    double *extremes = malloc(7 * 17 * sizeof(double)), *crossings = malloc(2 * 70 * sizeof(double));
    void *work = aligned_alloc(64, (size_t)fivtui_batch_size_baseline());
    double *segments = malloc(2 * (5 + 2 * 22) * sizeof(double));
    double *parameters = malloc(MEMBERS * 9 * sizeof(double));
    double *starts = malloc(MEMBERS * 4 * sizeof(double));
    double *results = malloc(MEMBERS * 19 * sizeof(double));
    uint8_t separation[MEMBERS];
    for (int round = 0; round < 40; round++) {
        int order = 8 + 4 * (round % 4);
        for (int i = 0; i < MEMBERS; i++) {
            double *p = parameters + 9 * i, *start = starts + 4 * i;
            for (int n = 0; n < 9; n++)
                p[n] = chance() < 0.1 ? odd_number() : BASE[n] * 2.0 * chance();
            for (int n = 0; n < 4; n++)
                start[n] = chance() < 0.2 ? odd_number() : 4.0 * chance() - 2.0;
            separation[i] = chance() < 0.8;
            fivtui_run_begin_baseline(run, p, separation[i], start, 2.0, 1e-15, order);
            int64_t status = 5;
            for (int call = 0; call < 200 && status == 5; call++)
                status = fivtui_run_advance_baseline(run, switches, call % 4, times, samples, 4,
                                                     call % 2 ? segments : NULL, call % 3, 7, result);
            int64_t count = 1 + i % 16;
            for (int n = 0; n < 13 * count; n++)
                seeds[n] = chance() < 0.02 ? odd_number() : 2.0 * chance() - 1.0;
            fivtui_vary_begin_baseline(varied, p, separation[i], start, seeds, count, 1.0, 1e-15, order);
            status = 5;
            for (int call = 0; call < 100 && status == 5; call++)
                status = fivtui_vary_advance_baseline(varied, crossings, call % 3, 7, result, derived,
                                                      extremes);
        }
        for (size_t n = 0; n < (size_t)fivtui_batch_size_baseline(); n++)
            ((char *)work)[n] = 0;
        if (round % 8 == 0)
            fivtui_static_starts_baseline(parameters, separation, starts, MEMBERS);
        for (int call = 0; call < 50 && fivtui_batch_ended_baseline(work) < MEMBERS; call++)
            fivtui_batch_advance_baseline(work, parameters, separation, starts, results, MEMBERS, 2.0,
                                          1e-15, 300.0, order, round % 5 != 0, round % 2, round % 3,
                                          1, 50);
        if (fivtui_batch_ended_baseline(work) != MEMBERS) {
            fprintf(stderr, "%d of %d members ended\n", (int)fivtui_batch_ended_baseline(work), MEMBERS);
            return 1;
        }
    }
    fivtui_batch_advance_baseline(work, NULL, NULL, NULL, NULL, 0, 1.0, 1e-15, 10.0, 20, 1, 1, 1, 1, 5);
    free(run), free(work), free(segments), free(parameters), free(starts), free(results);
    free(varied), free(seeds), free(derived), free(extremes), free(crossings);
    return 0;
}
