/* One run: Taylor steps with switches, exact extremes, samples and segments. */

#define LANES 1
#include "output.h"
#include "run.h"
#include "variant.h"

typedef struct {
    Run run;
    int64_t sampled;
} SampledRun;

/* Columns of a call after those of a result: numbers of rows in the buffers. */
enum { R_SWITCHES = RESULTS, R_SEGMENTS, R_SAMPLES };

/* Bytes of a run. */
EXPORT int64_t LIBRARY_NAME(run_size)(void) { return sizeof(SampledRun); }

/* Begin a run; `separation` is 0 if it is ignored, `start` is (x, ẋ, y, ẏ). */
EXPORT void LIBRARY_NAME(run_begin)(SampledRun *self, const double *parameters, int64_t separation,
                                    const double *start, double t_end, double tol, int64_t order)
{
    begin_run(&self->run, parameters, separation, start, t_end, tol, order);
    self->sampled = 0;
}

/* Continue until the run has ended, `switches` or `segments` is full, or after `budget` steps.

   `times` are ascending sample times; `samples` receives x, ẋ, y, ẏ in columns, `modes` the modes.
   `segments` may be NULL. `result` receives the columns of a result, and the numbers of switches,
   segments and samples. Returns the status. */
EXPORT int64_t LIBRARY_NAME(run_advance)(SampledRun *self, double *switches, int64_t max_switches,
                                         const double *times, int64_t time_count, double *samples,
                                         int8_t *modes, double *segments, int64_t max_segments,
                                         int64_t budget, double *result)
{
    Run *run = &self->run;
    Block *w = &run->w;
    const int groups = (int)run->order / GROUP_SIZE;
    const int64_t columns = SEGMENT_HEAD + 2 * (run->order + 2);
    int64_t switch_count = 0, stored = 0, sampled = self->sampled;
    int status = RUNNING, cut;
    while (status == RUNNING && budget-- > 0) {
        StepEnd step_end;
        if (switch_count == max_switches || (segments && stored == max_segments))
            break;
        if (!compute_step(run, &step_end, &cut)) {
            status = OVERFLOW;
            break;
        }
        for (; sampled < time_count
             && (times[sampled] < step_end.t || step_end.at_horizon); sampled++) {
            store_sample(w, groups, times[sampled], samples + sampled, time_count);
            modes[sampled] = (int8_t)mode_in_lane(w, 0);
        }
        if (segments)
            store_segment(w, groups, step_end.t, mode_in_lane(w, 0), segments + stored++ * columns);
        double switches_before = w->separations + w->reattachments;
        status = finish_step(run, &step_end, cut);
        if (w->separations + w->reattachments != switches_before)
            switches[switch_count++] = w->last_switch;
    }
    self->sampled = sampled;
    write_result(w, 0, status, result);
    result[R_SWITCHES] = (double)switch_count;
    result[R_SEGMENTS] = (double)stored;
    result[R_SAMPLES] = (double)sampled;
    return status;
}
