/* The experiment that an importer sets up, and the initialization. */

#include <math.h>

#include "instance.h"

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean with_stop, fmi2Real stop)
{
    Instance *i = c;
    REQUIRE(i, "setup_experiment", ANY_TYPE, IN(INSTANTIATED));
    State *s = &i->s;
    if (!isfinite(start))
        return report(i, fmi2Error, "start time = %g: must be a finite number of seconds", start);
    if (with_stop && !(isfinite(stop) && stop >= start))
        return report(i, fmi2Error, "stop time = %g: must be at least %g s", stop, start);
    if (with_tolerance && isnan(tolerance))
        return report(i, fmi2Error, "tolerance = nan: must be from %g to %g", LEAST_TOLERANCE,
                      GREATEST_TOLERANCE);
    s->start_time = start, s->stop_time = with_stop ? stop : INFINITY;
    /* The motion must begin anew under these settings. */
    s->is_set_up = 1, s->has_motion = 0;
    if (!with_tolerance)
        return fmi2OK;
    s->tolerance = fmin(fmax(tolerance, LEAST_TOLERANCE), GREATEST_TOLERANCE);
    if (s->tolerance == tolerance)
        return fmi2OK;
    return report(i, fmi2Warning, "tolerance = %g: must be from %g to %g, %g is used", tolerance,
                  LEAST_TOLERANCE, GREATEST_TOLERANCE, s->tolerance);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    Instance *i = c;
    REQUIRE(i, "enter_initialization_mode", ANY_TYPE, IN(INSTANTIATED));
    if (!i->s.is_set_up)
        return report(i, fmi2Error,
                      "enter_initialization_mode is not allowed before setup_experiment");
    i->s.phase = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *i = c;
    REQUIRE(i, "exit_initialization_mode", ANY_TYPE, IN(INITIALIZATION));
    const fmi2Status status = update_outputs(i);
    if (status != fmi2OK)
        return status;
    const char *reason = COMPONENT.check_values ? COMPONENT.check_values(i, i->s.values) : NULL;
    if (reason)
        return report(i, fmi2Error, "%s", reason);
    i->s.phase = i->type == fmi2CoSimulation ? STEPPING : EVENTS;
    const char *warning = COMPONENT.find_warning ? COMPONENT.find_warning(i) : NULL;
    /* The call returns fmi2OK even with a warning, because the values are valid. */
    if (warning)
        report(i, fmi2Warning, "%s", warning);
    return fmi2OK;
}
