"""The instance of the slider-belt model in the Python FMU, for co-simulation."""

from collections.abc import Sequence
from dataclasses import astuple
from typing import Any, Final

from pythonfmu.default_experiment import DefaultExperiment

from fivtui.model.modes import Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State
from fivtui.taylor.extremes import Extremes
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import DEFAULT_TOL, StepperSnapshot

from .experiment import Experiment
from .instance import Instance
from .motion import (
    MotionState,
    SliderBeltMotion,
    Totals,
    build_parameters,
    check_belt_speed,
    describe_unused_values,
    has_separation,
    start_state,
)
from .variables import REFERENCES, SLIDER_BELT_TABLE, STATES, SUMMARY, TOTALS

# Value references of the variables.
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
_TOTAL_SET: Final = frozenset(_TOTAL_REFERENCES)


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
        # Parameters and inputs from now on.
        self._parameters = Parameters()
        # Tolerance of the motion, and whether it has separation.
        self._settings: tuple[float, bool] = (0.0, False)

    def _create_motion(self, experiment: Experiment) -> None:
        state = start_state(self._values)
        self._parameters = build_parameters(self._values)
        self._begin_motion(self._parameters, state, experiment.start_time, experiment.tol)

    def _begin_motion(self, p: Parameters, state: State, t: float, tol: float) -> None:
        separation = has_separation(self._values)
        self._motion = SliderBeltMotion(p, state, t=t, separation=separation, tol=tol)
        self._settings = (tol, separation)

    def _apply_values(self, values: dict[int, float | bool]) -> None:
        check_belt_speed(values)
        self._parameters = build_parameters(values)

    def _initialization_warning(self) -> str:
        return describe_unused_values(self._values)

    def _advance(self, end: float, experiment: Experiment) -> None:
        self._motion.move_to(end, self._parameters)
        self._fast_until = min(self._motion.computed_until, experiment.stop_time)

    def _store_outputs(self) -> None:
        motion, values, p = self._motion, self._values, self._parameters
        current, state = motion.current, motion.state_at(self._t)
        x, vx, y, vy = state
        force = motion.contact_force(y, p)
        mode, friction, accelerations = motion.friction_and_accelerations(state, force, p)
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
        if self._needs_motion or _TOTAL_SET.isdisjoint(references):
            return values
        # Computed only if a host reads them, because the search for extremes takes time.
        motion_totals = self._motion.totals_at(self._t, self._parameters)
        totals = dict(zip(_TOTAL_REFERENCES, motion_totals, strict=True))
        return [totals.get(r, value) for r, value in zip(references, values, strict=True)]

    def _motion_state(self) -> MotionState:
        current = self._motion.current
        if current.t != self._t:
            self._motion.move_to(self._t, current.p)
        return self._motion.current

    def _restore_motion(
        self, values: dict[int, float | bool], experiment: Experiment, current: MotionState
    ) -> None:
        settings = experiment.tol, has_separation(values)
        if settings != self._settings:
            tol, separation = settings
            self._motion = SliderBeltMotion(
                current.p, current.state, t=current.t, separation=separation, tol=tol
            )
            self._settings = settings
        self._parameters = build_parameters(values)
        self._motion.restore(current)

    @staticmethod
    def _to_json(motion_state: MotionState) -> Any:
        segment = motion_state.segment
        return {
            **motion_state._asdict(),
            "p": motion_state.p.as_dict(),
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
            "p": Parameters().replaced(**content["p"]),
            "past": Totals(*content["past"]),
            "extremes": Extremes(*content["extremes"]),
            "stepper": stepper._replace(state=tuple(stepper.state), mode=Mode(stepper.mode)),
            "segment": None if segment is None else _segment_from_json(segment),
        }
        return MotionState(**(content | restored))


def _segment_from_json(content: list[Any]) -> Segment:
    mode, start, start_remainder, duration, end, x, y, final, next_mode = content
    times = start, start_remainder, duration, end
    return Segment(Mode(mode), *times, tuple(x), tuple(y), tuple(final), Mode(next_mode))
