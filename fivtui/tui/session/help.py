"""Help texts as rows. Imports no Textual."""

from typing import Final

from .equations import EQUATIONS
from .fields import Field
from .report import Row

KEYS: Final = (
    Row("Tab, Shift+Tab", "next and previous field, button, plot"),
    Row("↑ ↓", "in a number: a step more or less; with Shift: a tenth of it"),
    Row("Enter", "in a field: on to the next one"),
    Row("Escape", "stop typing; then j k: choose a field, h l: less, more, Enter: type"),
    Row("F2", "next tab; Shift+F2: the one before; Alt+1, Alt+2, …: a certain one"),
    Row("F3", "the list of runs, and back"),
    Row("F5", "run, or stop what runs"),
    Row("F4, F9", "engine native or FMU; run both and compare them"),
    Row("F6, F7", "write the charts as they are seen; the data of what the tab shows"),
    Row("F8", "reset the field in focus; Shift+F8: all of them"),
    Row("Ctrl+Z, Ctrl+Y", "undo and redo edits"),
    Row("Ctrl+O, Ctrl+S, Alt+S", "open a scene or a result; save the scene, save it as"),
    Row("Alt+O", "read a run, sweep, map or trade-off from a file"),
    Row("F1", "help on the field in focus"),
    Row("Ctrl+P", "palette: everything that can be done now"),
    Row("F10", "begin what the tab computes, or stop it"),
    Row("v", "in a tab: its next view"),
    Row("h j k l, arrows", "in a plot: move; Shift+↑ ↓: zoom y; + −, wheel: zoom"),
    Row("r, e", "in a plot: all of it; over time: the last tenth"),
    Row("c", "in a plot: cursor, moved by the arrows; Enter: open the point"),
    Row("1 … 9", "in a plot: hide or show a trace"),
    Row("g, x, y", "in a plot: type limits, logarithmic x, logarithmic y"),
    Row("mouse", "in a plot: point to read, drag to move, twice: open the point"),
    Row("in the list of runs", "Space: draw it or not, b: baseline, s: show, x: delete"),
    Row("", "Enter: load its scene, c: next colour, m: next marker"),
    Row("Ctrl+Q", "quit; what is edited is there again at the next start"),
)


def general_help() -> list[Row]:
    """Keys and equations."""
    model = [Row(f"Eq. {e.number}", e.text, e.subject) for e in EQUATIONS]
    return [*KEYS, Row("", ""), *model]


def field_help(field: Field) -> list[Row]:
    """Meaning, unit, range, default and details of a field."""
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
