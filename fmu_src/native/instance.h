/* An instance of the FMU, and what its FMI functions share: checks of calls, messages, outputs.

   In the FMI functions `c` is the fmi2Component that the importer passes, `i` the instance behind
   it, and `s` the state of the instance. The model in the FMU, slider-belt or brake actuator, is
   COMPONENT, which `component.h` declares. */

#ifndef FIVTUI_FMU_INSTANCE_H
#define FIVTUI_FMU_INSTANCE_H

#include "component.h"
#ifdef __ELF__
/* The headers of FMI declare its functions with the attribute visibility("default"). This macro
   makes that visibility("protected"), so that FMI functions call each other, and not functions of
   these names in the host or another FMU. */
#define visibility(kind) visibility("protected")
#endif
#include "fmi2Functions.h"
#include "fmi3Functions.h"
#undef visibility

/* Hidden: other libraries of the process may have functions of the same names. */
#pragma GCC visibility push(hidden)

/* Size of messages, in characters. */
enum { TEXT_SIZE = 320 };
/* The range of tolerances: `TOL_RANGE` in `fivtui.taylor.stepper`. */
#define LEAST_TOLERANCE 1e-13
#define GREATEST_TOLERANCE 1e-2

/* Phases of the calling sequence. INTERMEDIATE occurs only inside a step, and in no saved state. */
typedef enum {
    INSTANTIATED, INITIALIZATION, STEPPING, EVENTS, CONTINUOUS, TERMINATED, INTERMEDIATE
} Phase;

/* Categories of messages, as the model description names them. */
typedef enum { WARNINGS, DISCARDS, ERRORS, CATEGORIES } Category;

/* The state of an instance, which determines all later results. */
typedef struct {
    Phase phase;
    /* Status of the last communication step. */
    fmi2Status last_step;
    /* Whether the experiment is set up. */
    int is_set_up;
    /* Whether the motion has begun, with the parameters and inputs in `values`; whether the outputs
       in `values` are those at `t`. */
    int has_motion, has_outputs;
    /* Whether an input has a slope. Whether no input was set since the last communication step:
       then mode and acceleration of the belt are those at its end. */
    int has_slopes, has_inputs_of_step;
    /* Whether the last step ended at a switch (`component.h`) and the importer has not yet entered
       event mode there: until then mode and counts stay those before the switch. */
    int switch_pending;
    /* Times, s; `t` is the current one. The motion is computed up to `fast_until`, so that a
       communication step that ends before it only advances `t`. It is −INFINITY where the next step
       must check more. */
    double start_time, stop_time, tolerance, t, fast_until;
    /* Values of all variables; slopes of inputs over the next communication step. */
    double values[MAX_VARIABLES], slopes[MAX_VARIABLES];
    /* Continuous states, in model exchange. */
    double states[MAX_STATES];
    /* The motion, in co-simulation: memory that COMPONENT arranges. */
    double motion[MOTION_SIZE];
} State;

typedef struct Instance {
    State s;
    fmi2Type type;
    fmi2CallbackFunctions callbacks;
    char *name;
    int logging[CATEGORIES];
    /* FMI 3.0: the logger; whether co-simulation has an event mode, whether steps may return early,
       and whether they end at switches. */
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    int uses_events, returns_early, stops_at_switches;
    /* Callback of the importer for intermediate updates (FMI 3.0). */
    fmi3IntermediateUpdateCallback update;
    /* Whether the callback sets each variable, and whether it sets any input. */
    unsigned char is_updated[MAX_VARIABLES];
    int updates_inputs;
    /* Whether the FMU is waiting for inputs from the callback. */
    int wants_inputs;
    /* The functions for the instruction set of this processor, a `Stepping` of `stepping.h`. */
    const void *stepping;
    /* The newest text of `set_reason`. */
    char reason[TEXT_SIZE];
} Instance;

/* Creates an instance from `settings` (type, loggers); returns NULL, with a message, if the name or
   the GUID is wrong. */
Instance *make_instance(const Instance *settings, const char *name, const char *guid);

/* Does a communication step of `h` seconds from the time `current`. If `switched` is not NULL, the
   step ends early at its first switch, and sets *switched to 1. */
fmi2Status do_communication_step(Instance *i, double current, double h, int *switched);

/* Refuses a communication step from a wrong time, or of a wrong size h. */
fmi2Status check_step(Instance *i, double current, double h);

/* Advances to the time `end`, while inputs follow their slopes; `switched` as above. */
fmi2Status advance_to(Instance *i, double end, int *switched);

/* Does a step with intermediate updates; `returned` reports whether the importer ended it early. */
fmi2Status do_step_with_updates(Instance *i, double current, double h, int *switched,
                                int *returned);

/* Register the inputs among the variables that the importer requires in intermediate updates;
   returns whether all are variables. Those that are not continuous are ignored. */
int register_updates(Instance *i, const fmi3ValueReference *needed, size_t count);

/* The phase as a phrase, as in "not allowed while stepping". */
const char *phase_name(const Instance *i);

/* Reset to the state of a new instance. */
void clear_state(State *s);

/* Log a message for a call that returns `status`, a warning or failure; returns `status`. */
fmi2Status report(Instance *i, fmi2Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Format a text into `i->reason`; returns it. */
const char *set_reason(Instance *i, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Advice, and whether it applies. */
typedef struct {
    const char *text;
    int applies;
} Remedy;

/* Append "; use A, B or C" to the reason, from the remedies that apply; returns the reason. */
const char *advise(Instance *i, const Remedy *remedies, int count);

/* The reason why a communication step stopped at t: the motion needed too many steps of its own. */
const char *step_limit_reason(Instance *i, double t);

/* A number as the shortest text that reads back as the number, like Python's `repr`. */
typedef struct {
    char text[40];
} Number;
Number format_number(double value);

/* A set of one phase; sets are joined by |. */
#define IN(phase) (1u << (phase))
/* The phases after initialization, and all phases in which outputs can be computed. */
#define INITIALIZED (IN(STEPPING) | IN(EVENTS) | IN(CONTINUOUS))
#define READABLE (IN(INITIALIZATION) | INITIALIZED | IN(TERMINATED))
/* Return from an FMI function with a failure, unless the instance is of a type (or ANY_TYPE) and in
   one of some phases. */
#define REQUIRE(instance, call, type, phases)                            \
    do {                                                                 \
        fmi2Status status_ = check_call(instance, call, type, phases);   \
        if (status_ != fmi2OK)                                           \
            return status_;                                              \
    } while (0)
/* Both co-simulation and model exchange. */
enum { ANY_TYPE = -1 };
fmi2Status check_call(Instance *i, const char *call, int type, unsigned phases);

/* Begin the motion and compute the outputs, if needed. */
fmi2Status update_outputs(Instance *i);
/* The same, and compute the totals (`component.h`). */
fmi2Status update_totals(Instance *i);

/* Refuse reading while an intermediate update asks for inputs. */
fmi2Status check_readable(Instance *i);

/* Refuse a computed value that is not finite. */
fmi2Status check_finite(Instance *i, const char *name, double value);

/* The event indicators: as many numbers as COMPONENT.indicator_count. */
fmi2Status compute_indicators(Instance *i, double *indicators);

/* For each known variable, the sum over the unknowns of seed times partial derivative. */
fmi2Status get_adjoint_derivative(Instance *i, const fmi2ValueReference unknowns[],
                                  size_t unknown_count, const fmi2ValueReference knowns[],
                                  size_t known_count, const fmi2Real seeds[], fmi2Real result[]);

#pragma GCC visibility pop

#endif
