"""Stiffness: deviations decay much faster than the motion changes."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import (
    ComputationError,
    Mode,
    System,
    equilibrium,
    jacobian,
    use_one_of,
)

from .methods import uses_step
from .request import TOL_RANGE, Request

# Stability limit of an explicit high-order method, as decay rate times step.
_REACH: Final = 9.0
# A scene is stiff above this number of steps forced by stability, and this ratio of rates.
_BURDEN: Final = 20_000.0
_RATIO: Final = 100.0
# Methods for stiff scenes.
_IMPLICIT: Final = ("scipy-lsoda", "scipy-radau")


@dataclass(frozen=True, slots=True)
class Stiffness:
    """Why a scene is stiff."""

    decay: float
    motion: float
    steps: float

    def __str__(self) -> str:
        return (
            f"the scene is stiff: deviations decay at up to {self.decay:.3g} 1/s, the motion goes "
            f"at {self.motion:.3g} 1/s"
        )


def find_stiffness(system: System, *, t_end: float) -> Stiffness | None:
    """Stiffness of a scene, from the eigenvalues in contact and off the belt."""
    modes = (Mode.CONTACT, Mode.SEPARATED) if system.separation else (Mode.CONTACT,)
    try:
        y = min(equilibrium(system).y, 0.0)
    except ComputationError:
        y = 0.0
    stiffness = None
    for mode in modes:
        matrix = np.array(jacobian(system.parameters, y, mode))
        if not np.all(np.isfinite(matrix)):
            continue
        values = np.linalg.eigvals(matrix)
        decaying = values.real < -10.0 * np.abs(values.imag)
        if not np.any(decaying):
            continue
        decay = float(-values.real[decaying].min())
        motion = float(np.abs(values).min())
        steps = decay * t_end / _REACH
        if (
            decay > _RATIO * motion
            and steps > _BURDEN
            and (not stiffness or decay > stiffness.decay)
        ):
            stiffness = Stiffness(decay, motion, steps)
    return stiffness


def stiffness_of(request: Request) -> Stiffness | None:
    """Stiffness of a requested transient, see `find_stiffness`."""
    return find_stiffness(request.system, t_end=request.t_end)


def max_steps_error(steps: int, t: float, t_end: float, *, tol: float | None) -> ComputationError:
    """The error for a run that used all its steps up to the time t; without `tol` if it is None."""
    remedies = ["a shorter horizon"]
    if tol is not None and tol < TOL_RANGE[1]:
        remedies.append("a larger tol")
    return ComputationError(
        f"{steps} steps end at t = {t:.6g} s of {t_end:g} s", use_one_of(remedies)
    )


def step_limit_error(request: Request, t: float) -> ComputationError:
    """The error for a request that used all its steps up to the time t."""
    method = request.method
    tol = None if uses_step(method) else request.tol
    error = max_steps_error(request.max_steps, t, request.t_end, tol=tol)
    stiff = stiffness_of(request)
    if stiff is None:
        return error
    why = f"{error.why}; {stiff}"
    if method in _IMPLICIT or request.course is not None or request.sensitivities:
        return ComputationError(why, error.advice)
    return ComputationError(why, f"use the method {' or '.join(_IMPLICIT)}")
