"""Computation, charts and table of the uncertainty tab. Imports no Textual."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Chart, Guide, Trace
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.session import plain_names, symbol_of

if TYPE_CHECKING:
    from fivtui.reliability import Uncertainty
    from fivtui.sweeps import Study

FloatArray = NDArray[np.float64]

EXAMPLE: Final = "μ~uniform:0.2:0.8 F~normal:80:8"
# Quantities that can be displayed, in the order of their buttons.
TITLES: Final = {
    "growth_rate": "Growth",
    "critical_mu": "μ_c",
    "safe_mu": "Safe μ",
    "y_half_range": "±y",
    "P_max": "P",
}
# What they are called at an axis and in the table.
_AXES: Final = {
    "growth_rate": "growth rate",
    "critical_mu": "critical μ",
    "safe_mu": "safe μ",
    "y_half_range": "±y 2nd half",
    "P_max": "greatest P",
}
COLUMNS: Final = ("of", "input", "alone", "with others", "if linear", "0 … 1")
SAMPLES: Final = 4096
_BINS: Final = 60
_DOTS: Final = 2000
_MARKS: Final = ("○", "▫", "▲")
_LEVELS: Final = ("0.05", "0.5", "0.95")
_BAR: Final = 12
_DIGITS: Final = 4


def uncertainty_request(scene: Scene, text: str) -> "Study":
    """The study of a scene where inputs scatter, such as ``μ~uniform:0.2:0.8 F~normal:80:8``."""
    from fivtui.reliability import parse_inputs, scattered_study

    inputs = parse_inputs(plain_names(text).split())
    try:
        return scattered_study(scene, inputs, samples=SAMPLES)
    except InputError as error:
        key = "; F4 switches the engine" if str(error).startswith("method =") else ""
        raise InputError(f"{error}{key}") from None


def probability_words(result: "Uncertainty") -> str:
    """The probabilities of a study, with their errors."""
    names = {"unstable": "unstable", "squeal_possible": "squeal possible"}
    return "   ".join(
        f"P({names[name]}) = {each.value:.{_DIGITS}g} ± {each.error:.1g}"
        for name, each in result.probabilities.items()
    )


def truncation_words(result: "Uncertainty") -> str:
    """That distributions of a study are truncated; empty if none is."""
    from fivtui.reliability import truncations

    return ", truncated at bounds" if truncations(result.study) else ""


def index_remark(result: "Uncertainty") -> str:
    """Why Sobol indices of the table are above 1 or below 0; empty if none is."""
    from fivtui.reliability import beyond_share

    cells = (cell for row in index_rows(result) for cell in row[2:4])
    remarks = sorted({*map(beyond_share, cells)} - {""})
    return f", indices {' and '.join(remarks)}: sampling error" if remarks else ""


def drawn(result: "Uncertainty", wanted: str) -> str:
    """The quantity to be displayed: the one wanted, or else the first that has values."""
    known = [name for name, found in result.quantiles.items() if found]
    return wanted if wanted in known else next(iter(known), "")


def histogram_chart(result: "Uncertainty", wanted: str) -> Chart | None:
    """The shares of samples over a quantity, a step line per region, with quantiles."""
    from fivtui.sweeps import OUTPUTS

    name = drawn(result, wanted)
    if not name:
        return None
    values, column = result.samples(name), OUTPUTS[name]
    known = ~np.isnan(values)
    low, high = float(values[known].min()), float(values[known].max())
    if low == high:
        low, high = low - 0.5 * abs(low) - 1e-9, high + 0.5 * abs(high) + 1e-9
    edges = np.linspace(low, high, _BINS + 1)
    traces = []
    for region, here in result.regions().items():
        counts = np.histogram(values[known & here], bins=edges)[0]
        steps = np.repeat(counts / known.sum(), 2)
        traces.append(Trace(region, np.repeat(edges, 2)[1:-1], steps))
    quantiles = result.quantiles[name]
    guides = tuple(Guide(quantiles[level].value, f"{float(level):.0%}") for level in _LEVELS)
    return Chart(
        _label(_AXES.get(name, column.meaning), column.unit),
        "share of samples",
        tuple(traces),
        guides=guides,
        note=probability_words(result),
    )


def samples_chart(result: "Uncertainty", wanted: str) -> Chart | None:
    """Samples by region over the first two inputs, or over one and a quantity."""
    from fivtui.sweeps import OUTPUTS, VARIABLES

    names = [*result.inputs, *filter(None, [drawn(result, wanted)])][:2]
    if len(names) < 2:
        return None
    x, y = (result.samples(name) for name in names)
    units = {key: each.unit for key, each in VARIABLES.items()}
    units |= {key: each.unit for key, each in OUTPUTS.items()}
    places = np.linspace(0, x.size - 1, min(_DOTS, x.size)).astype(int)
    traces = []
    for (region, here), mark in zip(result.regions().items(), _MARKS, strict=False):
        chosen = places[here[places]]
        traces.append(Trace(region, x[chosen], y[chosen], look="points", ordered=False, mark=mark))
    x_label, y_label = (_label(symbol_of(name), units[name]) for name in names)
    return Chart(x_label, y_label, tuple(traces), note=probability_words(result))


def index_rows(result: "Uncertainty") -> Sequence[Sequence[str]]:
    """Sobol indices as rows of `COLUMNS`, by falling total index, with shares to first order."""
    rows = []
    for name, indices in result.indices.items():
        local = result.local.get(name, {})
        ranked = sorted(indices.items(), key=lambda item: -item[1].total.value)
        for place, (key, each) in enumerate(ranked):
            rows.append((
                _AXES.get(name, name.replace("_", " ")) if place == 0 else "",
                symbol_of(key),
                f"{each.first.value:z.2f} ± {each.first.error:.2f}",
                f"{each.total.value:z.2f} ± {each.total.error:.2f}",
                "" if key not in local else f"{local[key].share:.2f}",
                bar(each.first.value, each.total.value),
            ))  # fmt: skip
    return rows


def bar(first: float, total: float) -> str:
    """A bar from 0 to 1: full up to the first index, light up to the total one."""
    full, light = (round(_BAR * min(max(each, 0.0), 1.0)) for each in (first, total))
    return "█" * full + "░" * max(light - full, 0)


def _label(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name
