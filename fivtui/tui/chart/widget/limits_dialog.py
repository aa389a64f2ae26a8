"""The dialog for axis limits."""

from collections.abc import Sequence
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, Static

from fivtui.charts import LIMITS_FORMAT, Axis, Chart, View, parse_limits
from fivtui.model import InputError
from fivtui.ranges import with_decimal_points

from .text_input import TextInput


class LimitsDialog(ModalScreen[Sequence[Axis | None] | None]):
    """Dialog for ``LOW:HIGH`` of both axes; an axis without limits fits the data."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss", "Cancel")]

    def __init__(self, chart: Chart, view: View) -> None:
        super().__init__()
        # Label, axis, and the chosen limits or None, by the names of the axes.
        x, y = view.axes(chart)
        self._axes = {"x": (chart.x_label, x, view.x), "y": (chart.y_label, y, view.y)}

    def compose(self) -> ComposeResult:
        """One input per axis."""
        with Vertical(id="dialog"):
            yield Label("Axis limits", id="dialog-title")
            for name, (label, axis, chosen_axis) in self._axes.items():
                yield Label(label, markup=False)
                limits_text = f"{axis.low:.6g}:{axis.high:.6g}"
                yield TextInput(
                    "" if chosen_axis is None else limits_text,
                    replace_commas=with_decimal_points,
                    placeholder=f"now {limits_text}",
                    id=f"limits-{name}",
                    compact=True,
                )
            yield Static(LIMITS_FORMAT, id="dialog-hint", markup=False)
            with Horizontal(id="dialog-buttons"):
                yield Button("OK", id="limits-ok", compact=True, variant="primary")
                yield Button("Cancel", compact=True, action="screen.dismiss")

    @on(Input.Changed)
    def _read_limits(self) -> Sequence[Axis | None] | None:
        # The typed limits of x and y; if they are invalid, None, and the hint is the error.
        # While the dialog opens, an input or the hint may not exist yet.
        axes: list[Axis | None] = []
        errors: list[str] = []
        for field in self.query(Input):
            name = str(field.id).removeprefix("limits-")
            log = self._axes[name][1].log
            try:
                limits = parse_limits(name, field.value, log=log)
            except InputError as error:
                errors.append(str(error))
            else:
                axes.append(limits and Axis(*limits, log=log))
        for hint in self.query("#dialog-hint").results(Static):
            hint.update(errors[0] if errors else LIMITS_FORMAT)
            hint.set_class(bool(errors), "-wrong")
        return None if errors else axes

    @on(Input.Submitted)
    @on(Button.Pressed, "#limits-ok")
    def _accept(self) -> None:
        axes = self._read_limits()
        if axes is not None:
            self.dismiss(axes)
