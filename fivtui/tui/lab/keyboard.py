"""Handles keys in the order of typing, and keeps keys with Alt from inserting text."""

from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from string import ascii_lowercase, digits
from types import SimpleNamespace
from typing import Any, Final, cast

from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual.app import App
from textual.dom import DOMNode
from textual.events import Event, Key
from textual.keys import _character_to_key
from textual.screen import Screen

# Characters whose keys with Alt are read as keys.
_ALT_CHARACTERS: Final = f"{digits}{ascii_lowercase}-="
# Keys by the character that each types with a Mac's Option key if the terminal sends no Alt.
_KEY_OF_OPTION_CHARACTER: Final = {
    typed: _character_to_key(key) for typed, key in zip("¡™£¢∞§¶•ªº–", "1234567890-", strict=True)
}
# Terminals send a key with Alt as this character and the key.
_ESCAPE: Final = "\x1b"

# Letters whose Alt key in Textual is replaced: Alt+F goes to the fields, not a word forward.
_OVERRIDDEN_LETTERS: Final = "f"


def register_alt_keys() -> None:
    """Make Textual read Alt with a letter or digit as a key instead of inserting a symbol."""
    sequences = cast("dict[str, Any]", ANSI_SEQUENCES_KEYS)
    for character in _ALT_CHARACTERS:
        sequence = f"{_ESCAPE}{character}"
        # The table gives a tuple for a key of Textual, such as Alt+B (a word back), which stays;
        # for a symbol to insert it gives a text.
        is_undefined = isinstance(sequences.get(sequence, ""), str)
        if is_undefined or character in _OVERRIDDEN_LETTERS:
            # Like members of Textual's enumeration of keys.
            sequences[sequence] = (SimpleNamespace(value=f"alt+{_character_to_key(character)}"),)


def discard_alt_character(key: Key, *, mac_option: bool) -> None:
    """Remove the text of a key with Alt, so that no widget inserts it.

    With `mac_option`, a character that a Mac's Option key types with a digit or minus counts as Alt
    and this key.
    """
    option_key = _KEY_OF_OPTION_CHARACTER.get(key.character or "")
    if mac_option and option_key is not None:
        key.key = f"alt+{option_key}"
    if "alt" in key.key.split("+")[:-1]:
        key.character = None


class KeyQueue:
    """Queues keys and pasted text, so that they are handled in order.

    Textual inserts a letter at once, but runs the action of a key only after the key has reached
    the application. So letters typed after Ctrl+U would be inserted before it deletes. The queue
    hence handles an event only when the previous one had the time to reach the application.
    """

    def __init__(self, app: App[None], handle: Callable[[Event], Awaitable[None]]) -> None:
        self._app = app
        self._handle = handle
        # The events that wait.
        self.events: deque[Event] = deque()
        self._busy = False

    async def enqueue(self, event: Event) -> None:
        """Handle an event after all earlier events."""
        self.events.append(event)
        if not self._busy:
            await self._handle_first()

    async def _handle_first(self) -> None:
        self._busy = bool(self.events and self._app.screen_stack)
        if self._busy:
            event, screen = self.events.popleft(), self._app.screen
            focused = self._app.focused or screen
            await self._handle(event)
            # The focused widget may handle two messages: the key, then its own message of a changed
            # value.
            self._follow([focused, *focused.ancestors_with_self], screen)

    def _follow(self, nodes: Sequence[DOMNode], screen: Screen[Any]) -> None:
        # Follow an event from the focused widget to the application: a callback queued in a node
        # runs after the messages that the node has received before.
        if nodes:
            # A node that is being removed accepts no callback.
            if not nodes[0].call_later(self._follow, nodes[1:], screen):
                self._follow(nodes[1:], screen)
            return
        # A new screen first sets the focus, in its own message loop: resume after that.
        top_screens = [top for top in self._app.screen_stack[-1:] if top is not screen]
        if not (top_screens and top_screens[0].call_later(self._resume)):
            self._resume()

    def _resume(self) -> None:
        self._app.call_later(self._handle_first)
