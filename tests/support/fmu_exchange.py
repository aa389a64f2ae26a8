"""Model exchange with an FMU by an importer of our own, through fmpy."""

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
    """So many numbers from a function of fmpy."""
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
    """The states x, y, ẋ, ẏ at the end; the solver is restarted where the FMU tells to.

    It stops `late` after the zeros of event indicators, s.
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

    def crossing(place: int, between: Any, first: float, last: float) -> float:
        def value(t: float) -> float:
            return indicators(t, between(t))[place]

        t: float = brentq(value, first, last, xtol=1e-14)
        return t

    solver = solver_from(0.0)
    known = signs()
    while solver.status == "running":
        solver.step()
        assert solver.t_old is not None
        first, last = solver.t_old, solver.t
        now = [value > 0.0 for value in indicators(last, solver.y)]
        crossed = [place for place in range(INDICATORS) if now[place] != known[place]]
        if crossed:
            between = solver.dense_output()
            t = min(crossing(place, between, first, last) for place in crossed)
            t = min(t + late, last)
            rates(t, between(t))
            fmi.enterEventMode()
            more, stops, _, changed, timed, _ = fmi.newDiscreteStates()
            assert (more, stops, timed) == (0, 0, 0)
            fmi.enterContinuousTimeMode()
            known = signs()
            if changed:
                solver = solver_from(t)
    return instance.get("x", "y", "vx", "vy")
