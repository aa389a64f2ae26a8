"""The row of a field in the form."""

from textwrap import wrap
from typing import Final

from textual.content import Content
from textual.events import Click
from textual.geometry import Size
from textual.reactive import reactive
from textual.style import Style
from textual.widget import Widget

from fivtui.tui.session import FormField
from fivtui.tui.tabs import FieldFocused, FieldStepped, shorten

from .editors import editor_of

# Before the symbol of a field that differs from the loaded scene.
_CHANGED_SIGN: Final = "•"
# Signs after the editor of a number, and the direction of a step at a click on them.
_STEP_SIGNS: Final = (("−", -1), ("+", 1))
# Before an error message or note.
_INDENT: Final = "   "
# Widths of the parts of a row, in columns.
_SYMBOL_WIDTH: Final = 6
_STEP_WIDTH: Final = 3
_STEPS_WIDTH: Final = _STEP_WIDTH * len(_STEP_SIGNS)
_UNIT_WIDTH: Final = 6
# Column before which editor, steps and unit end; in a wide row, the meaning of the field follows.
_END: Final = 31
# Minimum width of the meaning of a field.
_MEANING_WIDTH: Final = 20
# Maximum number of displayed lines of an error message.
_MAX_LINES: Final = 8


class FieldRow(Widget):
    """Symbol, editor and unit of a field, and the error message or note below them.

    One widget draws everything but the editor: more widgets would slow the start and every key.
    """

    # Whether the field differs from the loaded scene, and is that of the list's cursor.
    changed = reactive(False)
    selected = reactive(False)
    error = reactive("", layout=True)
    note = reactive("", layout=True)

    def __init__(self, field: FormField, text: str) -> None:
        self.field = field
        self.editor = editor_of(field, text)
        super().__init__(self.editor, id=f"row-{field.name}")
        self._symbol = f"{field.symbol or field.name} ".ljust(_SYMBOL_WIDTH)
        # Columns of the steps and the unit, which follow the editor of a number.
        self._width_after = 0 if field.step_rule is None else _STEPS_WIDTH + _UNIT_WIDTH
        # The row itself draws everything around the editor.
        first_column, styles = len(_CHANGED_SIGN) + len(self._symbol), self.editor.styles
        styles.margin = (0, self._width_after, 0, first_column)
        styles.width, styles.max_width = "1fr", _END - self._width_after - first_column

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:  # noqa: ARG002
        """One line plus those of the error message or note."""
        return 1 + len(self._lines_below(width))

    def _lines_below(self, width: int) -> list[str]:
        lines = wrap(self.error or self.note, max(width - len(_INDENT) - 1, 1))
        return lines[:_MAX_LINES]

    def render(self) -> Content:
        """Draw everything but the editor."""
        field, width = self.field, self.size.width
        focused = self.editor.has_focus or self.selected
        width_before = min(width, _END) - self._width_after - len(_CHANGED_SIGN)
        parts: list[Content | str | tuple[str, str]] = [
            (_CHANGED_SIGN if self.changed else " ", "$text-warning"),
            (self._symbol[:-1], "bold reverse" if focused else ""),
            " " * (width_before - len(self._symbol) + 1),
        ]
        if field.step_rule is not None:
            for sign, direction in _STEP_SIGNS:
                button = Content.styled(sign.center(_STEP_WIDTH), "$button-foreground")
                parts.append(button.stylize(Style.from_meta({"step": direction})))
            parts.append(f" {field.unit}".ljust(_UNIT_WIDTH))
        if width >= _END + _MEANING_WIDTH:
            parts.append((f" {shorten(field.meaning, width - _END - 1)}", "$foreground 60%"))
        line = Content.assemble(*parts)
        style = "$text-warning" if self.error else "$text-muted"
        lines_below = (Content.styled(_INDENT + line, style) for line in self._lines_below(width))
        return Content("\n").join([line.truncate(width), *lines_below])

    def watch_error(self, error: str) -> None:
        """Mark the editor of an invalid text, and show the whole error."""
        self.editor.set_class(bool(error), "-invalid")
        self.call_after_refresh(self.on_resize)

    def on_resize(self) -> None:
        """Scroll to the whole error of the focused field."""
        if self.error and self.editor.has_focus:
            self.scroll_visible(animate=False)

    def on_descendant_focus(self) -> None:
        """Report that this field has the focus."""
        self.refresh()
        self.post_message(FieldFocused(self.field.name))

    def on_descendant_blur(self) -> None:
        """Redraw the row without the mark of the focus."""
        self.refresh()

    def on_click(self, event: Click) -> None:
        """Change the number by a step on a click on − or +; elsewhere focus the editor."""
        direction = event.style.meta.get("step")
        if direction is None:
            self.editor.focus()
        else:
            self.post_message(FieldStepped(self.field.name, direction, fine=False))
