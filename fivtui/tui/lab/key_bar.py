"""The key bar in the last line of the screen: the active keys and what they do."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import accumulate, groupby
from typing import Final

from textual.binding import ActiveBinding
from textual.content import Content
from textual.events import Click
from textual.screen import Screen
from textual.widget import Widget

# Identifiers of the keys that come first.
_ESSENTIAL_IDS: Final = ("run", "stop", "help", "next-tab")
# An essential key has its index as rank; keys of the focused widget follow, then all others.
_FOCUSED_RANK: Final = len(_ESSENTIAL_IDS)
_SCREEN_RANK: Final = _FOCUSED_RANK + 1
_KEY_STYLE: Final = "bold $footer-key-foreground"
_TEXT_STYLE: Final = "$footer-description-foreground"
_DIM_STYLE: Final = "dim $footer-description-foreground"


@dataclass(frozen=True, slots=True)
class _Item:
    # A key and its description, which is empty for all but the last key of a group.
    key: str
    display: str
    description: str
    enabled: bool

    @property
    def width(self) -> int:
        return sum(len(text) for text, _ in self.parts)

    @property
    def parts(self) -> tuple[tuple[str, str], ...]:
        text = f" {self.description} " if self.description else " "
        return ((self.display, _KEY_STYLE if self.enabled else _DIM_STYLE), (text, _TEXT_STYLE))


class KeyBar(Widget):
    """One line of active keys; a click presses a key.

    Textual's footer is noticeably slow: it creates a widget per key at every change of focus.
    """

    def __init__(self) -> None:
        super().__init__()
        # The displayed keys with their first columns.
        self._items: list[tuple[int, _Item]] = []

    def on_mount(self) -> None:
        """Follow changes of the active keys."""
        self.screen.bindings_updated_signal.subscribe(self, self._refresh_keys)

    def _refresh_keys(self, screen: Screen[object]) -> None:
        if screen is self.screen and screen.app.app_focus:
            self.refresh()

    def render(self) -> Content:
        """Essential keys, keys of the focused widget, others that fit, and the palette's key."""
        active_bindings = self.screen.active_bindings
        palette_binding = active_bindings.get(self.app.COMMAND_PALETTE_BINDING)
        palette_items = [] if palette_binding is None else next(self._groups([palette_binding]))
        bindings = [active for active in active_bindings.values() if active.binding.show]
        bindings.sort(key=self._rank)
        # The essential keys, and those of the focused widget.
        first_bindings = [active for active in bindings if self._rank(active) <= _FOCUSED_RANK]
        first_width = sum(map(_width, self._groups(first_bindings)))
        if first_width + _width(palette_items) > self.size.width:
            palette_items = [replace(item, description="") for item in palette_items]
        width = self.size.width - _width(palette_items)
        items: list[_Item] = []
        for group in self._groups(bindings):
            if _width(items) + _width(group) > width:
                break
            items += group
        blank_count = max(width - _width(items), 0)
        ends = accumulate(item.width for item in items)
        self._items = [(end - item.width, item) for end, item in zip(ends, items, strict=True)]
        self._items += [(width, item) for item in palette_items]
        return Content.assemble(
            *(part for item in items for part in item.parts),
            " " * blank_count,
            *(part for item in palette_items for part in item.parts),
        )

    def _rank(self, active: ActiveBinding) -> int:
        # Order of keys: essential ones, those of the focused widget, those of screen and app.
        if active.binding.id in _ESSENTIAL_IDS:
            return _ESSENTIAL_IDS.index(active.binding.id)
        return _SCREEN_RANK if active.node in (self.screen, self.app) else _FOCUSED_RANK

    def _groups(self, bindings: Iterable[ActiveBinding]) -> Iterator[list[_Item]]:
        # Yield the first key of every action, grouped as in the bindings.
        by_action: dict[str, ActiveBinding] = {}
        for active in bindings:
            by_action.setdefault(active.binding.action, active)
        for group, members in groupby(by_action.values(), key=lambda active: active.binding.group):
            items = [
                _Item(binding.key, self.app.get_key_display(binding), binding.description, enabled)
                for _, binding, enabled, _ in members
            ]
            if group is None:
                yield from ([item] for item in items)
            else:
                descriptions = [""] * (len(items) - 1) + [group.description]
                yield [
                    replace(item, description=description)
                    for item, description in zip(items, descriptions, strict=True)
                ]

    def on_click(self, event: Click) -> None:
        """Press the clicked key."""
        for column, item in self._items:
            if column <= event.x < column + item.width:
                if item.enabled:
                    self.app.simulate_key(item.key)
                else:
                    self.app.bell()


def _width(items: Iterable[_Item]) -> int:
    return sum(item.width for item in items)
