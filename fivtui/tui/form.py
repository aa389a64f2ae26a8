"""The form: one row for every field of the session."""

from collections.abc import Callable, Collection, Mapping
from itertools import groupby
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widget import Widget
from textual.widgets import Button, Checkbox, Input, Label, Select, Static

from .alt_digits import ALT_DIGITS
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

    def __init__(self, field: Field, text: str) -> None:
        super().__init__(text, compact=True, placeholder=field.when_empty)
        self._field = field

    def check_consume_key(self, key: str, character: str | None) -> bool:
        """Whether a key is text here; Alt and a digit is not, whatever a terminal makes of it."""
        return character not in ALT_DIGITS and super().check_consume_key(key, character)

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

    @property
    def text(self) -> str:
        """What it shows."""
        return self.value

    def show(self, text: str) -> None:
        """Show a text that the user did not type."""
        if self.value != text:
            with self.prevent(Input.Changed):
                self.value = text


class ChoiceEditor(Select[str]):
    """Edits a field of which the texts are known."""

    def __init__(self, field: Field, text: str) -> None:
        choices = field.choices or {}
        super().__init__(
            [(name, name) for name in choices],
            value=text,
            allow_blank=False,
            compact=True,
        )
        self._field = field

    @on(Select.Changed)
    def _changed(self, event: Select.Changed) -> None:
        event.stop()
        self.post_message(FieldEdited(self._field.name, str(self.value)))

    @property
    def text(self) -> str:
        """What it shows."""
        return str(self.value)

    def show(self, text: str) -> None:
        """Show a text that the user did not choose."""
        if self.value != text:
            with self.prevent(Select.Changed):
                self.value = text


class SeparationEditor(Checkbox):
    """Whether separation is considered or ignored, said in words beside the mark."""

    def __init__(self, field: Field, text: str) -> None:
        super().__init__(text, value=text == CONSIDERED, compact=True)
        self._field = field

    @on(Checkbox.Changed)
    def _changed(self, event: Checkbox.Changed) -> None:
        event.stop()
        self.label = CONSIDERED if self.value else IGNORED
        self.post_message(FieldEdited(self._field.name, str(self.label)))

    @property
    def text(self) -> str:
        """What it shows."""
        return str(self.label)

    def show(self, text: str) -> None:
        """Show a text that the user did not choose."""
        if str(self.label) == text:
            return
        self.label = text
        with self.prevent(Checkbox.Changed):
            self.value = text == CONSIDERED


_CHANGED: Final = "•"

Editor = TextEditor | ChoiceEditor | SeparationEditor

_EDITORS: Final[Mapping[str, Callable[[Field, str], Editor]]] = {"separation": SeparationEditor}


def _editor(field: Field, text: str) -> Editor:
    usual = TextEditor if field.choices is None else ChoiceEditor
    return _EDITORS.get(field.name, usual)(field, text)


class FieldRow(Vertical):
    """Symbol, editor and unit of a field, and below them what is wrong with it.

    Parameters
    ----------
    field : Field
        The field.
    text : str
        Its text.
    """

    def __init__(self, field: Field, text: str) -> None:
        super().__init__(id=f"row-{field.name}")
        self.field = field
        self._editor = _editor(field, text)
        self._error = ""
        self._changed = False

    def compose(self) -> ComposeResult:
        """The parts of the row."""
        field = self.field
        with Horizontal(classes="line"):
            yield Static(" ", classes="mark", markup=False)
            yield Label(field.symbol or field.name, classes="symbol", markup=False)
            yield self._editor
            if field.nudge is not None:
                for sign, direction in (("−", -1), ("+", 1)):
                    yield NudgeButton(sign, field.name, direction)
                yield Label(field.unit, classes="unit", markup=False)
            yield Label(field.meaning, classes="meaning", markup=False)
        yield Static("", classes="error", markup=False)

    @property
    def text(self) -> str:
        """The text that the editor shows."""
        return self._editor.text

    def show(self, text: str, error: str, *, changed: bool) -> None:
        """Show the text of the field, and what is wrong with it.

        Parameters
        ----------
        text : str
            Its text.
        error : str
            One line; empty if nothing is wrong.
        changed : bool
            Whether it differs from that of the scene loaded.
        """
        self._editor.show(text)
        if changed is not self._changed:
            self._changed = changed
            mark = _CHANGED if changed else " "
            self.query_one(".mark", Static).update(mark, layout=False)
        if error == self._error:
            return
        self._error = error
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


