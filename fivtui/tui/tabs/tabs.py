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
        Identifier, also in messages and commands.
    title : str
        Title.
    key : str
        Key that shows it.
    kind : callable
        The class of its pane; imports its module when called.
    """

    id: str
    title: str
    key: str
    kind: Callable[[], type[Pane]]

    def pane(self, session: Session) -> Pane:
        """A new pane for a session."""
        return self.kind()(session)


def _of(module: str, name: str) -> Callable[[], type[Pane]]:
    def kind() -> type[Pane]:
        return cast("type[Pane]", getattr(import_module(f".{module}", __package__), name))

    return kind


TABS: Final = (
    TabSpec("stability", "Stability", "alt+1", _of("stability", "StabilityPane")),
    TabSpec("transient", "Transient", "alt+2", _of("transient", "TransientPane")),
    TabSpec("sweep", "Sweep", "alt+3", _of("studies.sweep", "SweepPane")),
    TabSpec("map", "Map", "alt+4", _of("studies.map", "MapPane")),
    TabSpec("trade-off", "Trade-off", "alt+5", _of("studies.tradeoff", "TradeoffPane")),
    TabSpec("paper", "Paper", "alt+6", _of("paper", "PaperPane")),
    TabSpec("uncertainty", "Risk", "alt+7", _of("studies.uncertainty", "UncertaintyPane")),
    TabSpec("result", "Result", "alt+8", _of("result", "ResultPane")),
    TabSpec("log", "Log", "alt+9", _of("log", "LogPane")),
    TabSpec("branch", "Branches", "alt+0", _of("studies.branches", "BranchesPane")),
)
