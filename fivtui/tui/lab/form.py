"""The input form: one row per field."""

import re
from collections.abc import Callable, Collection, Mapping
from itertools import groupby
from textwrap import wrap
from typing import ClassVar, Final, Self, cast

from rich.cells import cell_len
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.events import Click
from textual.geometry import Offset, Region, Size, Spacing
from textual.layout import ArrangeResult, Layout, WidgetPlacement
from textual.widget import Widget
from textual.widgets import Checkbox, Input, Label, Select, Static

from fivtui.model import BELT_PARAMETERS
from fivtui.tui.session import CONSIDERED, FIELDS, IGNORED, FormField
from fivtui.tui.tabs import FieldEdited, FieldFocused, FieldStepped


class TextEditor(Input):
    """Edits a field as text; up and down change a number by a step."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "step(1)", "Increase", show=False),
        Binding("down", "step(-1)", "Decrease", show=False),
        Binding("shift+up,ctrl+up", "step(1, True)", "Increase slightly", show=False),
        Binding("shift+down,ctrl+down", "step(-1, True)", "Decrease slightly", show=False),
    ]

    def __init__(self, field: FormField, text: str) -> None:
        super().__init__(text, compact=True, placeholder=field.when_empty, validate_on=())
        self._field = field

    def refresh(
        self,
        *regions: Region,
        repaint: bool = True,
        layout: bool = False,  # noqa: ARG002
        recompose: bool = False,
    ) -> Self:
        """Redraw without a new layout: the editor never changes its size."""
        return super().refresh(*regions, repaint=repaint, recompose=recompose)

    def replace(self, text: str, start: int, end: int) -> None:
        """Insert text unless it turns a valid beginning into an invalid one."""
        # Pasted text may have surrounding blanks, and be of any length.
        new = text.strip() or text
        room = self._field.longest - len(self.value) + abs(end - start)
        if len(new) > room:
            self.restricted()
            new = new[: max(room, 0)]
        begin, finish = sorted((start, end))
        whole = f"{self.value[:begin]}{new}{self.value[finish:]}"
        good, right = (
            re.fullmatch(self._field.typed, text) is not None for text in (self.value, whole)
        )
        # After a deletion an invalid text may be mended by typing.
        if new and good and not right:
            self.restricted()
        else:
            super().replace(new, start, end)

    def check_consume_key(self, key: str, character: str | None) -> bool:
        """Whether a key types: no field takes a question mark, which asks for help."""
        return character != "?" and super().check_consume_key(key, character)

    def action_step(self, direction: int, fine: bool = False) -> None:
        """Increase or decrease by a step."""
        self.post_message(FieldStepped(self._field.name, direction, fine))

    @on(Input.Submitted)
    def _go_on(self, event: Input.Submitted) -> None:
        event.stop()
        self.screen.focus_next(TextEditor)

    @on(Input.Changed)
    def _changed(self, event: Input.Changed) -> None:
        event.stop()
        # The current value: an older message must not undo a newer edit.
        self.post_message(FieldEdited(self._field.name, self.value))

    @property
    def text(self) -> str:
        """The displayed text."""
        return self.value

    def show(self, text: str) -> None:
        """Display a text without reporting an edit."""
        if self.value != text:
            with self.prevent(Input.Changed):
                self.value = text


class ChoiceEditor(Select[str]):
    """Edits a field that has a fixed set of choices."""

    def __init__(self, field: FormField, text: str) -> None:
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
        """The displayed text."""
        return str(self.value)

    def show(self, text: str) -> None:
        """Display a text without reporting an edit."""
        if self.value != text:
            with self.prevent(Select.Changed):
                self.value = text


class SeparationEditor(Checkbox):
    """A check box for separation, labelled "considered" or "ignored"."""

    def __init__(self, field: FormField, text: str) -> None:
        super().__init__(text, value=text == CONSIDERED, compact=True)
        self._field = field

    @on(Checkbox.Changed)
    def _changed(self, event: Checkbox.Changed) -> None:
        event.stop()
        self.label = CONSIDERED if self.value else IGNORED
        self.post_message(FieldEdited(self._field.name, str(self.label)))

    @property
    def text(self) -> str:
        """The displayed text."""
        return str(self.label)

    def show(self, text: str) -> None:
        """Display a text without reporting an edit."""
        if str(self.label) == text:
            return
        self.label = text
        with self.prevent(Checkbox.Changed):
            self.value = text == CONSIDERED


_CHANGED: Final = "•"
_SIGNS: Final = ("−", "+")
_INDENT: Final = "   "
_SYMBOL_WIDTH: Final = 6
_STEP_WIDTH: Final = 3
_STEPS_WIDTH: Final = _STEP_WIDTH * len(_SIGNS)
_UNIT_WIDTH: Final = 6

Editor = TextEditor | ChoiceEditor | SeparationEditor

_EDITORS: Final[Mapping[str, Callable[[FormField, str], Editor]]] = {"separation": SeparationEditor}


def _editor(field: FormField, text: str) -> Editor:
    usual = TextEditor if field.choices is None else ChoiceEditor
    return _EDITORS.get(field.name, usual)(field, text)


class _RowLayout(Layout):
    # Places the editor between the parts that its row draws.

    name = "row"

    def arrange(
        self,
        parent: Widget,
        children: list[Widget],
        size: Size,
        greedy: bool = True,  # noqa: ARG002
    ) -> ArrangeResult:
        first, width = cast("FieldRow", parent).span(size.width)
        region = Region(first, 0, width, 1)
        return [WidgetPlacement(region, Offset(), Spacing(), child) for child in children]


_ROW_LAYOUT: Final = _RowLayout()


class FieldRow(Widget):
    """Symbol, editor and unit of a field, and its error message below.

    One widget draws all but the editor: a widget for each part would delay the start and every key.
    """

    def __init__(self, field: FormField, text: str) -> None:
        self.field = field
        self._editor = _editor(field, text)
        super().__init__(self._editor, id=f"row-{field.name}")
        self._symbol = field.symbol or field.name
        self._error = ""
        self._note = ""
        self._changed = False

    @property
    def layout(self) -> Layout:
        """Places the editor between the symbol and the unit."""
        return _ROW_LAYOUT

    def span(self, width: int) -> tuple[int, int]:
        """First column and width of the editor in a row of some width."""
        first = max(_SYMBOL_WIDTH, len(self._symbol) + 1) + len(_CHANGED)
        room = width - first - (0 if self.field.step_by is None else _STEPS_WIDTH + _UNIT_WIDTH)
        return first, max(room, 1)

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:  # noqa: ARG002
        """One line, plus those of the error message, or else of a note."""
        return 1 + len(self._lines_below(width))

    def _lines_below(self, width: int) -> list[str]:
        return wrap(self._error or self._note, max(width - len(_INDENT) - 1, 1))

    def render(self) -> Content:
        """Everything but the editor."""
        field, width = self.field, self.size.width
        first, editor_width = self.span(width)
        focused = self._editor.has_focus or self.has_class("-cursor")
        symbol = self._symbol.ljust(_SYMBOL_WIDTH - 1)
        parts: list[tuple[str, str]] = [
            (_CHANGED if self._changed else " ", "$text-warning"),
            (symbol, "bold reverse" if focused else ""),
            (" " * (first + editor_width - len(_CHANGED) - len(symbol)), ""),
        ]
        if field.step_by is not None:
            parts += [(sign.center(_STEP_WIDTH), "$button-foreground") for sign in _SIGNS]
            parts.append((f" {field.unit}".ljust(_UNIT_WIDTH), ""))
        line = Content.assemble(*parts)
        style = "$text-error" if self._error else "$text-muted"
        below = (Content.styled(_INDENT + line, style) for line in self._lines_below(width))
        return Content("\n").join([line.truncate(width), *below])

    @property
    def text(self) -> str:
        """The text in the editor."""
        return self._editor.text

    def show(self, text: str, error: str, note: str, *, changed: bool) -> None:
        """Display text, error message or else a note, and the mark of a changed field."""
        self._editor.show(text)
        if changed is not self._changed:
            self._changed = changed
            self.refresh()
        if (error, note) != (self._error, self._note):
            self._error, self._note = error, note
            self._editor.set_class(bool(error), "-invalid")
            self.refresh(layout=True)

    def on_descendant_focus(self) -> None:
        """Report that this field has the focus."""
        self.refresh()
        self.post_message(FieldFocused(self.field.name))

    def on_descendant_blur(self) -> None:
        """Redraw without focus."""
        self.refresh()

    def mark(self, *, here: bool) -> None:
        """Show or hide the list's cursor on this row."""
        self.set_class(here, "-cursor")
        self.refresh()

    def take_focus(self) -> None:
        """Focus the editor."""
        self._editor.focus()

    def on_click(self, event: Click) -> None:
        """Change the number by a step on a click on − or +; elsewhere focus the editor."""
        first, width = self.span(self.size.width)
        place = (event.x - first - width) // _STEP_WIDTH
        if self.field.step_by is not None and event.y == 0 and place in (0, 1):
            event.stop()
            self.post_message(FieldStepped(self.field.name, (-1, +1)[place], fine=False))
        else:
            self.take_focus()


