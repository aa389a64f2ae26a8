"""Dialogs for file paths and help."""

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Key
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, Static

from fivtui.io import home_path, output_path
from fivtui.model import InputError
from fivtui.results import Row
from fivtui.tui.chart import TextInput
from fivtui.tui.tabs import RowsView

# Parts of the screen by the keys of vi for their directions, and the arrows of these keys.
_PARTS: Final = {"h": "fields", "l": "plot", "k": "tabs", "j": "runs"}
_ARROWS: Final = {"left": "h", "right": "l", "up": "k", "down": "j"}


class PathDialog(ModalScreen[Path | None]):
    """Asks for a path; overwriting an existing file needs a second confirmation.

    `check` raises `InputError` for an invalid path. It runs in a thread, because it may import a
    library.
    """

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss", "Cancel")]

    def __init__(
        self,
        title: str,
        proposed_path: str,
        hint: str,
        check: Callable[[Path], object],
        verb: str = "Save",
    ) -> None:
        super().__init__()
        self._title = title
        self._proposed_path = proposed_path
        self._hint = hint
        self._check = check
        self._verb = verb
        # The path of an existing file for which the dialog asks whether to overwrite it.
        self._text_to_overwrite = ""

    def compose(self) -> ComposeResult:
        """Title, input, hint and buttons."""
        with Vertical(id="dialog"):
            yield Label(self._title, id="dialog-title", markup=False)
            yield TextInput(self._proposed_path, id="path", select_on_focus=False)
            yield Static(self._hint, id="dialog-hint", markup=False)
            with Horizontal(id="dialog-buttons"):
                yield Button(self._verb, id="save", variant="primary", compact=True)
                yield Button("Cancel", compact=True, action="screen.dismiss")

    @on(Input.Changed, "#path")
    def _reset_hint(self) -> None:
        self._text_to_overwrite = ""
        self._show_hint(self._hint, is_error=False)

    @on(Input.Submitted, "#path")
    @on(Button.Pressed, "#save")
    async def _confirm(self) -> None:
        text = self.query_one("#path", Input).value.strip()
        if not text:
            self._show_hint("type a path", is_error=True)
            return
        path = home_path(text)
        # A check refuses an existing file unless its path is marked as replaceable.
        replaceable_path = output_path(path, force=True)
        if self._text_to_overwrite == text:
            path = replaceable_path
        error = await asyncio.to_thread(self._path_error, path)
        if error and not await asyncio.to_thread(self._path_error, replaceable_path):
            self._text_to_overwrite = text
            error = f"{path} exists. Overwrite it?"
        if not self.is_current:
            return
        if error:
            self._show_hint(error, is_error=True)
        else:
            self.dismiss(path)

    def _path_error(self, path: Path) -> str:
        try:
            self._check(path)
        except InputError as error:
            return str(error)
        return ""

    def _show_hint(self, text: str, *, is_error: bool) -> None:
        # While the dialog opens or closes, the hint or the button may not exist.
        for hint in self.query("#dialog-hint").results(Static):
            hint.update(text)
            hint.set_class(is_error, "-wrong")
        for button in self.query("#save").results(Button):
            button.label = "Overwrite" if self._text_to_overwrite else self._verb


class HelpDialog(ModalScreen[None]):
    """The keys that work, and further help, as rows of label and value."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape,f1,q,enter", "dismiss", "Close")]

    def __init__(self, rows: Sequence[Row]) -> None:
        super().__init__()
        self._rows = rows

    def compose(self) -> ComposeResult:
        """A title over the rows, which have the focus."""
        with Vertical(id="dialog"):
            yield Label("Keys that work now", id="dialog-title")
            yield (view := RowsView())
            view.lines = self._rows
            yield Button("Close", compact=True, action="screen.dismiss")


class PartKey(ModalScreen[str]):
    """Waits for the key of the direction in which a part of the screen is."""

    def on_key(self, event: Key) -> None:
        """Return the part, or nothing for another key."""
        event.stop()
        key = event.key.removeprefix("ctrl+")
        self.dismiss(_PARTS.get(_ARROWS.get(key, key), ""))
