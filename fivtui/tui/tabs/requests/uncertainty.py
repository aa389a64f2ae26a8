"""The parser of the uncertainty tab's input, and the rows of its table. Imports no Textual."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.tui.session import replace_symbols, symbol_of

if TYPE_CHECKING:
    from fivtui.reliability import Uncertainty
    from fivtui.sweeps import Study

EXAMPLE: Final = "μ~uniform:0.2:0.8 F~normal:80:8"
# Quantities that can be displayed, in the order of their buttons.
TITLES: Final = {
    "growth_rate": "Growth",
    "critical_mu": "μ_c",
    "safe_mu": "Safe μ",
    "y_half_range": "±y",
    "P_max": "P",
}
# Columns of the table of Sobol indices. The first-order index is the share of the variance that an
# input causes alone, the total index that with others. The last columns are the share in a linear
# model, and a bar.
COLUMNS: Final = ("quantity", "input", "alone", "with others", "if linear", "0 … 1")
SAMPLES: Final = 4096
# Columns of a bar from 0 to 1.
_BAR_LENGTH: Final = 12


def uncertainty_request(scene: Scene, text: str) -> "Study":
    """The study of a scene with distributions such as ``μ~uniform:0.2:0.8``, not with its own."""
    from fivtui.reliability import parse_inputs, scattered_study

    inputs = parse_inputs(replace_symbols(text).split())
    try:
        return scattered_study(replace(scene, scatter=()), inputs, samples=SAMPLES)
    except InputError as error:
        # An FMU, which a scene may choose as its method, cannot compute a study.
        advice = "; another engine can" if str(error).startswith("method =") else ""
        raise InputError(f"{error}{advice}") from None


def index_remark(result: "Uncertainty") -> str:
    """A note on Sobol indices above 1 or below 0; empty if there are none."""
    from fivtui.reliability import excess_remark

    index_texts = (
        text for _, _, first, total, _, _ in index_rows(result) for text in (first, total)
    )
    remarks = sorted({*map(excess_remark, index_texts)} - {""})
    return f", indices {' and '.join(remarks)}: sampling error" if remarks else ""


def index_rows(result: "Uncertainty") -> Sequence[Sequence[str]]:
    """Sobol indices of every quantity as rows of `COLUMNS`, by decreasing total index."""
    from fivtui.reliability import quantity_name

    rows = []
    for name, indices in result.indices.items():
        # From derivatives at the means of all inputs.
        linear_indices = result.local.get(name, {})
        by_total_index = sorted(indices.items(), key=lambda item: -item[1].total.value)
        for rank, (input_name, index) in enumerate(by_total_index):
            linear = linear_indices.get(input_name)
            rows.append((
                quantity_name(name) if rank == 0 else "",
                symbol_of(input_name),
                f"{index.first.value:z.2f} ± {index.first.error:.2f}",
                f"{index.total.value:z.2f} ± {index.total.error:.2f}",
                "" if linear is None else f"{linear.share:.2f}",
                index_bar(index.first.value, index.total.value),
            ))  # fmt: skip
    return rows


def index_bar(first: float, total: float) -> str:
    """A bar from 0 to 1, dark up to the first-order index, light up to the total index."""
    dark, end = (round(_BAR_LENGTH * min(max(index, 0.0), 1.0)) for index in (first, total))
    return "█" * dark + "░" * max(end - dark, 0)
