"""The paper tab: the paper's figures and claims, computed on request.

The paper is "Nonlinear friction-induced vibration of a slider-belt system". A claim is a statement
of it; its verdict says whether the model confirms it. Figures are named by their keys in `PANELS`:
``2a`` is a panel of the figure with the number 2. The lines of a panel differ in one parameter, or
in separation: whether the slider may leave the belt.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import DataTable, Static

from fivtui.charts import NearestPoint
from fivtui.model import PARAMETERS, InputError
from fivtui.paper import (
    CLAIMS,
    PANELS,
    SEPARATION,
    CheckedClaim,
    Claim,
    ComputedPanel,
    Panel,
    PaperResults,
    check_claims,
    figure_charts,
    verdict_counts,
)
from fivtui.scene import Scene
from fivtui.studies import study
from fivtui.tui.chart import ChartView
from fivtui.tui.session import DisplayedStudy, Job, Session, study_command, symbol_of

from .export import DATA, FIGURE, Export, study_export
from .job_pane import JobPane
from .messages import RunRequested, SceneLoaded
from .tables import ListTable

# Key of the stored figure, and kind of study of the verdicts.
_FIGURE_SETTING: Final = "figure"
_CLAIMS_STUDY: Final = "claims"
_FIGURE_COLUMNS: Final = ("figure", "lines", "what it shows")
_CLAIM_COLUMNS: Final = ("verdict", "section", "statement", "stated")


class _PaperTable(ListTable[str]):
    BINDINGS: ClassVar[list[BindingType]] = [Binding("enter", "select_cursor", "Show")]


class PaperPane(JobPane):
    """Lists of figures and claims, and the selected figure."""

    NAME: ClassVar[str] = "paper"
    VERB: ClassVar[str] = "Check"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "figures": "Figures",
        "claims": "Claims",
        "figure": "Figure",
    }
    BINDINGS: ClassVar[list[BindingType]] = [Binding("o", "open_scene", "Load scene")]
    status = "Enter: figure, o: scene"

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
            self.query_one("#figures", _PaperTable).fill(_FIGURE_COLUMNS, rows)
        elif self.view == "claims":
            verdicts = self._verdicts
            rows = {claim.id: claim_row(claim, verdicts.get(claim.id)) for claim in CLAIMS}
            self.query_one("#claims-table", _PaperTable).fill(_CLAIM_COLUMNS, rows)
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
            self.log_result(study(_CLAIMS_STUDY).contents_name, [verdict_counts(result)])
        else:
            self.show_status(f"figure {result} computed")
            self.draw()

    # A figure

    @property
    def _figure_key(self) -> str:
        # Key of the chosen figure; in the list, and before one is chosen, that at the cursor.
        stored = self.stored_setting(_FIGURE_SETTING, "")
        if self.view == "figures" or stored not in PANELS:
            return list(PANELS)[self.query_one("#figures", _PaperTable).cursor_row]
        return stored

    @on(DataTable.RowSelected, "#figures")
    def _choose_listed_figure(self, event: DataTable.RowSelected) -> None:
        event.stop()
        self.stop()
        self._choose_figure(self._figure_key)
        self.show_view("figure")

    def _choose_figure(self, key: str) -> None:
        if key != self.stored_setting(_FIGURE_SETTING, ""):
            # The limits were chosen for another figure.
            self.reset_charts()
        self.store_setting(_FIGURE_SETTING, key)

    def _compute_figure(self, key: str, job: Job) -> str:
        # Compute all runs of a figure of amplitudes at once.
        panel = PANELS[key]
        self._results.prepare(panel.scenes() if panel.kind == "amplitude" else [], job.report)
        self._results.table(key)
        return key

    def _draw_figure(self) -> None:
        key = self._figure_key
        self._choose_figure(key)
        if key in self._results.tables:
            charts = figure_charts(PANELS[key], self._results.tables[key])
            first, second = self.query(ChartView)
            if len(charts) == 1:
                first.display, second.display = True, False
            for chart_view, chart in zip((first, second), charts, strict=False):
                chart_view.show(chart)
        else:
            # The charts may show another figure, whose points would be read as those of this one.
            for chart_view in self.query(ChartView):
                chart_view.show(None)
            if self.job is None:
                self.start(partial(self._compute_figure, key))

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
        key = self._figure_key
        if key not in self._results.tables:
            raise InputError(
                f"Fig. {key} is not computed yet: Enter in the list of figures computes it"
            )
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
            return study_command(_CLAIMS_STUDY, None, self.session)
        panel = ComputedPanel(self._figure_key, self._results)
        return study_command("figure", panel, self.session)

    def action_open_scene(self) -> None:
        """Load the scene of the selected figure."""
        key = self._figure_key
        scene = panel_scene(PANELS[key])
        self.post_message(SceneLoaded(scene, "", f"scene of figure {key}"))

    @on(ChartView.PointChosen)
    def _run_point(self, event: ChartView.PointChosen) -> None:
        panel = PANELS[self._figure_key]
        report = f"figure {panel.key}, {panel.along} = {event.point.x:g}"
        self.post_message(SceneLoaded(point_scene(panel, event.point), "", report))
        self.post_message(RunRequested())


def figure_row(panel: Panel, *, is_computed: bool) -> tuple[str, ...]:
    """A panel as row of `_FIGURE_COLUMNS`."""
    if panel.by == SEPARATION:
        # Separation considered, and ignored.
        lines = "both cases"
    else:
        values = [f"{getattr(line.scene.parameters, panel.by):g}" for line in panel.lines]
        lines = f"{symbol_of(panel.by)} {', '.join(values)}"
    # A separate column for the mark would be too wide.
    return f"{panel.key} ✓" if is_computed else panel.key, lines, panel.caption


def claim_row(claim: Claim, checked: CheckedClaim | None) -> tuple[str, ...]:
    """A claim as row of `_CLAIM_COLUMNS`."""
    verdict = "?" if checked is None else checked.verdict.value
    return verdict, claim.section, claim.statement, claim.stated


def claim_text(claim: Claim, checked: CheckedClaim | None) -> str:
    """A claim in a few lines: stated value, computed value, verdict, reason."""
    lines = [claim.statement, f"stated: {claim.stated}"]
    if checked is not None:
        lines.append(f"computed: {checked.computed} — {checked.verdict}")
        lines += [checked.reason] if checked.reason else []
    return "\n".join(lines)


def point_scene(panel: Panel, point: NearestPoint) -> Scene:
    """The scene at a point of a panel's chart."""
    line = panel.lines[point.trace]
    return line.scene.with_values({line.along: point.x} if line.along in PARAMETERS else {})


def panel_scene(panel: Panel) -> Scene:
    """A panel's scene nearest to the default parameters, named after the panel."""

    def distance(scene: Scene) -> float:
        if panel.by == SEPARATION:
            return float(not scene.separation)
        return abs(scene.parameters.as_dict()[panel.by] - PARAMETERS[panel.by].default)

    scene = min((line.scene for line in panel.lines), key=distance)
    description = f"Fig. {panel.key}: {panel.caption}"
    return replace(scene, name=f"fig-{panel.key}", description=description)
