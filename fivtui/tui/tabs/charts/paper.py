"""The figures of the paper as charts, its claims as rows. Imports no Textual."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.model.parameters import PARAMETERS
from fivtui.paper.claims.claim import CheckedClaim, Claim
from fivtui.paper.data import DATA_COLUMNS, FigureData
from fivtui.paper.families import PANELS, SEPARATION, Panel
from fivtui.scene.scene import Scene
from fivtui.tui.chart.chart import Chart, Found, Guide, Trace
from fivtui.tui.session.paper_scenes import paper_scenes

FIGURE_COLUMNS: Final = ("figure", "lines", "what it shows")
CLAIM_COLUMNS: Final = ("verdict", "section", "statement", "stated")
# Behind the key of a figure that is computed: a column of its own would push the others away.
COMPUTED: Final = " ✓"
_UNKNOWN: Final = "?"

# The columns drawn of every kind, a chart each; two columns of a chart are the two modes.
_DRAWN: Final[Mapping[str, Sequence[tuple[str, ...]]]] = {
    "equilibrium": (("y_e",),),
    "eigenvalues": (("omega_1", "omega_2"), ("sigma_1", "sigma_2")),
    "critical mu": (("mu_c",),),
    "amplitude": (("y_peak",), ("y_half_range",)),
}
_LABELS: Final = {
    "omega_1": "Im λ / rad/s",
    "sigma_1": "Re λ / 1/s",
    "mu_c": "μ_c",
    "y_peak": "peak |y| / m",
    "y_half_range": "half peak-to-peak, 2nd half / m",
}


def figure_rows(computed: Sequence[str]) -> list[tuple[str, ...]]:
    """The figures of the paper, a row a panel that has scenes of its own.

    Parameters
    ----------
    computed : sequence of str
        Keys of the panels that are computed.

    Returns
    -------
    list of tuple of str
        In the columns `FIGURE_COLUMNS`.
    """
    return [
        (f"{key}{COMPUTED if key in computed else ''}", _by(panel), panel.caption)
        for key, panel in PANELS.items()
    ]


def _by(panel: Panel) -> str:
    if panel.by == SEPARATION:
        return "both cases"
    values = ", ".join(f"{getattr(line.scene.parameters, panel.by):g}" for line in panel.lines)
    return f"{panel.by} {values}"


def claim_rows(
    claims: Sequence[Claim], checked: Mapping[str, CheckedClaim]
) -> list[tuple[str, ...]]:
    """The statements of the paper with their verdicts.

    Parameters
    ----------
    claims : sequence of Claim
        The statements.
    checked : mapping of str to CheckedClaim
        Those that are held against the model, by id.

    Returns
    -------
    list of tuple of str
        In the columns `CLAIM_COLUMNS`; a question mark where there is no verdict yet.
    """
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
    """A statement, what the paper gives, what was computed, and why.

    Parameters
    ----------
    claim : Claim
        The statement.
    checked : CheckedClaim or None
        What came of it, if it is known.

    Returns
    -------
    str
        A few lines.
    """
    lines = [claim.statement, f"stated: {claim.stated}"]
    if checked is not None:
        lines.append(f"computed: {checked.computed} — {checked.verdict}")
        lines += [checked.reason] if checked.reason else []
    return "\n".join(lines)


def _label(name: str) -> str:
    if name in _LABELS:
        return _LABELS[name]
    column = DATA_COLUMNS[name]
    return f"{name} / {column.unit}" if column.unit != "1" else name


def _line_name(by: str, value: float) -> str:
    if by == SEPARATION:
        return "considered" if value else "ignored"
    return f"{by} {value:g}"


def figure_charts(panel: Panel, data: FigureData) -> list[Chart]:
    """The charts of a panel.

    Parameters
    ----------
    panel : Panel
        The panel.
    data : FigureData
        Its numbers.

    Returns
    -------
    list of Chart
        One or two, a trace a line.
    """
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
    # A gap between the two modes.
    gap = [np.nan]
    first, second = names
    x = np.concatenate([line[line.along], gap, line[line.along]])
    y = np.concatenate([line[first], gap, line[second]])
    return Trace(name, x, y, ordered=False)


def point_scene(panel: Panel, point: Found) -> Scene:
    """The scene behind a point of a panel.

    Parameters
    ----------
    panel : Panel
        The panel.
    point : Found
        A point of one of its charts.

    Returns
    -------
    Scene
        That of the line, with the value at the point.
    """
    line = panel.lines[point.trace]
    if line.along in PARAMETERS:
        return line.scene.with_values({line.along: point.x})
    return line.scene


def panel_scene(key: str) -> Scene:
    """The scene with which to begin from a panel.

    Parameters
    ----------
    key : str
        Key of the panel.

    Returns
    -------
    Scene
        Named after the panel, with its caption.
    """
    place = list(PANELS).index(key)
    scene, caption = list(paper_scenes())[place]
    return replace(scene, description=f"Fig. {key}: {caption}")
