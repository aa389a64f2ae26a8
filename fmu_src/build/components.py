"""The components that FMUs can be built of, with their documentation and reference runs."""

import math
from collections.abc import Mapping
from typing import Any, Final

from fivtui.model import Parameters
from fivtui.taylor import DEFAULT_TOL
from fmu_src.slave import (
    ACTUATOR_SUMMARY,
    ACTUATOR_TABLE,
    SLIDER_BELT_TABLE,
    SUMMARY,
    VARIABLES,
    SliderBeltMotion,
    start_state,
)

from .component import Component, Reference, Terminal

# Modules that the Python FMUs contain: of every instance, and of the model.
_INSTANCE_MODULES: Final = ("experiment", "instance", "instance_state", "variable")
_MODEL_MODULES: Final[Mapping[str, tuple[str, ...]]] = {
    "fivtui.model": (
        "advice",
        "columns",
        "errors",
        "field",
        "modes",
        "numbers",
        "over_time",
        "parameters",
        "slider_belt",
        "system",
    ),
    "fivtui.taylor": (
        "belt",
        "expression",
        "extremes",
        "polynomial",
        "recurrence",
        "segment",
        "series",
        "stepper",
    ),
}
# Communication step and stop time of the reference runs, s.
_STEP_SIZE: Final = 0.01
_STOP_TIME: Final = 20.0
# Jump of preload or command in the reference run: time, s; forces before and after, N.
_JUMP_TIME: Final = 10.0
_FORCE_BEFORE: Final = 80.0
_FORCE_AFTER: Final = 120.0
# Contact force that is fed back to the actuator, as a fraction of the preload before the jump.
_FEEDBACK_RATIO: Final = 0.75


def _times() -> list[float]:
    return [count * _STEP_SIZE for count in range(round(_STOP_TIME / _STEP_SIZE) + 1)]


def _slider_belt_reference() -> Reference:
    p, p_after = Parameters(F=_FORCE_BEFORE), Parameters(F=_FORCE_AFTER)
    start = start_state({value_reference: v.start for value_reference, v in enumerate(VARIABLES)})
    motion = SliderBeltMotion(p, start, t=0.0, separation=True, tol=DEFAULT_TOL)
    names = ("x", "vx", "y", "vy", "P", "separations", "reattachments")
    rows = []
    for t in _times():
        if t > _JUMP_TIME:
            p = p_after
        if t > 0.0:
            motion.move_to(t, p)
        current = motion.current
        x, vx, y, vy = current.state
        force = motion.contact_force(y, p)
        rows.append((t, x, vx, y, vy, force, current.separations, current.reattachments))
    return Reference(
        stop_time=_STOP_TIME,
        step=_STEP_SIZE,
        tol=DEFAULT_TOL,
        inputs={
            "time": (0.0, _JUMP_TIME, _JUMP_TIME, _STOP_TIME),
            "F": (_FORCE_BEFORE, _FORCE_BEFORE, _FORCE_AFTER, _FORCE_AFTER),
            "mu": (p.mu,) * 4,
        },
        outputs=dict(zip(("time", *names), zip(*rows, strict=True), strict=True)),
    )


def _actuator_reference() -> Reference:
    starts: Mapping[str, Any] = {v.name: v.start for v in ACTUATOR_TABLE.variables}
    tau, gain, start_force = starts["tau"], starts["gain"], starts["F_start"]
    feedback = _FEEDBACK_RATIO * _FORCE_BEFORE

    target_before, target_after = (
        command + gain * (command - feedback) for command in (_FORCE_BEFORE, _FORCE_AFTER)
    )

    def preload(t: float) -> float:
        decay = math.exp(-min(t, _JUMP_TIME) / tau)
        force: float = target_before + (start_force - target_before) * decay
        if t > _JUMP_TIME:
            force = target_after + (force - target_after) * math.exp((_JUMP_TIME - t) / tau)
        return force

    times = _times()
    return Reference(
        stop_time=_STOP_TIME,
        step=_STEP_SIZE,
        tol=DEFAULT_TOL,
        inputs={
            "time": (0.0, _JUMP_TIME, _JUMP_TIME, _STOP_TIME),
            "command": (_FORCE_BEFORE, _FORCE_BEFORE, _FORCE_AFTER, _FORCE_AFTER),
            "P": (feedback,) * 4,
        },
        outputs={"time": times, "F": [preload(t) for t in times]},
    )


