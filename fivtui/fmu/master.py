"""Co-simulation master: runs the slider-belt FMU and turns its outputs into segments.

A segment is a polynomial of the motion between two communication points. Where the mode changes,
at a switch, a segment must end.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

from fivtui.model import (
    CONSTANT,
    HELD_OVER_TIME,
    IN_CONTACT,
    LINEAR_OVER_TIME,
    TIME_DEPENDENT,
    ComputationError,
    Course,
    Mode,
    Parameters,
    Rates,
    State,
    check_known,
    time_scale,
)
from fivtui.transient import Recorder, Request, segment_between

from .instance import Messages

MAX_STEPS: Final = 20_000_000
# Longest interval over which outputs are interpolated, as a part of √(m/tangent stiffness).
_LONGEST_INTERVAL: Final = 0.06
_STATES: Final = ("x", "vx", "y", "vy")
_READ_VARIABLES: Final = (*_STATES, "P", "mode", "last_event")
# Variables that count changes of the mode: without and with a finite belt speed.
_SLIDING_SWITCHES: Final = ("separations", "reattachments")
_BELT_SWITCHES: Final = ("switches",)
# Order of the derivatives of inputs that the FMU accepts.
_FIRST_ORDER: Final = 1


class Point(NamedTuple):
    """Outputs of the FMU at a communication point.

    `P` is the contact force, N; `last_event` is the time of the last switch, s.
    """

    t: float
    state: State
    P: float
    mode: Mode
    switches: int
    last_event: float


class Slave:
    """The slider-belt FMU as `integrate_fmu` uses it.

    `before_step` is called before every communication step and may raise; `steps` counts them.
    Inputs follow `course`, the parameters as functions of time, unless it is None.

    Raises `InputError` if the FMU lacks a variable of this model.
    """

    def __init__(
        self,
        instance: Any,
        messages: Messages,
        description: Any,
        before_step: Callable[[], None],
        course: Course | None = None,
    ) -> None:
        self._fmu = instance
        self._course = course
        self._before_step = before_step
        self._messages = messages
        self._references = {v.name: v.valueReference for v in description.modelVariables}
        self._read_references: list[int] = []
        self.steps = 0

    def _reference(self, name: str) -> int:
        check_known("FMU variable", name, self._references)
        reference: int = self._references[name]
        return reference

    def begin(self, request: Request) -> Point:
        """Initialize the FMU; `ComputationError` if it fails."""
        fmu = self._fmu
        values = request.parameters.as_dict()
        values |= {f"{n}_start": value for n, value in zip(_STATES, request.initial, strict=True)}
        # Not a static start, at rest at an equilibrium: the initial state is given.
        flags = {"separation": request.separation, "start_static": False}
        has_belt_speed = request.parameters.v_belt is not None
        if has_belt_speed:
            flags["finite_belt"] = True
        counters = _BELT_SWITCHES if has_belt_speed else _SLIDING_SWITCHES
        self._read_references = [self._reference(name) for name in (*_READ_VARIABLES, *counters)]
        fmu.setupExperiment(tolerance=request.tol, startTime=0.0, stopTime=request.t_end)
        fmu.setReal([self._reference(name) for name in values], list(values.values()))
        fmu.setBoolean([self._reference(name) for name in flags], list(flags.values()))
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        return self._point(0.0)

    def step(self, t: float, target: float) -> Point:
        """Take a communication step from `t` to `target`, s.

        Raises `ComputationError`, with the FMU's log, if it fails, or after `MAX_STEPS`.
        """
        from fmpy.fmi1 import FMICallException

        if self.steps == MAX_STEPS:
            raise ComputationError(
                f"more than {MAX_STEPS} communication steps are needed", "use a shorter horizon"
            )
        self.steps += 1
        self._before_step()
        try:
            if self._course is not None:
                self._set_inputs(self._course, t, target)
            self._fmu.doStep(t, target - t)
            if self._course is not None:
                # At a row of a table outputs are those of its parameters.
                self._set_values(self._course, HELD_OVER_TIME, target)
        except FMICallException:
            raise self._failure_error(t) from None
        return self._point(target)

    def _set_inputs(self, course: Course, t: float, target: float) -> None:
        # Set the values at `t`, and slopes that reach those of inputs at the target. Every step
        # needs both, because a restored state has other values.
        self._set_values(course, TIME_DEPENDENT, t)
        inputs = {name: course.tables[name] for name in LINEAR_OVER_TIME if name in course.tables}
        if not inputs:
            return
        slopes = [
            (table.before(target) - table.after(t)[0]) / (target - t) for table in inputs.values()
        ]
        references = [self._reference(name) for name in inputs]
        self._fmu.setRealInputDerivatives(references, [_FIRST_ORDER] * len(slopes), slopes)

    def _set_values(self, course: Course, names: Sequence[str], t: float) -> None:
        values = {name: course.tables[name].after(t)[0] for name in names if name in course.tables}
        if values:
            self._fmu.setReal([self._reference(name) for name in values], list(values.values()))

    def _point(self, t: float) -> Point:
        values = self._fmu.getReal(self._read_references)
        if not math.isfinite(sum(values)):
            raise self._failure_error(t)
        x, vx, y, vy, force, mode, last_event, *counters = values
        return Point(t, (x, vx, y, vy), force, Mode(int(mode)), int(sum(counters)), last_event)

    def _failure_error(self, t: float) -> ComputationError:
        # The FMU logs the cause of a failed computation, "; " and advice.
        cause, _, advice = (self._messages.last or "it logged no reason").rpartition("; ")
        if not cause:
            cause, advice = advice, "check the FMU: fivtui fmu check"
        return ComputationError(f"the FMU stops at t = {t:.6g} s: {cause}", advice)

    def save_state(self) -> "SavedState":
        """Save the FMU's state for the duration of a context."""
        return SavedState(self._fmu)

    def end(self) -> None:
        """Terminate the run."""
        self._fmu.terminate()


