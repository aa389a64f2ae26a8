"""The result of an uncertainty study: probabilities, quantiles and Sobol indices.

An event is an outcome of a member that has a probability: instability, or possible squeal. Samples
are the members that follow the distributions; the others serve Sobol indices. A knock is a
disturbance after which a slider squeals whose equilibrium is stable.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.distributions import Distribution
from fivtui.model import InputError, System
from fivtui.results import Plottable, Result, Table, Tabular, scene_text, to_data
from fivtui.sweeps import OUTPUTS, VIBRATES, Scatter, Study, Sweep, read_sweep, save_sweep

from .local import LocalSensitivity, local_sensitivities
from .means import confirmed_mu_limit
from .request import SAFE_MU, truncated_distribution_warnings
from .statistics import (
    LEAST_EFFECTIVE,
    SampleEstimate,
    SobolIndex,
    effective_samples,
    mark_sampling_error,
    mean_of,
    probability_of,
    probability_with_undecided,
    quantiles_of,
    rank_inputs,
    sobol_of,
    to_dicts,
)

if TYPE_CHECKING:
    from fivtui.charts import Sheet

Floats = NDArray[np.float64]

UNSTABLE: Final = "unstable"
SQUEAL: Final = "squeal_possible"
EVENT_MEANINGS: Final = {
    UNSTABLE: "the equilibrium is unstable",
    SQUEAL: "squeal is possible: μ is above the safe one",
    VIBRATES: "the run ends in vibration",
}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Uncertainty(Result, Tabular, Plottable):
    """Probabilities and quantiles of a scattered scene, with the influence of each input.

    Safe μ of the members is the least μ of the limit cycles on the branch from the Hopf point. A
    global search at the means of the inputs checks it. If the search finds a lower safe μ, or is
    undecided, results that depend on safe μ are left out.

    Attributes
    ----------
    sweep : Sweep
        The computed members, in the order of `Scatter`.
    probabilities : mapping of str to SampleEstimate
        Probabilities of ``unstable``: the equilibrium is unstable; and, if safe μ is known, of
        ``squeal_possible``: μ is above the safe μ. With the output ``vibrates``, also that the run
        ends in vibration: of the decided members; the interval includes the undecided ones.
    means : mapping of str to SampleEstimate
        Mean values of outputs.
    quantiles : mapping of str to mapping of str to SampleEstimate
        Quantiles of outputs, by level.
    indices : mapping of str to mapping of str to SobolIndex
        Sobol indices of outputs and events, by input.
    local : mapping of str to mapping of str to LocalSensitivity
        Derivatives of outputs by inputs, at the means of all inputs.
    missing : mapping of str to int
        Number of members without a value, for each output that has such members.
    unresolved : mapping of str to float
        Effective samples of outputs and events whose variance comes from too few samples. They have
        no Sobol indices, and the intervals of their means may be too narrow.
    safe_mu_unknown_above : float or None
        The μ above which safe μ is not known; None if the search confirms the continuation.
    """

    sweep: Sweep
    probabilities: Mapping[str, SampleEstimate]
    means: Mapping[str, SampleEstimate]
    quantiles: Mapping[str, Mapping[str, SampleEstimate]]
    indices: Mapping[str, Mapping[str, SobolIndex]]
    local: Mapping[str, Mapping[str, LocalSensitivity]]
    missing: Mapping[str, int]
    unresolved: Mapping[str, float]
    safe_mu_unknown_above: float | None = None

    @property
    def study(self) -> Study:
        """The computed study."""
        return self.sweep.study

    @property
    def scatter(self) -> Scatter:
        """The scattered design."""
        return scattered_design(self.study)

    @property
    def inputs(self) -> dict[str, Distribution]:
        """Distributions of the inputs by name."""
        return dict(self.scatter.axes)

    @property
    def error(self) -> float:
        """The greatest error of a probability: the distance to the farther end of its interval."""
        return max((estimate.error for estimate in self.probabilities.values()), default=np.inf)

    def samples(self, name: str) -> Floats:
        """Values of an input or output in the samples of the distributions; NaN without value."""
        values = self.scatter.sample_values(self.sweep.table.numbers[name])
        return np.asarray(values, dtype=float).ravel()

    def regions(self) -> dict[str, NDArray[np.bool_]]:
        """Flags of the samples in each region, by its name; the safest region is first."""
        unstable = self.samples("stable") == 0.0
        if SQUEAL not in self.probabilities:
            return {"stable": ~unstable, "squeals by itself": unstable}
        numbers = {name: self.samples(name) for name in (*self.inputs, *self.study.outputs)}
        possible = (event_flags(self.study, numbers)[SQUEAL] == 1.0) & ~unstable
        return {
            "no squeal known": ~(unstable | possible),
            "squeals after a knock": possible,
            "squeals by itself": unstable,
        }

    def _summary(self) -> list[tuple[str, str]]:
        study = self.study
        rows = [
            (
                "scene",
                scene_text(System(study.parameters, study.cases[0]), without=tuple(self.inputs)),
            ),
            *((name, str(axis)) for name, axis in self.inputs.items()),
            ("samples", f"{self.scatter.samples}, {self.sweep.table.failed} members failed"),
            *(
                (f"P({name})", f"{estimate.value:.6g} ± {estimate.error:.2g}")
                for name, estimate in self.probabilities.items()
            ),
        ]
        if self.safe_mu_unknown_above is not None:
            rows.append(("safe mu", f"not known above {self.safe_mu_unknown_above:.4g}"))
        for name, indices in self.indices.items():
            totals = ((key, f"{index.total.value:z.2f}") for key, index in rank_inputs(indices)[:4])
            texts = (f"{key} {mark_sampling_error(total)}" for key, total in totals)
            rows.append((f"drives {name}", ", ".join(texts)))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui uncertainty --json`` prints."""
        study, scatter = self.study, self.scatter
        # The number of computed safe μ, the folds of a table, and its errors at those for the test:
        # the greatest, and the 95 % quantile.
        safe_mu_table = study.safe
        fixed = study.parameters.as_dict()
        return {
            "parameters": {
                name: value for name, value in fixed.items() if name not in scatter.axes
            },
            "separation": study.cases[0],
            "t_end": study.t_end,
            "inputs": {name: str(axis) for name, axis in scatter.axes.items()},
            "truncated": truncated_distribution_warnings(study),
            "correlations": [list(entry) for entry in scatter.correlations],
            "design": scatter.kind,
            "samples": scatter.samples,
            "members": study.members,
            "failed": self.sweep.table.failed,
            "seeds": scatter.seeds,
            "safe_mu": None
            if safe_mu_table is None
            else {
                "folds": safe_mu_table.folds,
                "error": safe_mu_table.error,
                "usual_error": safe_mu_table.usual_error,
            },
            "safe_mu_not_known_above": self.safe_mu_unknown_above,
            "probabilities": to_dicts(self.probabilities),
            "means": to_dicts(self.means),
            "quantiles": {name: to_dicts(levels) for name, levels in self.quantiles.items()},
            "indices": {name: to_dicts(indices) for name, indices in self.indices.items()},
            "local": to_data(self.local),
            "missing": dict(self.missing),
            "unresolved": dict(self.unresolved),
        }

    def _table(self) -> Table:
        return self.sweep._table()

    def _sheet(self) -> "Sheet":
        from .charts import uncertainty_sheet

        return uncertainty_sheet(self)


