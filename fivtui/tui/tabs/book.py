"""The tab bar with its panes, created when first shown."""

from collections.abc import Callable, Sequence
from typing import Final

from textual import on
from textual.app import ComposeResult
from textual.content import Content
from textual.widgets import ContentSwitcher, TabbedContent, TabPane, Tabs
from textual.widgets._tabbed_content import ContentTabs

from fivtui.tui.session import Session

from .pane import Pane
from .tabs import TabSpec

# Columns at the ends of the border, and columns around every title.
_CORNERS: Final = 4
_PADDING: Final = 2
_MORE: Final = ("‹ ", " ›")


def titles_in(titles: Sequence[str], current: int, room: int) -> list[str]:
    """The titles that fit around the current one; "" for hidden titles, which arrows indicate."""

    def labels(start_tab: int, end_tab: int) -> list[str]:
        before = _MORE[0] * (start_tab > 0)
        after = _MORE[1] * (end_tab < len(titles) - 1)
        shown = [""] * len(titles)
        for index in range(start_tab, end_tab + 1):
            start, end = before * (index == start_tab), after * (index == end_tab)
            shown[index] = f"{start}{titles[index]}{end}"
        return shown

    start_tab = end_tab = current
    while True:
        wider = [(start_tab, end_tab + 1)] * (end_tab + 1 < len(titles)) + [
            (start_tab - 1, end_tab)
        ] * (start_tab > 0)
        fits = next((pair for pair in wider if _columns(labels(*pair)) <= room), None)
        if fits is None:
            return labels(start_tab, end_tab)
        start_tab, end_tab = fits


def _columns(labels: Sequence[str]) -> int:
    return sum(len(label) + _PADDING for label in labels if label)


class TabBook(TabbedContent):
    """The tabs of the laboratory, from left to right."""

    def __init__(self, tabs: Sequence[TabSpec], session: Session) -> None:
        exists = any(spec.id == session.tab for spec in tabs)
        super().__init__(initial=session.tab if exists else "", id="tabs")
        self.specs = tuple(tabs)
        self._session = session
        self._created: dict[str, Pane] = {}
        self._refocus = False
        self._waiting: list[Callable[[Pane], None]] = []

    def on_resize(self) -> None:
        """Show as many titles as fit."""
        self._fit_titles()

    def _fit_titles(self) -> None:
        titles = [spec.title for spec in self.specs]
        current = next((n for n, spec in enumerate(self.specs) if spec.id == self.active), 0)
        room = self.size.width - _CORNERS
        shown = titles_in(titles, current, room)
        for spec, title in zip(self.specs, shown, strict=True):
            tab = self.get_tab(spec.id)
            tab.display = bool(title)
            if title and tab.label_text != title:
                tab.label = Content(title)
        self.query_one(ContentTabs).styles.width = min(_columns(shown), room)

    def compose(self) -> ComposeResult:
        """The tabs, still empty."""
        for spec in self.specs:
            self.compose_add_child(TabPane(spec.title, id=spec.id))
        yield from super().compose()

    @property
    def pane(self) -> Pane | None:
        """The current pane, None before it is created."""
        return self._created.get(self.active)

    def update_pane(self, function: Callable[[Pane], None]) -> None:
        """Call a function with the current pane if it exists; hidden panes update when shown."""
        pane = self.pane
        if pane is not None and pane.is_mounted:
            function(pane)

    def when_ready(self, function: Callable[[Pane], None]) -> None:
        """Call a function with the current pane as soon as it exists."""
        self._waiting.append(function)
        self._call_waiting()

    def _call_waiting(self) -> None:
        pane = self.pane
        if pane is not None and pane.is_mounted:
            waiting, self._waiting = self._waiting, []
            for function in waiting:
                function(pane)

    def take_focus(self) -> None:
        """Focus the titles."""
        self.query_one(Tabs).focus()

    def turn(self, direction: int) -> None:
        """Show the next (+1) or previous (-1) tab."""
        names = [spec.id for spec in self.specs]
        self.show(names[(names.index(self.active) + direction) % len(names)])

    def show(self, name: str) -> None:
        """Show a tab by its identifier; focus inside the current tab moves to it."""
        focused = self.screen.focused
        if name != self.active and focused is not None and self in focused.ancestors:
            # A focus in the hidden tab would switch back to it.
            self.screen.set_focus(None)
            self._refocus = True
        self.active = name

    @on(TabbedContent.TabActivated)
    async def _shown(self) -> None:
        name = self._session.tab = self.active
        self._fit_titles()
        spec = next(spec for spec in self.specs if spec.id == name)
        if name not in self._created:
            self._created[name] = pane = spec.pane(self._session)
            await self.get_pane(name).mount(pane)
        self.query_one(ContentSwitcher).border_subtitle = "  ".join(self._created[name].key_words())
        self.catch_up()
        self._call_waiting()
        if self._refocus and name == self.active:
            self._refocus = False
            self._created[name].take_focus()

    def catch_up(self) -> None:
        """Bring the current pane up to date."""
        self.update_pane(lambda pane: pane.scene_changed())
        self.update_pane(lambda pane: pane.run_changed(self._session.runs.displayed))
        self.update_pane(lambda pane: pane.reported())
