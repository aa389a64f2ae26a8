"""Dialogs: where to write a file, and help."""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, Static

from fivtui.model.errors import InputError
from fivtui.tui.session.report import Row
from fivtui.tui.tabs.table import grid


@dataclass(frozen=True, slots=True)
class Target:
    """Where to write, and whether a file that exists may be replaced."""

    path: Path
    force: bool


class PathDialog(ModalScreen[Target | None]):
    """Asks for a path; a file that exists is overwritten only when that is said a second time.

    The check runs in a thread: it may have to import a library.

    Parameters
    ----------
    title : str
        What will be written.
    proposal : str
        Path to begin with.
    hint : str
        What is allowed.
    check : callable
        Takes the path and whether to overwrite; raises `InputError` if it will not do.
    verb : str
        What the button says.
    """

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss_dialog", "Cancel")]

    def __init__(
        self,
        title: str,
        proposal: str,
        hint: str,
        check: Callable[[Path, bool], object],
        verb: str = "Save",
    ) -> None:
        super().__init__()
        self._title = title
        self._proposal = proposal
        self._hint = hint
        self._check = check
        self._verb = verb
        self._confirmed = ""

    def compose(self) -> ComposeResult:
        """The parts from top to bottom."""
        with Vertical(id="dialog"):
            yield Label(self._title, id="dialog-title", markup=False)
            yield Input(self._proposal, id="path", select_on_focus=False)
            yield Static(self._hint, id="dialog-hint", markup=False)
            with Horizontal(id="dialog-buttons"):
                yield Button(self._verb, id="save", variant="primary", compact=True)
                yield Button("Cancel", id="cancel", compact=True)

    @on(Input.Changed, "#path")
    def _edited(self) -> None:
        self._say(self._hint, self._verb, wrong=False)
        self._confirmed = ""

    @on(Input.Submitted, "#path")
    @on(Button.Pressed, "#save")
    async def _accept(self) -> None:
        text = self.query_one("#path", Input).value.strip()
        path = Path(text).expanduser()
        force = bool(text) and self._confirmed == text
        error = await asyncio.to_thread(self._error, path, force) if text else "the path is empty"
        if not self.is_current:
            return
        if not error:
            self.dismiss(Target(path, force))
        elif text and not force and not await asyncio.to_thread(self._error, path, True):
            # Nothing but the file that exists stands in the way.
            self._confirmed = text
            self._say(f"{path} exists. Overwrite it?", "Overwrite", wrong=True)
        else:
            self._say(error, self._verb, wrong=True)

    def _error(self, path: Path, force: bool) -> str:
        try:
            self._check(path, force)
        except InputError as error:
            return str(error)
        return ""

    def _say(self, words: str, label: str, *, wrong: bool) -> None:
        # What the first text is comes before the button is there, or after all has gone.
        for hint in self.query("#dialog-hint").results(Static):
            hint.update(words)
            hint.set_class(wrong, "-wrong")
        for button in self.query("#save").results(Button):
            button.label = label

    @on(Button.Pressed, "#cancel")
    def action_dismiss_dialog(self) -> None:
        """Close without writing."""
        self.dismiss(None)


class HelpDialog(ModalScreen[None]):
    """Help as rows of label and value.

    Parameters
    ----------
    title : str
        What it is about.
    rows : sequence of Row
        What there is to say.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,f1,q,enter", "close", "Close"),
        Binding("j,down", "scroll(1)", "Down", show=False),
        Binding("k,up", "scroll(-1)", "Up", show=False),
    ]

    def __init__(self, title: str, rows: Sequence[Row]) -> None:
        super().__init__()
        self._title = title
        self._rows = rows

    def compose(self) -> ComposeResult:
        """A title over the rows."""
        with VerticalScroll(id="dialog"):
            yield Label(self._title, id="dialog-title", markup=False)
            yield Static(grid(self._rows))
            yield Button("Close", id="close", compact=True)

    def action_scroll(self, direction: int) -> None:
        """Scroll by a line."""
        self.query_one("#dialog").scroll_relative(y=direction)

    @on(Button.Pressed, "#close")
    def action_close(self) -> None:
        """Close the help."""
        self.dismiss()