class FieldList(VerticalScroll):
    """The rows, with a cursor for keys that do not type; Escape leads here from an editor."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j,down", "move(1)", "Down", show=False),
        Binding("k,up", "move(-1)", "Up", show=False),
        Binding("h,left,minus", "step(-1)", "Decrease", show=False),
        Binding("l,right,plus", "step(1)", "Increase", show=False),
        Binding("H,shift+left", "step(-1, True)", "Decrease slightly", show=False),
        Binding("L,shift+right", "step(1, True)", "Increase slightly", show=False),
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
        return self._shown[min(self._cursor, len(self._shown) - 1)]

    @property
    def _shown(self) -> list[FieldRow]:
        # Those of the belt are there only if it has a finite speed.
        return [row for row in self.query(FieldRow) if row.display]

    def on_focus(self) -> None:
        """Show the cursor."""
        self._mark()

    def on_blur(self) -> None:
        """Hide the cursor."""
        self.row.mark(here=False)

    def _mark(self) -> None:
        self.row.mark(here=True)
        self.scroll_to_widget(self.row, animate=False)
        self.post_message(FieldFocused(self.row.field.name))

    def action_move(self, by: int) -> None:
        """Move the cursor by some rows."""
        self.row.mark(here=False)
        self._cursor = min(max(self._cursor + by, 0), len(self._shown) - 1)
        self._mark()

    def action_step(self, direction: int, fine: bool = False) -> None:
        """Increase or decrease the number at the cursor by a step."""
        self.post_message(FieldStepped(self.row.field.name, direction, fine))

    def action_edit(self) -> None:
        """Edit the field at the cursor."""
        self.row.take_focus()

    @on(FieldFocused)
    def _follow(self, event: FieldFocused) -> None:
        names = [row.field.name for row in self._shown]
        if event.name in names:
            self._cursor = names.index(event.name)

    def action_leave_editor(self) -> None:
        """Leave an editor for the list."""
        self.focus()


class Form(Vertical):
    """All fields by group, and a hint about the focused one."""

    BORDER_TITLE = "Parameters"
    BORDER_SUBTITLE = "↑↓ step  F8 reset"

    def __init__(self, texts: Mapping[str, str]) -> None:
        super().__init__(id="form")
        self._rows = {name: FieldRow(field, texts[name]) for name, field in FIELDS.items()}
        for name in BELT_PARAMETERS:
            self._rows[name].display = bool(texts[name])

    def compose(self) -> ComposeResult:
        """Rows by group, hint."""
        with FieldList(id="fields"):
            for group, fields in groupby(FIELDS.values(), key=lambda field: field.group):
                if group != self.BORDER_TITLE:
                    yield Label(group, classes="heading")
                yield from (self._rows[field.name] for field in fields)
        yield Static("", id="hint", markup=False)

    def text_of(self, name: str) -> str:
        """The text in a field's editor."""
        return self._rows[name].text

    def show(
        self,
        texts: Mapping[str, str],
        errors: Mapping[str, str],
        changed: Collection[str],
        notes: Mapping[str, str],
    ) -> None:
        """Display texts, error messages, changed fields and notes, all by field name."""
        belt = any(texts[name] for name in BELT_PARAMETERS)
        for name, row in self._rows.items():
            if name in BELT_PARAMETERS:
                # A row that is being edited stays.
                row.display = belt or (row.display and row.has_focus_within)
            error, note = errors.get(name, ""), notes.get(name, "")
            row.show(texts[name], error, note, changed=name in changed)

    def hide_belt(self) -> None:
        """Hide the fields of a belt of finite speed."""
        for name in BELT_PARAMETERS:
            self._rows[name].display = False

    @on(FieldFocused)
    def _hint(self, event: FieldFocused) -> None:
        field = FIELDS[event.name]
        view = self.query_one("#hint", Static)
        # One below the other, or else without a gap.
        apart = cell_len(field.meaning) <= view.content_size.width
        hint = ("\n" if apart else "; ").join((field.meaning, field.allowed))
        view.update(hint, layout=False)

    def take_focus(self) -> None:
        """Focus the field at the list's cursor."""
        self.query_one(FieldList).row.take_focus()

    def focus_field(self, name: str) -> None:
        """Focus a field."""
        self._rows[name].take_focus()


def field_of(widget: Widget | None) -> FormField | None:
    """The field that a widget belongs to; of the field list, the one at its cursor."""
    if widget is None:
        return None
    if isinstance(widget, FieldList):
        return widget.row.field
    rows = (node.field for node in widget.ancestors_with_self if isinstance(node, FieldRow))
    return next(rows, None)
