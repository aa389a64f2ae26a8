"""The paper's method (section 5.1): fixed-step RK4 with bisection at every switch, in NumPy.

The paper is "Nonlinear friction-induced vibration of a slider-belt system". This is the reference
for all other methods, so it shares no stepping code with the Taylor integrator. Several parameter
sets advance together, one per column. A switch is a change between contact and separation.
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

# Largest ω·step, with a margin: RK4 is stable on an oscillator up to 2.83. Error messages advise
# a step of `_ADVISED_STEP`/ω.
_STABILITY_LIMIT: Final = 2.0
_ADVISED_STEP: Final = 0.1
_MAX_BISECTIONS: Final = 60
_MAX_SWITCHES_PER_STEP: Final = 64


@dataclass(frozen=True, slots=True)
class StepPart:
    """Part of a step between its switches, for n parameter sets: arrays (n,), states (4, n).

    A parameter set whose step is complete takes part with the duration 0.
    """

    # Whether the slider is in contact; see `RungeKutta4.contact`.
    contact: BoolArray
    # Start, s, since that of the step, and duration, s.
    begin: FloatArray
    duration: FloatArray
    # States (x, ẋ, y, ẏ) at both ends.
    first: FloatArray
    final: FloatArray
    # Whether the part ends at a switch.
    switches: BoolArray


class RungeKutta4:
    """Fourth-order Runge–Kutta steps of fixed length; bisection locates switches if requested."""

    def __init__(
        self,
        parameters: Sequence[Parameters],
        starts: Sequence[State],
        *,
        step: float,
        separation: bool = True,
        bisect: bool = True,
    ) -> None:
        if not 0.0 < step < np.inf:
            raise InputError(f"step = {step}: must be a positive number of seconds")
        self._parameters = parameters
        self.step = step
        self.separation = separation
        self.bisect = bisect
        self.steps = 0
        # States (x, ẋ, y, ẏ), shape (4, n), and whether the sliders are in contact, shape (n,).
        # Subclasses may have numbers of modes in `contact`.
        self.state: FloatArray = np.array(starts, dtype=float).T
        modes = [
            mode_of(p, start, separation=separation)
            for p, start in zip(parameters, starts, strict=True)
        ]
        self.contact: BoolArray = np.array([mode is Mode.CONTACT for mode in modes])
        self._values: dict[str, FloatArray] = {
            name: np.array([getattr(p, name) for p in parameters]) for name in PARAMETERS
        }

    @property
    def t(self) -> float:
        """Time reached, s."""
        return self.steps * self.step

    def advance(self) -> list[StepPart]:
        """Integrate over one step, in parts that end at its switches.

        Raises `ComputationError` if the step is too large for the stiffness, the motion overflows,
        or the step has more than 64 switches.
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
            start = self.state
            end = self._step(start, self.contact, remaining)
            if not np.isfinite(end).all():
                raise self._overflow_error(end)
            switches = self._violates(end, self.contact)
            duration = remaining
            if self.bisect and switches.any():
                duration = np.where(switches, self._bisect(start, remaining, switches), remaining)
                end = self._step(start, self.contact, duration)
            parts.append(StepPart(self.contact, elapsed, duration, start, end, switches))
            self.state, self.contact = self._next_state(end, switches)
            elapsed = elapsed + duration
            remaining = remaining - duration
        self.steps += 1
        return parts

    def _next_state(self, state: FloatArray, switches: BoolArray) -> tuple[FloatArray, BoolArray]:
        # States and modes after a part of a step, which `switches` says ends at a switch.
        return state, self.contact ^ switches

    def _derivatives(self, state: FloatArray, contact: BoolArray) -> FloatArray:
        # Right-hand side: Eqs. 2 and 5 of the paper, solved for the accelerations.
        p = self._values
        x, vx, y, vy = state
        if self.separation and not self.bisect:
            contact = y < 0.0
        force = np.where(contact, -p["k2"] * y - p["k_nl"] * y**3, 0.0)
        coupling = 0.5 * p["k3"] * (x - y)
        ax = (p["mu"] * force - p["c1"] * vx - p["k1"] * x - coupling) / p["m"]
        ay = (force - p["F"] - p["c2"] * vy + coupling) / p["m"]
        return np.array((vx, ax, vy, ay))

    def _step(self, state: FloatArray, contact: BoolArray, step: FloatArray) -> FloatArray:
        # The state after a step of RK4, whose slopes are s1 to s4.
        with np.errstate(over="ignore", invalid="ignore"):
            s1 = self._derivatives(state, contact)
            s2 = self._derivatives(state + 0.5 * step * s1, contact)
            s3 = self._derivatives(state + 0.5 * step * s2, contact)
            s4 = self._derivatives(state + step * s3, contact)
            return state + step / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4)

    def _violates(self, state: FloatArray, contact: BoolArray) -> BoolArray:
        # Whether y > 0 in contact (against Eq. 3), or y < 0 when separated (against Eq. 4).
        if not self.separation:
            return np.zeros_like(contact)
        return np.asarray(np.where(contact, state[2] > 0.0, state[2] < 0.0), dtype=bool)

    def _bisect(self, first: FloatArray, remaining: FloatArray, switches: BoolArray) -> FloatArray:
        # The shortest step that violates the mode: the next mode starts on its own side of y = 0.
        lower, upper = np.zeros_like(remaining), remaining
        for _ in range(_MAX_BISECTIONS):
            middle = 0.5 * (lower + upper)
            if np.all((middle <= lower) | (middle >= upper) | ~switches):
                break
            violates = self._violates(self._step(first, self.contact, middle), self.contact)
            lower = np.where(violates, lower, middle)
            upper = np.where(violates, middle, upper)
        return upper

    def _overflow_error(self, state: FloatArray) -> ComputationError:
        index = np.flatnonzero(~np.isfinite(state).all(axis=0))[0]
        # `advise` keeps the remedies that apply: separation if ignored, a cubic contact if linear.
        remedies = ("a smaller step", SEPARATION, CUBIC_CONTACT, "a shorter run")
        return ComputationError(
            f"the motion grows beyond the floating-point range at t = {self.t:.6g} s",
            advise(System(self._parameters[index], self.separation), remedies),
        )

    def _check_step(self) -> None:
        p = self._values
        _, _, y, _ = self.state
        tangent_stiffness = np.where(self.contact, p["k2"] + 3.0 * p["k_nl"] * y**2, 0.0)
        frequency = np.sqrt(np.max((p["k1"] + p["k3"] + tangent_stiffness) / p["m"]))
        decay_rate = np.max(np.maximum(p["c1"], p["c2"]) / p["m"])
        fastest_rate = max(frequency, decay_rate)
        if self.step * fastest_rate > _STABILITY_LIMIT:
            cause = "damping" if decay_rate > frequency else "tangent contact stiffness"
            raise ComputationError(
                f"step = {self.step:g} s is too large for RK4 at t = {self.t:.6g} s: the {cause} "
                f"allows steps up to about {_STABILITY_LIMIT / fastest_rate:.2g} s there",
                f"use a smaller step, such as {_ADVISED_STEP / fastest_rate:.1g} s, "
                "or the taylor method",
            )


