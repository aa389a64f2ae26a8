"""What every tab has in common."""

from textual.containers import Vertical

from .runs import Run
from .session import Session


class Pane(Vertical):
    """The contents of a tab; made when the tab is shown for the first time.

    The screen calls the methods below for the tab in sight alone, and all of them when a tab comes
    into sight: whatever a pane shows it derives from the session then.

    Parameters
    ----------
    session : Session
        The state of the laboratory; panes read it, and post messages to change it.
    """

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session

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

    def reported(self) -> None:
        """Something was appended to `session.reports`."""

    def theme_changed(self) -> None:
        """The theme has other colours: draw anew what the style sheets do not colour."""
