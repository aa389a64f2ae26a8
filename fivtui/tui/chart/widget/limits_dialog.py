"""The dialog for axis limits."""

from dataclasses import replace
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, Static

from fivtui.charts import Axis, Chart, View, parse_limits
from fivtui.model import InputError
from fivtui.ranges import with_decimal_points

from .text_input import TextInput

_LIMITS_FORMAT: Final = "LOW:HIGH, or empty to fit the data"


class LimitsDialog(ModalScreen[View | None]):
    """Dialog for ``LOW:HIGH`` of both axes; an axis without limits fits the data."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "cancel", "Cancel")]

    def __init__(self, chart: Chart, view: View) -> None:
        super().__init__()
        self._chart, self._view = chart, view

    def compose(self) -> ComposeResult:
        """One input per axis."""
        labels = {"x": self._chart.x_label, "y": self._chart.y_label}
        axes = dict(zip("xy", self._view.axes(self._chart), strict=True))
        with Vertical(id="dialog"):
            yield Label("Axis limits", id="dialog-title")
            for name, label in labels.items():
                yield Label(label, markup=False)
                axis = axes[name]
                limits_text = f"{axis.low:.6g}:{axis.high:.6g}"
                is_chosen = getattr(self._view, name) is not None
                yield TextInput(
                    limits_text if is_chosen else "",
                    replace_commas=with_decimal_points,
                    placeholder=f"now {limits_text}",
                    id=f"limits-{name}",
                    compact=True,
                )
            yield Static(_LIMITS_FORMAT, id="dialog-hint", markup=False)
            with Horizontal(id="dialog-buttons"):
                yield Button("OK", id="limits-ok", compact=True, variant="primary")
                yield Button("Cancel", id="limits-cancel", compact=True)

    @on(Input.Changed)
    def _read_limits(self) -> View | None:
        # The view with the typed limits; if they are invalid, None, and the hint is the error.
        # While the dialog opens, an input or the hint may not exist yet.
        texts = {field.id: field.value for field in self.query(Input)}
        # An axis without typed limits fits the data.
        view, error = replace(self._view, x=None, y=None), ""
        for axis_name, log in (("x", view.log_x), ("y", view.log_y)):
            try:
                limits = parse_limits(axis_name, texts.get(f"limits-{axis_name}", ""), log=log)
            except InputError as input_error:
                error = error or str(input_error)
            else:
                if limits is not None:
                    setattr(view, axis_name, Axis(*limits, log=log))
        for hint in self.query("#dialog-hint").results(Static):
            hint.update(error or _LIMITS_FORMAT)
            hint.set_class(bool(error), "-wrong")
        return None if error else view

    @on(Input.Submitted)
    @on(Button.Pressed, "#limits-ok")
    def _accept(self) -> None:
        view = self._read_limits()
        if view is not None:
            self.dismiss(view)

    @on(Button.Pressed, "#limits-cancel")
    def action_cancel(self) -> None:
        """Close without changes."""
        self.dismiss(None)