_SLIDER_BELT_ABOUT: Final = """\
<p>A slider pressed on a moving belt, the minimal model of brake squeal. With a = k1 + k3/2,
h = k3/2 and the contact force P, positive in compression:</p>
<pre>
m x'' + c1 x' + a x - h y = mu P
m y'' + c2 y' + h y - h x = P - F
P = -k2 y - k_nl y^3   in contact (y &lt; 0),   P = 0   when separated (y &gt; 0)
</pre>
<p>With separation = false the slider never separates: P = -k2 y - k_nl y^3 for all y.</p>
<p>With finite_belt = false a slider in contact always slides (mode 1), as on a belt that is faster
than the greatest vx. Impact at reattachment is not modelled.</p>
<p>With finite_belt = true the belt has the speed v_belt, an input, and v_r = v_belt - vx. In
contact the friction force on the slider is mu(v_r) P in forward slip (v_r &gt; 0, mode 2) and
-mu(|v_r|) P in backward slip (v_r &lt; 0, mode 3). In stick (v_r = 0, mode 4) it is the holding
force f = c1 v_belt + m dv_belt/dt + a x - h y, as long as |f| is at most mu_s P. A separated slider
is in mode 0. mu(v) = mu + (mu_s - mu) exp(-v/v_s). With v_s = 0 friction is static only in stick;
mu_s = 0 stands for mu_s = mu. mu above mu_s is refused; to raise both, set them in one call, or
mu_s first. With a negative v_belt the belt runs backward. With finite_belt = false, v_belt other
than 0 and its default is refused.</p>
"""
_EVENTS_ABOUT: Final = """\
<p>State events (separation and reattachment at y = 0; where stick and slip begin) are located
to rounding inside a communication step. An event is counted at the first communication
point at or after its time.</p>
<p>The page "What a tolerance promises" of fivtui's manual defines the accuracy of the relative
tolerance.</p>
"""
_ACTUATOR_ABOUT: Final = """\
<p>A brake actuator: the preload F follows a commanded contact force with a first-order lag; the
contact force P is fed back.</p>
<pre>
tau dF/dt = command + gain (command - P) - F
</pre>
<p>Inputs are held over a communication step; the solution over it is exact.</p>
"""

# In both components, so that they can be connected by it.
_PRELOAD: Final = {"preload": Terminal("preload, and contact force fed back", {"F": "F", "P": "P"})}
_FRICTION: Final = {
    "friction": Terminal(
        "friction force of the slider on the belt, and speed of the belt",
        {"force": "friction_belt", "speed": "v_belt"},
    )
}

COMPONENTS: Final[Mapping[str, Component]] = {
    "slider-belt": Component(
        model="SliderBelt",
        entry="entry",
        modules={
            **_MODEL_MODULES,
            "fmu_src.slave": (*_INSTANCE_MODULES, "motion", "slider_belt", "variables"),
        },
        variable_table=SLIDER_BELT_TABLE,
        terminals=_PRELOAD | _FRICTION,
        description=SUMMARY,
        about_html=_SLIDER_BELT_ABOUT + _EVENTS_ABOUT,
        reference_run=_slider_belt_reference,
    ),
    "brake-actuator": Component(
        model="BrakeActuator",
        entry="actuator_entry",
        modules={
            # The actuator's tolerance and advice come from modules that import many of the others.
            **_MODEL_MODULES,
            "fmu_src.slave": (*_INSTANCE_MODULES, "actuator", "actuator_variables"),
        },
        variable_table=ACTUATOR_TABLE,
        terminals=_PRELOAD,
        description=ACTUATOR_SUMMARY,
        about_html=_ACTUATOR_ABOUT,
        reference_run=_actuator_reference,
    ),
}
DEFAULT_COMPONENT: Final = "slider-belt"
