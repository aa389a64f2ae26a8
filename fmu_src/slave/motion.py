"""The motion of the slider in co-simulation; inputs may change at communication points.

A Taylor step usually covers many communication steps. Its polynomial, the segment, is used until
its end or a change of inputs, so the result does not depend on the communication points. `values`
are the values of the FMU's variables by value reference.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final, NamedTuple

from fivtui.model.errors import ComputationError, InputError
from fivtui.model.modes import IN_CONTACT, Mode
from fivtui.model.parameters import BELT_PARAMETERS, PARAMETERS, Parameters
from fivtui.model.slider_belt import (
    State,
    accelerations,
    contact_force,
    friction_force,
    mode_of,
    static_start,
)
from fivtui.model.system import System
from fivtui.taylor.belt import taylor_stepper
from fivtui.taylor.extremes import Extremes
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import StepperSnapshot, TaylorStepper

from .variables import REFERENCES, STATES, VARIABLES

Values = Mapping[int, float | bool]
# Limit of Taylor steps per communication step, which take about 15 s of CPU time.
_MAX_STEPS: Final = 500_000
_FRICTION_NAMES: Final = ("mu_s", "v_s")


class Totals(NamedTuple):
    """Peaks of |x| and |y|, m, greatest ẋ, m/s, range of contact force, N, time off the belt, s.

    They are over a part of the motion. The order is that of `variables.TOTALS`.
    """

    x_peak: float
    y_peak: float
    vx_max: float
    P_min: float
    P_max: float
    separated_time: float

    def joined(self, part: "Totals") -> "Totals":
        """The totals over this part of the motion and another one."""
        return Totals(
            max(self.x_peak, part.x_peak),
            max(self.y_peak, part.y_peak),
            max(self.vx_max, part.vx_max),
            min(self.P_min, part.P_min),
            max(self.P_max, part.P_max),
            self.separated_time + part.separated_time,
        )


_NO_TOTALS: Final = Totals(0.0, 0.0, -math.inf, math.inf, -math.inf, 0.0)


class MotionState(NamedTuple):
    """State of the motion at a communication point, immutable."""

    # Time, s; state (x, ẋ, y, ẏ), m and m/s; mode.
    t: float
    state: State
    mode: Mode
    # Parameters and inputs up to `t`.
    p: Parameters
    # Numbers of changes of the mode so far: to and from separation, all, and to stick, which
    # includes a start in stick. Time of the last change, or the start time, s.
    separations: int
    reattachments: int
    switches: int
    sticks: int
    last_event: float
    # Totals until the contact stiffness last changed; extremes and time off the belt, s, from then
    # until the start of the segment, or `t` without one. `extremes` are never changed.
    past: Totals
    extremes: Extremes
    separated_time: float
    # The integrator at the end of the segment that contains `t`; the segment is None just after a
    # change of inputs.
    stepper: StepperSnapshot
    segment: Segment | None


class SliderBeltMotion:
    """A motion computed step by step, with parameters held over each communication step.

    `p` are the parameters at the start, inputs included; with `separation` the slider may leave the
    belt. `docs/explanation/tolerance.md` defines the accuracy of `tol`. The
    attribute `current` is the state at the last communication point.
    """

    def __init__(
        self, p: Parameters, state: State, *, t: float, separation: bool, tol: float
    ) -> None:
        self._p = p
        self._separation = separation
        self._tol = tol
        self._stepper = self._create_stepper(state, t)
        snapshot = self._stepper.snapshot
        sticks = int(snapshot.mode is Mode.STICK)
        counts = (0, 0, 0, sticks)
        totals = (_NO_TOTALS, _extremes_at(state), 0.0)
        self.current = MotionState(t, state, snapshot.mode, p, *counts, t, *totals, snapshot, None)

    def state_at(self, t: float) -> State:
        """Evaluate the state at a time up to `computed_until`, s; the motion does not advance."""
        current = self.current
        if t == current.t or current.segment is None:
            return current.state
        return self._with_belt_speed(current.segment.state(t), current.mode)

    def friction_and_accelerations(
        self, state: State, force: float, p: Parameters
    ) -> tuple[Mode, float, tuple[float, float]]:
        """Mode, friction force on the slider, N, and accelerations, m/s², under parameters.

        `state` is a state of the current segment, `force` its contact force, N. On a belt of finite
        speed other parameters than those of the segment may change the mode.
        """
        mode = self.current.mode
        if p.v_belt is None:
            return mode, p.mu * force, accelerations(p, state, mode)
        if p is not self._p and p != self._p:
            state = self._project_on_switch(state, p)
            mode = mode_of(p, state, separation=self._separation)
        # Adding zero turns -0.0 into 0.0.
        return mode, friction_force(p, state, mode) + 0.0, accelerations(p, state, mode)

    def contact_force(self, y: float, p: Parameters) -> float:
        """Contact force P, N, at a height y, m, in the current mode; never -0.0."""
        return contact_force(p, y, self.current.mode) + 0.0

    def totals_at(self, t: float, p: Parameters) -> Totals:
        """Totals from the beginning to a time up to `computed_until`, s.

        They include the contact force at this time under other parameters.
        """
        extremes, separated_time = self._observe(t)
        # P falls with y; it is zero off the belt. Adding zero turns -0.0 into 0.0.
        highest = 0.0 if self._separation else math.inf
        P_min, P_max = (
            contact_force(self._p, min(y, highest), Mode.CONTACT) + 0.0
            for y in (extremes.y_max, extremes.y_min)
        )
        force = self.contact_force(self.state_at(t)[2], p)
        part = Totals(
            max(extremes.x_max, -extremes.x_min),
            max(extremes.y_max, -extremes.y_min),
            extremes.vx_max,
            min(P_min, force),
            max(P_max, force),
            separated_time,
        )
        return self.current.past.joined(part)

    @property
    def computed_until(self) -> float:
        """Time, s, up to which the motion is computed if its parameters do not change."""
        segment = self.current.segment
        return self.current.t if segment is None else segment.end

    def move_to(self, t: float, p: Parameters) -> None:
        """Advance to a later time, s, with parameters; on any exception nothing changes."""
        initial = self.current
        try:
            if p is not self._p:
                self._change_parameters(p)
            self._advance(t)
        except BaseException:
            self.restore(initial)
            raise

    def restore(self, current: MotionState) -> None:
        """Return to a state of a motion; from there on both motions are bitwise equal."""
        if current.p is not self._p:
            self._p = current.p
            self._stepper = self._create_stepper(current.state, current.t)
        self._stepper.resume(current.stepper)
        self.current = current

    def _create_stepper(self, state: State, t: float) -> TaylorStepper:
        return taylor_stepper(System(self._p, self._separation), state, t=t, tol=self._tol)

    def _change_parameters(self, p: Parameters) -> None:
        current = self.current
        if p == self._p:
            # The motion continues, without a new step.
            self._p = p
            self.current = current._replace(p=p)
            return
        state = self._project_on_switch(current.state, p)
        past, (extremes, separated_time) = current.past, self._observe(current.t)
        if (p.k2, p.k_nl) != (self._p.k2, self._p.k_nl):
            # The extremes of y before have another contact force than those that follow.
            past = self.totals_at(current.t, self._p)
            extremes, separated_time = _extremes_at(state), 0.0
        self._p = p
        self._stepper = self._create_stepper(state, current.t)
        snapshot = self._stepper.snapshot
        self.current = _count_switch(current, snapshot.mode, current.t)._replace(
            state=state,
            p=p,
            past=past,
            extremes=extremes,
            separated_time=separated_time,
            stepper=snapshot,
            segment=None,
        )

    def _observe(self, t: float) -> tuple[Extremes, float]:
        # Extremes and time off the belt, s, as in `MotionState`, but up to the time t, s.
        current, segment = self.current, self.current.segment
        if segment is None:
            return current.extremes, current.separated_time
        extremes, separated_time = replace(current.extremes), current.separated_time
        extremes.include_part(segment, -math.inf, t)
        if segment.mode not in IN_CONTACT:
            separated_time += (t - segment.start) - segment.start_remainder
        return extremes, separated_time

    def _with_belt_speed(self, state: State, mode: Mode) -> State:
        # In stick, replace the polynomial's speed by the exact speed of the belt.
        if mode is not Mode.STICK:
            return state
        x, _, y, vy = state
        return (x, self._p.v_belt or 0.0, y, vy)

    def _project_on_switch(self, state: State, p: Parameters) -> State:
        # By rounding, a state may lie slightly beyond the end of its mode, and would begin in
        # another mode under the new inputs in `p`. Move it onto the switch that ends its mode: the
        # belt's old speed, or y = 0.
        x, vx, y, vy = state
        mode, old_belt_speed = self.current.mode, self._p.v_belt or 0.0
        if mode is Mode.FORWARD:
            vx = min(vx, old_belt_speed)
        elif mode is Mode.BACKWARD:
            vx = max(vx, old_belt_speed)
        if self._separation:
            next_mode = mode_of(p, (x, vx, y, vy), separation=True)
            was_in_contact, is_in_contact = mode in IN_CONTACT, next_mode in IN_CONTACT
            if is_in_contact != was_in_contact:
                y = 0.0
        return (x, vx, y, vy)

    def _advance(self, t: float) -> None:
        current, segment = self.current, self.current.segment
        state, steps = None, 0
        while segment is None or segment.end <= t:
            if steps == _MAX_STEPS:
                raise ComputationError(
                    f"the step is stopped after {_MAX_STEPS} Taylor steps at "
                    f"t = {current.segment.end if current.segment else current.t:g} s",
                    "use shorter communication steps, or the native FMU",
                )
            steps += 1
            next_segment = self._stepper.advance()
            if segment is not None:
                # None if the state must be evaluated within the last segment.
                state = segment.final if segment.end == t else None
                current = _include_segment(current, segment)
                current = _count_switch(current, next_segment.mode, segment.end)
            segment = next_segment
            current = current._replace(stepper=self._stepper.snapshot, segment=segment)
        if state is None:
            state = self._with_belt_speed(segment.state(t), current.mode)
        # A slice, because it is faster than `_replace`.
        mode_to_stepper = current[2:-1]
        self.current = MotionState(t, state, *mode_to_stepper, segment)


def _extremes_at(state: State) -> Extremes:
    x, vx, y, _ = state
    return Extremes(x_min=x, y_min=y, x_max=x, y_max=y, vx_max=vx)


def _include_segment(current: MotionState, segment: Segment) -> MotionState:
    # The state with the extremes and the time off the belt of a segment that has ended.
    extremes = replace(current.extremes)
    extremes.include(segment)
    duration = segment.duration if segment.mode not in IN_CONTACT else 0.0
    return current._replace(extremes=extremes, separated_time=current.separated_time + duration)


def _count_switch(current: MotionState, mode: Mode, t: float) -> MotionState:
    # The state with a new mode from the time t on, and updated counts.
    if mode is current.mode:
        return current
    separates, reattaches = mode not in IN_CONTACT, current.mode not in IN_CONTACT
    return current._replace(
        mode=mode,
        separations=current.separations + separates,
        reattachments=current.reattachments + reattaches,
        switches=current.switches + 1,
        sticks=current.sticks + (mode is Mode.STICK),
        last_event=t,
    )


def start_state(values: Values) -> State:
    """The state (x, ẋ, y, ẏ) at the start, m and m/s.

    Raises `ComputationError` if the start is static and there is no equilibrium.
    """
    if values[REFERENCES["start_static"]]:
        return static_start(System(build_parameters(values), has_separation(values)))
    x, vx, y, vy = (float(values[REFERENCES[f"{name}_start"]]) for name in STATES)
    return (x, vx, y, vy)


def build_parameters(values: Values) -> Parameters:
    """Build the parameter set, inputs included; `InputError` if static friction is below `mu`."""
    check_friction(values)
    values_by_name = {name: float(values[REFERENCES[name]]) for name in PARAMETERS}
    if not values[REFERENCES["finite_belt"]]:
        return Parameters(**values_by_name)
    v_s = float(values[REFERENCES["v_s"]])
    return Parameters(
        **values_by_name,
        v_belt=float(values[REFERENCES["v_belt"]]),
        mu_s=float(values[REFERENCES["mu_s"]]) or None,
        v_s=v_s if v_s >= BELT_PARAMETERS["v_s"].lower else None,
    )


def check_friction(values: Values) -> None:
    """Raise `InputError` if on a belt of finite speed static friction is below `mu`."""
    finite, mu, static = (values[REFERENCES[name]] for name in ("finite_belt", "mu", "mu_s"))
    if finite and 0.0 < static < mu:
        raise InputError(f"mu = {mu:g}: must be at most mu_s = {static:g}")


def check_belt_speed(values: Values) -> None:
    """Raise `InputError` if a belt speed has no effect; 0 and the default count as not set."""
    reference = REFERENCES["v_belt"]
    speed = values[reference]
    if not values[REFERENCES["finite_belt"]] and speed not in (0.0, VARIABLES[reference].start):
        raise InputError(
            f"v_belt = {speed:g}: has no effect without finite_belt, which must be set"
        )


def describe_unused_values(values: Values) -> str:
    """A phrase that names friction values without effect; empty if there are none."""
    if values[REFERENCES["finite_belt"]]:
        has_effect = values[REFERENCES["mu_s"]] > 0.0 or not values[REFERENCES["v_s"]]
        return "" if has_effect else "v_s has no effect without mu_s"
    names = [n for n in _FRICTION_NAMES if values[REFERENCES[n]] > 0.0]
    verb = "has" if len(names) == 1 else "have"
    return f"{', '.join(names)} {verb} no effect without finite_belt" if names else ""


def has_separation(values: Values) -> bool:
    """Whether the slider may separate from the belt."""
    return bool(values[REFERENCES["separation"]])