class FieldList(VerticalScroll):
    """The rows, with a cursor for the keys of those who do not type; Escape leads here."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j,down", "move(1)", "Down", show=False),
        Binding("k,up", "move(-1)", "Up", show=False),
        Binding("h,left,minus", "nudge(-1)", "Less", show=False),
        Binding("l,right,plus", "nudge(1)", "More", show=False),
        Binding("H,shift+left", "nudge(-1, True)", "Slightly less", show=False),
        Binding("L,shift+right", "nudge(1, True)", "Slightly more", show=False),
        Binding("g,home", "move(-999)", "First", show=False),
        Binding("G,end", "move(999)", "Last", show=False),
        Binding("enter,i", "edit", "Edit", show=False),
        Binding("escape", "leave_editor", "Stop typing", show=False),
    ]

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id, can_focus=True)
        self._cursor = 0

    @property
    def row(self) -> FieldRow:
        """The row at the cursor."""
        return list(self.query(FieldRow))[self._cursor]

    def on_focus(self) -> None:
        """Show the cursor."""
        self._mark()

    def on_blur(self) -> None:
        """Hide the cursor."""
        self.row.remove_class("-cursor")

    def _mark(self) -> None:
        self.row.add_class("-cursor")
        self.scroll_to_widget(self.row, animate=False)
        self.post_message(FieldFocused(self.row.field.name))

    def action_move(self, by: int) -> None:
        """Move the cursor by some rows."""
        self.row.remove_class("-cursor")
        self._cursor = min(max(self._cursor + by, 0), len(self.query(FieldRow)) - 1)
        self._mark()

    def action_nudge(self, direction: int, fine: bool = False) -> None:
        """Ask for a little more or less at the cursor."""
        self.post_message(FieldNudged(self.row.field.name, direction, fine))

    def action_edit(self) -> None:
        """Type at the cursor."""
        self.row.take_focus()

    @on(FieldFocused)
    def _follow(self, event: FieldFocused) -> None:
        names = [row.field.name for row in self.query(FieldRow)]
        self._cursor = names.index(event.name)

    def action_leave_editor(self) -> None:
        """From the editor of a field to the list, at that field."""
        self.focus()


class Form(Vertical):
    """All fields under their headings, and a hint about the one in focus.

    Parameters
    ----------
    texts : mapping of str to str
        Texts of the fields to begin with, by name.
    """

    def __init__(self, texts: Mapping[str, str]) -> None:
        super().__init__(id="form")
        self._texts = texts

    def compose(self) -> ComposeResult:
        """The rows by groups, and the hint."""
        yield Static("", id="scene-name", markup=False)
        with FieldList(id="fields"):
            for group, fields in groupby(FIELDS.values(), key=lambda field: field.group):
                yield Label(group, classes="heading")
                yield from (FieldRow(field, self._texts[field.name]) for field in fields)
        yield Static("", id="hint", markup=False)

    def text_of(self, name: str) -> str:
        """The text that the editor of a field shows."""
        return self._row(name).text

    def _row(self, name: str) -> FieldRow:
        return self.query_one(f"#row-{name}", FieldRow)

    def show(
        self,
        title: str,
        texts: Mapping[str, str],
        errors: Mapping[str, str],
        changed: Collection[str],
    ) -> None:
        """Show the texts and what is wrong with them.

        Parameters
        ----------
        title : str
            Name of the scene, marked if changed.
        texts, errors : mapping of str to str
            By name of field.
        changed : collection of str
            Names of the fields that differ from the scene loaded.
        """
        self.query_one("#scene-name", Static).update(title, layout=False)
        for row in self.query(FieldRow):
            name = row.field.name
            row.show(texts[name], errors.get(name, ""), changed=name in changed)

    @on(FieldFocused)
    def _hint(self, event: FieldFocused) -> None:
        field = FIELDS[event.name]
        hint = f"{field.meaning}\n{field.allowed}"
        self.query_one("#hint", Static).update(hint, layout=False)

    def focus_field(self, name: str) -> None:
        """Give a field the focus."""
        self._row(name).take_focus()


def field_of(widget: Widget | None) -> Field | None:
    """The field that a widget belongs to or, of the list of fields, that at its cursor."""
    if widget is None:
        return None
    if isinstance(widget, FieldList):
        return widget.row.field
    rows = (node.field for node in widget.ancestors_with_self if isinstance(node, FieldRow))
    return next(rows, None)
