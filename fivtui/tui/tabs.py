"""The tabs, as data: a tab more is a pane and a line here."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from .log_pane import LogPane
from .map_pane import MapPane
from .pane import Pane
from .paper_pane import PaperPane
from .result_pane import ResultPane
from .session import Session
from .stability_pane import StabilityPane
from .sweep_pane import SweepPane
from .tradeoff_pane import TradeoffPane
from .transient_pane import TransientPane


@dataclass(frozen=True, slots=True)
class TabSpec:
    """A tab.

    Attributes
    ----------
    id : str
        Identifier, also in messages and commands.
    title : str
        What stands on it.
    key : str
        Key that shows it.
    pane : callable
        Takes the session, makes the contents. The module of a pane imports what is slow when it is
        needed, not before.
    """

    id: str
    title: str
    key: str
    pane: Callable[[Session], Pane]


TABS: Final = (
    TabSpec("stability", "Stability", "alt+1", StabilityPane),
    TabSpec("transient", "Transient", "alt+2", TransientPane),
    TabSpec("sweep", "Sweep", "alt+3", SweepPane),
    TabSpec("map", "Map", "alt+4", MapPane),
    TabSpec("trade-off", "Trade-off", "alt+5", TradeoffPane),
    TabSpec("paper", "Paper", "alt+6", PaperPane),
    TabSpec("result", "Result", "alt+8", ResultPane),
    TabSpec("log", "Log", "alt+9", LogPane),
)
