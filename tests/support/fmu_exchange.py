"""Model exchange with an FMU by an independent importer, through fmpy."""

from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import POINTER, fmi2Real
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests.support.fmu_instance import FmuInstance

FLOATS = POINTER(fmi2Real)
# Number of continuous states (x, y, ẋ, ẏ), and of event indicators, whose signs change at events.
STATES = 4
INDICATORS = 4


def model_exchange_instance(folder: Path, **values: float | bool) -> FmuInstance:
    """An initialized instance in continuous-time mode."""
    instance = FmuInstance(folder, "ModelExchange").begin(**values)
    instance.update_mode()
    instance.fmi.enterContinuousTimeMode()
    return instance


def write_states(fmi: Any, states: Any) -> None:
    """Set the states x, y, ẋ, ẏ, an array, m and m/s."""
    fmi.setContinuousStates(states.ctypes.data_as(FLOATS), STATES)


def read(function: Any, count: int) -> list[float]:
    """Values that a function of fmpy writes to a buffer of `count` numbers."""
    values = np.empty(count)
    function(values.ctypes.data_as(FLOATS), count)
    return values.tolist()


def integrate_instance(
    instance: FmuInstance, t_end: float, *, tol: float = 1e-11, late: float = 0.0
) -> list[float]:
    """Integrate from 0 to `t_end`; return x, y, ẋ, ẏ.

    The solver restarts where the FMU requests it. Each event is handled `late` seconds
    after the zero of its indicator.
    """
    fmi = instance.fmi

    def rates(t: float, states: Any) -> Any:
        # Also leaves the time and the states in the FMU, for the calls that follow.
        fmi.setTime(t)
        write_states(fmi, states)
        return read(fmi.getDerivatives, STATES)

    def indicators(t: float, states: Any) -> list[float]:
        rates(t, states)
        return read(fmi.getEventIndicators, INDICATORS)

    def signs() -> list[bool]:
        return [value > 0.0 for value in read(fmi.getEventIndicators, INDICATORS)]

    def solver_from(t: float) -> DOP853:
        start = np.array(read(fmi.getContinuousStates, STATES))
        return DOP853(rates, t, start, t_end, rtol=tol, atol=tol)

    def crossing(index: int, interpolant: Any, first: float, end: float) -> float:
        # The time at which an indicator passes zero within a step of the solver.
        def value(t: float) -> float:
            return indicators(t, interpolant(t))[index]

        t: float = brentq(value, first, end, xtol=1e-14)
        return t

    solver = solver_from(0.0)
    previous_signs = signs()
    while solver.status == "running":
        solver.step()
        assert solver.t_old is not None
        first, end = solver.t_old, solver.t
        current_signs = [value > 0.0 for value in indicators(end, solver.y)]
        crossed = [
            index for index in range(INDICATORS) if current_signs[index] != previous_signs[index]
        ]
        if crossed:
            interpolant = solver.dense_output()
            t = min(crossing(index, interpolant, first, end) for index in crossed)
            t = min(t + late, end)
            rates(t, interpolant(t))
            fmi.enterEventMode()
            repeat, terminate, _, changed, time_event, _ = fmi.newDiscreteStates()
            assert (repeat, terminate, time_event) == (0, 0, 0)
            fmi.enterContinuousTimeMode()
            previous_signs = signs()
            if changed:
                solver = solver_from(t)
    return instance.get("x", "y", "vx", "vy")
