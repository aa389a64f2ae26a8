"""The form: a list of rows with fields, and a hint about the focused field."""

from collections.abc import Sequence
from typing import ClassVar, Final

from rich.cells import cell_len
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical, VerticalScroll
from textual.events import Resize
from textual.widget import Widget
from textual.widgets import Label, Static

from fivtui.model import BELT_PARAMETERS
from fivtui.results import Row
from fivtui.transient import SETTINGS
from fivtui.tui.session import EQUATIONS, FIELDS, FormField, Session, field_help
from fivtui.tui.tabs import FieldFocused, FieldStepped, SearchableList, rows_table

from .editors import Editor
from .rows import FieldRow

# Lines that a row of help takes on average.
_LINES_PER_ROW: Final = 1.5


class FieldList(VerticalScroll, SearchableList, can_focus=True):
    """The rows, with a cursor; while it has the focus, letters are commands and type no text."""

    BINDINGS: ClassVar[list[BindingType]] = [
        # These replace the keys of the base class that scroll.
        *SearchableList.BINDINGS,
        Binding("h,left,minus", "step(-1)", "Decrease", show=False),
        Binding("l,right,plus", "step(1)", "Increase", show=False),
        Binding("H,shift+left", "step(-1, True)", "Decrease slightly", show=False),
        Binding("L,shift+right", "step(1, True)", "Increase slightly", show=False),
        Binding("enter,i", "edit", "Edit", show=False),
        Binding("escape", "app.focus('fields')", "Stop typing", show=False),
    ]

    # The name of the field at the cursor.
    _cursor = "mu"

    @property
    def row(self) -> FieldRow:
        """The row at the cursor."""
        # At the end of the laboratory, no row is visible.
        rows = self._visible_rows or list(self.query(FieldRow))
        return next((row for row in rows if row.field.name == self._cursor), rows[0])

    @property
    def _visible_rows(self) -> list[FieldRow]:
        # Parameters of a belt of finite speed are hidden while the belt has none.
        return [row for row in self.query(FieldRow) if row.display]

    def on_focus(self) -> None:
        """Show the cursor."""
        self._show_cursor()

    def on_blur(self) -> None:
        """Hide the cursor."""
        # At the end of the program there may be no row.
        for row in self._visible_rows:
            row.selected = False

    def _show_cursor(self) -> None:
        self.row.selected = True
        self.scroll_to_widget(self.row, animate=False)
        self.post_message(FieldFocused(self.row.field.name))

    @property
    def cursor_row(self) -> int:
        """The index of the row at the cursor."""
        return self._visible_rows.index(self.row)

    def row_texts(self) -> Sequence[str]:
        """Names, symbols and meanings of the visible fields."""
        fields = [row.field for row in self._visible_rows]
        return [f"{field.name} {field.symbol} {field.meaning}" for field in fields]

    def action_move(self, rows: int) -> None:
        """Move the cursor by rows down, or up if negative."""
        # A check box leaves ↑ and ↓ to this list. If it kept the focus, the next Enter would toggle
        # it, not edit the row that the cursor is moved to.
        self.focus()
        self.row.selected = False
        index = min(max(self.cursor_row + rows, 0), len(self._visible_rows) - 1)
        self._cursor = self._visible_rows[index].field.name
        self._show_cursor()

    def action_step(self, direction: int, fine: bool = False) -> None:
        """Increase or decrease the number at the cursor by a step."""
        self.post_message(FieldStepped(self.row.field.name, direction, fine))

    def action_edit(self) -> None:
        """Focus the editor at the cursor."""
        self.row.editor.focus()

    @on(FieldFocused)
    def _move_cursor_to(self, event: FieldFocused) -> None:
        self._cursor = event.name


class Form(Vertical):
    """All fields by group, and a hint about the focused one."""

    BORDER_TITLE = "Parameters"

    def __init__(self, session: Session) -> None:
        super().__init__(id="form")
        self.border_subtitle = f"↑↓ step  {session.key_names['reset']} reset"
        self._session = session
        self._rows = {name: FieldRow(field, session.texts[name]) for name, field in FIELDS.items()}
        for name in BELT_PARAMETERS:
            self._rows[name].display = session.belt_is_finite

    def compose(self) -> ComposeResult:
        """Rows by group, hint."""
        with FieldList(id="fields"):
            for name, row in self._rows.items():
                if name == next(iter(SETTINGS)):
                    yield Label("Transient", classes="heading")
                yield row
        yield Static("", id="hint", markup=False)

    def editor(self, name: str) -> Editor:
        """The editor of a field."""
        return self._rows[name].editor

    def show(self) -> None:
        """Display the texts of the session, and its errors and notes on them."""
        session = self._session
        errors, notes, changed = session.errors, session.notes, session.changed_fields
        for name, row in self._rows.items():
            if name in BELT_PARAMETERS:
                # Keep a row that is being edited.
                is_edited = row.display and row.editor is self.screen.focused
                row.display = session.belt_is_finite or is_edited
            row.editor.show(session.texts[name])
            row.error, row.note = errors.get(name, ""), notes.get(name, "")
            row.changed = name in changed

    @on(FieldFocused)
    @on(Resize)
    def _update_hint(self) -> None:
        self.call_after_refresh(self._fit_hint)

    def _fit_hint(self) -> None:
        # All help on the field at the cursor if there is room, else its meaning and range.
        field, view = self.query_one(FieldList).row.field, self.query_one("#hint", Static)
        width, height = view.content_size
        labels = {row.label for row in EQUATIONS}
        rows = [row for row in field_help(field) if row.label not in labels]
        rows += [Row("", ""), *EQUATIONS]
        if height >= _LINES_PER_ROW * len(rows):
            view.update(rows_table(rows), layout=False)
            return
        # On two lines, or on one that wraps if the meaning is longer than a line.
        separator = "\n" if cell_len(field.meaning) <= width else "; "
        view.update(separator.join((field.meaning, field.allowed)), layout=False)


def field_of(widget: Widget | None) -> FormField | None:
    """The field of a widget; for the field list, the field at its cursor."""
    for node in [] if widget is None else widget.ancestors_with_self:
        if isinstance(node, FieldRow):
            return node.field
        if isinstance(node, FieldList):
            return node.row.field
    return None
