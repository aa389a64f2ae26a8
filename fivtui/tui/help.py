"""Help as rows. Imports no Textual."""

from typing import Final

from .equations import EQUATIONS
from .fields import Field
from .report import Row

KEYS: Final = (
    Row("Tab, Shift+Tab", "next and previous field, button, plot"),
    Row("↑ ↓", "in a number: a step more or less; with Shift: a tenth of it"),
    Row("Enter", "in a field: on to the next one"),
    Row("F2", "next tab; Shift+F2: the one before"),
    Row("F5", "run, or stop what runs"),
    Row("F6, F7", "write the figure, the data of the run shown"),
    Row("F8", "reset the field in focus; Shift+F8: all of them"),
    Row("Ctrl+O, Ctrl+S", "open a scene, save it as"),
    Row("F1", "help on the field in focus"),
    Row("Ctrl+P", "palette: everything that can be done now"),
    Row("h j k l, arrows", "in a plot: earlier, zoom out, zoom in, later"),
    Row("r, e", "in a plot: the whole horizon, its last tenth"),
    Row("Ctrl+Q", "quit"),
)


def general_help() -> list[Row]:
    """The keys and the model.

    Returns
    -------
    list of Row
        In reading order.
    """
    model = [Row(f"Eq. {e.number}", e.text, e.subject) for e in EQUATIONS]
    return [*KEYS, Row("", ""), *model]


def field_help(field: Field) -> list[Row]:
    """All about a field.

    Parameters
    ----------
    field : Field
        The field.

    Returns
    -------
    list of Row
        In reading order.
    """
    rows = [
        Row("meaning", field.meaning),
        Row("symbol", field.symbol or field.name),
        Row("unit", field.unit or "none"),
        Row("allowed", field.allowed),
        Row("default", field.default or "none"),
        *(Row(label, text) for label, text in field.details),
    ]
    if field.nudge is not None:
        rows.append(Row("keys", "↑ ↓ a step more or less, with Shift a tenth of it"))
    return rows
