"""Handles keys before they reach a widget: in order, and keys with Alt never as text."""

from collections import deque
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from string import ascii_lowercase, digits
from typing import Any, Final, cast

from textual.app import App
from textual.dom import DOMNode
from textual.events import Event, Key
from textual.widget import Widget

# Signs typed with a Mac's Option key if the terminal does not send Alt.
_OPTION_DIGITS: Final = dict(zip("¡™£¢∞§¶•ªº", "1234567890", strict=True))
_NAMES: Final = {sign: sign for sign in digits + ascii_lowercase} | {
    "-": "minus",
    "=": "equals_sign",
}

# Alt+f goes to the fields; Ctrl+→ also moves forward by a word.
_OVERRIDDEN: Final = "f"

# An editor handles the key, then its message that its value has changed.
_TURNS: Final = 2


@dataclass(frozen=True, slots=True)
class _AltKey:
    # A key in the form of Textual's table.
    value: str


def register_alt_keys() -> None:
    """Make Textual read Alt with a letter or digit as a key; by default it inserts a symbol."""
    # Versions of Textual without this table insert no symbols.
    with suppress(ImportError):
        from textual._ansi_sequences import ANSI_SEQUENCES_KEYS

        sequences = cast("dict[str, Any]", ANSI_SEQUENCES_KEYS)
        for sign, name in _NAMES.items():
            # Keep existing keys, such as Alt+b (word back), except the overridden one.
            if sign in _OVERRIDDEN or isinstance(sequences.get(f"\x1b{sign}", ""), str):
                sequences[f"\x1b{sign}"] = (_AltKey(f"alt+{name}"),)


def discard_alt_character(key: Key, *, option: bool) -> None:
    """Turn a key with Alt into a key without text.

    `option` also reads the signs that Option and a digit type on a Mac as Alt and that digit.
    """
    digit = _OPTION_DIGITS.get(key.character or "")
    if option and digit is not None:
        key.key = f"alt+{digit}"
    if "alt" in key.key.split("+")[:-1]:
        key.character = None


class KeyQueue:
    """Queues keys and pasted text, so that they are handled in order.

    Textual lets a widget type a letter at once, but runs the action of a key only after the key has
    reached the application: letters after Ctrl+U would be typed before it deletes.
    """

    def __init__(self, app: App[None], handle: Callable[[Event], Awaitable[None]]) -> None:
        self._app = app
        self._handle = handle
        self._events: deque[Event] = deque()
        self._busy = False

    async def put(self, event: Event) -> None:
        """Handle an event after all earlier events."""
        self._events.append(event)
        if not self._busy:
            await self._handle_first()

    async def _handle_first(self) -> None:
        self._busy = bool(self._events and self._app.screen_stack)
        if not self._busy:
            return
        event, screen = self._events.popleft(), self._app.screen
        target = self._app.focused or screen
        await self._handle(event)

        def climb(node: DOMNode, turns: int = 1) -> None:
            # Post a callback: it is handled after the event.
            # A widget that is being removed accepts none.
            if not node.call_later(follow, node, turns):
                follow(node, 1)

        def follow(node: DOMNode, turns: int) -> None:
            if turns > 1:
                climb(node, turns - 1)
            elif node is self._app or _is_typed(event, node):
                finish()
            else:
                climb(node.parent or self._app)

        def finish() -> None:
            stack = self._app.screen_stack
            # A new screen chooses its focused widget in its own message loop.
            if not (stack and stack[-1] is not screen and stack[-1].call_later(self._go_on)):
                self._go_on()

        climb(target, _TURNS)

    def _go_on(self) -> None:
        self._app.call_later(self._handle_first)


def _is_typed(event: Event, node: DOMNode) -> bool:
    if not isinstance(event, Key):
        return True
    return isinstance(node, Widget) and node.check_consume_key(event.key, event.character)
