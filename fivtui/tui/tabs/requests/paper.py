"""Table rows and scenes of the paper tab. Imports no Textual.

A panel is one plot of a figure of the paper "Nonlinear friction-induced vibration of a slider-belt
system". Its lines differ in one parameter, or in separation: whether the slider may leave the belt.
"""

from dataclasses import replace
from typing import Final

from fivtui.charts import NearestPoint
from fivtui.model import PARAMETERS
from fivtui.paper import SEPARATION, CheckedClaim, Claim, Panel
from fivtui.scene import Scene
from fivtui.tui.session import symbol_of

FIGURE_COLUMNS: Final = ("figure", "lines", "what it shows")
CLAIM_COLUMNS: Final = ("verdict", "section", "statement", "stated")
# Appended to the key of a computed figure; a separate column would be too wide.
_COMPUTED_MARK: Final = " ✓"
_NOT_CHECKED: Final = "?"


def figure_row(panel: Panel, *, is_computed: bool) -> tuple[str, ...]:
    """A panel as row of `FIGURE_COLUMNS`."""
    if panel.by == SEPARATION:
        # Separation considered, and ignored.
        lines = "both cases"
    else:
        values = [f"{getattr(line.scene.parameters, panel.by):g}" for line in panel.lines]
        lines = f"{symbol_of(panel.by)} {', '.join(values)}"
    return f"{panel.key}{_COMPUTED_MARK if is_computed else ''}", lines, panel.caption


def claim_row(claim: Claim, checked: CheckedClaim | None) -> tuple[str, ...]:
    """A claim as row of `CLAIM_COLUMNS`."""
    verdict = _NOT_CHECKED if checked is None else checked.verdict.value
    return verdict, claim.section, claim.statement, claim.stated


def claim_text(claim: Claim, checked: CheckedClaim | None) -> str:
    """A claim in a few lines: stated value, computed value, verdict, reason."""
    lines = [claim.statement, f"stated: {claim.stated}"]
    if checked is not None:
        lines.append(f"computed: {checked.computed} — {checked.verdict}")
        lines += [checked.reason] if checked.reason else []
    return "\n".join(lines)


def point_scene(panel: Panel, point: NearestPoint) -> Scene:
    """The scene at a point of a panel's chart."""
    line = panel.lines[point.trace]
    if line.along in PARAMETERS:
        return line.scene.with_values({line.along: point.x})
    return line.scene


def panel_scene(panel: Panel) -> Scene:
    """A panel's scene nearest to the default parameters, named after the panel."""

    def distance(scene: Scene) -> float:
        if panel.by == SEPARATION:
            return float(not scene.separation)
        return abs(scene.parameters.as_dict()[panel.by] - PARAMETERS[panel.by].default)

    scene = min((line.scene for line in panel.lines), key=distance)
    description = f"Fig. {panel.key}: {panel.caption}"
    return replace(scene, name=f"fig-{panel.key}", description=description)
