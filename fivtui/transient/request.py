"""Requests for a transient, checked: parameters, start, horizon, accuracy, method, output."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    CONSTANT,
    Course,
    InputError,
    Mode,
    Parameters,
    State,
    System,
    check_known,
    check_names,
    check_parameters,
    mode_of,
    parameter_spec,
    static_start,
)
from fivtui.taylor import DEFAULT_TOL as TAYLOR_TOL, TOL_RANGE as TAYLOR_TOL_RANGE

from .settings.checks import (
    DEFAULT_T_END,
    Start,
    check_horizon,
    check_start,
    check_step,
    check_tolerance,
)

if TYPE_CHECKING:
    from .trajectory import Trajectory

# The output of a run: none, the motion as a function of time, a number of samples, or their times.
Samples = Literal["none", "dense"] | int | Sequence[float] | NDArray[np.float64]
Kernel = Literal["compiled", "interpreted", "exact"]
KernelChoice = Literal["auto"] | Kernel
# Callback for consecutive parts of a trajectory during the run.
OnSamples = Callable[["Trajectory"], None]

DEFAULT_TOL: Final = TAYLOR_TOL
TOL_RANGE: Final = TAYLOR_TOL_RANGE
# Default of the largest number of steps, and largest number of samples.
MAX_STEPS: Final = 20_000_000
_MAX_SAMPLES: Final = 100_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Request:
    """A transient to be computed, checked; `fivtui.simulate` documents the options."""

    # If parameters change over time, the system has their values at the start.
    system: System
    t_end: float = DEFAULT_T_END
    tol: float = DEFAULT_TOL
    start: Start = "static"
    # `integrate` and `simulate` check the method.
    method: str = "taylor"
    step: float | None = None
    samples: Samples = "none"
    max_steps: int = MAX_STEPS
    kernel: KernelChoice = "auto"
    sensitivities: Sequence[str] = ()
    # The parameters as functions of time; None if all are constant.
    course: Course | None = field(init=False)
    # (x, ẋ, y, ẏ) at t = 0, m and m/s.
    initial: State = field(init=False)
    # Sample times, s.
    times: NDArray[np.float64] | None = field(init=False)

    def __post_init__(self) -> None:
        # Fields of a frozen dataclass are set by `object.__setattr__`.
        system, set_field = self.system, object.__setattr__
        p = check_parameters(system.parameters)
        course = Course(p, system.over_time) if system.over_time else None
        set_field(self, "course", course)
        if course is not None:
            # The parameters just after t = 0, where a table may jump.
            p = course.initial
            system = System(p, system.separation, system.over_time)
            set_field(self, "system", system)
        set_field(self, "t_end", check_horizon(self.t_end))
        set_field(self, "tol", check_tolerance(self.tol))
        set_field(self, "max_steps", check_max_steps(self.max_steps))
        if self.step is not None:
            set_field(self, "step", check_step(self.step, self.t_end))
        set_field(self, "sensitivities", check_sensitivities(self.sensitivities, p))
        set_field(self, "initial", resolve_start(system, self.start))
        set_field(self, "times", _sample_times(self.samples, self.t_end))

    @property
    def parameters(self) -> Parameters:
        """The parameter set, at the start if parameters change over time."""
        return self.system.parameters

    @property
    def separation(self) -> bool:
        """Whether separation is considered."""
        return self.system.separation

    @property
    def first_mode(self) -> Mode:
        """The mode at the start."""
        # Rates are the slopes of F, μ, μ_s and v_belt over time; all zero in `CONSTANT`.
        p, rates = self.system.parameters, CONSTANT
        if self.course is not None:
            p, rates = self.course.after(0.0)
        return mode_of(p, self.initial, separation=self.system.separation, rates=rates)

    @property
    def dense(self) -> bool:
        """Whether the result has the motion as a function of time."""
        return isinstance(self.samples, str) and self.samples == "dense"


def resolve_start(system: System, start: Start) -> State:
    """The start state (x, ẋ, y, ẏ) in m and m/s."""
    checked = check_start(start)
    return static_start(system) if isinstance(checked, str) else checked


def check_sensitivities(names: Sequence[str], p: Parameters) -> tuple[str, ...]:
    """Names of the parameters for sensitivities.

    Raises `InputError` if a name is unknown or given twice, or its parameter has no value.
    """
    names = check_names("sensitivities", names)
    for index, name in enumerate(names):
        # Optional parameters describe a belt of finite speed: they have no effect without `v_belt`.
        optional = parameter_spec(name).optional
        if optional and None in (getattr(p, name), p.v_belt):
            missing = name if getattr(p, name) is None else "v_belt"
            raise InputError(f"{missing} = none: must have a value for sensitivities to {name}")
        if name in names[:index]:
            raise InputError(f"sensitivities: {name} is given twice; every name must be given once")
    return names


def check_max_steps(max_steps: object) -> int:
    """A number of steps; raises `InputError` unless it is whole and at least 1."""
    if (
        isinstance(max_steps, int | np.integer)
        and not isinstance(max_steps, bool)
        and max_steps > 0
    ):
        return int(max_steps)
    raise InputError(f"max_steps = {max_steps}: must be a whole number, at least 1")


def _sample_times(samples: Samples, t_end: float) -> NDArray[np.float64] | None:
    # Sample times, s; None without samples. A number of samples includes the ends of the run.
    if isinstance(samples, str):
        check_known("samples", samples, ("none", "dense"))
        return None
    if isinstance(samples, int | np.integer) and not isinstance(samples, bool):
        if not 2 <= samples <= _MAX_SAMPLES:
            raise InputError(f"samples = {samples}: must be 2 to {_MAX_SAMPLES}")
        return np.linspace(0.0, t_end, int(samples))
    times = np.atleast_1d(np.asarray(samples, dtype=float))
    inside = times.size > 0 and times[0] >= 0.0 and times[-1] <= t_end
    if not inside or not np.all(np.diff(times) >= 0.0):
        raise InputError(f"samples: must be ascending times from 0 to {t_end:g} s")
    return times
