"""The tabs, as data: a tab more is a pane and a line here."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Final, cast

from .pane import Pane
from .session import Session


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
        Takes the session, makes the contents. The module of a pane is imported by it, when the tab
        is first shown.
    """

    id: str
    title: str
    key: str
    pane: Callable[[Session], Pane]


def _of(module: str, name: str) -> Callable[[Session], Pane]:
    def make(session: Session) -> Pane:
        return cast("Pane", getattr(import_module(f".{module}", __package__), name)(session))

    return make


TABS: Final = (
    TabSpec("stability", "Stability", "alt+1", _of("stability_pane", "StabilityPane")),
    TabSpec("transient", "Transient", "alt+2", _of("transient_pane", "TransientPane")),
    TabSpec("sweep", "Sweep", "alt+3", _of("sweep_pane", "SweepPane")),
    TabSpec("map", "Map", "alt+4", _of("map_pane", "MapPane")),
    TabSpec("trade-off", "Trade-off", "alt+5", _of("tradeoff_pane", "TradeoffPane")),
    TabSpec("paper", "Paper", "alt+6", _of("paper_pane", "PaperPane")),
    TabSpec("result", "Result", "alt+8", _of("result_pane", "ResultPane")),
    TabSpec("log", "Log", "alt+9", _of("log_pane", "LogPane")),
)
