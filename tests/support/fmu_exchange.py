"""Model exchange with an FMU by an independent importer, through fmpy."""

from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import POINTER, fmi2Real
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests.support.fmu_instance import FmuInstance

FLOATS = POINTER(fmi2Real)
INDICATORS = 4


def exchanged(folder: Path, **values: float | bool) -> FmuInstance:
    """An initialized instance in continuous-time mode."""
    instance = FmuInstance(folder, "ModelExchange").begin(**values)
    instance.fmi.newDiscreteStates()
    instance.fmi.enterContinuousTimeMode()
    return instance


def read(function: Any, count: int) -> list[float]:
    """Values that a function of fmpy writes to a buffer of `count` numbers."""
    values = np.empty(count)
    function(values.ctypes.data_as(FLOATS), count)
    return values.tolist()


def integrated(
    instance: FmuInstance,
    t_end: float,
    *,
    begin: float = 0.0,
    tol: float = 1e-11,
    late: float = 0.0,
) -> list[float]:
    """Final x, y, ẋ, ẏ; the solver restarts where the FMU requests it.

    Each event is handled `late` seconds after the zero of its indicator.
    """
    fmi = instance.fmi

    def rates(t: float, states: Any) -> Any:
        fmi.setTime(t)
        fmi.setContinuousStates(states.ctypes.data_as(FLOATS), 4)
        return read(fmi.getDerivatives, 4)

    def indicators(t: float, states: Any) -> list[float]:
        rates(t, states)
        return read(fmi.getEventIndicators, INDICATORS)

    def signs() -> list[bool]:
        return [value > 0.0 for value in read(fmi.getEventIndicators, INDICATORS)]

    def solver_from(t: float) -> DOP853:
        start = np.array(read(fmi.getContinuousStates, 4))
        return DOP853(rates, t, start, t_end, rtol=tol, atol=tol)

    def crossing(index: int, between: Any, first: float, end: float) -> float:
        def value(t: float) -> float:
            return indicators(t, between(t))[index]

        t: float = brentq(value, first, end, xtol=1e-14)
        return t

    solver = solver_from(0.0)
    known_signs = signs()
    while solver.status == "running":
        solver.step()
        assert solver.t_old is not None
        first, end = solver.t_old, solver.t
        current_signs = [value > 0.0 for value in indicators(end, solver.y)]
        crossed = [
            index for index in range(INDICATORS) if current_signs[index] != known_signs[index]
        ]
        if crossed:
            between = solver.dense_output()
            t = min(crossing(index, between, first, end) for index in crossed)
            t = min(t + late, end)
            rates(t, between(t))
            fmi.enterEventMode()
            needed, stops, _, changed, timed, _ = fmi.newDiscreteStates()
            assert (needed, stops, timed) == (0, 0, 0)
            fmi.enterContinuousTimeMode()
            known_signs = signs()
            if changed:
                solver = solver_from(t)
    return instance.get("x", "y", "vx", "vy")
