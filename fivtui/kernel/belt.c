/* One run on a belt of finite speed, or with a table of parameters over time. With constant
   parameters and friction, a run whose belt stays faster than the slider has the same bits as one
   of `single.c`, which computes runs on belts that are always faster. A switch is a change of mode.
   An exact time is t + `remainder`. LIBRARY_NAME adds the instruction set to exported names
   (`variant.h`). */

#define LANES 1
/* The headers have their functions for belts of finite speed. */
#define FINITE_BELT 1
#include "driven.h"
#include "output.h"
#include "variant.h"

/* Columns of a call after those of a result: numbers of rows in the buffers, the stick time so far,
   s, and counts of switches at mode before · MODES + mode after. */
enum { R_SWITCHES = RESULTS, R_SEGMENTS, R_SAMPLES, R_STICK_TIME, R_SWITCH_COUNTS };

/* Columns of a switch: its time, and the modes before and after it. */
enum { C_T, C_BEFORE, C_AFTER, SWITCH_COLUMNS };

/* Columns of a row of the table over time: its time, values and slopes from that time, the speed of
   the belt just before the next row, and the parameters from that time. The run writes the least
   and greatest y since the contact spring last changed, up to the next row. */
enum {
    L_BEGIN, L_F, L_F_SLOPE, L_MU, L_MU_SLOPE, L_MU_S, L_MU_S_SLOPE, L_V, L_V_SLOPE, L_NEXT_V,
        L_PARAMETERS, L_Y_MIN = L_PARAMETERS + PARAMETERS, L_Y_MAX, ROW_COLUMNS
};

/* `sampled` is the number of samples so far, `last_switch` the time of the last switch. `rows` are
   those of the table from the current time on; the table belongs to the caller, and is NULL without
   parameters over time. `greatest_load` is the greatest |F| of the table. `course` has the inputs as
   functions of time from the first of these rows to the next. */
typedef struct {
    Run run;
    Belt belt;
    int64_t sampled;
    double stick_time, last_switch, switch_counts[MODES * MODES];
    double *rows, greatest_load;
    int64_t row_count;
    Course course;
} BeltRun;

/* Bytes of a cache line of the processor. */
#define CACHE_LINE 64

/* The run in the caller's memory, aligned to a cache line: this speeds up vectors. */
INLINE BeltRun *aligned_run(void *memory)
{
    return (BeltRun *)(((uintptr_t)memory + (CACHE_LINE - 1)) & ~(uintptr_t)(CACHE_LINE - 1));
}

INLINE void clear_counts(BeltRun *self)
{
    self->sampled = 0;
    self->stick_time = self->last_switch = 0.0;
    memset(self->switch_counts, 0, sizeof self->switch_counts);
}

/* Compute a step and its extremes; returns whether its end is finite. */
INLINE int compute_belt_step(BeltRun *self, StepEnd *step_end, StepCut *cut, int64_t *next_mode)
{
    Run *run = &self->run;
    Block *w = &run->w;
    const Belt *belt = &self->belt;
    /* Polynomials are evaluated in groups of GROUP_SIZE terms. */
    const int order = (int)run->order, groups = order / GROUP_SIZE;
    int slides = expand_belt_step(belt, w, run->tol, order, run->cubic != 0);
    evaluate_end_y(w, groups);
    *cut = cut_step(belt, w, groups, slides, next_mode);
    if (mask_bits(clip_at_horizon(w, run->t_end, groups))) {
        *cut = NOT_CUT;
        evaluate_end_x(w, groups, 1);
    }
    if (!is_finite_step(w))
        return 0;
    if (*cut == CUT_AT_SPEED || belt->mode == STICK)
        w->vx = belt->p[P_V_BELT];
    prepare_exponential(&self->belt, w);
    /* Some extremes are those of the second half of the run. */
    observe_extremes(w, groups, 0.5 * run->t_end, speed_limit(&self->belt, w->h));
    *step_end = find_step_end(w, run->t_end, *cut != NOT_CUT);
    return 1;
}

