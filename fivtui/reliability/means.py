"""The scene at the means of the inputs, and the check of its safe μ.

Members are the parameter sets of a study. Their safe μ is found by continuation: it follows the
branch of limit cycles from the Hopf point. A global search at the means of the inputs finds limit
cycles on other branches too.
"""

from functools import lru_cache

import numpy as np

from fivtui.distributions import Distribution
from fivtui.model import ALL_PARAMETERS, ComputationError, Parameters, System
from fivtui.safety import safe_friction, safe_mus
from fivtui.sweeps import Study

from .request import SAFE_MU


def moments_of(study: Study) -> dict[str, tuple[float, float]]:
    """Mean and standard deviation of inputs that are parameters, not components of the start."""
    return {
        name: axis.moments()
        for name, axis in study.design.axes.items()
        if name in ALL_PARAMETERS and isinstance(axis, Distribution)
    }


def parameters_at_means(study: Study) -> Parameters:
    """The parameters of a scattered study, each input at its mean."""
    means = {name: mean for name, (mean, _) in moments_of(study).items()}
    return study.parameters.with_values(means)


def confirmed_mu_limit(study: Study) -> float | None:
    """The μ up to which a global search at the means of the inputs confirms safe μ by continuation.

    None if the search confirms it entirely, or safe μ is not an output.
    """
    if SAFE_MU not in study.outputs:
        return None
    p = parameters_at_means(study).with_values({"mu": 0.0})
    # A scattered study has one case: separation considered (True) or ignored.
    return _confirmed_limit(System(p, study.cases[0]))


@lru_cache(maxsize=64)
def _confirmed_limit(system: System) -> float | None:
    # The μ up to which the search confirms safe μ by continuation; None if entirely.
    p, separation = system.parameters, system.separation
    # By continuation, as for the members; NaN if there is neither a limit cycle nor a critical μ.
    (continued_mu,) = safe_mus(p, {}, np.array([separation])).tolist()
    try:
        verdict = safe_friction(p, separation=separation)
    except ComputationError:
        # Without an equilibrium at the means, safe μ is not known there.
        return 0.0
    confirmed_to = verdict.limit_of(continued_mu)
    # Without a safe μ by continuation, the search must find no limit cycle at any μ.
    required_mu = verdict.searched_to if np.isnan(continued_mu) else continued_mu
    return confirmed_to if confirmed_to < required_mu else None
