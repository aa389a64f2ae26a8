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

# Columns of the border that are not for titles, and of every title around it.
_CORNERS: Final = 4
_PADDING: Final = 2
_MORE: Final = ("‹ ", " ›")


def titles_in(titles: Sequence[str], current: int, room: int) -> list[str]:
    """The titles around the current one that have room; "" for others, which arrows point to."""

    def labels(first: int, last: int) -> list[str]:
        before = _MORE[0] * (first > 0)
        after = _MORE[1] * (last < len(titles) - 1)
        shown = [""] * len(titles)
        for place in range(first, last + 1):
            start, end = before * (place == first), after * (place == last)
            shown[place] = f"{start}{titles[place]}{end}"
        return shown

    first = last = current
    while True:
        wider = [(first, last + 1)] * (last + 1 < len(titles)) + [(first - 1, last)] * (first > 0)
        fits = next((each for each in wider if _columns(labels(*each)) <= room), None)
        if fits is None:
            return labels(first, last)
        first, last = fits


def _columns(labels: Sequence[str]) -> int:
    return sum(len(label) + _PADDING for label in labels if label)


class TabBook(TabbedContent):
    """The tabs of the laboratory, from left to right."""

    def __init__(self, tabs: Sequence[TabSpec], session: Session) -> None:
        known = any(spec.id == session.tab for spec in tabs)
        super().__init__(initial=session.tab if known else "", id="tabs")
        self.specs = tuple(tabs)
        self._session = session
        self._made: dict[str, Pane] = {}
        self._refocus = False
        self._waiting: list[Callable[[Pane], None]] = []

    def on_resize(self) -> None:
        """Show as many titles as have room."""
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
        return self._made.get(self.active)

    def update_pane(self, what: Callable[[Pane], None]) -> None:
        """Call a function with the current pane if it exists; others catch up when shown."""
        pane = self.pane
        if pane is not None and pane.is_mounted:
            what(pane)

    def when_ready(self, what: Callable[[Pane], None]) -> None:
        """Call a function with the current pane as soon as it exists."""
        self._waiting.append(what)
        self._call_waiting()

    def _call_waiting(self) -> None:
        pane = self.pane
        if pane is not None and pane.is_mounted:
            waiting, self._waiting = self._waiting, []
            for what in waiting:
                what(pane)

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
            # Focus left behind would switch back to its tab.
            self.screen.set_focus(None)
            self._refocus = True
        self.active = name

    @on(TabbedContent.TabActivated)
    async def _shown(self) -> None:
        name = self._session.tab = self.active
        self._fit_titles()
        spec = next(spec for spec in self.specs if spec.id == name)
        if name not in self._made:
            self._made[name] = pane = spec.pane(self._session)
            await self.get_pane(name).mount(pane)
        self.query_one(ContentSwitcher).border_subtitle = "  ".join(self._made[name].key_words())
        self.catch_up()
        self._call_waiting()
        if self._refocus and name == self.active:
            self._refocus = False
            self._made[name].take_focus()

    def catch_up(self) -> None:
        """Bring the current pane up to date."""
        self.update_pane(lambda pane: pane.scene_changed())
        self.update_pane(lambda pane: pane.run_changed(self._session.runs.displayed))
        self.update_pane(lambda pane: pane.reported())
