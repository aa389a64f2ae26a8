"""Detection of stiff scenes, in which deviations decay much faster than the motion changes.

Explicit methods need very many steps there; errors about the number of steps say so.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import (
    ComputationError,
    Mode,
    System,
    advise_one_of,
    equilibrium,
    jacobian,
    sliding_mode,
)

from .methods import uses_step
from .request import TOL_RANGE, Request

# Stability limit of an explicit high-order method: the product of decay rate and step.
_STABILITY_LIMIT: Final = 9.0
# A scene is stiff if stability requires more than this number of steps and the decay rate exceeds
# the rate of the motion by more than this ratio.
_STIFF_STEPS: Final = 20_000.0
_STIFF_RATIO: Final = 100.0
# An eigenvalue decays, rather than oscillates, if its real part is greater by this factor.
_DECAY_RATIO: Final = 10.0
# Methods for stiff scenes.
_STIFF_METHODS: Final = ("scipy-lsoda", "scipy-radau")


@dataclass(frozen=True, slots=True)
class Stiffness:
    """Rates of decay and of the motion, 1/s, in a stiff scene, and steps needed for stability."""

    decay_rate: float
    motion_rate: float
    steps: float

    def __str__(self) -> str:
        return (
            f"the scene is stiff: deviations decay at up to {self.decay_rate:.3g} 1/s, "
            f"the motion changes at {self.motion_rate:.3g} 1/s"
        )


def find_stiffness(system: System, *, t_end: float) -> Stiffness | None:
    """Stiffness of a scene, from the eigenvalues in contact and off the belt; None if not stiff."""
    contact = sliding_mode(system.parameters)
    modes = (contact, Mode.SEPARATED) if system.separation else (contact,)
    try:
        y = min(equilibrium(system).y, 0.0)
    except ComputationError:
        y = 0.0
    stiffness = None
    for mode in modes:
        matrix = np.array(jacobian(system.parameters, y, mode))
        if not np.all(np.isfinite(matrix)):
            continue
        eigenvalues = np.linalg.eigvals(matrix)
        decaying = eigenvalues.real < -_DECAY_RATIO * np.abs(eigenvalues.imag)
        if not np.any(decaying):
            continue
        decay_rate = float(-eigenvalues.real[decaying].min())
        motion_rate = float(np.abs(eigenvalues).min())
        steps = decay_rate * t_end / _STABILITY_LIMIT
        if (
            decay_rate > _STIFF_RATIO * motion_rate
            and steps > _STIFF_STEPS
            and (not stiffness or decay_rate > stiffness.decay_rate)
        ):
            stiffness = Stiffness(decay_rate, motion_rate, steps)
    return stiffness


def max_steps_error(steps: int, t: float, t_end: float, *, tol: float | None) -> ComputationError:
    """The error for a run that used all its steps up to the time t, s.

    Without `tol` the method has a fixed step.
    """
    remedies = ["a shorter horizon"]
    if tol is not None and tol < TOL_RANGE[1]:
        remedies.append("a larger tol")
    return ComputationError(
        f"{steps} steps reach t = {t:.6g} s of {t_end:g} s", advise_one_of(remedies)
    )


def step_limit_error(request: Request, t: float) -> ComputationError:
    """The error for a request that used all its steps up to the time t, s; mentions stiffness."""
    method = request.method
    tol = None if uses_step(method) else request.tol
    error = max_steps_error(request.max_steps, t, request.t_end, tol=tol)
    stiffness = find_stiffness(request.system, t_end=request.t_end)
    if stiffness is None:
        return error
    reason = f"{error.why}; {stiffness}"
    # Methods for stiff scenes support neither a course (parameters over time) nor sensitivities.
    if method in _STIFF_METHODS or request.course is not None or request.sensitivities:
        return ComputationError(reason, error.advice)
    return ComputationError(reason, f"use the method {' or '.join(_STIFF_METHODS)}")
