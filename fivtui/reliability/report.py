"""Console output of uncertainty studies.

Samples are the members that follow the distributions of the inputs; a study with Sobol indices has
further members.
"""

import math

from fivtui.console import number, print_list, print_rows
from fivtui.results import Row
from fivtui.sweeps import OUTPUTS, VIBRATES, SweepProgress

from .request import SAFE_MU, truncated_distribution_warnings
from .result import EVENT_MEANINGS, Uncertainty
from .statistics import SampleEstimate, mark_sampling_error, rank_inputs

_QUANTILE_LEVELS = ("0.05", "0.5", "0.95")
_DIGITS = 4


class UncertaintyProgress(SweepProgress):
    """Progress of a study on stderr, with the probabilities so far and their errors."""

    def __init__(self, members: int) -> None:
        super().__init__(members)
        self._estimates = ""

    def show_estimates(self, members: int, text: str) -> None:
        """Show `text` beside the progress of a study with a number of members, which may grow."""
        # Measure the rate, members per second, anew.
        if members != self._members:
            self._members, self._start = members, None
        self._estimates = text

    def _display(self, fraction: float, text: str, time_s: float) -> None:
        super()._display(
            fraction, f"{self._estimates}; {text}" if self._estimates else text, time_s
        )


def estimate_text(estimate: SampleEstimate, digits: int = _DIGITS) -> str:
    """An estimate, rounded to one digit beyond the first digit of its error, and the error."""
    if estimate.error > 0.0 and estimate.value != 0.0:
        value_decade, error_decade = (
            math.floor(math.log10(abs(size))) for size in (estimate.value, estimate.error)
        )
        digits_to_error = value_decade - error_decade + 1
        digits = max(2, min(digits_to_error + 1, 10))
    return f"{number(estimate.value, digits)} ± {number(estimate.error, 2)}"


def uncertainty_rows(result: Uncertainty) -> list[Row]:
    """Probabilities, quantiles and total Sobol indices as rows of a table."""
    rows = [
        Row(f"P({name})", estimate_text(estimate), EVENT_MEANINGS[name])
        for name, estimate in result.probabilities.items()
    ]
    if result.safe_mu_unknown_above is not None:
        rows.append(Row("safe μ", safe_mu_text(result), "safe friction coefficient"))
    for name, levels in result.quantiles.items():
        if levels:
            low, middle, high = (number(levels[level].value, _DIGITS) for level in _QUANTILE_LEVELS)
            column = OUTPUTS[name]
            value = f"{middle} ({low} .. {high}) {column.unit}".rstrip()
            rows.append(Row(name, value, f"{column.meaning}: median, 5 and 95 %"))
    for name, indices in result.indices.items():
        text = ", ".join(
            f"{key} {mark_sampling_error(number(index.total.value, 2))}"
            for key, index in rank_inputs(indices)
        )
        rows.append(Row(f"what drives {name}", text, "total Sobol indices"))
    return rows


def safe_mu_text(result: Uncertainty) -> str:
    """How the safe μ of the members was found."""
    safe_mu_table = result.study.safe
    if result.safe_mu_unknown_above is not None:
        return (
            f"not known above μ = {number(result.safe_mu_unknown_above, _DIGITS)}: a global search "
            "at the means of the inputs does not confirm the result of continuation"
        )
    if safe_mu_table is None:
        return "by continuation from the Hopf point for each distinct member"
    return (
        f"interpolated between {safe_mu_table.folds} values, each by continuation from the Hopf "
        f"point; error at most {number(safe_mu_table.usual_error, 2)} at 95 % of the test values, "
        f"{number(safe_mu_table.error, 2)} at all of them"
    )


def print_uncertainty(result: Uncertainty) -> None:
    """Print probabilities, quantiles and Sobol indices of a study."""
    scatter = result.scatter
    inputs = [(name, str(axis)) for name, axis in result.inputs.items()]
    inputs += [
        (f"{first}, {second}", f"correlation {number(value)}")
        for first, second, value in scatter.correlations
    ]
    inputs += [
        ("samples", f"{scatter.samples} in {scatter.repeats} scramblings ({scatter.kind})"),
        ("members", f"{result.study.members}, {result.sweep.table.failed} failed"),
    ]
    if SAFE_MU in result.study.outputs:
        inputs.append(("safe μ", safe_mu_text(result)))
    print_list("Uncertainty", inputs)
    print_rows(
        "Probabilities, with 95 % intervals",
        ("", "probability", "from", "to"),
        [
            (
                EVENT_MEANINGS[name],
                *(number(value, 6) for value in (estimate.value, estimate.low, estimate.high)),
            )
            for name, estimate in result.probabilities.items()
        ],
    )
    quantiles = [(name, values) for name, values in result.quantiles.items() if values]
    if quantiles:
        levels = list(quantiles[0][1])
        print_rows(
            "Quantiles",
            ("output", "unit", "mean", *(f"{float(level):.0%}" for level in levels)),
            [
                (
                    OUTPUTS[name].meaning,
                    OUTPUTS[name].unit,
                    number(result.means[name].value, _DIGITS),
                    *(number(values[level].value, _DIGITS) for level in levels),
                )
                for name, values in quantiles
            ],
        )
    for name in dict.fromkeys((*result.indices, *result.local)):
        _print_sensitivities(name, result)


def _print_sensitivities(output: str, result: Uncertainty) -> None:
    # Sobol indices and local sensitivities of an output.
    indices, local = result.indices.get(output, {}), result.local.get(output, {})
    header = ["input"]
    inputs = [input_name for input_name, _ in rank_inputs(indices)] or list(local)
    rows = {input_name: [input_name] for input_name in inputs}
    if indices:
        header += ["alone", "with others"]
        for input_name in inputs:
            for estimate in (indices[input_name].first, indices[input_name].total):
                rows[input_name].append(mark_sampling_error(estimate_text(estimate, 2)))
    if local:
        header += ["change per SD", "share if linear"]
        for input_name in inputs:
            change = local.get(input_name)
            rows[input_name] += (
                ["", ""] if change is None else [number(change.per_sd, 3), number(change.share, 2)]
            )
    parts = ["Sobol indices with 95 % intervals"] if indices else []
    parts += ["change at the means of the inputs"] if local else []
    print_rows(f"What drives {output}: {'; '.join(parts)}", header, list(rows.values()))


def study_warning(result: Uncertainty) -> str | None:
    """The warning of a study in one sentence; None if there is none."""
    parts = truncated_distribution_warnings(result.study)
    parts += [
        f"{count} members are undecided between rest and vibration: the probability leaves them "
        "out, and its interval includes them as all at rest and as all vibrating"
        if name == VIBRATES
        else f"{count} members have no {name}: they are left out, and {name} has no Sobol indices"
        if result.scatter.indices
        else f"{count} members have no {name}: they are left out"
        for name, count in result.missing.items()
    ]
    parts += [
        _unresolved_text(name, effective_samples, result)
        for name, effective_samples in result.unresolved.items()
    ]
    return "; ".join(filter(None, parts)) or None


def _unresolved_text(name: str, effective_samples: float, result: Uncertainty) -> str:
    # Warning that the variance of an output or event comes from few samples; empty if no index and
    # no interval of the result depends on it.
    consequences = ["there are no Sobol indices of it"] if result.scatter.indices else []
    consequences += ["the interval of its mean may be too narrow"] if name in result.means else []
    if not consequences:
        return ""
    return (
        f"about {effective_samples:.0f} of {result.scatter.samples} samples make up the variance "
        f"of {name}: {', and '.join(consequences)}"
    )