/* The parameters as functions of time from a row of the table on. */
INLINE Course row_course(const double *row)
{
    return (Course){.force = {row[L_F], row[L_F_SLOPE]}, .friction = {row[L_MU], row[L_MU_SLOPE]},
                    .mu_static = {row[L_MU_S], row[L_MU_S_SLOPE]},
                    .speed = {row[L_V], row[L_V_SLOPE]}, .start = row[L_BEGIN]};
}

/* The time of the next row; infinite after the last one. */
INLINE double row_end(const BeltRun *self)
{
    return self->row_count > 1 ? self->rows[ROW_COLUMNS + L_BEGIN] : INFINITE;
}

/* As `compute_belt_step`, for a run with a table over time. */
INLINE int compute_driven_step(BeltRun *self, StepEnd *step_end, StepCut *cut, int64_t *next_mode)
{
    Run *run = &self->run;
    Block *w = &run->w;
    const int order = (int)run->order, groups = order / GROUP_SIZE;
    const double end = row_end(self);
    expand_driven_step(&self->belt, w, run->tol, order, (end - w->t) - w->remainder);
    evaluate_end_y(w, groups);
    *cut = cut_step(&self->belt, w, groups, 0, next_mode);
    if (mask_bits(clip_at_horizon(w, run->t_end, groups))) {
        *cut = NOT_CUT;
        evaluate_end_x(w, groups, 1);
    }
    if (!is_finite_step(w))
        return 0;
    /* Some extremes are those of the second half of the run. */
    observe_extremes(w, groups, 0.5 * run->t_end, speed_limit(&self->belt, w->h));
    *step_end = find_step_end(w, run->t_end, *cut != NOT_CUT);
    if (step_end->t >= end)
        step_end->t = end, step_end->remainder = 0.0;
    return 1;
}

/* Set the parameters of a row. Extremes of y begin anew where the contact spring changes: extremes of
   the contact force follow from them. */
static void set_row_parameters(BeltRun *self, const double *row)
{
    Belt *belt = &self->belt;
    Block *w = &self->run.w;
    Extremes *extremes = &w->extremes;
    const double *p = row + L_PARAMETERS, k2 = belt->p[P_K2], k_nl = belt->p[P_K_NL];
    memcpy(belt->p, p, sizeof(double) * PARAMETERS);
    set_constants(w, 0, p);
    set_field(w);
    set_belt_fields(belt);
    belt->frequency = w->frequency;
    /* The scale of displacements is that of the greatest load, in place of that of the row. */
    w->deflection = self->greatest_load / total_stiffness(p);
    if (p[P_K2] != k2 || p[P_K_NL] != k_nl)
        extremes->y_low = INFINITE, extremes->y_high = -INFINITE;
}

/* Accept the step; at a row of the table continue with the row's course. */
INLINE StepFlags finish_driven_step(BeltRun *self, const StepEnd *step_end, StepCut cut,
                                    int64_t next_mode)
{
    const int at_row = step_end->t == row_end(self);
    double speed = at_row ? self->rows[L_NEXT_V] : end_speed(&self->course, step_end);
    if (at_row) {
        self->rows[L_Y_MIN] = self->run.w.extremes.y_low;
        self->rows[L_Y_MAX] = self->run.w.extremes.y_high;
        self->rows += ROW_COLUMNS, self->row_count--;
        self->course = row_course(self->rows);
        set_row_parameters(self, self->rows);
    }
    return accept_driven_step(&self->belt, &self->run.w, step_end, cut, next_mode, speed,
                              &self->course, at_row);
}

/* Bytes of a run at any address. */
EXPORT int64_t LIBRARY_NAME(belt_size)(void) { return sizeof(BeltRun) + CACHE_LINE; }

/* Begin a run; `p` has BELT_PARAMETERS columns, `separation` is 0 if contact never breaks. */
EXPORT void LIBRARY_NAME(belt_begin)(void *memory, const double *p, int64_t separation,
                                     const double *start, double t_end, double tol, int64_t order)
{
    BeltRun *self = aligned_run(memory);
    begin_run(&self->run, p, separation, start, t_end, tol, order);
    begin_belt(&self->belt, &self->run.w, 0, p, 1);
    clear_counts(self);
    self->rows = NULL, self->row_count = 0;
}