class SavedState:
    """A saved state of an FMU: the context yields a function that restores it, then frees it.

    A class, because a generator's context takes longer and every communication step enters one.
    """

    __slots__ = ("_fmu", "_state")

    def __init__(self, fmu: Any) -> None:
        self._fmu, self._state = fmu, fmu.getFMUstate()

    def _restore(self) -> None:
        self._fmu.setFMUstate(self._state)

    def __enter__(self) -> Callable[[], None]:
        return self._restore

    def __exit__(self, *_error: object) -> None:
        self._fmu.freeFMUstate(self._state)


class Master:
    """Runs the FMU step by step and turns its outputs into segments.

    The recorder receives one segment for each communication step, split at switches; `point` is the
    last communication point. Raises `ComputationError` if the FMU fails.
    """

    def __init__(self, slave: Slave, request: Request, recorder: Recorder) -> None:
        self._slave = slave
        self._request = request
        self._recorder = recorder
        self.point = slave.begin(request)

    def step_to(self, target: float) -> None:
        """Take a communication step to a time, s.

        Raises `ComputationError` if the FMU fails, or its switches cannot be separated.
        """
        with self._slave.save_state() as restore_first:
            self.point = self._integrate(restore_first, self.point, target)

    def _integrate(self, restore_first: Callable[[], None], first: Point, target: float) -> Point:
        # Step from the point `first` to a time, and record the segments; returns the point there.
        # `restore_first` returns the FMU to `first`.
        slave = self._slave
        final = slave.step(first.t, target)
        switches = final.switches - first.switches
        if switches == 1 and final.last_event <= first.t:
            # A jump or kink of inputs changes the mode at `first`. The earlier mode, which a run at
            # t = 0 does not have, ends by a segment without duration.
            if first.t > 0.0:
                self._include(first, first, next_mode=final.mode)
            self._include(first._replace(mode=final.mode), final, next_mode=final.mode)
            return final
        if switches > 1 or final.t - first.t > self._longest_interval(first, final):
            self._bisect(restore_first, first, final)
            return final
        if switches == 0 or final.last_event >= final.t:
            self._include(first, final, next_mode=final.mode)
            return final
        with slave.save_state() as restore_final:
            restore_first()
            switch = slave.step(first.t, final.last_event)
            restore_final()
        self._include(first, switch, next_mode=final.mode)
        self._include(switch._replace(mode=final.mode), final, next_mode=final.mode)
        return final

    def _bisect(self, restore_first: Callable[[], None], first: Point, final: Point) -> None:
        # Record both halves of a step, then return to its end `final`: the FMU's result does not
        # depend on the communication step.
        slave = self._slave
        middle_time = 0.5 * (first.t + final.t)
        if not first.t < middle_time < final.t:
            # The method taylor computes the same motion without an FMU.
            raise ComputationError(
                f"at t = {first.t:.17g} s motion changes faster than floating-point time resolves",
                "use a less stiff contact or the taylor method",
            )
        with slave.save_state() as restore_final:
            restore_first()
            middle_point = self._integrate(restore_first, first, middle_time)
            with slave.save_state() as restore_middle:
                self._integrate(restore_middle, middle_point, final.t)
            restore_final()

    def _longest_interval(self, first: Point, final: Point) -> float:
        # Longest interval over which interpolation is accurate enough for peaks, s.
        p, _ = self._parameters_after(first.t)
        has_contact = first.mode in IN_CONTACT or final.mode in IN_CONTACT
        (_, _, first_y, _), (_, _, final_y, _) = first.state, final.state
        y = max(abs(first_y), abs(final_y)) if has_contact else 0.0
        return _LONGEST_INTERVAL * time_scale(p, y)

    def _parameters_after(self, t: float) -> tuple[Parameters, Rates]:
        # The parameters, and their rates of change, which are zero (CONSTANT) without a course.
        course = self._request.course
        return (self._request.parameters, CONSTANT) if course is None else course.after(t)

    def _include(self, first: Point, final: Point, *, next_mode: Mode) -> None:
        # Record the segment between two points; after it the mode is `next_mode`.
        p, rates = self._parameters_after(first.t)
        segment = segment_between(
            p,
            first.mode,
            (first.t, final.t),
            (first.state, final.state),
            next_mode=next_mode,
            rates=rates,
        )
        self._recorder.include(segment)
