"""Table rows and scenes of the paper tab. Imports no Textual.

A panel is one plot of a figure of the paper "Nonlinear friction-induced vibration of a slider-belt
system". Its lines differ in one parameter, or in separation: whether the slider may leave the belt.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from fivtui.charts import NearestPoint
from fivtui.model import PARAMETERS
from fivtui.paper import PANELS, SEPARATION, CheckedClaim, Claim, Panel
from fivtui.scene import Scene
from fivtui.tui.session import symbol_of

FIGURE_COLUMNS: Final = ("figure", "lines", "what it shows")
CLAIM_COLUMNS: Final = ("verdict", "section", "statement", "stated")
# Appended to the key of a computed figure; a separate column would be too wide.
COMPUTED_MARK: Final = " ✓"
_NOT_CHECKED: Final = "?"


def figure_rows(computed: Sequence[str]) -> list[tuple[str, ...]]:
    """The paper's figures as rows of `FIGURE_COLUMNS`; `computed` ones are marked."""
    return [
        (f"{key}{COMPUTED_MARK if key in computed else ''}", _lines_text(panel), panel.caption)
        for key, panel in PANELS.items()
    ]


def _lines_text(panel: Panel) -> str:
    if panel.by == SEPARATION:
        # Separation considered, and ignored.
        return "both cases"
    values = ", ".join(f"{getattr(line.scene.parameters, panel.by):g}" for line in panel.lines)
    return f"{symbol_of(panel.by)} {values}"


def claim_rows(
    claims: Sequence[Claim], checked: Mapping[str, CheckedClaim]
) -> list[tuple[str, ...]]:
    """The paper's claims as rows of `CLAIM_COLUMNS`, with "?" if not checked yet."""
    return [
        (
            str(checked[claim.id].verdict) if claim.id in checked else _NOT_CHECKED,
            claim.section,
            claim.statement,
            claim.stated,
        )
        for claim in claims
    ]


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


def paper_scenes() -> Iterator[tuple[Scene, str]]:
    """Each figure's scene nearest to the default parameters, and the figure's caption."""
    for key, panel in PANELS.items():
        distances = [_distance(panel.by, line.scene) for line in panel.lines]
        scene = panel.lines[distances.index(min(distances))].scene
        yield replace(scene, name=f"fig-{key}", description=""), panel.caption


def _distance(parameter: str, scene: Scene) -> float:
    # Distance of a parameter from its default; separation is considered by default.
    if parameter == SEPARATION:
        return float(not scene.separation)
    return abs(scene.parameters.as_dict()[parameter] - PARAMETERS[parameter].default)


def panel_scene(key: str) -> Scene:
    """A panel's scene nearest to the default parameters, named after the panel."""
    index = list(PANELS).index(key)
    scene, caption = list(paper_scenes())[index]
    return replace(scene, description=f"Fig. {key}: {caption}")
