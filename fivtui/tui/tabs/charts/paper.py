"""Charts and table rows of the paper tab. Imports no Textual."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.charts import Chart, Guide, NearestPoint, Trace
from fivtui.model import PARAMETERS
from fivtui.paper import DATA_COLUMNS, PANELS, SEPARATION, CheckedClaim, Claim, FigureData, Panel
from fivtui.scene import Scene
from fivtui.tui.session import paper_scenes, symbol_of

FIGURE_COLUMNS: Final = ("figure", "lines", "what it shows")
CLAIM_COLUMNS: Final = ("verdict", "section", "statement", "stated")
# Appended to the key of a computed figure: a column of its own would take too much room.
COMPUTED: Final = " ✓"
_UNKNOWN: Final = "?"

# Columns of every chart by kind of panel; a pair of columns is the two modes.
_DRAWN: Final[Mapping[str, Sequence[tuple[str, ...]]]] = {
    "equilibrium": (("y_e",),),
    "eigenvalues": (("omega_1", "omega_2"), ("sigma_1", "sigma_2")),
    "critical mu": (("mu_c",),),
    "amplitude": (("y_peak",), ("y_half_range",)),
}
_LABELS: Final = {
    "omega_1": "Im λ (rad/s)",
    "sigma_1": "Re λ (1/s)",
    "mu_c": "μ_c",
    "y_peak": "peak |y| (m)",
    "y_half_range": "half peak-to-peak, 2nd half (m)",
}


def figure_rows(computed: Sequence[str]) -> list[tuple[str, ...]]:
    """The paper's figures as rows of `FIGURE_COLUMNS`; `computed` ones are marked."""
    return [
        (f"{key}{COMPUTED if key in computed else ''}", _by(panel), panel.caption)
        for key, panel in PANELS.items()
    ]


def _by(panel: Panel) -> str:
    if panel.by == SEPARATION:
        return "both cases"
    values = ", ".join(f"{getattr(line.scene.parameters, panel.by):g}" for line in panel.lines)
    return f"{symbol_of(panel.by)} {values}"


def claim_rows(
    claims: Sequence[Claim], checked: Mapping[str, CheckedClaim]
) -> list[tuple[str, ...]]:
    """The paper's claims as rows of `CLAIM_COLUMNS`, with "?" where not checked yet."""
    return [
        (
            str(checked[claim.id].verdict) if claim.id in checked else _UNKNOWN,
            claim.section,
            claim.statement,
            claim.stated,
        )
        for claim in claims
    ]


def claim_words(claim: Claim, checked: CheckedClaim | None) -> str:
    """A claim in a few lines: stated value, computed value, verdict, reason."""
    lines = [claim.statement, f"stated: {claim.stated}"]
    if checked is not None:
        lines.append(f"computed: {checked.computed} — {checked.verdict}")
        lines += [checked.reason] if checked.reason else []
    return "\n".join(lines)


def _label(name: str) -> str:
    if name in _LABELS:
        return _LABELS[name]
    column = DATA_COLUMNS[name]
    return f"{symbol_of(name)} ({column.unit})" if column.unit != "1" else symbol_of(name)


def _line_name(by: str, value: float) -> str:
    if by == SEPARATION:
        return "separation considered" if value else "separation ignored"
    return f"{symbol_of(by)} {value:g}"


def figure_charts(panel: Panel, data: FigureData) -> list[Chart]:
    """One or two charts of a panel, with a trace per line."""
    drawn = _DRAWN.get(panel.kind, ((panel.shown,),))
    charts = []
    for names in drawn:
        traces = tuple(
            _trace(_line_name(data.by, value), line, names) for value, line in data.lines()
        )
        signed = names[0] in ("sigma_1", "y", "x", "P")
        charts.append(
            Chart(
                _label(data.along),
                _label(names[0]),
                traces,
                guides=(Guide(0.0, vertical=False),) if signed else (),
            )
        )
    return charts


def _trace(name: str, line: FigureData, names: Sequence[str]) -> Trace:
    if len(names) == 1:
        return Trace(name, line[line.along], line[names[0]])
    # NaN separates the two modes.
    gap = [np.nan]
    first, second = names
    x = np.concatenate([line[line.along], gap, line[line.along]])
    y = np.concatenate([line[first], gap, line[second]])
    return Trace(name, x, y, ordered=False)


def point_scene(panel: Panel, point: NearestPoint) -> Scene:
    """The scene at a point of a panel's chart."""
    line = panel.lines[point.trace]
    if line.along in PARAMETERS:
        return line.scene.with_values({line.along: point.x})
    return line.scene


def panel_scene(key: str) -> Scene:
    """A panel's scene nearest to the base set, named after the panel."""
    place = list(PANELS).index(key)
    scene, caption = list(paper_scenes())[place]
    return replace(scene, description=f"Fig. {key}: {caption}")
