"""Texts of the trade-off tab: error against CPU time. Imports no Textual.

A setting is a method with its tolerance or step. It is on the Pareto front if no other measured
setting is both faster and more accurate. The floor is the uncertainty of the errors themselves.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from fivtui.scene import Scene
from fivtui.tradeoffs import MeasuredSetting, Setting, cheapest

if TYPE_CHECKING:
    from fivtui.tradeoffs import Tradeoff

# Settings whose values differ by fewer decades than this count as equal.
_EQUAL_DECADES: Final = 0.3

# Titles of the quantities whose error is shown. The half range is ± half the peak-to-peak of y over
# the second half of the run.
TITLES: Final[Mapping[str, str]] = {
    "final": "State",
    "peak": "Peak",
    "half_range": "±2nd ½",
    "events": "Events",
}


def current_setting(result: "Tradeoff", scene: Scene) -> MeasuredSetting | None:
    """The measured setting nearest to that of a scene.

    None if its method was not measured, or if error targets choose the setting.
    """
    if scene.accuracy:
        return None
    # The kernel is empty for a method that cannot be both compiled and interpreted.
    rows = [
        row
        for row in result.rows
        if row.setting.method == scene.method
        and row.error is not None
        and row.setting.kernel in ("", "compiled")
    ]
    if not rows:
        return None
    value = _scene_value(rows[0].setting, scene)
    if value is None:
        return None
    return min(rows, key=lambda row: abs(math.log(row.setting.value / value)))


def _scene_value(setting: Setting, scene: Scene) -> float | None:
    # The scene's tolerance or step, whichever the setting sets.
    return scene.tol if setting.knob == "tol" else scene.step


def setting_text(
    result: "Tradeoff", scene: Scene, quantity: str, current: MeasuredSetting | None
) -> str:
    """Error and time of a scene's setting, and the cheapest setting that is as accurate."""
    if scene.accuracy:
        return "; ".join(
            f"{name} to {error:g}: {_row_text(cheapest(result.rows, name, error), name)}"
            for name, error in scene.accuracy
        )
    if current is None or current.error is None:
        methods = {row.setting.method for row in result.rows}
        if scene.step is None and scene.method in methods:
            # Measured settings have steps, to which no step of the scene could be compared.
            return f"{scene.method} with its default step: enter a step to see its error"
        return f"{scene.method} was not measured"
    error = current.error.of(quantity)
    value = _scene_value(current.setting, scene)
    is_same = value is not None and abs(math.log10(current.setting.value / value)) < _EQUAL_DECADES
    text = f"{'now' if is_same else 'nearest measured:'} {_row_text(current, quantity)}"
    # Errors below the reference's uncertainty count as equal.
    better = cheapest(result.rows, quantity, max(error, result.floor.of(quantity)))
    if better is None or better.setting == current.setting or better.cpu_s >= current.cpu_s:
        return f"{text}; no measured setting is as accurate in less time"
    ratio = current.cpu_s / better.cpu_s
    return f"{text}; as accurate, {ratio:.2g} times faster: {_row_text(better, quantity)}"


def _row_text(row: MeasuredSetting | None, quantity: str) -> str:
    if row is None or row.error is None:
        return "no setting measured"
    setting = row.setting
    measurement = f"error {row.error.of(quantity):.1e}, {1e3 * row.cpu_s:.3g} ms"
    return f"{setting.label} {setting.text}, {measurement}"
