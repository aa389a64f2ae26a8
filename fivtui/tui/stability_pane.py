"""The tab of the equilibrium."""

from textual.app import ComposeResult

from fivtui.core.errors import ComputationError, InputError

from .pane import Pane
from .report import stability_rows
from .table import RowsView


class StabilityPane(Pane):
    """All that is known about the equilibrium of what is edited."""

    def compose(self) -> ComposeResult:
        """The rows."""
        yield RowsView(id="stability-rows")

    def scene_changed(self) -> None:
        """Show the equilibrium of what is edited now."""
        view = self.query_one("#stability-rows", RowsView)
        try:
            parameters, found = self.session.parameters(), self.session.stability()
        except (InputError, ComputationError) as error:
            view.show([], str(error))
        else:
            view.show(stability_rows(parameters, found), "")
