"""How the parts of a chart look, in the colours of the theme. Imports no Textual."""

from collections.abc import Mapping
from typing import Final

_MUTED: Final = "$foreground-muted"

# By the names in `picture`. Style sheets could say it too, but each of their rules would be looked
# for again for every chart, whenever its style may have changed.
CHART_STYLES: Final[Mapping[str, str]] = {
    "plot": "",
    "tick": _MUTED,
    "label": _MUTED,
    "guide": _MUTED,
    "cursor": "bold $warning",
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

# What differs in a chart that has the focus.
FOCUSED_STYLES: Final[Mapping[str, str]] = {
    "tick": "$foreground",
    "label": "bold underline $foreground",
}
