/* Functions of the kernel, and numbers of columns, for the programs in this folder.

   The library has each function once for each instruction set; the suffix is the name of the set.
   A kernel that is compiled without a VARIANT has the set `baseline` (`variant.h`). A `driven` run
   has a table of parameters over time, a `vary` run derivatives. */

#ifndef EXPORTS_H
#define EXPORTS_H

#include <stdint.h>

int64_t fivtui_run_size_baseline(void);
void fivtui_run_begin_baseline(void *run, const double *parameters, int64_t separation,
                               const double *start, double t_end, double tol, int64_t order);
int64_t fivtui_run_advance_baseline(void *run, double *switches, int64_t max_switches,
                                    const double *times, int64_t time_count, double *samples,
                                    int8_t *modes, double *segments, int64_t max_segments,
                                    int64_t budget, double *result);
int64_t fivtui_belt_size_baseline(void);
void fivtui_belt_begin_baseline(void *run, const double *parameters, int64_t separation,
                                const double *start, double t_end, double tol, int64_t order);
void fivtui_driven_begin_baseline(void *run, const double *parameters, int64_t separation,
                                  const double *start, double t_end, double tol, int64_t order,
                                  int64_t finite, double *rows, int64_t row_count,
                                  double greatest_load);
int64_t fivtui_belt_advance_baseline(void *run, double *switches, int64_t max_switches,
                                     const double *times, int64_t time_count, double *samples,
                                     int8_t *modes, double *segments, int64_t max_segments,
                                     int64_t budget, double *result);
int64_t fivtui_vary_size_baseline(void);
void fivtui_vary_begin_baseline(void *run, const double *parameters, int64_t separation,
                                const double *start, const double *seeds, int64_t count,
                                double t_end, double tol, int64_t order);
int64_t fivtui_vary_advance_baseline(void *run, double *crossings, int64_t max_crossings,
                                     int64_t budget, double *result, double *deviations,
                                     double *extremes);
int64_t fivtui_orbit_request_size_baseline(void);
int64_t fivtui_orbit_size_baseline(void);
int64_t fivtui_orbit_solve_baseline(void *run, const void *request, const double *guess,
                                    const double *normals, const double *heading,
                                    int64_t is_normal_to_flow, void *orbit);
int64_t fivtui_batch_size_baseline(void);
double fivtui_batch_advance_baseline(void *work, const double *parameters,
                                     const uint8_t *separation, const double *starts,
                                     double *results, int64_t count, double t_end, double tol,
                                     double max_steps, int64_t order, int64_t cubic,
                                     int64_t amplitude, int64_t peak, int64_t steady,
                                     int64_t budget);
int64_t fivtui_batch_ended_baseline(const void *work);
int64_t fivtui_belts_size_baseline(void);
double fivtui_belts_advance_baseline(void *work, const double *parameters,
                                     const uint8_t *separation, const double *starts,
                                     double *results, int64_t count, double t_end, double tol,
                                     double max_steps, int64_t order, int64_t cubic,
                                     int64_t amplitude, int64_t peak, int64_t steady,
                                     int64_t budget);
int64_t fivtui_belts_ended_baseline(const void *work);
void fivtui_static_starts_baseline(const double *parameters, const uint8_t *separation,
                                   double *starts, int64_t count);

/* Numbers of columns, and the status of a run that has not ended, as in the kernel. */
enum { PARAMETERS = 9, BELT_PARAMETERS = 12, STATE = 4, RESULTS = 19, MODES = 5, RUNNING = 5 };
/* Numbers that a call adds to a result: numbers of switches, segments and samples (or of crossings,
   ẍ and ÿ); on belts also the stick time, and counts of switches for each pair of modes. */
enum { COUNTS = 3, TALLY = 1 + MODES * MODES };
/* Columns of a switch on a belt: time, and modes before and after it. Columns of a row of a table:
   time, values and slopes of F, μ, μ_s and v_belt, and v_belt just before the next row (inputs),
   parameters, and two numbers that the run writes. */
enum { CHANGE_COLUMNS = 3, INPUT_COLUMNS = 10, ROW_COLUMNS = INPUT_COLUMNS + PARAMETERS + 2 };
/* Bytes of a cache line of the processor. */
enum { CACHE_LINE = 64 };

#endif
