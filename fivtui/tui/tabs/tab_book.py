"""The registry of tabs, and the tab bar with the panes, which are created when first shown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Final, cast

from textual import on
from textual.app import ComposeResult
from textual.content import Content
from textual.widgets import ContentSwitcher, TabbedContent, TabPane, Tabs
from textual.widgets._tabbed_content import ContentTabs

from fivtui.tui.session import Session

from .pane import Pane


@dataclass(frozen=True, slots=True)
class TabSpec:
    """A tab.

    Attributes
    ----------
    id : str
        Identifier of the tab, also in messages and commands.
    title : str
        Title in the tab bar.
    key : str
        Key that shows the tab.
    module, class_name : str
        Module in `fivtui.tui.tabs` and class of the pane; imported when the tab is first shown.
    """

    id: str
    title: str
    key: str
    module: str
    class_name: str

    def import_pane_class(self) -> type[Pane]:
        """Import the class of the pane."""
        module = import_module(f".{self.module}", __package__)
        return cast("type[Pane]", getattr(module, self.class_name))

    def new_pane(self, session: Session) -> Pane:
        """Create the pane for a session."""
        return self.import_pane_class()(session)


TABS: Final = (
    TabSpec("stability", "Stability", "alt+1", "stability", "StabilityPane"),
    TabSpec("transient", "Transient", "alt+2", "transient", "TransientPane"),
    TabSpec("sweep", "Sweep", "alt+3", "studies.sweep", "SweepPane"),
    TabSpec("map", "Map", "alt+4", "studies.map", "MapPane"),
    TabSpec("trade-off", "Trade-off", "alt+5", "studies.tradeoff", "TradeoffPane"),
    TabSpec("paper", "Paper", "alt+6", "paper", "PaperPane"),
    TabSpec("uncertainty", "Risk", "alt+7", "studies.uncertainty", "UncertaintyPane"),
    TabSpec("result", "Result", "alt+8", "result", "ResultPane"),
    TabSpec("log", "Log", "alt+9", "log", "LogPane"),
    TabSpec("branch", "Branch", "alt+0", "studies.branches", "BranchesPane"),
    TabSpec("identification", "Fit", "alt+minus", "studies.identification", "IdentificationPane"),
)

# Columns of the border at both ends of the titles, and of the blanks around a title.
_CORNER_COLUMNS: Final = 4
_TITLE_PADDING: Final = 2
# Before and after the titles, where further tabs are hidden.
_ARROWS: Final = ("‹ ", " ›")


def fitting_titles(titles: Sequence[str], current: int, width: int) -> list[str]:
    """The titles that fit beside the current one; "" for hidden titles, which arrows indicate."""
    last_tab = len(titles) - 1

    def labels(start: int, end: int) -> list[str]:
        # The titles of the tabs with indices from `start` to `end`, with arrows.
        shown_titles = [""] * start + list(titles[start : end + 1]) + [""] * (last_tab - end)
        if start > 0:
            shown_titles[start] = f"{_ARROWS[0]}{shown_titles[start]}"
        if end < last_tab:
            shown_titles[end] = f"{shown_titles[end]}{_ARROWS[1]}"
        return shown_titles

    start = end = current
    while True:
        # Add the next tab if it fits, or else the previous one.
        if end < last_tab and _total_width(labels(start, end + 1)) <= width:
            end += 1
        elif start > 0 and _total_width(labels(start - 1, end)) <= width:
            start -= 1
        else:
            return labels(start, end)


def _total_width(labels: Sequence[str]) -> int:
    return sum(len(label) + _TITLE_PADDING for label in labels if label)


class TabBook(TabbedContent):
    """The tabs of the laboratory, with a pane each."""

    def __init__(self, tabs: Sequence[TabSpec], session: Session) -> None:
        is_known = any(spec.id == session.tab for spec in tabs)
        super().__init__(initial=session.tab if is_known else "", id="tabs")
        self.specs = tuple(tabs)
        self._session = session
        # The created panes, by the identifiers of their tabs.
        self._created: dict[str, Pane] = {}
        # Whether the focus is to move to the tab that is being shown.
        self._moves_focus = False
        # Functions to call when the current pane exists.
        self._ready_callbacks: list[Callable[[Pane], None]] = []

    def on_resize(self) -> None:
        """Show as many titles as fit."""
        self._fit_titles()

    def _fit_titles(self) -> None:
        titles, ids = [spec.title for spec in self.specs], [spec.id for spec in self.specs]
        current = ids.index(self.active) if self.active in ids else 0
        width = self.size.width - _CORNER_COLUMNS
        fitting = fitting_titles(titles, current, width)
        for spec, title in zip(self.specs, fitting, strict=True):
            tab = self.get_tab(spec.id)
            tab.display = bool(title)
            if title and tab.label_text != title:
                tab.label = Content(title)
        self.query_one(ContentTabs).styles.width = min(_total_width(fitting), width)

    def compose(self) -> ComposeResult:
        """The tabs, still empty."""
        for spec in self.specs:
            self.compose_add_child(TabPane(spec.title, id=spec.id))
        yield from super().compose()

    @property
    def pane(self) -> Pane | None:
        """The pane of the current tab; None before it is created."""
        return self._created.get(self.active)

    def update_pane(self, function: Callable[[Pane], None]) -> None:
        """Call a function with the current pane if it exists; other panes update when shown."""
        pane = self.pane
        if pane is not None and pane.is_mounted:
            function(pane)

    def when_ready(self, function: Callable[[Pane], None]) -> None:
        """Call a function with the current pane as soon as it exists."""
        self._ready_callbacks.append(function)
        self._call_ready_callbacks()

    def _call_ready_callbacks(self) -> None:
        pane = self.pane
        if pane is not None and pane.is_mounted:
            callbacks, self._ready_callbacks = self._ready_callbacks, []
            for function in callbacks:
                function(pane)

    def focus_titles(self) -> None:
        """Focus the titles of the tabs."""
        self.query_one(Tabs).focus()

    def show_neighbour(self, direction: int) -> None:
        """Show the next (+1) or previous (-1) tab."""
        names = [spec.id for spec in self.specs]
        self.show(names[(names.index(self.active) + direction) % len(names)])

    def show(self, name: str) -> None:
        """Show a tab by its identifier; focus inside the current tab moves to it."""
        focused = self.screen.focused
        if name != self.active and focused is not None and self in focused.ancestors:
            # If the focus remained in the hidden tab, Textual would switch back to it.
            self.screen.set_focus(None)
            self._moves_focus = True
        self.active = name

    @on(TabbedContent.TabActivated)
    async def _show_active_pane(self) -> None:
        name = self._session.tab = self.active
        self._fit_titles()
        spec = next(spec for spec in self.specs if spec.id == name)
        if name not in self._created:
            self._created[name] = pane = spec.new_pane(self._session)
            await self.get_pane(name).mount(pane)
        self.query_one(ContentSwitcher).border_subtitle = "  ".join(self._created[name].key_hints())
        self.update_pane_from_session()
        self._call_ready_callbacks()
        if self._moves_focus and name == self.active:
            self._moves_focus = False
            self._created[name].focus_content()

    def update_pane_from_session(self) -> None:
        """Update the current pane from the session."""
        self.update_pane(lambda pane: pane.scene_changed())
        self.update_pane(lambda pane: pane.run_changed(self._session.runs.displayed))
        self.update_pane(lambda pane: pane.report_added())
