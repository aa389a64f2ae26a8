"""The line of tabs: their titles by group over the whole width of the screen."""

from collections.abc import Mapping
from itertools import groupby
from typing import ClassVar, Final

from textual.binding import Binding, BindingType
from textual.content import Content
from textual.reactive import reactive
from textual.style import Style
from textual.widget import Widget

from .tab_book import TABS, TabSpec

# What the line shows, from the widest to the narrowest, and the blanks between titles.
_TITLES, _KEYS, _MODIFIER, _GROUPS = "titles", "keys", "modifier", "groups"
_VARIANTS: Final = (
    ({_TITLES, _KEYS, _MODIFIER, _GROUPS}, 2),
    ({_TITLES, _KEYS, _MODIFIER, _GROUPS}, 1),
    ({_TITLES, _KEYS, _MODIFIER}, 1),
    ({_TITLES, _KEYS}, 1),
    ({_TITLES, _MODIFIER}, 1),
    ({_TITLES}, 1),
    ({_KEYS, _MODIFIER}, 1),
    ({_KEYS}, 1),
)
_KEY_STYLE: Final = "$foreground 60%"


class TabLine(Widget, can_focus=True):
    """The titles of the tabs; a click or the arrow keys show a tab.

    `progress` is that of a run, displayed beside the title of the first tab. `key_names` has the
    displayed keys by identifier.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("left,h", "screen.switch_tab(-1)", "Previous tab", show=False),
        Binding("right,l", "screen.switch_tab(1)", "Next tab", show=False),
        Binding("down,j,enter", "screen.focus_part('plot')", "Into the tab", show=False),
    ]
    active = reactive("")
    progress = reactive("")

    def __init__(self, key_names: Mapping[str, str]) -> None:
        super().__init__(id="tab-line")
        self._keys = {spec: key_names[f"tab-{spec.id}"] for spec in TABS}
        # The modifier that the keys of all tabs share, such as "Alt+"; else empty.
        modifiers = {key[: -len(key.rpartition("+")[2])] for key in self._keys.values()}
        self._modifier = modifiers.pop() if len(modifiers) == 1 else ""

    def render(self) -> Content:
        """All titles, with their keys and the names of groups if they fit."""
        lines = [self._line(*variant) for variant in _VARIANTS]
        return next((line for line in lines if line.cell_length <= self.size.width), lines[-1])

    def _line(self, parts: set[str], blank_count: int) -> Content:
        blanks, active_span = " " * blank_count, (0, 0)
        line = Content(" ")
        if _MODIFIER in parts and self._modifier:
            # Without the keys of all tabs, the first one stands for them.
            first = "" if _KEYS in parts else f"{self._sign(TABS[0])}… "
            line += Content.styled(f"{self._modifier}{first}", _KEY_STYLE)
        for index, (group, specs) in enumerate(groupby(TABS, key=lambda spec: spec.group)):
            if index > 0:
                line += Content.styled("│", "$foreground 30%") + blanks
            if _GROUPS in parts and group:
                line += Content.styled(group, "$foreground 60% italic") + blanks
            for spec in specs:
                title = self._title(spec, parts)
                if spec.id == self.active:
                    # One blank at least separates the active title from its neighbours.
                    margin = blank_count - 1
                    active_span = len(line) - margin, len(line) + len(title) + margin
                line += title + blanks
        style = "bold reverse $text-accent" if self.has_focus else "bold reverse"
        return line.stylize(style, *active_span)

    def _sign(self, spec: TabSpec) -> str:
        return self._keys[spec].removeprefix(self._modifier)

    def _title(self, spec: TabSpec, parts: set[str]) -> Content:
        sign = self._sign(spec) if _KEYS in parts else ""
        title = spec.title if _TITLES in parts or spec.id == self.active else ""
        if title and self.progress and spec is TABS[0]:
            title = f"{title} {self.progress}"
        content = Content.assemble((sign, _KEY_STYLE), " " if sign and title else "", title)
        return content.stylize(Style.from_meta({"@click": f"screen.show_tab('{spec.id}')"}))
