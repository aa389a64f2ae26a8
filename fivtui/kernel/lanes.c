/* Many runs side by side, on belts that are always faster than the slider. */

#define LANES 8
#define FINITE 0
#include "lanes.h"
#include "rest.h"
#include "variant.h"

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
                           (int)order, cubic != 0, amplitude != 0, peak != 0, steady != 0,
                           0};
    return advance(work, &asked, budget);
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
