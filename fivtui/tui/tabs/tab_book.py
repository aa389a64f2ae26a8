"""The registry of tabs, and their panes, which are created when first shown."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Final, cast

from textual import on
from textual.message import Message
from textual.widgets import ContentSwitcher

from fivtui.tui.session import Session

from .pane import Pane


@dataclass(frozen=True, slots=True)
class TabSpec:
    """A tab: its identifier, also in saved sessions; its title, group of neighbours and key.

    `pane` is the module in `fivtui.tui.tabs` and the class of its pane.
    """

    id: str
    title: str
    group: str
    key: str
    pane: str

    def import_pane_class(self) -> type[Pane]:
        """Import the class of the pane, when the tab is first shown."""
        module, _, name = self.pane.partition(":")
        return cast("type[Pane]", getattr(import_module(f".{module}", __package__), name))


TABS: Final = (
    TabSpec("transient", "Run", "", "alt+1", "transient:TransientPane"),
    TabSpec("stability", "Modes", "Stability", "alt+2", "stability:StabilityPane"),
    TabSpec("map", "Map", "Stability", "alt+3", "studies.map:MapPane"),
    TabSpec("branch", "Branches", "Stability", "alt+4", "studies.branches:BranchesPane"),
    TabSpec("safe-mu", "Safe μ", "Stability", "alt+5", "studies.map:SafeFrictionPane"),
    TabSpec("sweep", "Sweep", "Studies", "alt+6", "studies.sweep:SweepPane"),
    TabSpec("uncertainty", "Risk", "Studies", "alt+7", "studies.uncertainty:UncertaintyPane"),
    TabSpec("trade-off", "Trade-off", "Studies", "alt+8", "studies.tradeoff:TradeoffPane"),
    TabSpec(
        "identification", "Fit", "Studies", "alt+9", "studies.identification:IdentificationPane"
    ),
    TabSpec("paper", "Paper", "", "alt+0", "paper:PaperPane"),
    TabSpec("log", "Log", "", "alt+minus", "log:LogPane"),
)
_PREFIX: Final = "tab-"


class TabBook(ContentSwitcher):
    """The panes of the tabs, of which one is visible."""

    class Changed(Message):
        """Another tab is shown."""

    def __init__(self, session: Session) -> None:
        super().__init__(id="tabs")
        self._specs = {spec.id: spec for spec in TABS}
        self._session = session
        if session.tab not in self._specs:
            session.tab = TABS[0].id
        # The created panes, by the identifiers of their tabs.
        self._created: dict[str, Pane] = {}
        # Whether the focus is to move to the tab that is being shown.
        self._moves_focus = False
        # Functions to call when the current pane exists.
        self._ready_callbacks: list[Callable[[Pane], None]] = []

    def on_mount(self) -> None:
        """Show the tab of the session."""
        self.post_message(self.Changed())

    @property
    def pane(self) -> Pane | None:
        """The pane of the current tab; None before it is created."""
        return self._created.get(self._session.tab)

    def update_pane(self, function: Callable[[Pane], None]) -> None:
        """Call a function with the current pane if it exists; other panes update when shown."""
        pane = self.pane
        if pane is not None and pane.is_mounted:
            # Messages that the pane posts would end at this widget if they were sent in its name.
            with pane._context():
                function(pane)

    def when_ready(self, function: Callable[[Pane], None]) -> None:
        """Call a function with the current pane as soon as it exists."""
        self._ready_callbacks.append(function)
        self.update_pane(self._call_ready_callbacks)

    def _call_ready_callbacks(self, pane: Pane) -> None:
        callbacks, self._ready_callbacks = self._ready_callbacks, []
        for function in callbacks:
            function(pane)

    def show_neighbour(self, direction: int) -> None:
        """Show the next (+1) or previous (-1) tab."""
        names = list(self._specs)
        self.show(names[(names.index(self._session.tab) + direction) % len(names)])

    def show(self, name: str) -> None:
        """Show a tab by its identifier; focus inside the current tab moves to it."""
        if name == self._session.tab:
            return
        focused = self.screen.focused
        if focused is not None and self in focused.ancestors:
            # A hidden widget would pass the focus on to any other.
            self.screen.set_focus(None)
            self._moves_focus = True
        self._session.tab = name
        self.post_message(self.Changed())

    @on(Changed)
    async def _show_active_pane(self) -> None:
        name = self._session.tab
        if name not in self._created:
            pane = self._created[name] = self._specs[name].import_pane_class()(self._session)
            pane.border_subtitle = "  ".join(pane.key_hints())
            await self.add_content(pane, id=f"{_PREFIX}{name}")
        self.current = f"{_PREFIX}{name}"
        self.update_pane_from_session()
        self.update_pane(self._call_ready_callbacks)
        if self._moves_focus and name == self._session.tab:
            self._moves_focus = False
            self._created[name].focus_content()

    def update_pane_from_session(self) -> None:
        """Update the current pane from the session."""
        self.update_pane(lambda pane: pane.scene_changed())
        self.update_pane(lambda pane: pane.run_changed(self._session.runs.displayed))
        self.update_pane(lambda pane: pane.status_changed())
        self.update_pane(lambda pane: pane.report_added())
