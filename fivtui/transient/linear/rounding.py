"""Rounding errors of the exact solution of a linear scene.

Parameters, and so the frequency ω of a vibration, have a relative error ε = 2⁻⁵². After a time t
the phase has an error of ω t ε, and the state has that fraction of the vibration as its error.
"""

import math
from typing import Final

import numpy as np

from fivtui.model import Mode, jacobian, time_scale
from fivtui.transient.errors import Deviation
from fivtui.transient.result import Transient

_EPSILON: Final = float(np.finfo(float).eps)


def rounding_error(run: Transient) -> Deviation:
    """Relative rounding errors of the exact solution, which runs at two tolerances share.

    They are zero for other runs, whose rounding differs between tolerances.
    """
    if run.stats.kernel != "exact":
        return Deviation(0.0, 0.0, 0.0, 0.0, 0)
    p, omega = run.parameters, 1.0 / time_scale(run.parameters)
    growth = float(np.linalg.eigvals(np.array(jacobian(p, 0.0, Mode.CONTACT))).real.max())
    _, *final = run.final
    size = max(map(abs, final))
    amplitude = max(run.peak.x_abs, run.peak.y_abs) * max(1.0, omega)
    if size == 0.0:
        return Deviation(0.0, 0.0, 0.0, 0.0, 0)
    # Ratio of the vibration at the end to the final state, and the time for which it stays large.
    ratio = 1.0 if growth >= 0.0 else min(1.0, math.exp(growth * run.t_end) * amplitude / size)
    duration = run.t_end if growth >= 0.0 else min(run.t_end, -1.0 / growth)
    # Rounding of the result, of the greatest amplitude and of the phase.
    final_error = _EPSILON * (1.0 + amplitude / size + omega * run.t_end * ratio)
    peak_error = _EPSILON * (1.0 + omega * duration)
    return Deviation(final_error, peak_error, peak_error, 0.0, 0)
