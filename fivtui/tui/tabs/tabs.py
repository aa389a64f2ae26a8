"""The registry of tabs: a new tab is a pane and a line in `TABS`."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Final, cast

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
    pane_class : callable
        Function that imports and returns the class of the pane.
    """

    id: str
    title: str
    key: str
    pane_class: Callable[[], type[Pane]]

    def new_pane(self, session: Session) -> Pane:
        """A new pane for a session."""
        return self.pane_class()(session)


def _pane_class(module: str, name: str) -> Callable[[], type[Pane]]:
    def import_class() -> type[Pane]:
        return cast("type[Pane]", getattr(import_module(f".{module}", __package__), name))

    return import_class


TABS: Final = (
    TabSpec("stability", "Stability", "alt+1", _pane_class("stability", "StabilityPane")),
    TabSpec("transient", "Transient", "alt+2", _pane_class("transient", "TransientPane")),
    TabSpec("sweep", "Sweep", "alt+3", _pane_class("studies.sweep", "SweepPane")),
    TabSpec("map", "Map", "alt+4", _pane_class("studies.map", "MapPane")),
    TabSpec("trade-off", "Trade-off", "alt+5", _pane_class("studies.tradeoff", "TradeoffPane")),
    TabSpec("paper", "Paper", "alt+6", _pane_class("paper", "PaperPane")),
    TabSpec("uncertainty", "Risk", "alt+7", _pane_class("studies.uncertainty", "UncertaintyPane")),
    TabSpec("result", "Result", "alt+8", _pane_class("result", "ResultPane")),
    TabSpec("log", "Log", "alt+9", _pane_class("log", "LogPane")),
    TabSpec("branch", "Branches", "alt+0", _pane_class("studies.branches", "BranchesPane")),
)
