"""The base class of tabs."""

from itertools import takewhile
from typing import ClassVar, Final

from textual.containers import Vertical
from textual.widget import Widget
from textual.widgets import Button, Input

from fivtui.tui.session import Run, Session, study_command

from .export import Export, run_export

# Prefixes of actions that change only what a tab displays.
_DISPLAY_ACTIONS: Final = ("next_", "show_")


class Pane(Vertical):
    """The contents of a tab, created when the tab is first shown.

    The screen tells only the pane of the current tab what has changed. Panes read the session, and
    post messages to change it.
    """

    # Key of the tab's stored settings.
    NAME: ClassVar[str] = ""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session

    def stored_setting(self, key: str, default: str) -> str:
        """A stored setting of this tab."""
        return self.session.settings.get(self.NAME, {}).get(key, default)

    def store_setting(self, key: str, value: str) -> None:
        """Store a setting of this tab."""
        self.session.settings.setdefault(self.NAME, {})[key] = value

    def focus_content(self, container: Widget | None = None, *, bar_first: bool = False) -> None:
        """Focus the plot or list, else a button, else an input; the reverse if `bar_first`."""

        def rank(widget: Widget) -> int:
            return 2 if isinstance(widget, Input) else int(isinstance(widget, Button))

        def is_shown(widget: Widget) -> bool:
            # Charts that style sheets hide until their first result are focused already before.
            nodes = takewhile(lambda node: node is not self, widget.ancestors_with_self)
            return all(node.styles.inline.display != "none" for node in nodes)

        container = container or self
        widgets = [container, *container.query("*")]
        focusable = [widget for widget in widgets if widget.focusable and is_shown(widget)]
        focusable.sort(key=rank, reverse=bar_first)
        self.screen.set_focus(focusable[0] if focusable else None)

    async def run_key(self, key: str) -> None:
        """Run the action of a key of this tab if it changes only what is displayed."""
        for binding in self._bindings.key_to_bindings.get(key, ()):
            if binding.action.startswith(_DISPLAY_ACTIONS):
                await self.run_action(binding.action)

    def key_hints(self) -> list[str]:
        """Keys of the tab with their effects, displayed in the border."""
        return [f"{self.session.key_names[kind]} {kind}" for kind in ("figure", "data")]

    def scene_changed(self) -> None:
        """Called when a field was edited or a scene loaded; must be fast: called on every key."""

    def run_changed(self, run: Run | None) -> None:
        """Called when the set of displayed and overlaid runs has changed.

        `session.runs.plotted` has all runs to plot, the displayed one last.
        """

    def status_changed(self) -> None:
        """Called when the state of the newest run or of the live curve has changed."""

    def run_progressed(self, run: Run) -> None:
        """Called about ten times a second with the run being computed."""

    def export(self, kind: str) -> Export:
        """Figure or data of the contents, by default of the displayed run; `InputError` if none."""
        return run_export(kind, self.session.runs.displayed)

    def command_line(self) -> str:
        """The shell command that computes the contents; `InputError` if none does."""
        run = self.session.runs.displayed
        scene = self.session.scene() if run is None else run.scene
        return study_command("run", scene, self.session)

    def report_added(self) -> None:
        """Called when `session.reports` has a new message."""
