"""The slider-belt model for co-simulation."""

from dataclasses import astuple
from typing import Any

from pythonfmu.default_experiment import DefaultExperiment

from fivtui.model.modes import Mode
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import DEFAULT_TOL, StepperSnapshot

from .experiment import Experiment
from .instance import Instance
from .instance_state import Phase
from .motion import (
    MotionState,
    SliderBeltMotion,
    Values,
    check_friction,
    fixed_values,
    motion_from,
    start_state,
    unused_values,
)
from .variable import Type
from .variables import INPUTS, REFERENCES, SLIDER_BELT_TABLE, STATES, SUMMARY

_F, _MU, _V_BELT = (REFERENCES[name] for name in INPUTS)
_X, _VX, _Y, _VY = (REFERENCES[name] for name in STATES)
_P, _ON_SLIDER, _ON_BELT, _SWITCHING, _AX, _AY = (
    REFERENCES[name] for name in ("P", "friction_slider", "friction_belt", "switching", "ax", "ay")
)
_MODE, _MODE_INTEGER, _MODE_ENUMERATION = (
    REFERENCES[name] for name in ("mode", "mode_integer", "mode_enumeration")
)
_SEPARATIONS, _REATTACHMENTS, _SWITCHES, _STICKS, _LAST_EVENT = (
    REFERENCES[name]
    for name in ("separations", "reattachments", "switches", "sticks", "last_event")
)


class SliderBeltInstance(Instance):
    """One instance of the slider-belt model."""

    TABLE = SLIDER_BELT_TABLE

    def __init__(self, **kwargs: Any) -> None:
        default = DefaultExperiment(0.0, 100.0, 0.01, DEFAULT_TOL)
        super().__init__(SUMMARY, default, **kwargs)
        self.modelName = "SliderBelt"
        self._motion: SliderBeltMotion
        # Tolerance and fixed parameters of the motion.
        self._fixed_inputs: tuple[float, ...] = ()

    def _begin_motion(self, experiment: Experiment) -> None:
        state = start_state(self._values)
        self._motion = motion_from(self._values, state, t=experiment.start_time, tol=experiment.tol)
        self._fixed_inputs = _fixed_inputs(self._values, experiment)

    def _remark(self) -> str:
        return unused_values(self._values)

    def _move_on(self, end: float, experiment: Experiment) -> None:
        values = self._values
        self._motion.move_to(end, F=values[_F], mu=values[_MU], v_belt=values[_V_BELT])
        self._free_until = min(self._motion.known_until, experiment.stop_time)

    def _publish(self) -> None:
        motion, values = self._motion, self._values
        current, state = motion.current, motion.state_at(self._t)
        force = motion.contact_force(state[2])
        mode, friction, accelerations = motion.forces(
            state, force, F=values[_F], mu=values[_MU], v_belt=values[_V_BELT]
        )
        # Assigned one by one for speed: reading outputs spends most time here.
        values[_X], values[_VX], values[_Y], values[_VY] = state
        values[_P], values[_ON_SLIDER], values[_ON_BELT] = force, friction, -friction
        values[_SWITCHING] = state[2]
        values[_AX], values[_AY] = accelerations
        values[_MODE] = values[_MODE_INTEGER] = values[_MODE_ENUMERATION] = mode
        values[_SEPARATIONS], values[_REATTACHMENTS] = current.separations, current.reattachments
        values[_SWITCHES], values[_STICKS] = current.switches, current.sticks
        values[_LAST_EVENT] = current.last_event

    def _checked(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = super()._checked(reference, kind, value)
        if reference == _MU and self._phase is Phase.STEPPING:
            check_friction({**self._values, _MU: checked})
        return checked

    def _motion_state(self) -> MotionState:
        at = self._motion.current
        if at.t != self._t:
            self._motion.move_to(self._t, F=at.F, mu=at.mu, v_belt=at.v_belt)
        return self._motion.current

    def _resume(
        self, values: dict[int, float | bool], experiment: Experiment, current: MotionState
    ) -> None:
        fixed_inputs = _fixed_inputs(values, experiment)
        if fixed_inputs != self._fixed_inputs:
            motion = motion_from(values, current.state, t=current.t, tol=experiment.tol)
            self._motion, self._fixed_inputs = motion, fixed_inputs
        self._motion.restore(current)

    @staticmethod
    def _to_json(current: MotionState) -> Any:
        segment = current.segment
        return {**current._asdict(), "segment": None if segment is None else astuple(segment)}

    @staticmethod
    def _from_json(content: Any) -> MotionState:
        t, remainder, state, mode, stalled = content["stepper"]
        segment = content["segment"]
        return MotionState(
            **content
            | {
                "state": tuple(content["state"]),
                "mode": Mode(content["mode"]),
                "stepper": StepperSnapshot(t, remainder, tuple(state), Mode(mode), stalled),
                "segment": None if segment is None else _segment(segment),
            }
        )


def _fixed_inputs(values: Values, experiment: Experiment) -> tuple[float, ...]:
    return (experiment.tol, *fixed_values(values))


def _segment(content: list[Any]) -> Segment:
    mode, start, remainder, duration, end, x, y, final, next_mode = content
    times = start, remainder, duration, end
    return Segment(Mode(mode), *times, tuple(x), tuple(y), tuple(final), Mode(next_mode))
