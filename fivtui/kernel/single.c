/* One run: Taylor steps, switches, exact extremes, samples and polynomials. */

#define LANES 1
#include "output.h"
#include "run.h"
#include "variant.h"

typedef struct {
    Run run;
    int64_t sampled;
} Sampled;

/* What a call gives back behind the columns of a result. */
enum { R_SWITCHES = RESULTS, R_SEGMENTS, R_SAMPLES };

/* Bytes of a run. */
EXPORT int64_t NAME(run_size)(void) { return sizeof(Sampled); }

/* Begin a run: parameters, whether separation is considered, and (x, ẋ, y, ẏ). */
EXPORT void NAME(run_begin)(Sampled *of, const double *parameters, int64_t separation,
                            const double *start, double t_end, double tol, int64_t order)
{
    begin_run(&of->run, parameters, separation, start, t_end, tol, order);
    of->sampled = 0;
}

/* Go on until the run is ended, `switches` or `segments` is full, or `budget` steps are made.

   `times` are ascending sample times; `samples` receives x, ẋ, y, ẏ there in columns, `modes` the
   modes; `segments` may be NULL.
   `result` receives the columns of a result and how many switches, segments and samples are in the
   buffers. Returns the status. */
EXPORT int64_t NAME(run_advance)(Sampled *of, double *switches, int64_t switch_room,
                                 const double *times, int64_t time_count, double *samples,
                                 int8_t *modes, double *segments, int64_t segment_room,
                                 int64_t budget, double *result)
{
    Run *run = &of->run;
    Block *w = &run->w;
    const int groups = (int)run->order / 4;
    const int64_t columns = SEGMENT_HEAD + 2 * (run->order + 2);
    int64_t switched = 0, stored = 0, sampled = of->sampled;
    int status = RUNNING, cut;
    while (status == RUNNING && budget-- > 0) {
        Ending ending;
        if (switched == switch_room || (segments && stored == segment_room))
            break;
        if (!begin_step(run, &ending, &cut)) {
            status = OVERFLOW;
            break;
        }
        for (; sampled < time_count && (times[sampled] < ending.t || ending.last); sampled++) {
            store_sample(w, groups, times[sampled], samples + sampled, time_count);
            modes[sampled] = (int8_t)mode_in_lane(w, 0);
        }
        if (segments)
            store_segment(w, groups, ending.t, mode_in_lane(w, 0), segments + stored++ * columns);
        double switches_before = w->lifts + w->landings;
        status = end_step(run, &ending, cut);
        if (w->lifts + w->landings != switches_before)
            switches[switched++] = w->last;
    }
    of->sampled = sampled;
    write_result(w, 0, status, result);
    result[R_SWITCHES] = (double)switched;
    result[R_SEGMENTS] = (double)stored;
    result[R_SAMPLES] = (double)sampled;
    return status;
}