/* Begin a run with a table over time, on a belt that is `finite` or always faster than the slider. */
EXPORT void LIBRARY_NAME(driven_begin)(void *memory, const double *p, int64_t separation,
                                       const double *start, double t_end, double tol,
                                       int64_t order, int64_t finite, double *rows,
                                       int64_t row_count, double greatest_load)
{
    BeltRun *self = aligned_run(memory);
    begin_run(&self->run, p, separation, start, t_end, tol, order);
    Block *w = &self->run.w;
    begin_belt(&self->belt, w, 0, p, finite != 0);
    clear_counts(self);
    self->rows = rows, self->row_count = row_count, self->greatest_load = greatest_load;
    self->course = row_course(rows);
    set_row_parameters(self, rows);
    begin_driven(&self->belt, w, &self->course);
}

/* Continue until the run has ended, `switches` or `segments` is full, or after `budget` steps.

   `times` are ascending sample times; `samples` receives x, ẋ, y, ẏ in columns, `modes` the modes.
   `segments` receives a row of `output.h` for each step; it may be NULL. `switches` receives time,
   mode before and mode after of every switch. Returns the status: DONE, RUNNING, OVERFLOW, or
   STALLED, if too many steps in a row did not advance the motion. */
EXPORT int64_t LIBRARY_NAME(belt_advance)(void *memory, double *switches, int64_t max_switches,
                                          const double *times, int64_t time_count,
                                          double *samples, int8_t *modes, double *segments,
                                          int64_t max_segments, int64_t budget, double *result)
{
    BeltRun *self = aligned_run(memory);
    Run *run = &self->run;
    Block *w = &run->w;
    const int groups = (int)run->order / GROUP_SIZE;
    const int64_t columns = SEGMENT_HEAD + 2 * (run->order + 2);
    int64_t switch_count = 0, stored = 0, sampled = self->sampled;
    int status = RUNNING;
    while (status == RUNNING && budget-- > 0) {
        StepEnd step_end;
        StepCut cut;
        int64_t mode = self->belt.mode, next_mode = STICK;
        if (switch_count == max_switches || (segments && stored == max_segments))
            break;
        if (!(self->rows ? compute_driven_step(self, &step_end, &cut, &next_mode)
                       : compute_belt_step(self, &step_end, &cut, &next_mode))) {
            status = OVERFLOW;
            break;
        }
        for (; sampled < time_count
             && (times[sampled] < step_end.t || step_end.at_horizon); sampled++) {
            store_sample(w, groups, times[sampled], samples + sampled, time_count);
            modes[sampled] = (int8_t)mode;
        }
        if (segments)
            store_segment(w, groups, step_end.t, (int)mode, segments + stored++ * columns);
        StepFlags flags = self->rows ? finish_driven_step(self, &step_end, cut, next_mode)
                                     : accept_belt_step(&self->belt, w, &step_end, cut, next_mode);
        if (flags.finished)
            status = DONE;
        else if (flags.stalled)
            status = STALLED;
        if (self->belt.mode != mode) {
            double *row = switches + SWITCH_COLUMNS * switch_count++;
            row[C_T] = step_end.t;
            row[C_BEFORE] = (double)mode, row[C_AFTER] = (double)self->belt.mode;
            self->switch_counts[mode * MODES + self->belt.mode] += 1.0;
            if (mode == STICK)
                self->stick_time += step_end.t - self->last_switch;
            self->last_switch = step_end.t;
        }
    }
    self->sampled = sampled;
    write_result(w, 0, status, result);
    result[R_SWITCHES] = (double)switch_count;
    result[R_SEGMENTS] = (double)stored;
    result[R_SAMPLES] = (double)sampled;
    result[R_STICK_TIME] = self->stick_time
        + (self->belt.mode == STICK ? w->t - self->last_switch : 0.0);
    memcpy(result + R_SWITCH_COUNTS, self->switch_counts, sizeof self->switch_counts);
    return status;
}
