"""Lists and texts with the keys of vi and a search."""

from collections.abc import Callable, Sequence
from typing import ClassVar, Final, Generic, TypeVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.visual import VisualType
from textual.widget import Widget
from textual.widgets import Input, Label, Static

from fivtui.tui.chart import TextInput

# More rows than any list has.
_ALL_ROWS: Final = 10**6
# The texts of a line.
Line = TypeVar("Line", bound=tuple[str, ...])

_SEARCH: Final = "search: "
_NO_MATCH: Final = "no match: "


class Searchable(Widget):
    """A list or text with a search, and keys that move by half pages."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("slash", "search", "Search", show=False),
        Binding("ctrl+d", "half_page(1)", "Half a page down", show=False),
        Binding("ctrl+u", "half_page(-1)", "Half a page up", show=False),
    ]

    def find(self, text: str) -> bool:
        """Show what contains a text, or the state before the search if it is empty.

        Returns whether anything contains the text.
        """
        raise NotImplementedError

    def action_move(self, rows: int) -> None:
        """Move by rows down, or up if negative."""
        raise NotImplementedError

    def action_half_page(self, direction: int) -> None:
        """Move by half a page down (+1) or up (-1)."""
        self.action_move(direction * max(self.size.height // 2, 1))

    def action_search(self) -> None:
        """Ask for a text and find it while it is typed."""
        self.app.push_screen(SearchLine(self.find))


class SearchLine(ModalScreen[None]):
    """The text to find, in a line at the lower edge; Enter keeps what is shown, Escape does not."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "cancel", "Cancel")]

    def __init__(self, find: Callable[[str], bool]) -> None:
        super().__init__()
        self._find = find

    def compose(self) -> ComposeResult:
        """The line."""
        with Horizontal():
            yield Label(_SEARCH)
            yield TextInput("", compact=True)

    @on(Input.Changed)
    def _show_matches(self, event: Input.Changed) -> None:
        self.query_one(Label).update(_SEARCH if self._find(event.value.lower()) else _NO_MATCH)

    @on(Input.Submitted)
    def _close(self) -> None:
        self.dismiss()

    def action_cancel(self) -> None:
        """Restore the state before the search."""
        self._find("")
        self.dismiss()


class SearchableList(Searchable):
    """A list with a cursor, which a search moves to the next row that contains the text."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j,down", "move(1)", "Down", show=False),
        Binding("k,up", "move(-1)", "Up", show=False),
        Binding("g,home", f"move(-{_ALL_ROWS})", "First", show=False),
        Binding("G,end", f"move({_ALL_ROWS})", "Last", show=False),
        Binding("n", "find_next(1)", "Next match", show=False),
        Binding("N", "find_next(-1)", "Previous match", show=False),
    ]
    _search_text = ""
    # The row of the cursor before the search.
    _search_start = 0

    @property
    def cursor_row(self) -> int:
        """The row of the cursor."""
        raise NotImplementedError

    def row_texts(self) -> Sequence[str]:
        """The texts of all rows."""
        raise NotImplementedError

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Whether an action is available: the next match after a search."""
        if action == "find_next":
            return bool(self._search_text)
        return super().check_action(action, parameters)

    def action_search(self) -> None:
        """Ask for a text, and move the cursor to it while it is typed."""
        self._search_start = self.cursor_row
        super().action_search()

    def find(self, text: str) -> bool:
        """Move the cursor to the next row that contains a text."""
        self._search_text = text
        return self._find_from(self._search_start, 1)

    def action_find_next(self, direction: int) -> None:
        """Move the cursor to the next (+1) or previous (-1) row that contains the text."""
        self._find_from(self.cursor_row + direction, direction)

    def _find_from(self, start: int, direction: int) -> bool:
        texts = self.row_texts()
        for offset in range(len(texts)):
            index = (start + direction * offset) % len(texts)
            if self._search_text in texts[index].lower():
                self.action_move(index - self.cursor_row)
                return True
        return False


class TextView(VerticalScroll, Searchable, Generic[Line]):
    """Lines that scroll; a search hides all lines that do not contain the text.

    Textual's `RichLog` draws nothing before it has a size, and if it was scrolled, it may get none.
    """

    lines: Sequence[Line] = ()
    _empty_text: VisualType = ""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j", "scroll_down", "Down", show=False),
        Binding("k", "scroll_up", "Up", show=False),
        Binding("g", "scroll_home", "Start", show=False),
        Binding("G", "scroll_end", "End", show=False),
    ]

    def compose(self) -> ComposeResult:
        """The lines."""
        yield Static(self.content_of(self.lines), classes="lines", markup=False)

    def content_of(self, lines: Sequence[Line]) -> VisualType:
        """What displays lines."""
        return Content("\n".join(map(" ".join, lines)))

    def show(self, lines: Sequence[Line], empty_text: VisualType = "") -> None:
        """Display lines, or a text in place of none."""
        self.lines, self._empty_text = lines, empty_text
        self.find("")

    def find(self, text: str) -> bool:
        """Display only the lines that contain a text."""
        matches = [line for line in self.lines if text in " ".join(line).lower()]
        content = self.content_of(matches) if self.lines else self._empty_text
        self.query_one(".lines", Static).update(content)
        return bool(matches)

    def action_move(self, rows: int) -> None:
        """Scroll by rows down, or up if negative."""
        self.scroll_relative(y=rows, animate=False)
