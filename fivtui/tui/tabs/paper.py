"""The paper tab: the paper's figures and claims, computed on request.

The paper is "Nonlinear friction-induced vibration of a slider-belt system". A claim is a statement
of it; its verdict says whether the model confirms it. Figures are named by their keys in `PANELS`:
``2a`` is a panel of the figure with the number 2.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import DataTable, Static

from fivtui.model import InputError
from fivtui.paper import (
    CLAIMS,
    PANELS,
    CheckedClaim,
    ComputedPanel,
    PaperResults,
    check_claims,
    figure_charts,
    verdict_counts,
)
from fivtui.studies import study
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session, study_command

from .exports.export import DATA, FIGURE, Export, study_export
from .job_pane import JobPane
from .messages import RunRequested, SceneLoaded
from .requests.paper import (
    CLAIM_COLUMNS,
    FIGURE_COLUMNS,
    claim_row,
    claim_text,
    figure_row,
    panel_scene,
    point_scene,
)
from .tables import ListTable

# Key of the stored figure, and kind of study of the verdicts.
_FIGURE_SETTING: Final = "figure"
_CLAIMS_STUDY: Final = "claims"


class _PaperTable(ListTable[str]):
    BINDINGS: ClassVar[list[BindingType]] = [Binding("enter", "select_cursor", "Show")]


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
        # Figures and claims share computed results.
        self._results = PaperResults()
        # The verdicts that are drawn; empty before the first drawing.
        self._drawn_verdicts: object = ""

    def compose_views(self) -> ComposeResult:
        """The lists of figures and claims, and the two charts of a figure."""
        yield _PaperTable("figures", wrapped="what it shows", omitted=("lines",))
        with Vertical(id="claims"):
            # "stated" is omitted first: the text below the list repeats it.
            yield _PaperTable("claims-table", wrapped="statement", omitted=("stated", "section"))
            yield Static("", id="claim", markup=False)
        with Vertical(id="figure"):
            yield ChartView("figure-1", runs_points=True)
            yield ChartView("figure-2", runs_points=True)

    # The lists

    @property
    def _verdicts(self) -> dict[str, CheckedClaim]:
        # The verdicts by claim, computed in this session or restored.
        displayed = self.session.studies.get(_CLAIMS_STUDY)
        checked = [] if displayed is None else displayed.value
        return {entry.claim.id: entry for entry in checked}

    def scene_changed(self) -> None:
        """Draw the current view when the tab is first shown, and other verdicts."""
        displayed = self.session.studies.get(_CLAIMS_STUDY)
        if displayed is not self._drawn_verdicts:
            self._drawn_verdicts = displayed
            if displayed is not None and self.job is None:
                self.show_status(verdict_counts(displayed.value))
            self.draw()

    def draw(self) -> None:
        """Draw the current view."""
        if self.view == "figures":
            computed = self._results.tables
            rows = {
                key: figure_row(panel, is_computed=key in computed) for key, panel in PANELS.items()
            }
            self.query_one("#figures", _PaperTable).fill(FIGURE_COLUMNS, rows)
        elif self.view == "claims":
            verdicts = self._verdicts
            rows = {claim.id: claim_row(claim, verdicts.get(claim.id)) for claim in CLAIMS}
            self.query_one("#claims-table", _PaperTable).fill(CLAIM_COLUMNS, rows)
        else:
            self._draw_figure()

    @on(DataTable.RowHighlighted, "#claims-table")
    def _show_highlighted_claim(self, event: DataTable.RowHighlighted) -> None:
        claim = CLAIMS[event.cursor_row]
        self.query_one("#claim", Static).update(claim_text(claim, self._verdicts.get(claim.id)))

    # Computing

    def start_from_inputs(self) -> None:
        """Check the claims one by one."""
        if self.view == "figure":
            self.show_view("claims")
        self.start(lambda job: check_claims(self._results, progress=job.report))

    def show_result(self, result: Any) -> None:
        """Display a computed figure (its key), or the verdicts (a list)."""
        if isinstance(result, list):
            self.session.studies[_CLAIMS_STUDY] = DisplayedStudy(result, _CLAIMS_STUDY)
            self.scene_changed()
        else:
            self.show_status(f"figure {result} computed")
            self.draw()

    # A figure

    @property
    def _figure_key(self) -> str:
        # Key of the figure in the view of a figure; empty before one is chosen.
        stored = self.stored_setting(_FIGURE_SETTING, "")
        return stored if stored in PANELS else ""

    @property
    def _listed_key(self) -> str:
        # Key of the figure at the cursor of the list.
        return list(PANELS)[self.query_one("#figures", _PaperTable).cursor_row]

    @property
    def _selected_key(self) -> str:
        return self._listed_key if self.view == "figures" else self._figure_key

    @on(DataTable.RowSelected, "#figures")
    def _choose_listed_figure(self, event: DataTable.RowSelected) -> None:
        event.stop()
        self.stop()
        self._choose_figure(self._listed_key)
        self.show_view("figure")

    def _choose_figure(self, key: str) -> None:
        if key != self._figure_key:
            # The limits were chosen for another figure.
            for chart_view in self.query(ChartView):
                chart_view.view.reset()
                chart_view.view.hidden.clear()
        self.store_setting(_FIGURE_SETTING, key)

    def _compute_figure(self, key: str) -> None:
        results, panel = self._results, PANELS[key]
        # Compute all runs of a figure of amplitudes at once.
        scenes = panel.scenes() if panel.kind == "amplitude" else []

        def compute(job: Job) -> str:
            results.prepare(scenes, job.report)
            results.table(key)
            return key

        self.start(compute)

    def _draw_figure(self) -> None:
        if not self._figure_key:
            self._choose_figure(self._listed_key)
        key = self._figure_key
        if key in self._results.tables:
            charts = figure_charts(PANELS[key], self._results.tables[key])
            first, second = self.query(ChartView)
            if len(charts) == 1:
                first.display, second.display = True, False
            for chart_view, chart in zip((first, second), charts, strict=False):
                chart_view.show(chart)
        elif self.job is None:
            self._compute_figure(key)

    def export(self, kind: str) -> Export:
        """Figure or data of the selected figure, or the claims as data."""
        if self.view == "claims":
            if kind == FIGURE:
                raise InputError(
                    f"claims have no figure: {self.session.key_names[DATA]} exports them"
                )
            if not self._verdicts:
                raise InputError("no claims to export yet: press Check")
            return study_export(kind, _CLAIMS_STUDY, list(self._verdicts.values()), _CLAIMS_STUDY)
        key = self._selected_key
        if key not in self._results.tables:
            problem = f"Fig. {key} is not computed yet" if key else "no figure is selected yet"
            raise InputError(f"{problem}: Enter in the list of figures computes it")
        panel = ComputedPanel(key, self._results)
        if kind == FIGURE:
            # The displayed charts, or else all panels of the figure: the name has no panel.
            stem, subject = f"fig-{panel.number:02d}", f"Fig. {panel.number}"
        else:
            stem, subject = study("figure").stem(panel), f"Fig. {key}"
        return study_export(kind, "figure", panel, stem, subject, charts=self.visible_charts())

    def command_line(self) -> str:
        """The command that computes the selected figure or the claims."""
        if self.view == "claims":
            return study_command(_CLAIMS_STUDY, None, self.session.origin)
        if not self._selected_key:
            raise InputError("no figure is chosen yet: Enter in the list of figures computes one")
        panel = ComputedPanel(self._selected_key, self._results)
        return study_command("figure", panel, self.session.origin)

    def action_open_scene(self) -> None:
        """Load the scene of the selected figure."""
        key = self._selected_key
        if key:
            scene = panel_scene(PANELS[key])
            self.post_message(SceneLoaded(scene, "", f"scene of figure {key}"))

    @on(ChartView.PointChosen)
    def _run_point(self, event: ChartView.PointChosen) -> None:
        panel = PANELS[self._figure_key]
        report = f"figure {panel.key}, {panel.along} = {event.point.x:g}"
        self.post_message(SceneLoaded(point_scene(panel, event.point), "", report))
        self.post_message(RunRequested())
