"""Local sensitivities: derivatives of outputs at the means of all inputs.

Safe μ is the least μ of stable limit cycles on the branch from the Hopf point, or the critical μ if
that is less.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Final

from fivtui.equilibrium import critical_mu_derivatives
from fivtui.model import ComputationError, Parameters, System
from fivtui.safety import safe_mu_derivatives
from fivtui.simulation import simulate
from fivtui.sweeps import OUTPUTS, Study

from .means import moments_of, parameters_at_means
from .request import SAFE_MU

_CRITICAL_MU: Final = "critical_mu"
# Attributes of a transient that have derivatives; counts of events have none.
_DIFFERENTIABLE: Final = ("peak", "steady", "contact_force", "final")


@dataclass(frozen=True, slots=True)
class LocalSensitivity:
    """How an output changes with one input, to first order about the means of all inputs.

    Attributes
    ----------
    derivative : float
        Change of the output per unit of the input.
    per_sd : float
        Change of the output per standard deviation of the input.
    share : float
        Square of `per_sd` over the sum of squares of all inputs: the Sobol index of a linear
        output.
    """

    derivative: float
    per_sd: float
    share: float


def local_sensitivities(study: Study) -> dict[str, dict[str, LocalSensitivity]]:
    """Local sensitivities of a study whose inputs follow distributions, by output and input.

    Derivatives of the critical μ are exact. Those of the safe μ are those of the fold at which the
    branch of limit cycles has its least μ, those of transients come from the variational equations.
    Components of the start and outputs without derivatives are left out.
    """
    standard_deviations = {name: sd for name, (_, sd) in moments_of(study).items()}
    names = tuple(standard_deviations)
    if not names:
        return {}
    try:
        derivatives_by_output = _derivatives(study, parameters_at_means(study), names)
    except ComputationError:
        return {}
    # A parameter without a derivative, such as μ for safe μ, has no effect on the output.
    complete = {
        output: {name: derivatives.get(name, 0.0) for name in names}
        for output, derivatives in derivatives_by_output.items()
    }
    return {
        output: _with_shares(derivatives, standard_deviations)
        for output, derivatives in complete.items()
        if all(map(math.isfinite, derivatives.values()))
    }


def _with_shares(
    derivatives: Mapping[str, float], standard_deviations: Mapping[str, float]
) -> dict[str, LocalSensitivity]:
    changes = {name: slope * standard_deviations[name] for name, slope in derivatives.items()}
    total = sum(change * change for change in changes.values())
    return {
        name: LocalSensitivity(
            derivatives[name], change, change * change / total if total > 0.0 else 0.0
        )
        for name, change in changes.items()
    }


def _derivatives(
    study: Study, means: Parameters, names: tuple[str, ...]
) -> dict[str, Mapping[str, float]]:
    # Derivatives by output and input, without outputs that have none.
    # A scattered study has one case: separation considered (True) or ignored.
    separation = study.cases[0]
    derivatives: dict[str, Mapping[str, float] | None] = {}
    if _CRITICAL_MU in study.outputs:
        derivatives[_CRITICAL_MU] = critical_mu_derivatives(System(means, separation))
    if SAFE_MU in study.outputs:
        derivatives[SAFE_MU] = safe_mu_derivatives(System(means, separation))
    paths = {
        name: OUTPUTS[name].path
        for name in study.outputs
        if OUTPUTS[name].path.partition(".")[0] in _DIFFERENTIABLE
    }
    if paths:
        run = simulate(
            means,
            t_end=study.t_end,
            tol=study.tol,
            separation=separation,
            start=study.start,
            sensitivities=names,
        )
        sensitivities = run.sensitivities
        if sensitivities is not None:
            for output, path in paths.items():
                read_output = attrgetter(path)
                derivatives[output] = {name: read_output(sensitivities[name]) for name in names}
    return {name: values for name, values in derivatives.items() if values is not None}
