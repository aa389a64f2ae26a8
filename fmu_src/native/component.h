/* What a component is to the FMI functions: its variables, its motion, its equations. */

#ifndef FIVTUI_FMU_COMPONENT_H
#define FIVTUI_FMU_COMPONENT_H

#include <stdint.h>

/* Not to be taken for functions of the same name elsewhere in the process. */
#pragma GCC visibility push(hidden)

typedef enum { REAL, INTEGER, BOOLEAN } Kind;
typedef enum { PARAMETER, INPUT, OUTPUT, LOCAL } Role;

/* A row of the table that is made of `fmu_src.slave`'s; `allowed` is the range in words. */
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

/* Functions that return text say why they refuse, NULL if they do not. */
typedef struct {
    const char *guid;
    const Variable *variables;
    uint32_t variable_count;
    /* References of the states and of their derivatives, in the order of the model description. */
    const uint32_t *states, *derivatives;
    uint32_t state_count, indicator_count;
    /* Begins the motion of the values, at the start time. */
    const char *(*begin)(struct Instance *i);
    /* What is said of the values once they are fixed, NULL if nothing is; NULL: never anything. */
    const char *(*remark)(struct Instance *i);
    /* Why a value of an input, in its range, is not possible beside the others once the motion has
       begun. NULL: all are. */
    const char *(*fits)(struct Instance *i, uint32_t reference, double value);
    /* Moves on to t, or with `switched` to the first switch not after it; ramps begin at `from`. */
    const char *(*move)(struct Instance *i, double from, double *t, int *switched);
    /* The time up to which moving on under the same inputs, held, needs no computation. */
    double (*known_until)(const struct Instance *i);
    /* Where a step of the motion ends that goes on under the inputs, held: later than the time. */
    double (*part_end)(struct Instance *i);
    /* Computes the outputs from the motion or, in model exchange, from the states. */
    void (*publish)(struct Instance *i);
    /* Model exchange: the event indicators, and the switch of the mode; whether it has switched. */
    void (*indicate)(const struct Instance *i, double *indicators);
    int (*settle)(struct Instance *i);
    /* By value reference: given the changes of parameters, inputs and states, those of outputs and
       of derivatives of states; given those of parameters and inputs, those of states at the start. */
    void (*differentiate)(const struct Instance *i, double *changes);
    void (*differentiate_start)(const struct Instance *i, double *changes);
    /* The motion as MOTION_NUMBERS numbers and back; whether they are those of a motion. */
    void (*pack)(const struct Instance *i, double *numbers);
    int (*unpack)(struct Instance *i, const double *numbers);
} Component;

#define MOTION_NUMBERS 40

extern const Component COMPONENT;

#pragma GCC visibility pop

#endif
