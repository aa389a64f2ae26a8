/* A component is the model in an FMU: its variables, its motion in co-simulation, its equations in
   model exchange. The FMI functions call it through `COMPONENT`.

   A mode of the motion, such as contact, has its own equations; it ends at a switch. In
   co-simulation the component computes the motion in steps of its own (Taylor steps of the
   slider-belt), which may end long after the communication step. */

#ifndef FIVTUI_FMU_COMPONENT_H
#define FIVTUI_FMU_COMPONENT_H

#include <stdint.h>

/* Hidden: other libraries of the process may have functions of the same names. */
#pragma GCC visibility push(hidden)

/* Sizes of arrays, enough for both models. MOTION_SIZE is that of the motion in an instance, and
   MOTION_NUMBERS that of the motion in a serialised state, both in numbers. */
enum {
    MAX_VARIABLES = 48, MAX_STATES = 4, MAX_INDICATORS = 4, MAX_DERIVATIVE_ORDER = 3,
    MOTION_SIZE = 304, MOTION_NUMBERS = 64
};

typedef enum { REAL, INTEGER, BOOLEAN } Kind;
/* Parameters come first: fixed, then tunable ones; `is_settable` compares roles by this order. */
typedef enum { PARAMETER, TUNABLE, INPUT, OUTPUT, LOCAL } Role;

/* A row of the table of variables; its index is the value reference. */
typedef struct {
    const char *name;
    Kind kind;
    Role role;
    double start, lower, upper;
    /* The range as a phrase for messages. */
    const char *allowed;
    /* Typical size. */
    double nominal;
    int is_continuous;
    /* Whether it is computed by `compute_totals`. */
    int is_total;
} Variable;

static inline int is_settable(const Variable *v)
{
    return v->role <= INPUT;
}

struct Instance;

/* A function that returns text returns the reason why it failed, or NULL. */
typedef struct {
    const char *guid;
    const Variable *variables;
    uint32_t variable_count;
    /* References of the states and of their derivatives, in the order of the model description. */
    const uint32_t *states, *derivatives;
    uint32_t state_count, indicator_count;
    /* Begins the motion from the values, at the start time. */
    const char *(*begin)(struct Instance *i);
    /* A warning about initial values that have no effect, or NULL. Optional. */
    const char *(*find_warning)(struct Instance *i);
    /* Checks values of all variables against each other, and against those before, at the end of
       the initialization and where values change after it. Optional. */
    const char *(*check_values)(struct Instance *i, const double *values);
    /* Advances to t with inputs that follow their slopes from the time `from` on. Unless `switched`
       is NULL, stops at the first switch up to t, sets t to its time and `switched` to 1. */
    const char *(*advance)(struct Instance *i, double from, double *t, int *switched);
    /* Computes the derivatives of continuous outputs and locals by time, at the current time, under
       inputs that are held or have slopes: rates[n][r] is that of order n, from 1 to
       `derivative_order`, of the variable with the value reference r. */
    const char *(*differentiate_in_time)(struct Instance *i, double rates[][MAX_VARIABLES]);
    int derivative_order;
    /* End of the step of the motion that has been computed: until then the motion is known if its
       inputs do not change. */
    double (*computed_until)(const struct Instance *i);
    /* End of the step of the motion that contains the current time, or begins there, under held
       inputs; computes this step if needed. */
    double (*motion_step_end)(struct Instance *i);
    /* Computes the outputs from the motion, in model exchange from the states. */
    void (*compute_outputs)(struct Instance *i);
    /* Computes the outputs over the motion so far, such as peaks, after the others. Optional. */
    void (*compute_totals)(struct Instance *i);
    /* Model exchange: computes event indicators; updates the mode of the motion, returns whether it
       changed. */
    void (*event_indicators)(const struct Instance *i, double *indicators);
    int (*update_mode)(struct Instance *i);
    /* Model exchange: includes the states in totals, such as peaks; returns whether these are
       finite, and logs it if not. Optional. */
    int (*complete_step)(struct Instance *i);
    /* Directional derivatives; `changes` has the change of each variable, by value reference.
       `differentiate` computes the changes of outputs and state derivatives from those of
       parameters, inputs and states; `differentiate_start` computes those of the initial states. */
    void (*differentiate)(const struct Instance *i, double *changes);
    void (*differentiate_start)(const struct Instance *i, double *changes);
    /* Write the motion to MOTION_NUMBERS numbers; read it, and return whether they are valid. */
    void (*pack)(const struct Instance *i, double *numbers);
    int (*unpack)(struct Instance *i, const double *numbers);
} Component;

extern const Component COMPONENT;

#pragma GCC visibility pop

#endif
