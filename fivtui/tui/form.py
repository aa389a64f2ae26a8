"""The form: one row for every field of the session."""

from collections.abc import Callable, Mapping
from itertools import groupby
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widget import Widget
from textual.widgets import Button, Checkbox, Input, Label, Select, Static

from .fields import CONSIDERED, FIELDS, IGNORED, Field
from .messages import FieldEdited, FieldFocused, FieldNudged


class TextEditor(Input):
    """Edits a field as text; the arrows up and down change a number by a step."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "nudge(1)", "More", show=False),
        Binding("down", "nudge(-1)", "Less", show=False),
        Binding("shift+up,ctrl+up", "nudge(1, True)", "Slightly more", show=False),
        Binding("shift+down,ctrl+down", "nudge(-1, True)", "Slightly less", show=False),
    ]

    def __init__(self, field: Field) -> None:
        super().__init__(field.default, compact=True, placeholder=field.when_empty)
        self._field = field

    def action_nudge(self, direction: int, fine: bool = False) -> None:
        """Ask for a little more or less."""
        self.post_message(FieldNudged(self._field.name, direction, fine))

    @on(Input.Submitted)
    def _go_on(self, event: Input.Submitted) -> None:
        event.stop()
        self.screen.focus_next(TextEditor)

    @on(Input.Changed)
    def _changed(self, event: Input.Changed) -> None:
        event.stop()
        # The value now, not that of the message: an older message must not undo a newer edit.
        self.post_message(FieldEdited(self._field.name, self.value))

    def show(self, text: str) -> None:
        """Show a text that the user did not type."""
        if self.value != text:
            with self.prevent(Input.Changed):
                self.value = text


class ChoiceEditor(Select[str]):
    """Edits a field of which the texts are known."""

    def __init__(self, field: Field) -> None:
        choices = field.choices or {}
        super().__init__(
            [(name, name) for name in choices],
            value=field.default,
            allow_blank=False,
            compact=True,
        )
        self._field = field

    @on(Select.Changed)
    def _changed(self, event: Select.Changed) -> None:
        event.stop()
        self.post_message(FieldEdited(self._field.name, str(self.value)))

    def show(self, text: str) -> None:
        """Show a text that the user did not choose."""
        if self.value != text:
            with self.prevent(Select.Changed):
                self.value = text


class SeparationEditor(Checkbox):
    """Whether separation is considered or ignored, said in words beside the mark."""

    def __init__(self, field: Field) -> None:
        super().__init__(CONSIDERED, value=True, compact=True)
        self._field = field

    @on(Checkbox.Changed)
    def _changed(self, event: Checkbox.Changed) -> None:
        event.stop()
        self.label = CONSIDERED if self.value else IGNORED
        self.post_message(FieldEdited(self._field.name, str(self.label)))

    def show(self, text: str) -> None:
        """Show a text that the user did not choose."""
        self.label = text
        with self.prevent(Checkbox.Changed):
            self.value = text == CONSIDERED


Editor = TextEditor | ChoiceEditor | SeparationEditor

_EDITORS: Final[Mapping[str, Callable[[Field], Editor]]] = {"separation": SeparationEditor}


def _editor(field: Field) -> Editor:
    usual = TextEditor if field.choices is None else ChoiceEditor
    return _EDITORS.get(field.name, usual)(field)


class FieldRow(Vertical):
    """Symbol, editor and unit of a field, and below them what is wrong with it.

    Parameters
    ----------
    field : Field
        The field.
    """

    def __init__(self, field: Field) -> None:
        super().__init__(id=f"row-{field.name}")
        self.field = field
        self._editor = _editor(field)

    def compose(self) -> ComposeResult:
        """The parts of the row."""
        field = self.field
        with Horizontal(classes="line"):
            yield Label(field.symbol or field.name, classes="symbol", markup=False)
            yield self._editor
            if field.nudge is not None:
                for sign, direction in (("−", -1), ("+", 1)):
                    yield NudgeButton(sign, field.name, direction)
                yield Label(field.unit, classes="unit", markup=False)
            yield Label(field.meaning, classes="meaning", markup=False)
        yield Static("", classes="error", markup=False)

    def show(self, text: str, error: str) -> None:
        """Show the text of the field, and what is wrong with it.

        Parameters
        ----------
        text : str
            Its text.
        error : str
            One line; empty if nothing is wrong.
        """
        self._editor.show(text)
        self._editor.set_class(bool(error), "-invalid")
        self.set_class(bool(error), "-wrong")
        self.query_one(".error", Static).update(error)

    def on_descendant_focus(self) -> None:
        """Say which field has the focus."""
        self.post_message(FieldFocused(self.field.name))

    def take_focus(self) -> None:
        """Give the editor the focus."""
        self._editor.focus()


class NudgeButton(Button):
    """A step more or less, by mouse."""

    def __init__(self, sign: str, name: str, direction: int) -> None:
        super().__init__(sign, compact=True)
        self.can_focus = False
        self._nudged = (name, direction)

    @on(Button.Pressed)
    def _press(self, event: Button.Pressed) -> None:
        event.stop()
        self.post_message(FieldNudged(*self._nudged, fine=False))


class Form(Vertical):
    """All fields under their headings, and a hint about the one in focus."""

    def compose(self) -> ComposeResult:
        """The rows by groups, and the hint."""
        yield Label("", id="scene-name", markup=False)
        with VerticalScroll(id="fields", can_focus=False):
            for group, fields in groupby(FIELDS.values(), key=lambda field: field.group):
                yield Label(group, classes="heading")
                yield from map(FieldRow, fields)
        yield Static("", id="hint", markup=False)

    def show(self, title: str, texts: Mapping[str, str], errors: Mapping[str, str]) -> None:
        """Show the texts and what is wrong with them.

        Parameters
        ----------
        title : str
            Name of the scene, marked if changed.
        texts, errors : mapping of str to str
            By name of field.
        """
        self.query_one("#scene-name", Label).update(title)
        for row in self.query(FieldRow):
            row.show(texts[row.field.name], errors.get(row.field.name, ""))

    @on(FieldFocused)
    def _hint(self, event: FieldFocused) -> None:
        field = FIELDS[event.name]
        self.query_one("#hint", Static).update(f"{field.meaning}\n{field.allowed}")

    def focus_field(self, name: str) -> None:
        """Give a field the focus."""
        self.query_one(f"#row-{name}", FieldRow).take_focus()


def field_of(widget: Widget | None) -> Field | None:
    """The field that a widget belongs to, if it belongs to one."""
    if widget is None:
        return None
    rows = (node.field for node in widget.ancestors_with_self if isinstance(node, FieldRow))
    return next(rows, None)
