/* Instances: creation, logging, phases. */

#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const CATEGORY_NAMES[CATEGORIES] = {
    "logStatusWarning", "logStatusDiscard", "logStatusError",
};
static const char *const PHASE_NAMES[] = {
    "before initialization", "in initialization mode",  "while stepping",
    "in event mode",         "in continuous-time mode", "after termination",
    "during an intermediate update",
};
/* The tolerance if none is given: `DEFAULT_TOL` in `fivtui.taylor.stepper`. */
#define DEFAULT_TOLERANCE 1e-12

const char *phase_name(const Instance *i) { return PHASE_NAMES[i->s.phase]; }

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

void clear_state(State *s)
{
    memset(s, 0, sizeof *s);
    /* −INFINITY: nothing is computed ahead. */
    s->stop_time = INFINITY, s->tolerance = DEFAULT_TOLERANCE, s->fast_until = -INFINITY;
    for (uint32_t r = 0; r < COMPONENT.variable_count; r++)
        s->values[r] = COMPONENT.variables[r].start;
}

Number format_number(double value)
{
    Number number = {"nan"};
    if (isnan(value))
        return number;
    /* Doubles have 15 digits for certain, and need at most 17 to be read back. */
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(number.text, sizeof number.text, "%.*g", digits, value);
        if (strtod(number.text, NULL) == value)
            break;
    }
    if (isfinite(value) && !strpbrk(number.text, ".,e"))
        strcat(number.text, ".0");
    return number;
}

static void log_text(Instance *i, fmi2Status status, const char *text)
{
    const Category category = status == fmi2Warning   ? WARNINGS
                              : status == fmi2Discard ? DISCARDS
                                                      : ERRORS;
    if (!i->logging[category])
        return;
    if (i->log)
        i->log(i->environment, (fmi3Status)status, CATEGORY_NAMES[category], text);
    else if (i->callbacks.logger)
        i->callbacks.logger(i->callbacks.componentEnvironment, i->name, status,
                            CATEGORY_NAMES[category], text);
}

fmi2Status report(Instance *i, fmi2Status status, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    log_text(i, status, text);
    return status;
}

const char *set_reason(Instance *i, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(i->reason, sizeof i->reason, format, arguments);
    va_end(arguments);
    return i->reason;
}

const char *advise(Instance *i, const Remedy *remedies, int count)
{
    int applying = 0, listed = 0;
    for (int n = 0; n < count; n++)
        applying += remedies[n].applies != 0;
    for (int n = 0; n < count; n++) {
        if (!remedies[n].applies)
            continue;
        /* "; use " before the first, " or " before the last, commas between the others. */
        const char *separator = !listed ? "; use " : listed + 1 < applying ? ", " : " or ";
        const size_t length = strlen(i->reason);
        snprintf(i->reason + length, sizeof i->reason - length, "%s%s", separator,
                 remedies[n].text);
        listed++;
    }
    return i->reason;
}

const char *step_limit_reason(Instance *i, double t)
{
    return set_reason(i, "the step is stopped at t = %g s, because it needs too much computation; "
                         "use a shorter step", t);
}

fmi2Status check_call(Instance *i, const char *call, int type, unsigned phases)
{
    if (!i)
        return fmi2Error;
    if (type != ANY_TYPE && type != (int)i->type)
        return report(i, fmi2Error, "%s is for %s", call,
                      type == fmi2CoSimulation ? "co-simulation" : "model exchange");
    if (!(phases & IN(i->s.phase)))
        return report(i, fmi2Error, "%s is not allowed %s", call, phase_name(i));
    return fmi2OK;
}

fmi2Status update_outputs(Instance *i)
{
    State *s = &i->s;
    if (!s->has_motion) {
        const char *reason = COMPONENT.begin(i);
        if (reason)
            return report(i, fmi2Error, "%s", reason);
        s->t = s->start_time, s->has_motion = 1, s->has_outputs = 0;
        /* The motion has begun with these inputs; slopes change them from the next step on. */
        s->has_inputs_of_step = !s->has_slopes;
    }
    if (!s->has_outputs) {
        COMPONENT.compute_outputs(i);
        s->has_outputs = 1;
    }
    return fmi2OK;
}

fmi2Status update_totals(Instance *i)
{
    const fmi2Status status = update_outputs(i);
    if (status == fmi2OK && COMPONENT.compute_totals)
        COMPONENT.compute_totals(i);
    return status;
}

Instance *make_instance(const Instance *settings, const char *name, const char *guid)
{
    const char *instance_name = name ? name : "";
    Instance *i = calloc(1, sizeof *i);
    if (!i)
        return NULL;
    *i = *settings;
    i->name = malloc(strlen(instance_name) + 1);
    if (!i->name) {
        free(i);
        return NULL;
    }
    strcpy(i->name, instance_name);
    for (int category = 0; category < CATEGORIES; category++)
        i->logging[category] = 1;
    if (!*instance_name || !guid || strcmp(guid, COMPONENT.guid) != 0) {
        if (!*instance_name)
            report(i, fmi2Error, "the name of the instance is empty");
        else
            report(i, fmi2Error, "the GUID is not that of this FMU, %s", COMPONENT.guid);
        fmi2FreeInstance(i);
        return NULL;
    }
    clear_state(&i->s);
    return i;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    /* There are no debug messages that `logging` could select. Refusals are logged, until
       fmi2SetDebugLogging switches their category off. */
    (void)resources, (void)visible, (void)logging;
    if (!callbacks || (type != fmi2CoSimulation && type != fmi2ModelExchange))
        return NULL;
    const Instance settings = {.type = type, .callbacks = *callbacks};
    return make_instance(&settings, name, guid);
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *i = c;
    if (i && i->s.phase == INTERMEDIATE) {
        /* The step continues, and needs the instance. */
        report(i, fmi2Error, "free_instance is not allowed %s", phase_name(i));
    } else if (i) {
        free(i->name);
        free(i);
    }
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String categories[])
{
    Instance *i = c;
    int chosen[CATEGORIES] = {0};
    if (!i)
        return fmi2Error;
    for (size_t n = 0; n < count; n++) {
        const char *name = categories && categories[n] ? categories[n] : "";
        const int is_all = strcmp(name, "logAll") == 0;
        int is_known = is_all;
        for (int category = 0; category < CATEGORIES; category++)
            if (is_all || strcmp(name, CATEGORY_NAMES[category]) == 0)
                is_known = chosen[category] = 1;
        if (!is_known)
            return report(i, fmi2Error, "there is no such category of messages");
    }
    for (int category = 0; category < CATEGORIES; category++)
        if (count == 0 || chosen[category])
            i->logging[category] = on != 0;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    Instance *i = c;
    REQUIRE(i, "terminate", ANY_TYPE, INITIALIZED);
    i->s.phase = TERMINATED, i->s.fast_until = -INFINITY;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    Instance *i = c;
    REQUIRE(i, "reset", ANY_TYPE, ~IN(INTERMEDIATE));
    clear_state(&i->s);
    return fmi2OK;
}
