"""Transients: the mode-by-mode event loop over any integrator, and its result."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from . import taylor
from .errors import Cancelled, ComputationError, InputError
from .extremes import Extremes
from .methods import METHODS, Problem, check_takes_step
from .model import Mode, State, contact_force, mode_of, static_start
from .parameters import Parameters, parse_number, unknown_name
from .segment import Segment, Stepper
from .taylor import overflow_error
from .trajectory import DenseSolution, Trajectory

Progress = Callable[[float], bool]
Start = Literal["static"] | Sequence[float]
Samples = Literal["none", "dense"] | Sequence[float] | NDArray[np.float64]
Kernel = Literal["compiled", "interpreted"]
KernelChoice = Literal["auto"] | Kernel

DEFAULT_T_END: Final = 100.0
DEFAULT_TOL: Final = taylor.DEFAULT_TOL
MAX_T_END: Final = 1e7
TOL_RANGE: Final = taylor.TOL_RANGE
MAX_STEPS: Final = 20_000_000
_CHUNK: Final = 256
_PROGRESS_EVERY: Final = 128


@dataclass(frozen=True, slots=True)
class FinalState:
    """State at the end: t in s, x and y in m, vx and vy in m/s."""

    t: float
    x: float
    vx: float
    y: float
    vy: float


@dataclass(frozen=True, slots=True)
class Peak:
    """Exact extremes over the whole run, m; `vx_max`, m/s, is the least valid belt speed."""

    y_abs: float
    y_max: float
    y_min: float
    x_abs: float
    vx_max: float


@dataclass(frozen=True, slots=True)
class Steady:
    """Half range of y over the second half of the horizon, m."""

    y_half_range: float


@dataclass(frozen=True, slots=True)
class ContactForce:
    """Least and greatest contact force over the run, N."""

    min: float
    max: float


@dataclass(frozen=True, slots=True)
class Events:
    """Switches of the run.

    Attributes
    ----------
    separations, reattachments : int
        Their numbers.
    separated_time : float
        Time off the belt, s.
    first, last : float or None
        Time of the first and last switch, s.
    """

    separations: int
    reattachments: int
    separated_time: float
    first: float | None
    last: float | None


@dataclass(slots=True)
class Stats:
    """Work done.

    Attributes
    ----------
    steps : int
        Integration steps.
    cpu_s : float or None
        CPU time, s, where the caller measured it.
    kernel : str or None
        What ran the method ``taylor``: ``"compiled"`` or ``"interpreted"`` code. None for other
        methods.
    """

    steps: int
    cpu_s: float | None = None
    kernel: Kernel | None = None


@dataclass(frozen=True, slots=True)
class Transient:
    """Result of a transient.

    Attributes
    ----------
    parameters : Parameters
        The parameter set.
    separation : bool
        Whether separation was considered.
    start : State
        (x, ẋ, y, ẏ) at t = 0, m and m/s.
    t_end : float
        Horizon, s.
    method : str
        Name of the integration method.
    tol : float
        Relative tolerance.
    step : float or None
        Step asked of a fixed-step method, s.
    final, peak, steady, contact_force, events, stats
        See their classes.
    switch_times : ndarray, shape (n,)
        Times of all switches, s, alternately of one kind and the other.
    first_mode : Mode
        Mode before the first switch.
    trajectory : Trajectory or None
        The motion at the times asked for.
    solution : DenseSolution or None
        The motion as a function of time, where ``"dense"`` was asked for.
    """

    parameters: Parameters
    separation: bool
    start: State
    t_end: float
    method: str
    tol: float
    step: float | None
    final: FinalState
    peak: Peak
    steady: Steady
    contact_force: ContactForce
    events: Events
    stats: Stats
    switch_times: NDArray[np.float64]
    first_mode: Mode
    trajectory: Trajectory | None = None
    solution: DenseSolution | None = None

    @property
    def separated_intervals(self) -> list[tuple[float, float]]:
        """Start and end of every interval off the belt, s."""
        edges = [0.0, *self.switch_times.tolist(), self.t_end]
        first = 0 if self.first_mode is Mode.SEPARATED else 1
        pairs = list(pairwise(edges))
        return [pair for pair in pairs[first::2] if pair[1] > pair[0]]


def resolve_start(p: Parameters, start: Start, *, separation: bool) -> State:
    """The start state in numbers.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    start : "static" or sequence of four floats
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    State
        (x, ẋ, y, ẏ).

    Raises
    ------
    InputError
        If `start` is neither.
    """
    allowed = "static, or four finite numbers x,vx,y,vy in m and m/s"
    if isinstance(start, str):
        if start != "static":
            raise InputError(f"start = {start!r}: allowed is {allowed}")
        return static_start(p, separation=separation)
    given = np.asarray(start)
    if given.shape != (4,):
        raise InputError(f"start = {start!r}: allowed is {allowed}")
    x, vx, y, vy = (parse_number("start", value, allowed) for value in given.tolist())
    return (x, vx, y, vy)


class Recorder:
    """Takes in the segments of a run and keeps what its result requires, nothing else.

    Parameters
    ----------
    problem : Problem
        What is being integrated.
    samples : "none", "dense" or sequence of float
        Times at which the trajectory is kept, ascending, s; or all polynomials; or nothing.

    Raises
    ------
    InputError
        If the times are not ascending or lie outside [0, t_end].
    """

    def __init__(self, problem: Problem, samples: Samples = "none") -> None:
        self._problem = problem
        self._extremes = Extremes()
        self._second_half = Extremes()
        self._half = 0.5 * problem.t_end
        self._switches: list[float] = []
        self._separated = [0.0]
        self._final: State = problem.start
        self._steps = 0
        self._dense = isinstance(samples, str) and samples == "dense"
        self._times = sample_times(samples, problem.t_end)
        self._kept: list[Segment] = []
        self._parts: list[Trajectory] = []
        self.t = 0.0
        self.first_mode = mode_of(problem.parameters, problem.start, separation=problem.separation)
        self._separations = 0

    @property
    def t_end(self) -> float:
        """The horizon, s."""
        return self._problem.t_end

    @property
    def complete(self) -> bool:
        """Whether the horizon is reached."""
        return self.t >= self._problem.t_end

    def include(self, segment: Segment) -> None:
        """Take in the next segment.

        Parameters
        ----------
        segment : Segment
            It may reach beyond the horizon; what lies there does not count.
        """
        t_end = self._problem.t_end
        self._steps += 1
        self.t = segment.end
        if segment.end <= t_end:
            self._extremes.include(segment)
            self._final = segment.final
            duration = segment.duration
            if segment.switches:
                self._switches.append(segment.end)
                self._separations += segment.mode is Mode.CONTACT
        else:
            self._extremes.include_part(segment, segment.start, t_end)
            self._final = segment.state(t_end)
            duration = (t_end - segment.start) - segment.start_remainder
        if segment.end > self._half:
            if segment.start >= self._half and segment.end <= t_end:
                self._second_half.include(segment)
            else:
                self._second_half.include_part(segment, self._half, t_end)
        if segment.mode is Mode.SEPARATED:
            self._separated.append(duration)
        if self._times is not None:
            self._kept.append(segment)
            if len(self._kept) >= _CHUNK:
                self._sample(self._times)
        elif self._dense:
            self._kept.append(segment)

    def _sample(self, times: NDArray[np.float64]) -> None:
        # Evaluates the waiting segments at their sample times and lets them go.
        solution = DenseSolution(self._problem.parameters, self._kept)
        count = int(np.searchsorted(times, solution.t_end, side="right"))
        self._parts.append(solution(times[:count]))
        self._times = times[count:]
        self._kept = []

    def result(self, method: str, kernel: Kernel | None = None) -> Transient:
        """The result of the run.

        Parameters
        ----------
        method : str
            Name of the method that made the segments.
        kernel : str, optional
            See `Stats`.

        Returns
        -------
        Transient
            Without CPU time, which the caller measures.

        Raises
        ------
        ComputationError
            If the contact force is out of the range of numbers.
        """
        if self._times is not None and self._kept:
            self._sample(self._times)
        return assemble(
            self._problem,
            method,
            final=self._final,
            whole=self._extremes,
            second_half=self._second_half,
            switches=np.array(self._switches),
            separations=self._separations,
            separated_time=math.fsum(self._separated),
            stats=Stats(steps=self._steps, kernel=kernel),
            first_mode=self.first_mode,
            trajectory=Trajectory.joined(self._parts) if self._parts else None,
            solution=(DenseSolution(self._problem.parameters, self._kept) if self._dense else None),
        )


def assemble(
    problem: Problem,
    method: str,
    *,
    final: State,
    whole: Extremes,
    second_half: Extremes,
    switches: NDArray[np.float64],
    separations: int,
    separated_time: float,
    stats: Stats,
    first_mode: Mode,
    trajectory: Trajectory | None,
    solution: DenseSolution | None,
) -> Transient:
    """The result of a run from what was seen of it.

    Parameters
    ----------
    problem : Problem
        What was integrated.
    method : str
        Name of the method.
    final : State
        State at the horizon.
    whole, second_half : Extremes
        Over the run and over its second half.
    switches : ndarray, shape (n,)
        Times of all switches, s.
    separations : int
        How many of them left the belt.
    separated_time : float
        Time off the belt, s.
    stats : Stats
        Work done.
    first_mode : Mode
        Mode before the first switch.
    trajectory, solution
        As in `Transient`.

    Returns
    -------
    Transient
        Everything that a run reports.

    Raises
    ------
    ComputationError
        If the contact force is out of the range of numbers.
    """
    p, considered = problem.parameters, problem.separation
    # P decreases with y, so its extremes are those of y, except that it ends at zero.
    highest = min(whole.y_max, 0.0) if considered else whole.y_max
    lowest = min(whole.y_min, 0.0) if considered else whole.y_min
    force = ContactForce(
        min=contact_force(p, highest, Mode.CONTACT) + 0.0,
        max=contact_force(p, lowest, Mode.CONTACT) + 0.0,
    )
    if not math.isfinite(force.max - force.min):
        raise overflow_error(problem.t_end, final)
    return Transient(
        parameters=p,
        separation=considered,
        start=problem.start,
        t_end=problem.t_end,
        method=method,
        tol=problem.tol,
        step=problem.step,
        final=FinalState(problem.t_end, *final),
        peak=Peak(
            y_abs=max(whole.y_max, -whole.y_min),
            y_max=whole.y_max,
            y_min=whole.y_min,
            x_abs=max(whole.x_max, -whole.x_min),
            vx_max=whole.vx_max,
        ),
        steady=Steady(y_half_range=0.5 * (second_half.y_max - second_half.y_min)),
        contact_force=force,
        events=Events(
            separations=separations,
            reattachments=len(switches) - separations,
            separated_time=separated_time,
            first=float(switches[0]) if switches.size else None,
            last=float(switches[-1]) if switches.size else None,
        ),
        stats=stats,
        switch_times=switches,
        first_mode=first_mode,
        trajectory=trajectory,
        solution=solution,
    )


def sample_times(samples: Samples, t_end: float) -> NDArray[np.float64] | None:
    """Check a request for samples.

    Parameters
    ----------
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory.
    t_end : float
        Horizon, s.

    Returns
    -------
    ndarray or None
        The times, s, if times were given.

    Raises
    ------
    InputError
        If the times are not ascending or lie outside [0, t_end].
    """
    if isinstance(samples, str):
        if samples not in ("none", "dense"):
            raise unknown_name("samples", samples, ("none", "dense"))
        return None
    times = np.atleast_1d(np.asarray(samples, dtype=float))
    inside = times.size > 0 and times[0] >= 0.0 and times[-1] <= t_end
    if not inside or not np.all(np.diff(times) >= 0.0):
        raise InputError(f"samples: allowed are ascending times in 0 to {t_end:g} s")
    return times


def check_horizon(t_end: float | str) -> float:
    """Check a horizon.

    Parameters
    ----------
    t_end : float or str
        Horizon, s; text that reads as a number will do.

    Returns
    -------
    float
        The horizon, s.

    Raises
    ------
    InputError
        If it is not in 0 < t_end <= 1e7 s.
    """
    allowed = f"0 < t_end <= {MAX_T_END:g} s"
    number = parse_number("t_end", t_end, allowed)
    if not 0.0 < number <= MAX_T_END:
        raise InputError(f"t_end = {number:g}: allowed is {allowed}")
    return number


def make_problem(
    p: Parameters,
    *,
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    separation: bool = True,
    start: Start = "static",
    step: float | None = None,
) -> Problem:
    """Check a request for a transient.

    Parameters
    ----------
    p, t_end, tol, separation, start, step
        As in `integrate`.

    Returns
    -------
    Problem
        Ready to be integrated.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    t_end = check_horizon(t_end)
    allowed = f"{TOL_RANGE[0]:g} <= tol <= {TOL_RANGE[1]:g}"
    tol = parse_number("tol", tol, allowed)
    if not TOL_RANGE[0] <= tol <= TOL_RANGE[1]:
        raise InputError(f"tol = {tol:g}: allowed is {allowed}")
    if step is not None:
        allowed = f"0 < step <= {t_end:g} s"
        step = parse_number("step", step, allowed)
        if not 0.0 < step <= t_end:
            raise InputError(f"step = {step:g}: allowed is {allowed}")
    return Problem(p, resolve_start(p, start, separation=separation), t_end, separation, tol, step)


