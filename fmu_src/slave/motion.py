"""The motion at communication points, under inputs that may change there.

A Taylor step covers many communication steps. Its polynomial is kept until it is used up or an
input changes, so the result does not depend on the communication points.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from fivtui.model.errors import ComputationError
from fivtui.model.modes import Mode
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.model.slider_belt import (
    State,
    accelerations,
    contact_force,
    mode_of,
    static_start,
)
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import StepperSnapshot, TaylorStepper, local_tolerance

from .variable import Role
from .variables import REFERENCES, STATES, VARIABLES

Values = Mapping[int, float | bool]
# Taylor steps after which a communication step is given up: about a quarter of a minute.
_MOST_STEPS: Final = 500_000
_FIXED: Final = [r for r, v in enumerate(VARIABLES) if v.role is Role.PARAMETER]


class MotionState(NamedTuple):
    """State of the motion at a communication point `t`, immutable.

    `F` and `mu` are the inputs up to `t`, `last_event` the time of the last switch (the start time
    before the first), `stepper` the integrator at the end of `segment`, and `segment` the one that
    contains `t`, or None if the inputs have just changed.
    """

    t: float
    state: State
    mode: Mode
    F: float
    mu: float
    separations: int
    reattachments: int
    last_event: float
    stepper: StepperSnapshot
    segment: Segment | None


class SliderBeltMotion:
    """A motion that is moved on step by step, with inputs held over each step.

    The inputs F and μ of `p` are the first ones; `examples/trust.md` says what `tol` promises.
    `current` is the state of the motion.
    """

    def __init__(
        self, p: Parameters, state: State, *, t: float, separation: bool, tol: float
    ) -> None:
        self._p = p
        self._separation = separation
        self._tol = tol
        self._stepper = self._stepper_from(state, t)
        snapshot = self._stepper.snapshot
        self.current = MotionState(t, state, snapshot.mode, p.F, p.mu, 0, 0, t, snapshot, None)

    def state_at(self, t: float) -> State:
        """The state at a time from now to `known_until`, s, without moving on."""
        current = self.current
        if t == current.t or current.segment is None:
            return current.state
        return current.segment.state(t)

    def accelerations(self, state: State, *, F: float, mu: float) -> tuple[float, float]:
        """Accelerations (ẍ, ÿ), m/s², in the current mode under given inputs."""
        p = self._p
        if F != p.F or mu != p.mu:
            p = p.with_values({"F": F, "mu": mu})
        return accelerations(p, state, self.current.mode)

    def contact_force(self, y: float) -> float:
        """Contact force P, N, at a height y, m, in the current mode."""
        return contact_force(self._p, y, self.current.mode) + 0.0

    @property
    def known_until(self) -> float:
        """Time, s, up to which moving on under the same inputs needs no Taylor step."""
        segment = self.current.segment
        return self.current.t if segment is None else segment.end

    def move_to(self, t: float, *, F: float, mu: float) -> None:
        """Move on to a later time, s, with preload `F`, N, and friction coefficient `mu`.

        On any exception the motion stays where it was.

        Raises
        ------
        InputError
            If an input is out of range.
        ComputationError
            If the motion cannot be continued.
        """
        begin = self.current
        try:
            if F != begin.F or mu != begin.mu:
                self._change_inputs(F, mu)
            self._advance(t)
        except BaseException:
            self.restore(begin)
            raise

    def restore(self, current: MotionState) -> None:
        """Return to a state of a motion of the same problem; what follows is bit-identical."""
        if current.F != self._p.F or current.mu != self._p.mu:
            self._p = self._p.with_values({"F": current.F, "mu": current.mu})
            self._stepper = self._stepper_from(current.state, current.t)
        self._stepper.resume(current.stepper)
        self.current = current

    def _stepper_from(self, state: State, t: float) -> TaylorStepper:
        return TaylorStepper(
            self._p, state, t=t, separation=self._separation, tol=local_tolerance(self._tol)
        )

    def _change_inputs(self, F: float, mu: float) -> None:
        at = self.current
        p = self._p.with_values({"F": F, "mu": mu})
        state = at.state
        if self._separation and at.mode is not mode_of(p, state, separation=True):
            # y is on the wrong side by rounding alone: the slider is at the switch.
            state = (state[0], state[1], 0.0, state[3])
        self._p = p
        self._stepper = self._stepper_from(state, at.t)
        snapshot = self._stepper.snapshot
        self.current = _counted(at, snapshot.mode, at.t)._replace(
            state=state, F=F, mu=mu, stepper=snapshot, segment=None
        )

    def _advance(self, t: float) -> None:
        current, segment = self.current, self.current.segment
        state, steps = None, 0
        while segment is None or segment.end <= t:
            if steps == _MOST_STEPS:
                raise ComputationError(
                    f"the step needs more than {_MOST_STEPS} Taylor steps, it is given up at "
                    f"t = {current.segment.end if current.segment else current.t:g} s",
                    "use shorter communication steps, or the native FMU",
                )
            steps += 1
            following = self._stepper.advance()
            if segment is not None:
                state = segment.final if segment.end == t else None
                current = _counted(current, following.mode, segment.end)
            segment = following
            current = current._replace(stepper=self._stepper.snapshot, segment=segment)
        # Built directly for speed: most communication steps do nothing else.
        _, _, mode, F, mu, separations, reattachments, last_event, snapshot, _ = current
        self.current = MotionState(
            t,
            segment.state(t) if state is None else state,
            mode,
            F,
            mu,
            separations,
            reattachments,
            last_event,
            snapshot,
            segment,
        )


def _counted(current: MotionState, mode: Mode, t: float) -> MotionState:
    if mode is current.mode:
        return current
    separates = mode is not Mode.CONTACT
    return current._replace(
        mode=mode,
        separations=current.separations + separates,
        reattachments=current.reattachments + (not separates),
        last_event=t,
    )


def start_state(values: Values) -> State:
    """The state (x, ẋ, y, ẏ) at the start, m and m/s, from values by value reference.

    Raises `ComputationError` if the start is static and there is no equilibrium.
    """
    if values[REFERENCES["start_static"]]:
        return static_start(parameters_from(values), separation=separation_in(values))
    x, vx, y, vy = (float(values[REFERENCES[f"{name}_start"]]) for name in STATES)
    return (x, vx, y, vy)


def motion_from(values: Values, state: State, *, t: float, tol: float) -> SliderBeltMotion:
    """The motion from a state, with parameters, inputs and separation from the values."""
    return SliderBeltMotion(
        parameters_from(values), state, t=t, separation=separation_in(values), tol=tol
    )


def fixed_values(values: Values) -> list[float]:
    """The values of the fixed parameters; motions with equal ones can exchange their states."""
    return [values[reference] for reference in _FIXED]


def parameters_from(values: Values) -> Parameters:
    """The parameter set, inputs included."""
    return Parameters(**{name: float(values[REFERENCES[name]]) for name in PARAMETERS})


def separation_in(values: Values) -> bool:
    """Whether separation is considered (Case 1 of the paper)."""
    return bool(values[REFERENCES["separation"]])
