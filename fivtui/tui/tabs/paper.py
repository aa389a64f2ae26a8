"""The paper tab: the paper's figures and claims, computed on request.

The paper is "Nonlinear friction-induced vibration of a slider-belt system". A claim is a statement
of it; its verdict says whether the model confirms it. Figures are named by their keys in `PANELS`:
``2a`` is a panel of the figure with the number 2.
"""

from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import DataTable, Static

from fivtui.model import Cancelled, InputError
from fivtui.paper import PANELS
from fivtui.studies import study
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session, study_command

from .exports.export import DATA, FIGURE, Export, study_export, with_displayed_charts
from .job_pane import JobPane
from .messages import RunRequested, SceneLoaded
from .tables import ListTable

if TYPE_CHECKING:
    from fivtui.paper import CheckedClaim, ComputedPanel, FigureData, PaperResults


# Key of the stored figure, and kind of study of the verdicts.
_FIGURE_SETTING: Final = "figure"
_CLAIMS_STUDY: Final = "claims"


class _PaperTable(ListTable[str]):
    BINDINGS: ClassVar[list[BindingType]] = [Binding("enter", "select_cursor", "Show")]


class _FigureTable(_PaperTable):
    wrapped_column, omitted_if_narrow = "what it shows", ("lines",)


class _ClaimTable(_PaperTable):
    # "stated" is omitted first: the text below the list repeats it.
    wrapped_column, omitted_if_narrow = "statement", ("stated", "section")


