/* Many runs side by side, on belts of finite speed. LIBRARY_NAME adds the instruction set to
   exported names (`variant.h`). */

#define LANES 8
#define FINITE_BELT 1
#include "lanes.h"
#include "variant.h"

/* Bytes of `work`, which must be zero at first and aligned to 64 bytes. */
EXPORT int64_t LIBRARY_NAME(belts_size)(void) { return sizeof(LaneWork); }

/* Continue until all `count` runs have ended or `budget` steps of all lanes have been taken.

   Rows of `parameters` are parameter sets. All have a cubic contact spring, k_nl > 0 (`cubic`), or
   all have k_nl = 0; all have a friction law, v_s > 0, or none has. `separation` is 0 for runs
   whose contact never breaks; rows of `starts` are states (x, ẋ, y, ẏ), and `results` receives the
   results. The flags select extremes of y (`amplitude`), all extremes (`peak`), and those of y in
   the second half (`steady`). Returns the number of ended runs plus the computed fractions of the
   others. */
EXPORT double LIBRARY_NAME(belts_advance)(LaneWork *work, const double *parameters,
                                          const uint8_t *separation, const double *starts,
                                          double *results, int64_t count, double t_end, double tol,
                                          double max_steps, int64_t order, int64_t cubic,
                                          int64_t amplitude, int64_t peak, int64_t steady,
                                          int64_t budget)
{
    const Batch batch = {parameters, starts, separation, results, count, t_end, tol, max_steps,
                         (int)order, cubic != 0, amplitude != 0, peak != 0, steady != 0,
                         .by_law = count > 0 && parameters[P_V_S] > 0.0};
    return advance_batch(work, &batch, budget);
}

/* Number of runs that have ended. */
EXPORT int64_t LIBRARY_NAME(belts_ended)(const LaneWork *work) { return work->ended_count; }
