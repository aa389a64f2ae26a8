"""The instance of the slider-belt model in the Python FMU, for co-simulation."""

from collections.abc import Sequence
from dataclasses import astuple
from typing import Any, Final

from pythonfmu.default_experiment import DefaultExperiment

from fivtui.model.modes import Mode
from fivtui.taylor.extremes import Extremes
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import DEFAULT_TOL, StepperSnapshot

from .experiment import Experiment
from .instance import Instance
from .instance_state import Phase
from .motion import (
    MotionState,
    SliderBeltMotion,
    Totals,
    Values,
    check_friction,
    describe_unused_values,
    fixed_values,
    new_motion,
    start_state,
)
from .variable import Type
from .variables import INPUTS, REFERENCES, SLIDER_BELT_TABLE, STATES, SUMMARY, TOTALS

# Value references of the variables.
_F, _MU, _V_BELT = (REFERENCES[name] for name in INPUTS)
_X, _VX, _Y, _VY = (REFERENCES[name] for name in STATES)
_P, _FRICTION_SLIDER, _FRICTION_BELT, _SWITCHING, _AX, _AY = (
    REFERENCES[name] for name in ("P", "friction_slider", "friction_belt", "switching", "ax", "ay")
)
_MODE, _MODE_INTEGER, _MODE_ENUMERATION = (
    REFERENCES[name] for name in ("mode", "mode_integer", "mode_enumeration")
)
_SEPARATIONS, _REATTACHMENTS, _SWITCHES, _STICKS, _LAST_EVENT = (
    REFERENCES[name]
    for name in ("separations", "reattachments", "switches", "sticks", "last_event")
)
_TOTAL_REFERENCES: Final = tuple(REFERENCES[name] for name in TOTALS)


class SliderBeltInstance(Instance):
    """One instance of the slider-belt model."""

    TABLE = SLIDER_BELT_TABLE

    def __init__(self, **kwargs: Any) -> None:
        default = DefaultExperiment(
            start_time=0.0, stop_time=100.0, step_size=0.01, tolerance=DEFAULT_TOL
        )
        super().__init__(SUMMARY, default, **kwargs)
        self.modelName = "SliderBelt"
        self._motion: SliderBeltMotion
        # Tolerance and fixed parameters of the motion.
        self._settings: tuple[float, ...] = ()

    def _create_motion(self, experiment: Experiment) -> None:
        state = start_state(self._values)
        self._motion = new_motion(self._values, state, t=experiment.start_time, tol=experiment.tol)
        self._settings = _motion_settings(self._values, experiment)

    def _initialization_warning(self) -> str:
        return describe_unused_values(self._values)

    def _advance(self, end: float, experiment: Experiment) -> None:
        values = self._values
        self._motion.move_to(end, F=values[_F], mu=values[_MU], v_belt=values[_V_BELT])
        self._fast_until = min(self._motion.computed_until, experiment.stop_time)

    def _store_outputs(self) -> None:
        motion, values = self._motion, self._values
        current, state = motion.current, motion.state_at(self._t)
        x, vx, y, vy = state
        force = motion.contact_force(y)
        mode, friction, accelerations = motion.friction_and_accelerations(
            state, force, F=values[_F], mu=values[_MU], v_belt=values[_V_BELT]
        )
        # Written out, without a loop, for speed: reading outputs spends most time here.
        values[_X], values[_VX], values[_Y], values[_VY] = x, vx, y, vy
        values[_P], values[_FRICTION_SLIDER], values[_FRICTION_BELT] = force, friction, -friction
        # y is the switching function: its sign changes at separation and reattachment.
        values[_SWITCHING] = y
        values[_AX], values[_AY] = accelerations
        values[_MODE] = values[_MODE_INTEGER] = values[_MODE_ENUMERATION] = mode
        values[_SEPARATIONS], values[_REATTACHMENTS] = current.separations, current.reattachments
        values[_SWITCHES], values[_STICKS] = current.switches, current.sticks
        values[_LAST_EVENT] = current.last_event

    def _read(self, references: Sequence[int]) -> list[float | bool]:
        values = super()._read(references)
        if self._needs_motion or not any(r in _TOTAL_REFERENCES for r in references):
            return values
        # Computed only if a host reads them, because the search for extremes takes time.
        totals = dict(zip(_TOTAL_REFERENCES, self._motion.totals_at(self._t), strict=True))
        return [totals.get(r, value) for r, value in zip(references, values, strict=True)]

    def _check_value(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = super()._check_value(reference, kind, value)
        if reference == _MU and self._phase is Phase.STEPPING:
            check_friction({**self._values, _MU: checked})
        return checked

    def _motion_state(self) -> MotionState:
        current = self._motion.current
        if current.t != self._t:
            self._motion.move_to(self._t, F=current.F, mu=current.mu, v_belt=current.v_belt)
        return self._motion.current

    def _restore_motion(
        self, values: dict[int, float | bool], experiment: Experiment, current: MotionState
    ) -> None:
        settings = _motion_settings(values, experiment)
        if settings != self._settings:
            motion = new_motion(values, current.state, t=current.t, tol=experiment.tol)
            self._motion, self._settings = motion, settings
        self._motion.restore(current)

    @staticmethod
    def _to_json(motion_state: MotionState) -> Any:
        segment = motion_state.segment
        return {
            **motion_state._asdict(),
            "extremes": astuple(motion_state.extremes),
            "segment": None if segment is None else astuple(segment),
        }

    @staticmethod
    def _from_json(content: Any) -> MotionState:
        stepper: Any = StepperSnapshot(*content["stepper"])
        segment = content["segment"]
        # Values that JSON stores in another type.
        restored = {
            "state": tuple(content["state"]),
            "mode": Mode(content["mode"]),
            "past": Totals(*content["past"]),
            "extremes": Extremes(*content["extremes"]),
            "stepper": stepper._replace(state=tuple(stepper.state), mode=Mode(stepper.mode)),
            "segment": None if segment is None else _segment_from_json(segment),
        }
        return MotionState(**(content | restored))


def _motion_settings(values: Values, experiment: Experiment) -> tuple[float, ...]:
    return (experiment.tol, *fixed_values(values))


def _segment_from_json(content: list[Any]) -> Segment:
    mode, start, start_remainder, duration, end, x, y, final, next_mode = content
    times = start, start_remainder, duration, end
    return Segment(Mode(mode), *times, tuple(x), tuple(y), tuple(final), Mode(next_mode))
