"""The Textual application."""

from collections.abc import Callable
from pathlib import Path, PurePath
from typing import ClassVar

from textual.app import App
from textual.binding import Binding, BindingType
from textual.command import Provider

from fivtui.scene import Scene

from .lab import LabScreen
from .session import Session

_STYLES = Path(__file__).parent / "styles"


def _commands() -> type[Provider]:
    from .commands import LabCommands

    return LabCommands


class FivtuiApp(App[None]):
    """The terminal laboratory.

    Parameters
    ----------
    scene : Scene, optional
        The scene to begin with; the base scene if not given.
    source : str
        How the command line names it; empty if it does not.
    """

    TITLE = "fivtui"
    CSS_PATH: ClassVar[list[str | PurePath]] = [
        _STYLES / "lab.tcss",
        _STYLES / "charts.tcss",
        _STYLES / "dialogs.tcss",
    ]
    COMMANDS: ClassVar[set[type[Provider] | Callable[[], type[Provider]]]] = {_commands}
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+q", "quit", "Quit", show=True, priority=True),
    ]
    HORIZONTAL_BREAKPOINTS = [  # noqa: RUF012 (the base class says so)
        (0, "-narrow"),
        (80, "-regular"),
        (140, "-wide"),
    ]
    VERTICAL_BREAKPOINTS = [  # noqa: RUF012 (the base class says so)
        (0, "-tiny"),
        (16, "-low"),
        (24, "-short"),
        (36, "-tall"),
    ]

    def __init__(self, scene: Scene | None = None, source: str = "") -> None:
        super().__init__()
        self.session = Session(scene, source)

    def get_default_screen(self) -> LabScreen:
        """The laboratory is the screen under all others."""
        return LabScreen(self.session)


def run(scene: Scene | None = None, source: str = "") -> None:
    """Run the terminal UI until the user quits.

    Parameters
    ----------
    scene : Scene, optional
        The scene to begin with; the base scene if not given.
    source : str
        How the command line names it, a preset or a file; empty if it does not.
    """
    FivtuiApp(scene, source).run()
