"""The native integration methods, as data."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.model import InputError, Parameters, State
from fivtui.taylor import Stepper, TaylorStepper, local_tolerance

# RK4 steps per √(m/stiffness) when no step is given.
_REFERENCE_STEP: Final = 0.01


@dataclass(frozen=True, slots=True)
class Problem:
    """What an integrator is asked to do.

    Attributes
    ----------
    parameters : Parameters
        The parameter set.
    start : State
        (x, ẋ, y, ẏ) at t = 0, m and m/s.
    t_end : float
        Horizon, s.
    separation : bool
        Whether separation is considered.
    tol : float
        Relative tolerance.
    step : float or None
        Step of a fixed-step method, s; None for its default.
    """

    parameters: Parameters
    start: State
    t_end: float
    separation: bool
    tol: float
    step: float | None


@dataclass(frozen=True, slots=True)
class Method:
    """An integration method.

    Attributes
    ----------
    name : str
        Name on the command line.
    meaning : str
        One phrase for lists and help.
    fixed_step : bool
        Whether it takes a step rather than a tolerance.
    stepper : callable
        Makes the integrator of a problem.
    """

    name: str
    meaning: str
    fixed_step: bool
    stepper: Callable[[Problem], Stepper]


def takes_step(method: str) -> bool:
    """Whether a native method is set by its step, and not by a tolerance."""
    return method in METHODS and METHODS[method].fixed_step


def check_takes_step(method: str) -> None:
    """Check that a method takes a step.

    Parameters
    ----------
    method : str
        Its name; names that are not in `METHODS` take one.

    Raises
    ------
    InputError
        If it chooses its own.
    """
    if method in METHODS and not METHODS[method].fixed_step:
        raise InputError(f"step: the method {method} chooses its own; set tol instead")


def time_scale(p: Parameters) -> float:
    """√(m/stiffness), s, with all linear springs in parallel: the scale of fixed steps."""
    return math.sqrt(p.m / (p.k1 + p.k2 + p.k3))


def _taylor(problem: Problem) -> Stepper:
    return TaylorStepper(
        problem.parameters,
        problem.start,
        separation=problem.separation,
        tol=local_tolerance(problem.tol),
    )


def fixed_step(problem: Problem) -> float:
    """Step of the fixed-step methods.

    Parameters
    ----------
    problem : Problem
        What is asked.

    Returns
    -------
    float
        The step asked for, or the default for its stiffness, s.
    """
    if problem.step is not None:
        return problem.step
    return _REFERENCE_STEP * time_scale(problem.parameters)


def _rk4(*, locate: bool) -> Callable[[Problem], Stepper]:
    def stepper(problem: Problem) -> Stepper:
        from .rk4 import ReferenceStepper

        return ReferenceStepper(
            problem.parameters,
            problem.start,
            step=fixed_step(problem),
            separation=problem.separation,
            locate=locate,
        )

    return stepper


def _scipy(solver: str) -> Callable[[Problem], Stepper]:
    def stepper(problem: Problem) -> Stepper:
        from .scipy_solvers import ScipyStepper

        return ScipyStepper(
            problem.parameters,
            problem.start,
            solver=solver,
            t_end=problem.t_end,
            separation=problem.separation,
            tol=problem.tol,
        )

    return stepper


METHODS: Final[Mapping[str, Method]] = {
    method.name: method
    for method in (
        Method("taylor", "Taylor series of variable step, events to rounding", False, _taylor),
        Method("rk4", "the paper's fixed-step RK4 with bisection", True, _rk4(locate=True)),
        Method("rk4-across", "fixed-step RK4 across the switch", True, _rk4(locate=False)),
        Method("scipy-dop853", "SciPy's explicit Runge-Kutta of order 8", False, _scipy("DOP853")),
        Method("scipy-radau", "SciPy's implicit Radau of order 5", False, _scipy("Radau")),
        Method("scipy-lsoda", "SciPy's Adams/BDF with automatic choice", False, _scipy("LSODA")),
    )
}
