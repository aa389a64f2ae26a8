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
    s->stop_time = INFINITY, s->tolerance = DEFAULT_TOLERANCE, s->free_until = -INFINITY;
    for (uint32_t r = 0; r < COMPONENT.variable_count; r++)
        s->values[r] = COMPONENT.variables[r].start;
}

Number number(double value)
{
    Number n = {"nan"};
    if (isnan(value))
        return n;
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(n.text, sizeof n.text, "%.*g", digits, value);
        if (strtod(n.text, NULL) == value)
            break;
    }
    if (isfinite(value) && !strpbrk(n.text, ".,e"))
        strcat(n.text, ".0");
    return n;
}

static void say(Instance *i, fmi2Status status, const char *text)
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

fmi2Status refuse(Instance *i, fmi2Status status, const char *format, ...)
{
    char text[TEXT];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    say(i, status, text);
    return status;
}

const char *because(Instance *i, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(i->why, sizeof i->why, format, arguments);
    va_end(arguments);
    return i->why;
}

const char *advise(Instance *i, const Remedy *remedies, int count)
{
    int applying = 0, listed = 0;
    for (int n = 0; n < count; n++)
        applying += remedies[n].applies != 0;
    for (int n = 0; n < count; n++) {
        if (!remedies[n].applies)
            continue;
        const char *joint = !listed ? "; use " : listed + 1 < applying ? ", " : " or ";
        const size_t length = strlen(i->why);
        snprintf(i->why + length, sizeof i->why - length, "%s%s", joint, remedies[n].text);
        listed++;
    }
    return i->why;
}

const char *needs_too_much(Instance *i, double t)
{
    return because(i, "the step needs too much computation, it is given up at t = %g s; use a "
                      "shorter step", t);
}

fmi2Status allow(Instance *i, const char *call, int type, unsigned phases)
{
    if (!i)
        return fmi2Error;
    if (type != EITHER && type != (int)i->type)
        return refuse(i, fmi2Error, "%s is for %s", call,
                      type == fmi2CoSimulation ? "co-simulation" : "model exchange");
    if (!(phases & IN(i->s.phase)))
        return refuse(i, fmi2Error, "%s is not allowed %s", call, phase_name(i));
    return fmi2OK;
}

fmi2Status ready(Instance *i)
{
    State *s = &i->s;
    if (!s->begun) {
        const char *why = COMPONENT.begin(i);
        if (why)
            return refuse(i, fmi2Error, "%s", why);
        s->t = s->start_time, s->begun = 1, s->published = 0;
        s->are_left = !s->is_sloped;
    }
    if (!s->published) {
        COMPONENT.publish(i);
        s->published = 1;
    }
    return fmi2OK;
}

Instance *make_instance(const Instance *like, const char *name, const char *guid)
{
    const char *given = name ? name : "";
    Instance *i = calloc(1, sizeof *i);
    if (!i)
        return NULL;
    *i = *like;
    i->name = malloc(strlen(given) + 1);
    if (!i->name) {
        free(i);
        return NULL;
    }
    strcpy(i->name, given);
    for (int category = 0; category < CATEGORIES; category++)
        i->logging[category] = 1;
    if (!*given || !guid || strcmp(guid, COMPONENT.guid) != 0) {
        if (!*given)
            refuse(i, fmi2Error, "the name of the instance is empty");
        else
            refuse(i, fmi2Error, "the GUID is not that of this FMU, %s", COMPONENT.guid);
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
    /* There is nothing to say for debugging: refusals are told without it. */
    (void)resources, (void)visible, (void)logging;
    if (!callbacks || (type != fmi2CoSimulation && type != fmi2ModelExchange))
        return NULL;
    const Instance like = {.type = type, .callbacks = *callbacks};
    return make_instance(&like, name, guid);
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *i = c;
    if (i && i->s.phase == INTERMEDIATE) {
        /* The step goes on. */
        refuse(i, fmi2Error, "free_instance is not allowed %s", phase_name(i));
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
        const int all = strcmp(name, "logAll") == 0;
        int found = all;
        for (int category = 0; category < CATEGORIES; category++)
            if (all || strcmp(name, CATEGORY_NAMES[category]) == 0)
                found = chosen[category] = 1;
        if (!found)
            return refuse(i, fmi2Error, "there is no such category of messages");
    }
    for (int category = 0; category < CATEGORIES; category++)
        if (count == 0 || chosen[category])
            i->logging[category] = on != 0;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    Instance *i = c;
    ALLOWED("terminate", EITHER, INITIALIZED);
    i->s.phase = TERMINATED, i->s.free_until = -INFINITY;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    Instance *i = c;
    ALLOWED("reset", EITHER, ~IN(INTERMEDIATE));
    clear_state(&i->s);
    return fmi2OK;
}
