"""Errors that rounding makes in the exact solution of a linear scene.

Parameters are known to a relative ε = 2⁻⁵², and so is the frequency of every mode: after a time t
the phase is off by ω t ε, and the error of the state is that part of the vibration that is left.
"""

import math
from typing import Final

import numpy as np

from fivtui.model import Mode, jacobian, time_scale
from fivtui.transient.errors import Deviation
from fivtui.transient.result import Transient

_EPSILON: Final = float(np.finfo(float).eps)


def rounding_error(run: Transient) -> Deviation:
    """Relative rounding errors of a run as a `Deviation`, where two runs do not show them.

    Zero for runs in steps, whose rounding differs between tolerances.
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
    # Vibration left at the end, as a share, and the time for which it stays large.
    share = 1.0 if growth >= 0.0 else min(1.0, math.exp(growth * run.t_end) * amplitude / size)
    lasting = run.t_end if growth >= 0.0 else min(run.t_end, -1.0 / growth)
    # The longest span contributes the rounding error of the amplitude.
    final_error = _EPSILON * (1.0 + amplitude / size + omega * run.t_end * share)
    peak_error = _EPSILON * (1.0 + omega * lasting)
    return Deviation(final_error, peak_error, peak_error, 0.0, 0)
