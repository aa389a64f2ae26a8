"""The paper's method (section 5.1): fixed-step RK4 with bisection at every switch, in NumPy.

Written to be read and to be independent: it shares no stepping code with the Taylor integrator and
is the yardstick for everything else. Several parameter sets advance together, one per column.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    CUBIC_CONTACT,
    PARAMETERS,
    SEPARATION,
    ComputationError,
    InputError,
    Mode,
    Parameters,
    State,
    System,
    advise,
    mode_of,
)
from fivtui.taylor import Segment
from fivtui.transient.trajectory import segment_between

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# RK4 is stable on an oscillator up to ω·step = 2.83; the limit keeps a margin.
_STABLE: Final = 2.0
_BISECTIONS: Final = 60
_MAX_SWITCHES_PER_STEP: Final = 64


@dataclass(frozen=True, slots=True)
class StepPart:
    """One part of a step of n parameter sets."""

    contact: BoolArray
    begin: FloatArray
    duration: FloatArray
    first: FloatArray
    final: FloatArray
    switches: BoolArray


class RungeKutta4:
    """Fourth-order Runge–Kutta steps of fixed length, with the switch found by bisection."""

    def __init__(
        self,
        parameters: Sequence[Parameters],
        starts: Sequence[State],
        *,
        step: float,
        separation: bool = True,
        locate: bool = True,
    ) -> None:
        if not 0.0 < step < np.inf:
            raise InputError(f"step = {step}: must be a positive number of seconds")
        self._parameters = parameters
        self.step = step
        self.separation = separation
        self.locate = locate
        self.steps = 0
        self.state: FloatArray = np.array(starts, dtype=float).T
        modes = [
            mode_of(p, start, separation=separation)
            for p, start in zip(parameters, starts, strict=True)
        ]
        self.contact: BoolArray = np.array([mode is Mode.CONTACT for mode in modes])
        self._table: dict[str, FloatArray] = {
            name: np.array([getattr(p, name) for p in parameters]) for name in PARAMETERS
        }

    @property
    def t(self) -> float:
        """Time reached, s."""
        return self.steps * self.step

    def advance(self) -> list[StepPart]:
        """Take one step, in as many parts as its switches need.

        Raises `ComputationError` if the step is too large for the stiffness, the motion overflows,
        or the step holds more switches than can be believed.
        """
        self._check_step()
        parts: list[StepPart] = []
        elapsed = np.zeros(self.state.shape[1])
        remaining = np.full_like(elapsed, self.step)
        while (remaining > 0.0).any():
            if len(parts) > _MAX_SWITCHES_PER_STEP:
                raise ComputationError(
                    f"over {_MAX_SWITCHES_PER_STEP} switches in the step at t = {self.t:.6g} s",
                    "use a smaller step, or the taylor method",
                )
            first = self.state
            final = self._rk4(first, self.contact, remaining)
            if not np.isfinite(final).all():
                raise self._overflow(final)
            crossed = self._crossed(final, self.contact)
            duration = remaining
            if self.locate and crossed.any():
                duration = np.where(crossed, self._bisect(first, remaining, crossed), remaining)
                final = self._rk4(first, self.contact, duration)
            parts.append(StepPart(self.contact, elapsed, duration, first, final, crossed))
            self.state, self.contact = self._after(final, crossed)
            elapsed = elapsed + duration
            remaining = remaining - duration
        self.steps += 1
        return parts

    def _after(self, state: FloatArray, crossed: BoolArray) -> tuple[FloatArray, BoolArray]:
        # State and mode after a switch.
        return state, self.contact ^ crossed

    def _derivatives(self, state: FloatArray, contact: BoolArray) -> FloatArray:
        # Eqs. 2 and 5, solved for the accelerations.
        p = self._table
        x, vx, y, vy = state
        if self.separation and not self.locate:
            contact = y < 0.0
        force = np.where(contact, -p["k2"] * y - p["k_nl"] * y**3, 0.0)
        coupling = 0.5 * p["k3"] * (x - y)
        ax = (p["mu"] * force - p["c1"] * vx - p["k1"] * x - coupling) / p["m"]
        ay = (force - p["F"] - p["c2"] * vy + coupling) / p["m"]
        return np.array((vx, ax, vy, ay))

    def _rk4(self, state: FloatArray, contact: BoolArray, step: FloatArray) -> FloatArray:
        with np.errstate(over="ignore", invalid="ignore"):
            s1 = self._derivatives(state, contact)
            s2 = self._derivatives(state + 0.5 * step * s1, contact)
            s3 = self._derivatives(state + 0.5 * step * s2, contact)
            s4 = self._derivatives(state + step * s3, contact)
            return state + step / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4)

    def _crossed(self, state: FloatArray, contact: BoolArray) -> BoolArray:
        # Eq. 3 violated in contact, or Eq. 4 violated when separated.
        if not self.separation:
            return np.zeros_like(contact)
        return np.asarray(np.where(contact, state[2] > 0.0, state[2] < 0.0), dtype=bool)

    def _bisect(self, first: FloatArray, remaining: FloatArray, crossed: BoolArray) -> FloatArray:
        # The shortest step that crosses, so that the new mode starts on the correct side of y = 0.
        before, after = np.zeros_like(remaining), remaining
        for _ in range(_BISECTIONS):
            middle = 0.5 * (before + after)
            if np.all((middle <= before) | (middle >= after) | ~crossed):
                break
            beyond = self._crossed(self._rk4(first, self.contact, middle), self.contact)
            before = np.where(beyond, before, middle)
            after = np.where(beyond, middle, after)
        return after

    def _overflow(self, state: FloatArray) -> ComputationError:
        member = np.flatnonzero(~np.isfinite(state).all(axis=0))[0]
        remedies = ("a smaller step", SEPARATION, CUBIC_CONTACT, "a shorter run")
        return ComputationError(
            f"the motion grows beyond the floating-point range at t = {self.t:.6g} s",
            advise(System(self._parameters[member], self.separation), remedies),
        )

    def _check_step(self) -> None:
        p = self._table
        tangent = np.where(self.contact, p["k2"] + 3.0 * p["k_nl"] * self.state[2] ** 2, 0.0)
        frequency = np.sqrt(np.max((p["k1"] + p["k3"] + tangent) / p["m"]))
        decay = np.max(np.maximum(p["c1"], p["c2"]) / p["m"])
        fastest = max(frequency, decay)
        if self.step * fastest > _STABLE:
            cause = "damping" if decay > frequency else "tangent contact stiffness"
            raise ComputationError(
                f"step = {self.step:g} s is too large for RK4 at t = {self.t:.6g} s: the {cause} "
                f"makes it unstable",
                f"use a step below {0.1 / fastest:.1g} s, or the taylor method",
            )


class ReferenceStepper:
    """`RungeKutta4` with one parameter set, as segments.

    Switches that are not located count at the end of the step in which they lie.
    """

    def __init__(self, p: Parameters, integrator: RungeKutta4) -> None:
        self._p, self._integrator = p, integrator
        # Segments in reverse order.
        self._waiting: list[Segment] = []

    def advance(self) -> Segment:
        """The next segment: a step, or the part of it up to or after a switch.

        Interpolated between the states of the integrator; raises as `RungeKutta4.advance`.
        """
        while not self._waiting:
            begin = self._integrator.t
            parts = self._integrator.advance()
            next_mode = self._mode(self._integrator.contact)
            for part in reversed(parts):
                start = begin + float(part.begin[0])
                # The last part ends on the grid, so that no rounding accumulates.
                complete = not (self._integrator.locate and bool(part.switches[0]))
                end = self._integrator.t if complete else start + float(part.duration[0])
                if end > start:
                    mode = self._mode(part.contact)
                    first, final = (state[:, 0].tolist() for state in (part.first, part.final))
                    segment = segment_between(
                        self._p, mode, (start, end), (first, final), next_mode=next_mode
                    )
                    self._waiting.append(segment)
                    next_mode = mode
        return self._waiting.pop()

    def _mode(self, contact: NDArray[Any]) -> Mode:
        # `contact` is a flag, or the number of a mode.
        return Mode(int(contact[0]))
