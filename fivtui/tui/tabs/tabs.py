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
    import_pane_class : callable
        Function that imports and returns the class of the pane.
    """

    id: str
    title: str
    key: str
    import_pane_class: Callable[[], type[Pane]]

    def new_pane(self, session: Session) -> Pane:
        """A new pane for a session."""
        return self.import_pane_class()(session)


def _importer(module: str, name: str) -> Callable[[], type[Pane]]:
    def import_class() -> type[Pane]:
        return cast("type[Pane]", getattr(import_module(f".{module}", __package__), name))

    return import_class


TABS: Final = (
    TabSpec("stability", "Stability", "alt+1", _importer("stability", "StabilityPane")),
    TabSpec("transient", "Transient", "alt+2", _importer("transient", "TransientPane")),
    TabSpec("sweep", "Sweep", "alt+3", _importer("studies.sweep", "SweepPane")),
    TabSpec("map", "Map", "alt+4", _importer("studies.map", "MapPane")),
    TabSpec("trade-off", "Trade-off", "alt+5", _importer("studies.tradeoff", "TradeoffPane")),
    TabSpec("paper", "Paper", "alt+6", _importer("paper", "PaperPane")),
    TabSpec("uncertainty", "Risk", "alt+7", _importer("studies.uncertainty", "UncertaintyPane")),
    TabSpec("result", "Result", "alt+8", _importer("result", "ResultPane")),
    TabSpec("log", "Log", "alt+9", _importer("log", "LogPane")),
    TabSpec("branch", "Branches", "alt+0", _importer("studies.branches", "BranchesPane")),
)
