"""The slider-belt model for co-simulation."""

from dataclasses import astuple
from typing import Any, Final

from pythonfmu.default_experiment import DefaultExperiment

from fivtui.model.errors import InputError
from fivtui.model.modes import ALWAYS_SLIDING, MODES, Mode
from fivtui.model.slider_belt import State
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import DEFAULT_TOL, StepperSnapshot

from .experiment import Experiment
from .instance import Instance
from .instance_state import DAMAGED, Phase, number, numbers
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
_FINITE_BELT = REFERENCES["finite_belt"]
_SEPARATIONS, _REATTACHMENTS, _SWITCHES, _STICKS, _LAST_EVENT = (
    REFERENCES[name]
    for name in ("separations", "reattachments", "switches", "sticks", "last_event")
)


# Counts, and all numbers of a `MotionState`.
_COUNTS: Final = ("separations", "reattachments", "switches", "sticks")
_OF_MOTION: Final = ("t", "F", "mu", *_COUNTS, "last_event")
_ROUNDING: Final = 2.0**-50


class SliderBeltInstance(Instance):
    """One instance of the slider-belt model."""

    TABLE = SLIDER_BELT_TABLE

    def __init__(self, **kwargs: Any) -> None:
        default = DefaultExperiment(0.0, 100.0, 0.01, DEFAULT_TOL)
        super().__init__(SUMMARY, default, **kwargs)
        self.modelName = "SliderBelt"
        self._motion: SliderBeltMotion
        # Tolerance and fixed parameters of the motion.
        self._made_of: tuple[float, ...] = ()

    def _begin_motion(self, experiment: Experiment) -> None:
        state = start_state(self._values)
        self._motion = motion_from(self._values, state, t=experiment.start_time, tol=experiment.tol)
        self._made_of = _made_of(self._values, experiment)

    def _remark(self) -> str:
        return unused_values(self._values)

    def _go_on(self, end: float, experiment: Experiment) -> None:
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
        # Assigned one by one, as this is most of the cost of reading.
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
        made_of = _made_of(values, experiment)
        if (current.v_belt is not None) is not bool(values[_FINITE_BELT]):
            raise InputError(DAMAGED)
        if made_of != self._made_of:
            motion = motion_from(values, current.state, t=current.t, tol=experiment.tol)
            self._motion, self._made_of = motion, made_of
        self._motion.restore(current)

    @staticmethod
    def _to_json(current: MotionState) -> Any:
        segment = current.segment
        return {**current._asdict(), "segment": None if segment is None else astuple(segment)}

    @staticmethod
    def _from_json(content: Any) -> MotionState:
        speed, mode = content["v_belt"], Mode(content["mode"])
        *stepper, ahead, then, stalled = content["stepper"]
        t, remainder = _exact_time(*stepper)
        segment = content["segment"]
        made = {
            **{name: number(content[name]) for name in _OF_MOTION},
            "v_belt": None if speed is None else number(speed),
            "state": _state(content["state"]),
            "mode": mode,
            "stepper": StepperSnapshot(t, remainder, _state(ahead), Mode(then), number(stalled)),
            "segment": None if segment is None else _segment(segment),
        }
        finite = speed is not None
        if len(made) != len(content) or not {mode, Mode(then)} <= _modes(finite=finite):
            raise ValueError
        return MotionState(**made)


def _made_of(values: Values, experiment: Experiment) -> tuple[float, ...]:
    return (experiment.tol, *fixed_values(values))


def _modes(*, finite: bool) -> set[Mode]:
    # Those on a belt of finite speed, or on one that is always faster.
    on_belt = {mode for mode, row in MODES.items() if row.finite_belt or mode is Mode.SEPARATED}
    return on_belt if finite else set(ALWAYS_SLIDING)


def _exact_time(t: object, remainder: object) -> tuple[Any, ...]:
    # A time, and what it lacks of the exact one by rounding.
    found = numbers([t, remainder], 2)
    if abs(found[1]) > _ROUNDING * (abs(found[0]) + 1.0):
        raise ValueError
    return found


def _segment(content: list[Any]) -> Segment:
    mode, start, remainder, duration, end, x, y, final, then = content
    if len(x) < 2:
        raise ValueError
    given: tuple[Any, ...] = (
        Mode(mode),
        *_exact_time(start, remainder),
        *numbers([duration, end], 2),
        numbers(x, len(x)),
        numbers(y, len(x)),
        _state(final),
        Mode(then),
    )
    return Segment(*given)


def _state(content: list[float]) -> State:
    x, vx, y, vy = numbers(content, 4)
    return (x, vx, y, vy)
