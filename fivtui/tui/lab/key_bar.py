"""The key bar in the last line of the screen: the active keys and what they do."""

from textual.binding import ActiveBinding
from textual.content import Content
from textual.events import Click
from textual.screen import Screen
from textual.style import Style
from textual.widget import Widget

from .keys import KEY_IDS


class KeyBar(Widget):
    """One line of active keys; a click presses a key.

    Textual's footer is noticeably slow: it creates a widget per key at every change of focus.
    """

    def on_mount(self) -> None:
        """Follow changes of the active keys."""
        self.screen.bindings_updated_signal.subscribe(self, self._refresh_keys)

    def _refresh_keys(self, screen: Screen[object]) -> None:
        if screen is self.screen and screen.app.app_focus:
            self.refresh()

    def render(self) -> Content:
        """Keys that always work, those of the focused widget that fit, and the palette's key."""
        active_bindings = self.screen.active_bindings
        palette = active_bindings.get(self.app.COMMAND_PALETTE_BINDING)
        palette_key = Content("") if palette is None else self._key(palette)
        # The first key of every action.
        by_action: dict[str, ActiveBinding] = {}
        for active in active_bindings.values():
            if active.binding.show:
                by_action.setdefault(active.binding.action, active)
        line, width = Content(""), self.size.width - palette_key.cell_length
        for active in sorted(by_action.values(), key=self._rank):
            key = self._key(active)
            if line.cell_length + key.cell_length > width:
                break
            line += key
        return line.pad_right(max(width - line.cell_length, 0)) + palette_key

    def _rank(self, active: ActiveBinding) -> tuple[bool, int]:
        # Keys of screen and app come first, in the order of `KEY_IDS` also if they are configured.
        is_of_widget = active.node not in (self.screen, self.app)
        name = str(active.binding.id)
        return is_of_widget, KEY_IDS.index(name) if name in KEY_IDS else len(KEY_IDS)

    def _key(self, active: ActiveBinding) -> Content:
        binding = active.binding
        key = Content.assemble(
            (self.app.get_key_display(binding), "bold $footer-key-foreground"),
            (f" {binding.description} ", "$footer-description-foreground"),
        )
        return key.stylize(Style.from_meta({"key": binding.key}))

    def on_click(self, event: Click) -> None:
        """Press the clicked key."""
        if key := event.style.meta.get("key"):
            self.app.simulate_key(key)
