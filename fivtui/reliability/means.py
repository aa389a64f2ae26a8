"""The scene at the means of the inputs, and the check of its safe μ.

Safe μ of members is found by continuation: it follows the branch of limit cycles from the Hopf
point. A global search at the means finds limit cycles on other branches too.
"""

from functools import lru_cache

import numpy as np

from fivtui.distributions import Distribution
from fivtui.model import ALL_PARAMETERS, ComputationError, Parameters, System
from fivtui.safety import safe_friction, safe_mus
from fivtui.sweeps import Study

from .request import SAFE_MU


def moments_of(study: Study) -> dict[str, tuple[float, float]]:
    """Mean and standard deviation of the scattered parameters; inputs of the start are left out."""
    return {
        name: axis.moments()
        for name, axis in study.design.axes.items()
        if name in ALL_PARAMETERS and isinstance(axis, Distribution)
    }


def parameters_at_means(study: Study) -> Parameters:
    """The parameters of a scattered study, each input at its mean."""
    means = {name: mean for name, (mean, _) in moments_of(study).items()}
    return study.parameters.with_values(means)


def safe_mu_unknown_above(study: Study) -> float | None:
    """The μ above which a global search at the means of the inputs does not confirm safe μ.

    None if the search confirms safe μ by continuation, or safe μ is not an output.
    """
    if SAFE_MU not in study.outputs:
        return None
    p = parameters_at_means(study).with_values({"mu": 0.0})
    return _unconfirmed_above(System(p, study.cases[0]))


@lru_cache(maxsize=64)
def _unconfirmed_above(system: System) -> float | None:
    # The μ above which the search does not confirm safe μ by continuation; None if it does.
    p, separation = system.parameters, system.separation
    (continued_mu,) = safe_mus(p, {}, np.array([separation])).tolist()
    try:
        verdict = safe_friction(p, separation=separation)
    except ComputationError:
        # Without an equilibrium at the means, safe μ is not known there.
        return 0.0
    limit = verdict.limit_of(continued_mu)
    # Without a safe μ by continuation, no μ that was searched may have a limit cycle.
    required_mu = verdict.searched_to if np.isnan(continued_mu) else continued_mu
    return limit if limit < required_mu else None
