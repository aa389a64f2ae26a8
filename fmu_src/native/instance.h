/* An instance, and how its calls are checked, refused and logged. */

#ifndef FIVTUI_FMU_INSTANCE_H
#define FIVTUI_FMU_INSTANCE_H

#include "component.h"
#ifdef __ELF__
/* The functions of FMI call each other, not those of the same name that a host or FMU may have. */
#define visibility(kind) visibility("protected")
#endif
#include "fmi2Functions.h"
#include "fmi3Functions.h"
#undef visibility

/* Not to be taken for functions of the same name elsewhere in the process. */
#pragma GCC visibility push(hidden)

enum { MOST_VARIABLES = 48, MOST_STATES = 4, MOST_INDICATORS = 4, MOTION_ROOM = 288, TEXT = 320 };

/* The last is within a step alone, and never in a state that is saved. */
typedef enum {
    INSTANTIATED, INITIALIZATION, STEPPING, EVENTS, CONTINUOUS, TERMINATED, INTERMEDIATE
} Phase;

/* Categories of messages, as the model description names them. */
typedef enum { WARNINGS, DISCARDS, ERRORS, CATEGORIES } Category;

/* All that decides what comes next. `t` is the time reached, s. Up to `free_until` a step needs no
   computation and is allowed: the last one was well, and no switch is pending. `begun` says that the
   motion is of the values, `published` that the outputs are of the motion. `slopes` are those of the
   inputs over the next communication step; `are_left`: the inputs are as the last step left them;
   `is_pending`: a switch has been reached, and its event mode not entered; `states` are the importer's in model exchange. */
typedef struct {
    Phase phase;
    fmi2Status last_step;
    int is_set_up, begun, published, is_sloped, are_left, is_pending;
    double start_time, stop_time, tolerance, t, free_until;
    double values[MOST_VARIABLES], slopes[MOST_VARIABLES], states[MOST_STATES];
    double motion[MOTION_ROOM];
} State;

typedef struct Instance {
    State s;
    fmi2Type type;
    fmi2CallbackFunctions callbacks;
    char *name;
    int logging[CATEGORIES];
    /* FMI 3.0: the logger; whether there is an event mode in co-simulation, whether steps may return
       early, and whether they end at switches. */
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    int uses_events, returns_early, announces;
    /* Intermediate updates: inputs that the importer sets in them, and whether it may do so now. */
    fmi3IntermediateUpdateCallback update;
    unsigned char updated[MOST_VARIABLES];
    int updates_inputs, asks;
    /* The component's choice for this processor. */
    const void *stepping;
    char why[TEXT];
} Instance;

/* An instance, NULL with a message if the name or the GUID are wrong; `like` has its loggers. */
Instance *make_instance(const Instance *like, const char *name, const char *guid);

/* A communication step; with `switched` it may end at a switch, and says so. */
fmi2Status take_communication_step(Instance *i, double current, double h, int *switched);

/* The parts of it: refuse a wrong time or step size; move on to `end`, along the slopes of the
   inputs, or to the first switch before it. */
fmi2Status check_step(Instance *i, double current, double h);
fmi2Status advance_to(Instance *i, double end, int *switched);

/* The same with intermediate updates; `returned` says whether the importer made it end early. */
fmi2Status take_updated_step(Instance *i, double current, double h, int *switched, int *returned);

/* Register the inputs among the variables that the importer requires in intermediate updates;
   returns whether all are variables. Those that are not continuous are ignored. */
int prepare_updates(Instance *i, const fmi3ValueReference *needed, size_t count);

/* The phase in words, as in "not allowed while stepping". */
const char *phase_name(const Instance *i);

/* Back to how an instance begins. */
void clear_state(State *s);

/* Log why a call is refused; returns its status. */
fmi2Status refuse(Instance *i, fmi2Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Put a text together in `i->why`, for functions that return one. */
const char *because(Instance *i, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Append "; use A, B or C" to that reason, of the remedies that apply; returns it. */
typedef struct {
    const char *text;
    int applies;
} Remedy;
const char *advise(Instance *i, const Remedy *remedies, int count);

/* Why a communication step of too many steps of the motion is given up at t. */
const char *needs_too_much(Instance *i, double t);

/* Shortest text that reads back as the number, as Python writes it. */
typedef struct {
    char text[40];
} Number;
Number number(double value);

/* Refuse a call unless the instance is of a type and in one of some phases. */
#define IN(phase) (1u << (phase))
#define INITIALIZED (IN(STEPPING) | IN(EVENTS) | IN(CONTINUOUS))
#define COMPUTED (IN(INITIALIZATION) | INITIALIZED | IN(TERMINATED))
#define ALLOWED(call, type, phases)                          \
    do {                                                     \
        fmi2Status status_ = allow(c, call, type, phases);   \
        if (status_ != fmi2OK)                               \
            return status_;                                  \
    } while (0)
enum { EITHER = -1 };
fmi2Status allow(Instance *i, const char *call, int type, unsigned phases);

/* Bring motion and outputs up to date. */
fmi2Status ready(Instance *i);

/* Refuse to read values while the importer is asked for inputs. */
fmi2Status check_reading(Instance *i);

/* Refuse a computed value that is not finite. */
fmi2Status check_finite(Instance *i, const char *name, double value);

/* The event indicators, COMPONENT.indicator_count numbers. */
fmi2Status compute_indicators(Instance *i, double *indicators);

/* For each known, the sum over the unknowns of the seed times the derivative by the known. */
fmi2Status get_adjoint_derivative(Instance *i, const fmi2ValueReference unknowns[],
                                  size_t unknown_count, const fmi2ValueReference knowns[],
                                  size_t known_count, const fmi2Real seeds[], fmi2Real result[]);

#pragma GCC visibility pop

#endif