class RungeKuttaStepper:
    """A stepper that returns the steps of `RungeKutta4` for one parameter set as segments.

    A switch that is not located is attributed to the end of its step.
    """

    def __init__(self, p: Parameters, integrator: RungeKutta4) -> None:
        self._p, self._integrator = p, integrator
        # Segments in reverse order.
        self._segments: list[Segment] = []

    def advance(self) -> Segment:
        """The next segment: a step, or its part before or after a switch, interpolated.

        Raises `ComputationError` as `RungeKutta4.advance` does.
        """
        while not self._segments:
            begin = self._integrator.t
            parts = self._integrator.advance()
            next_mode = self._mode_of(self._integrator.contact)
            for part in reversed(parts):
                start = begin + float(part.begin[0])
                # Only a switch that bisection located ends a part within the step. Any other part
                # ends exactly at the end of the step, to accumulate no rounding.
                switch_is_located = self._integrator.bisect and bool(part.switches[0])
                end = start + float(part.duration[0]) if switch_is_located else self._integrator.t
                if end > start:
                    mode = self._mode_of(part.contact)
                    first, final = (state[:, 0].tolist() for state in (part.first, part.final))
                    segment = segment_between(
                        self._p, mode, (start, end), (first, final), next_mode=next_mode
                    )
                    self._segments.append(segment)
                    next_mode = mode
        return self._segments.pop()

    def _mode_of(self, contact: NDArray[Any]) -> Mode:
        # `contact`, shape (1,), has the number of a mode on a belt of finite speed. Otherwise it is
        # a flag, whose values 0 and 1 are the numbers of SEPARATED and CONTACT.
        return Mode(int(contact[0]))