class PaperPane(JobPane):
    """Lists of figures and claims, and the selected figure."""

    NAME: ClassVar[str] = "paper"
    VERB: ClassVar[str] = "Check"
    HINT: ClassVar[str] = "Enter: figure, o: scene"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "figures": "Figures",
        "claims": "Claims",
        "figure": "Figure",
    }
    BINDINGS: ClassVar[list[BindingType]] = [Binding("o", "open_scene", "Load scene")]

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._computed: dict[str, FigureData] = {}
        # The verdicts that the list shows.
        self._listed_claims: DisplayedStudy[list[CheckedClaim]] | None = None
        # Only a figure other than the drawn one resets the axis limits: the stored figure, which
        # counts as drawn, keeps the stored limits.
        self._figure_key = self._drawn_key = self.stored_setting(_FIGURE_SETTING, "")

    def compose_views(self) -> ComposeResult:
        """The lists of figures and claims, and the two charts of a figure."""
        yield _FigureTable(id="figures", cursor_type="row", zebra_stripes=True)
        with Vertical(id="claims"):
            yield _ClaimTable(id="claims-table", cursor_type="row", zebra_stripes=True)
            yield Static("", id="claim", markup=False)
        with Vertical(id="figure"):
            yield ChartView("figure-1", runs_points=True)
            yield ChartView("figure-2", runs_points=True)

    def on_mount(self) -> None:
        """List the figures, or restore the last figure."""
        self.query_one("#figure-2").display = False
        # Textual calls the base class's on_mount after this one.
        self.call_later(self._restore)

    def _restore(self) -> None:
        if self._figure_key not in PANELS:
            self._figure_key = ""
        self.draw()

    @cached_property
    def _results(self) -> "PaperResults":
        # Figures and claims share computed results.
        from fivtui.paper import PaperResults

        return PaperResults()

    def _panel(self, key: str) -> "ComputedPanel":
        from fivtui.paper import ComputedPanel

        return ComputedPanel(key, self._results)

    # The lists

    def draw(self) -> None:
        """Draw the current view."""
        if self.view == "figures":
            self._list_figures()
        elif self.view == "claims":
            self._list_claims()
        else:
            self._draw_figure()

    def _list_figures(self) -> None:
        from .requests.paper import FIGURE_COLUMNS, figure_rows

        rows = dict(zip(PANELS, figure_rows(list(self._computed)), strict=True))
        self.query_one("#figures", _PaperTable).fill(FIGURE_COLUMNS, rows)

    @property
    def _verdicts(self) -> "dict[str, CheckedClaim]":
        # The verdicts by claim, computed in this session or restored.
        displayed = self.session.studies.get(_CLAIMS_STUDY)
        return (
            {} if displayed is None else {checked.claim.id: checked for checked in displayed.value}
        )

    def scene_changed(self) -> None:
        """Display restored verdicts."""
        displayed = self.session.studies.get(_CLAIMS_STUDY)
        if displayed is not None and displayed is not self._listed_claims:
            if self.job is None:
                self._show_counts()
            if self.view == "claims":
                self._list_claims()

    def _show_counts(self) -> None:
        counts = Counter(str(entry.verdict) for entry in self._verdicts.values())
        text = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
        self.show_status(f"{counts.total()} claims: {text}")

    def _list_claims(self) -> None:
        from fivtui.paper import CLAIMS

        from .requests.paper import CLAIM_COLUMNS, claim_rows

        self._listed_claims = self.session.studies.get(_CLAIMS_STUDY)
        rows = claim_rows(CLAIMS, self._verdicts)
        row_keys = [claim.id for claim in CLAIMS]
        table = self.query_one("#claims-table", _PaperTable)
        table.fill(CLAIM_COLUMNS, dict(zip(row_keys, rows, strict=True)))

    @on(DataTable.RowHighlighted, "#claims-table")
    def _show_highlighted_claim(self, event: DataTable.RowHighlighted) -> None:
        from fivtui.paper import CLAIMS

        from .requests.paper import claim_text

        claim = CLAIMS[event.cursor_row]
        self.query_one("#claim", Static).update(claim_text(claim, self._verdicts.get(claim.id)))

    @on(DataTable.RowSelected, "#figures")
    def _choose_selected_figure(self, event: DataTable.RowSelected) -> None:
        event.stop()
        self.stop()
        self._figure_key = list(PANELS)[event.cursor_row]
        self.show_view("figure")

    def _compute_figure(self, key: str) -> None:
        def compute(job: Job) -> object:
            results, panel = self._results, PANELS[key]
            if panel.kind == "amplitude":
                # Compute all runs of the figure at once.
                results.prepare(panel.scenes(), job.report)
            data = results.table(key)
            if not job.report(1.0):
                raise Cancelled
            return key, data

        self.start(compute)

    # Computing

    def start_from_inputs(self) -> None:
        """Check the claims one by one."""
        from fivtui.paper import check_claims

        if self.view == "figure":
            self.show_view("claims")

        def compute(job: Job) -> object:
            return check_claims(self._results, progress=job.report)

        self.start(compute)

    def show_result(self, result: object) -> None:
        """Display a computed figure (key and data), or the verdicts (a list)."""
        if isinstance(result, tuple):
            key, data = result
            self._computed[key] = data
            self.show_status(f"figure {key} computed")
            self.draw()
        elif isinstance(result, list):
            self.session.studies[_CLAIMS_STUDY] = DisplayedStudy(result, _CLAIMS_STUDY)
            self._show_counts()
            self.draw()

    # A figure

    def _draw_figure(self) -> None:
        from fivtui.paper import figure_charts

        if not self._figure_key:
            row = self.query_one("#figures", _PaperTable).cursor_row
            self._figure_key = list(PANELS)[row]
        self.store_setting(_FIGURE_SETTING, self._figure_key)
        if self._figure_key not in self._computed:
            if self.job is None:
                self._compute_figure(self._figure_key)
            return
        charts = figure_charts(PANELS[self._figure_key], self._computed[self._figure_key])
        is_new, self._drawn_key = self._drawn_key != self._figure_key, self._figure_key
        second = self.query_one("#figure-2", ChartView)
        second.display = len(charts) > 1
        first = self.query_one("#figure-1", ChartView)
        for chart_view, chart in zip((first, second), charts, strict=False):
            if is_new:
                chart_view.view.reset()
                chart_view.view.hidden.clear()
            chart_view.show(chart)

    @property
    def _selected_key(self) -> str:
        # Key of the selected figure; empty if no figure is selected.
        if self.view == "figures":
            return list(PANELS)[self.query_one("#figures", _PaperTable).cursor_row]
        return self._figure_key

    def export(self, kind: str) -> Export:
        """Figure or data of the selected figure, or the claims as data."""
        if self.view == "claims":
            if kind == FIGURE:
                raise InputError(
                    f"claims have no figure: {self.session.key_names[DATA]} exports them"
                )
            if not self._verdicts:
                raise InputError("no claims to export yet: press Check")
            return study_export(kind, "claims", list(self._verdicts.values()), "claims")
        key = self._selected_key
        if key not in self._computed:
            problem = f"Fig. {key} is not computed yet" if key else "no figure is selected yet"
            raise InputError(f"{problem}: Enter in the list of figures computes it")
        panel = self._panel(key)
        if kind == FIGURE:
            # The displayed charts, or else all panels of the figure: the name has no panel.
            number = panel.number
            figure = study_export(kind, "figure", panel, f"fig-{number:02d}", f"Fig. {number}")
            return with_displayed_charts(figure, self.visible_charts())
        return study_export(kind, "figure", panel, study("figure").stem(panel), f"Fig. {key}")

    def command_line(self) -> str:
        """The command that computes the selected figure or the claims."""
        if self.view == "claims":
            return study_command("claims", None, self.session.origin)
        if not self._selected_key:
            raise InputError("no figure is chosen yet: Enter in the list of figures computes one")
        return study_command("figure", self._panel(self._selected_key), self.session.origin)

    def action_open_scene(self) -> None:
        """Load the scene of the selected figure."""
        from .requests.paper import panel_scene

        key = self._selected_key
        if key:
            self.post_message(SceneLoaded(panel_scene(key), "", f"scene of figure {key}"))

    @on(ChartView.PointChosen)
    def _run_point(self, event: ChartView.PointChosen) -> None:
        from .requests.paper import point_scene

        panel = PANELS[self._figure_key]
        report = f"figure {panel.key}, {panel.along} = {event.point.x:g}"
        self.post_message(SceneLoaded(point_scene(panel, event.point), "", report))
        self.post_message(RunRequested())
