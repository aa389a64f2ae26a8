"""Rows of the help dialog, and the text of the first start. Imports no Textual."""

from collections.abc import Mapping
from typing import Final

from fivtui.results import Row

from .fields import FormField

# Keys and what they do, beside those that the list of keys has.
HINTS: Final = (
    Row("↑ ↓", "in a number: increase or decrease by a step; with Shift: by a tenth of it"),
    Row(
        "Escape",
        "stop typing, in a tab to go to its plot; in a field, j k or / then select a field, "
        "h l decrease or increase it, Enter types",
    ),
    Row(
        "mouse",
        "on the gauge: drag the dot, or click where it is to go; a click on a bound or its number "
        "goes to the bound, rounded to the safer side",
    ),
    Row(
        "mouse",
        "in a plot: hover to read, drag to pan, wheel to zoom, double-click to run a point's "
        "parameters",
    ),
    Row(
        "c, C",
        "in a plot: set the first or second cursor in all plots of the tab (mouse: left or right "
        "button); ← → move the cursor of the key pressed last, which removes it if pressed again",
    ),
    # Not keys: a text in the titles of plots.
    Row(
        "zoom t, y", "in a title: axes t and y keep their limits for new runs; r fits them to data"
    ),
)


def welcome_text(key_names: Mapping[str, str]) -> str:
    """The lines of the first start; `key_names` has the displayed keys by identifier."""
    return (
        "Brake squeal: a slider on a moving belt.\n"
        f"↑ ↓ change a value · {key_names['run']} keep a run · {key_names['help']} keys"
    )


def field_help(field: FormField) -> list[Row]:
    """Meaning, unit, range, default and details of a field."""
    return [
        Row("meaning", field.meaning),
        Row("symbol", field.symbol or field.name),
        Row("unit", field.unit or "none"),
        Row("allowed", field.allowed),
        Row("default", field.default or "none"),
        *field.details,
    ]