def integrate(
    p: Parameters,
    *,
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    separation: bool = True,
    start: Start = "static",
    method: str = "taylor",
    step: float | None = None,
    samples: Samples = "none",
    max_steps: int = MAX_STEPS,
    progress: Progress | None = None,
    kernel: KernelChoice = "auto",
) -> Transient:
    """Compute a transient with a native method.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    t_end : float
        Horizon, s.
    tol : float
        Relative tolerance of the variable-step methods, 1e-13 to 1e-2. For ``taylor`` it is the
        relative error to expect of the end state after about a hundred periods.
    separation : bool
        Whether separation is considered (the paper's Case 1) or ignored (Case 2).
    start : "static" or sequence of four floats
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s.
    method : str
        A name in `METHODS`.
    step : float, optional
        Step of a fixed-step method, s.
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory: nothing, everything, or its values at ascending times, s.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        Called now and then with the fraction done; the run is cancelled when it returns False.
    kernel : "auto", "compiled" or "interpreted"
        What runs the method ``taylor``, see `kernel_choice.chosen`.

    Returns
    -------
    Transient
        Final state, exact extremes, events, and the trajectory if asked for.

    Raises
    ------
    InputError
        If the request is wrong.
    ComputationError
        If the run cannot be finished.
    Cancelled
        If `progress` returned False.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    problem = make_problem(p, t_end=t_end, tol=tol, separation=separation, start=start, step=step)
    if step is not None:
        check_takes_step(method)
    used: Kernel | None = None
    if method == "taylor":
        from .kernel_choice import chosen

        whole_run = chosen(kernel)
        if whole_run is not None:
            return whole_run(problem, samples, max_steps, progress)
        used = "interpreted"
    else:
        check_has_kernels(method, kernel)
    recorder = Recorder(problem, samples)
    run_segments(METHODS[method].stepper(problem), recorder, max_steps, progress)
    return recorder.result(method, used)


def check_has_kernels(method: str, kernel: KernelChoice) -> None:
    """Check that no kernel is asked for where there is no choice.

    Parameters
    ----------
    method : str
        Name of a method other than ``taylor``.
    kernel : str
        What was asked for.

    Raises
    ------
    InputError
        If that is not ``"auto"``.
    """
    if kernel != "auto":
        raise InputError(f"kernel = {kernel!r}: the method {method} has no choice of kernels")


def run_segments(
    stepper: Stepper, recorder: Recorder, max_steps: int, progress: Progress | None
) -> None:
    """The event loop: segment after segment until the horizon.

    Parameters
    ----------
    stepper : Stepper
        The integrator.
    recorder : Recorder
        Takes in its segments.
    max_steps : int
        Steps after which the run is given up.
    progress : callable, optional
        See `integrate`.

    Raises
    ------
    ComputationError
        If the run cannot be finished.
    Cancelled
        If `progress` returned False.
    """
    t_end = recorder.t_end
    report = progress or _keep_going
    for count in range(max_steps):
        if count % _PROGRESS_EVERY == 0 and not report(min(recorder.t / t_end, 1.0)):
            raise Cancelled
        recorder.include(stepper.advance())
        if recorder.complete:
            report(1.0)
            return
    raise step_limit_error(max_steps, recorder.t, t_end)


def step_limit_error(max_steps: int, t: float, t_end: float) -> ComputationError:
    """An error for a run that takes too many steps.

    Parameters
    ----------
    max_steps : int
        Their greatest number.
    t, t_end : float
        Time reached and horizon, s.

    Returns
    -------
    ComputationError
        To be raised by the caller.
    """
    return ComputationError(
        f"{max_steps} steps end at t = {t:.6g} s of {t_end:g} s",
        "use a shorter horizon, a larger tol, or scipy-radau if the scene is stiff",
    )


def _keep_going(_fraction: float) -> bool:
    return True
