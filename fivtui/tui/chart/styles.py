"""Styles of the parts of a chart, in theme colours. Imports no Textual."""

from collections.abc import Mapping
from typing import Final

_MUTED: Final = "$foreground-muted"

# Styles by the names of spans. Rules of a style sheet would be slow: Textual evaluates them for
# every chart at every change.
CHART_STYLES: Final[Mapping[str, str]] = {
    "plot": "",
    "tick": _MUTED,
    "label": _MUTED,
    "guide": _MUTED,
    "cursor": "bold $warning",
    "cursor-2": "bold $foreground",
    "zoomed": "bold $accent",
    "outside": "bold $warning",
    "readout": "bold $warning",
    "hidden": f"strike {_MUTED}",
    "strip": "$warning",
    "control": _MUTED,
    "control-on": "reverse",
    "stable": "$success",
    "unstable": "$error",
    "trace-1": "$primary",
    "trace-2": "$warning",
    "trace-3": "$success",
    "trace-4": "$error",
    "trace-5": "$accent",
    "trace-6": "$secondary",
    "trace-7": "$foreground",
    "trace-8": _MUTED,
}

# Styles that differ in a focused chart.
FOCUSED_STYLES: Final[Mapping[str, str]] = {
    "tick": "$foreground",
    "label": "bold underline $foreground",
}