def save_uncertainty(result: Uncertainty, path: Path) -> None:
    """Write the members of a study; `InputError` if the file cannot be written."""
    save_sweep(result.sweep, path)


def read_uncertainty(path: Path) -> Uncertainty:
    """Read a study from the file of its members; `InputError` if it is another file, or damaged."""
    return evaluate(read_sweep(path))


def scattered_design(study: Study) -> Scatter:
    """The design of a scattered sweep; `InputError` if the design is not scattered."""
    if not isinstance(study.design, Scatter):
        raise InputError(
            "the sweep is not scattered; it is a result of fivtui sweep, not of fivtui uncertainty"
        )
    return study.design


def mu_excess(study: Study, numbers: Mapping[str, Floats]) -> Floats:
    """μ minus safe μ of members."""
    safe_mu = numbers[SAFE_MU]
    return numbers.get("mu", np.full(safe_mu.size, study.parameters.mu)) - safe_mu


def event_flags(study: Study, numbers: Mapping[str, Floats]) -> dict[str, Floats]:
    """Events by name: 1 if the event occurs in a member, 0 if not, NaN if unknown."""
    events = {}
    if "stable" in study.outputs:
        events[UNSTABLE] = 1.0 - numbers["stable"]
    if SAFE_MU in study.outputs:
        excess = mu_excess(study, numbers)
        events[SQUEAL] = np.where(np.isnan(excess), np.nan, excess > 0.0)
    if VIBRATES in study.outputs:
        events[VIBRATES] = numbers[VIBRATES]
    return events


