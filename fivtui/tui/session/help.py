"""Help texts as rows. Imports no Textual."""

from typing import Final

from fivtui.results import Row

from .equations import EQUATIONS
from .fields import FormField

KEYS: Final = (
    Row("Tab, Shift+Tab", "next and previous field, button, plot"),
    Row("↑ ↓", "in a number: increase or decrease by a step; with Shift: by a tenth of it"),
    Row("Enter", "in a field: go to the next one"),
    Row("Escape", "stop typing; then j k: select a field, h l: decrease, increase, Enter: type"),
    Row("F2", "next tab; Shift+F2: previous tab; Alt+1, Alt+2, …: tab by number"),
    Row("F3", "go to the run list, and back"),
    Row("F5", "start a run, or stop it"),
    Row("F4, F9", "native solver, Python FMU or native FMU; run solver and FMU and compare"),
    Row("F6, F7", "export the displayed charts as a figure; the data of the current tab"),
    Row("F8", "reset the focused field; Shift+F8: reset all"),
    Row("Ctrl+Z, Ctrl+Y", "undo and redo edits"),
    Row("Ctrl+O, Ctrl+S, Alt+S", "open a scene or result; save the scene; save it as"),
    Row("Alt+O", "read a run, sweep, map or trade-off from a file"),
    Row("F1", "help on the focused field"),
    Row("Ctrl+P", "palette: all commands that apply now"),
    Row("F10", "start or stop the computation of the current tab"),
    Row("v, n", "in a tab: next view; over time, the next quantity where not all have room"),
    Row("h j k l, arrows", "in a plot: pan; Shift+↑ ↓: zoom y; + −, wheel: zoom"),
    Row("r, e", "in a plot: r fits the data; e, over time: the last tenth of the run"),
    Row("c", "in a plot: cursor on or off, moved by the arrows; Enter: run the point"),
    Row("1 … 9", "in a plot: hide or show a trace"),
    Row("g, x, y", "in a plot: axis limits, logarithmic x, logarithmic y"),
    Row("mouse", "in a plot: hover to read, drag to pan, double-click: run the point"),
    Row("in the run list", "Space: overlay on/off, b: baseline, s: show, x: delete"),
    Row("", "Enter: load the scene, c: next colour, m: next marker"),
    Row("Ctrl+Q", "quit; the next start restores the session"),
)


def general_help() -> list[Row]:
    """Keys and equations."""
    model = [Row(f"Eq. {e.number}", e.text, e.subject) for e in EQUATIONS]
    return [*KEYS, Row("", ""), *model]


def field_help(field: FormField) -> list[Row]:
    """Meaning, unit, range, default and details of a field."""
    rows = [
        Row("meaning", field.meaning),
        Row("symbol", field.symbol or field.name),
        Row("unit", field.unit or "none"),
        Row("allowed", field.allowed),
        Row("default", field.default or "none"),
        *(Row(label, text) for label, text in field.details),
    ]
    if field.step_by is not None:
        rows.append(Row("keys", "↑ ↓ increase or decrease by a step, with Shift by a tenth of it"))
    return rows
