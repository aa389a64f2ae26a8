/* Interface of a component to the FMI functions: variables, motion, equations. */

#ifndef FIVTUI_FMU_COMPONENT_H
#define FIVTUI_FMU_COMPONENT_H

#include <stdint.h>

/* Hidden: other libraries of the process may have functions of the same names. */
#pragma GCC visibility push(hidden)

typedef enum { REAL, INTEGER, BOOLEAN } Kind;
typedef enum { PARAMETER, INPUT, OUTPUT, LOCAL } Role;

/* A row of the table of variables; `allowed` describes the range in messages. */
typedef struct {
    const char *name;
    Kind kind;
    Role role;
    double start, lower, upper;
    const char *allowed;
    double nominal;
    int is_continuous;
} Variable;

static inline int is_settable(const Variable *v)
{
    return v->role == PARAMETER || v->role == INPUT;
}

struct Instance;

/* Functions that return text return the reason for a refusal, or NULL. */
typedef struct {
    const char *guid;
    const Variable *variables;
    uint32_t variable_count;
    /* References of the states and of their derivatives, in the order of the model description. */
    const uint32_t *states, *derivatives;
    uint32_t state_count, indicator_count;
    /* Begins the motion from the values, at the start time. */
    const char *(*begin)(struct Instance *i);
    /* A warning about the fixed values, or NULL. Optional. */
    const char *(*find_warning)(struct Instance *i);
    /* The reason to refuse a value that is in the range of an input, but contradicts other values.
       Called after the motion has begun. Optional. */
    const char *(*check_input)(struct Instance *i, uint32_t reference, double value);
    /* Advances to t, or with `switched` to the first switch up to t; ramps begin at `from`. */
    const char *(*move)(struct Instance *i, double from, double *t, int *switched);
    /* The time up to which the motion under the same held inputs is computed. */
    double (*computed_until)(const struct Instance *i);
    /* End of the step of the motion after the current time, under held inputs. */
    double (*motion_step_end)(struct Instance *i);
    /* Computes the outputs from the motion, in model exchange from the states. */
    void (*compute_outputs)(struct Instance *i);
    /* Model exchange: computes event indicators; updates the mode, returns whether it changed. */
    void (*event_indicators)(const struct Instance *i, double *indicators);
    int (*update_mode)(struct Instance *i);
    /* Directional derivatives; `changes` are those of all variables, by value reference. From the
       changes of parameters, inputs and states, the first function computes the changes of outputs
       and state derivatives, the second the changes of initial states. */
    void (*differentiate)(const struct Instance *i, double *changes);
    void (*differentiate_start)(const struct Instance *i, double *changes);
    /* Write the motion to MOTION_NUMBERS numbers; read it, and return whether they are valid. */
    void (*pack)(const struct Instance *i, double *numbers);
    int (*unpack)(struct Instance *i, const double *numbers);
} Component;

#define MOTION_NUMBERS 40

extern const Component COMPONENT;

#pragma GCC visibility pop

#endif