def _squeal_probability(possible: Floats, excess: Floats, errors: Floats) -> SampleEstimate | None:
    # The probability of possible squeal; its interval includes errors of the table of safe μ.
    # `possible` has the flags of samples, `excess` their μ minus safe μ. `errors` are those of the
    # table at test points, ascending. A flag is wrong if the error of its safe μ is above |excess|.
    estimate = probability_of(possible)
    if estimate is None:
        return None
    share_of_smaller_errors = np.searchsorted(errors, np.abs(excess), side="left") / errors.size
    chance_of_wrong_flag = 1.0 - share_of_smaller_errors
    wrong_hits = float(np.mean(np.where(possible == 1.0, chance_of_wrong_flag, 0.0)))
    wrong_misses = float(np.mean(np.where(possible == 0.0, chance_of_wrong_flag, 0.0)))
    low, high = estimate.low - wrong_hits, estimate.high + wrong_misses
    return SampleEstimate(estimate.value, max(low, 0.0), min(high, 1.0))


def evaluate(sweep: Sweep) -> Uncertainty:
    """The probabilities, quantiles and indices of a scattered sweep."""
    study, scatter = sweep.study, scattered_design(sweep.study)
    events = event_flags(study, sweep.table.numbers)
    outputs = {
        name: sweep.table.numbers[name] for name in study.outputs if OUTPUTS[name].kind != "truth"
    }
    local = local_sensitivities(study)
    unknown_above = confirmed_mu_limit(study)
    if unknown_above is not None:
        del events[SQUEAL], outputs[SAFE_MU]
        local.pop(SAFE_MU, None)
    samples = {
        name: np.asarray(scatter.sample_values(values), dtype=float)
        for name, values in (outputs | events).items()
    }
    probabilities = {name: probability_of(samples[name]) for name in events}
    if study.safe is not None and SQUEAL in events:
        excess = scatter.sample_values(mu_excess(study, sweep.table.numbers))
        errors = np.array(study.safe.errors)
        probabilities[SQUEAL] = _squeal_probability(samples[SQUEAL], excess, errors)
    missing = {name: int(np.isnan(values).sum()) for name, values in outputs.items()}
    if VIBRATES in events:
        del outputs[VIBRATES]
        probabilities[VIBRATES] = probability_with_undecided(samples[VIBRATES])
    means = {name: mean_of(samples[name]) for name in outputs}
    effective = {name: effective_samples(values) for name, values in samples.items()}
    return Uncertainty(
        sweep,
        {name: value for name, value in probabilities.items() if value is not None},
        {name: value for name, value in means.items() if value is not None},
        {name: quantiles_of(samples[name]) for name in outputs},
        {
            name: indices
            for name, values in (events | outputs).items()
            if scatter.indices and (indices := sobol_of(scatter, values))
        },
        local,
        {name: count for name, count in missing.items() if count},
        {name: count for name, count in effective.items() if 0.0 < count < LEAST_EFFECTIVE},
        unknown_above,
    )
