"""What every tab has in common."""

from typing import TYPE_CHECKING, ClassVar

from textual.containers import Vertical

from fivtui.tui.session.runs import Run
from fivtui.tui.session.session import Session

if TYPE_CHECKING:
    from .exports import Export


class Pane(Vertical):
    """The contents of a tab; made when the tab is shown for the first time.

    The screen calls the methods below for the tab in sight alone, and all of them when a tab comes
    into sight: whatever a pane shows it derives from the session then.

    Parameters
    ----------
    session : Session
        The state of the laboratory; panes read it, and post messages to change it.

    Attributes
    ----------
    NAME : str
        Under which the settings of the tab are kept.
    """

    NAME: ClassVar[str] = ""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session

    def setting(self, key: str, default: str) -> str:
        """What the tab is set to; kept from one start to the next."""
        return self.session.settings.get(self.NAME, {}).get(key, default)

    def keep(self, key: str, value: str) -> None:
        """Keep what the tab is set to."""
        self.session.settings.setdefault(self.NAME, {})[key] = value

    def scene_changed(self) -> None:
        """A field was edited, or another scene was loaded. Called at every key press: be quick."""

    def run_changed(self, run: Run | None) -> None:
        """Another run is shown, or other runs are drawn beside it.

        Parameters
        ----------
        run : Run or None
            The run that is shown, None before the first result. `session.runs.drawn` has all that
            are to be drawn, this one last, each with a result and a style (`Run.style`).
        """

    def run_progressed(self, run: Run) -> None:
        """A run goes on. Called about ten times a second.

        Parameters
        ----------
        run : Run
            The run that is being computed, not the one shown.
        """

    def work(self) -> bool:
        """Begin what the tab computes when it is asked to, or stop it.

        Returns
        -------
        bool
            Whether there is such a thing.
        """
        return False

    def export(self, what: str) -> "Export":
        """What can be written of what is shown: of the run, where the tab says nothing else.

        Parameters
        ----------
        what : str
            A name in `exports.KINDS`.

        Returns
        -------
        Export
            To be written.

        Raises
        ------
        InputError
            If there is nothing to write yet; it says what to do.
        """
        from .exports import run_export

        return run_export(what, self.session.runs.shown)

    def command_line(self) -> str:
        """The command that computes in a shell what is shown, or would be.

        Returns
        -------
        str
            Quoted for a POSIX shell.

        Raises
        ------
        InputError
            If a field is wrong, or no command can say it.
        """
        from fivtui.tui.session.command_lines import transient_line

        run = self.session.runs.shown
        scene = self.session.scene() if run is None else run.scene
        return transient_line(scene, self.session.origin)

    def reported(self) -> None:
        """Something was appended to `session.reports`."""

    def theme_changed(self) -> None:
        """The theme has other colours: draw anew what the style sheets do not colour."""
