"""The table of the native integration methods, which need no FMU.

The methods ``fmu`` and ``fmu-native`` run an FMU, written in Python or in C. The paper is
"Nonlinear friction-induced vibration of a slider-belt system".
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.model import InputError, time_scale
from fivtui.taylor import Stepper

from .request import Request

# Default step of RK4, relative to √(m/(k1 + k2 + k3)).
_RELATIVE_STEP: Final = 0.01


@dataclass(frozen=True, slots=True)
class Method:
    """An integration method: its name, its meaning in help texts, and how it is created.

    A method of fixed step has a step in place of a tolerance. `stepper` creates the integrator of a
    request.
    """

    name: str
    meaning: str
    fixed_step: bool
    stepper: Callable[[Request], Stepper]


# Kinds of the FMU by method; the step of these methods is the communication step.
FMU_FLAVOURS: Final[Mapping[str, str]] = {"fmu": "python", "fmu-native": "native"}


def uses_step(method: str) -> bool:
    """Whether a native method takes a step rather than a tolerance."""
    return method in METHODS and METHODS[method].fixed_step


def check_uses_step(method: str) -> None:
    """Raise `InputError` if a method chooses its own step; the FMU takes one."""
    if method in METHODS and not METHODS[method].fixed_step:
        raise InputError(f"step: the method {method} sets its step by tol; set tol instead")


def fixed_step(request: Request) -> float:
    """Step of a fixed-step method, s: as requested, or the default for the stiffness."""
    if request.step is not None:
        return request.step
    return _RELATIVE_STEP * time_scale(request.parameters)


# `_taylor` creates the stepper of a request; for families of methods, a function returns the
# function that creates it. The modules of the steppers are imported on first use.
def _taylor(request: Request) -> Stepper:
    from fivtui.taylor import taylor_stepper

    return taylor_stepper(request.system, request.initial, tol=request.tol)


def _rk4(*, bisect: bool) -> Callable[[Request], Stepper]:
    def create_stepper(request: Request) -> Stepper:
        from .steppers.rk4 import RungeKutta4, RungeKuttaStepper
        from .steppers.rk4_on_belts import BeltRungeKutta4

        p = request.parameters
        integrator_class = RungeKutta4 if p.v_belt is None else BeltRungeKutta4
        # The integrator takes any number of runs, here one.
        integrator = integrator_class(
            [p],
            [request.initial],
            step=fixed_step(request),
            separation=request.separation,
            bisect=bisect,
        )
        return RungeKuttaStepper(p, integrator)

    return create_stepper


def _scipy(solver: str) -> Callable[[Request], Stepper]:
    def create_stepper(request: Request) -> Stepper:
        from .steppers.scipy_solvers import ScipyStepper

        return ScipyStepper(
            request.system, request.initial, solver=solver, t_end=request.t_end, tol=request.tol
        )

    return create_stepper


METHODS: Final[Mapping[str, Method]] = {
    method.name: method
    for method in (
        Method("taylor", "Taylor series of variable step, events to rounding", False, _taylor),
        Method("rk4", "the paper's fixed-step RK4 with bisection", True, _rk4(bisect=True)),
        Method("rk4-across", "fixed-step RK4 across the switch", True, _rk4(bisect=False)),
        Method("scipy-dop853", "SciPy's explicit Runge-Kutta of order 8", False, _scipy("DOP853")),
        Method("scipy-radau", "SciPy's implicit Radau of order 5", False, _scipy("Radau")),
        Method("scipy-lsoda", "SciPy's Adams/BDF with automatic choice", False, _scipy("LSODA")),
    )
}

# Descriptions of all methods, native or by FMU.
ALL_METHODS: Final[Mapping[str, str]] = {
    **{name: method.meaning for name, method in METHODS.items()},
    "fmu": "the Python FMU, run by fmpy",
    "fmu-native": "the native FMU, run by fmpy",
}
