"""The paper tab: figures and claims, computed on request."""

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

from .exports.export import DATA, FIGURE, KINDS, Export, as_displayed, study_export
from .job_pane import JobPane
from .messages import RunRequested, SceneLoaded
from .tables import ListTable

if TYPE_CHECKING:
    from fivtui.paper import CheckedClaim, FigureData, PanelOf, PaperResults


_SHOWN: Final = "figure"
_CLAIMS: Final = "claims"


class _Table(ListTable[str]):
    BINDINGS: ClassVar[list[BindingType]] = [Binding("enter", "select_cursor", "Show")]


class _Figures(_Table):
    wrapped, dropped = "what it shows", ("lines",)


class _Claims(_Table):
    # The stated value is displayed below the list, too.
    wrapped, dropped = "statement", ("stated", "section")


class PaperPane(JobPane):
    """Lists of figures and claims, and the selected figure."""

    NAME: ClassVar[str] = "paper"
    VERB: ClassVar[str] = "Check"
    HINT: ClassVar[str] = "Enter: figure, F10: claims, o: scene"
    VIEWS: ClassVar[Mapping[str, str]] = {
        "figures": "Figures",
        "claims": "Claims",
        "figure": "Figure",
    }
    BINDINGS: ClassVar[list[BindingType]] = [Binding("o", "open_scene_of", "Load scene")]

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._computed: dict[str, FigureData] = {}
        self._listed: DisplayedStudy[list[CheckedClaim]] | None = None
        # The stored axis limits belong to the stored figure.
        self._shown = self._drawn = self.setting(_SHOWN, "")

    def compose_views(self) -> ComposeResult:
        """Two tables and two charts."""
        yield _Figures(id="figures", cursor_type="row", zebra_stripes=True)
        with Vertical(id="claims"):
            yield _Claims(id="claims-table", cursor_type="row", zebra_stripes=True)
            yield Static("", id="claim", markup=False)
        with Vertical(id="figure"):
            yield ChartView("figure-1", empty_text="select a figure", openable=True)
            yield ChartView("figure-2", openable=True)

    def on_mount(self) -> None:
        """List the figures, or restore the last figure."""
        self.query_one("#figure-2").display = False
        # Textual calls the base class's on_mount after this one.
        self.call_later(self._restore)

    def _restore(self) -> None:
        if self._shown not in PANELS:
            self._shown = ""
        elif self.view == "figure":
            self._choose(self._shown)
        self.draw()

    @cached_property
    def _results(self) -> "PaperResults":
        # Figures and claims share computed results.
        from fivtui.paper import PaperResults

        return PaperResults()

    def _panel(self, key: str) -> "PanelOf":
        from fivtui.paper import PanelOf

        return PanelOf(key, self._results)

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
        self.query_one("#figures", _Table).fill(FIGURE_COLUMNS, rows)

    @property
    def _checked(self) -> "dict[str, CheckedClaim]":
        # Computed in this session, or restored.
        displayed = self.session.studies.get(_CLAIMS)
        return (
            {} if displayed is None else {checked.claim.id: checked for checked in displayed.value}
        )

    def scene_changed(self) -> None:
        """List verdicts that were restored."""
        displayed = self.session.studies.get(_CLAIMS)
        if displayed is not None and displayed is not self._listed:
            if self.job is None:
                self._count()
            if self.view == "claims":
                self._list_claims()

    def _count(self) -> None:
        counts = Counter(str(entry.verdict) for entry in self._checked.values())
        text = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
        self.show_status(f"{counts.total()} claims: {text}")

    def _list_claims(self) -> None:
        from fivtui.paper import CLAIMS

        from .requests.paper import CLAIM_COLUMNS, claim_rows

        self._listed = self.session.studies.get(_CLAIMS)
        rows = claim_rows(CLAIMS, self._checked)
        named = {claim.id: row for claim, row in zip(CLAIMS, rows, strict=True)}
        self.query_one("#claims-table", _Table).fill(CLAIM_COLUMNS, named)

    @on(DataTable.RowHighlighted, "#claims-table")
    def _claim_chosen(self, event: DataTable.RowHighlighted) -> None:
        from fivtui.paper import CLAIMS

        from .requests.paper import claim_words

        claim = CLAIMS[event.cursor_row]
        self.query_one("#claim", Static).update(claim_words(claim, self._checked.get(claim.id)))

    @on(DataTable.RowSelected, "#figures")
    def _figure_chosen(self, event: DataTable.RowSelected) -> None:
        event.stop()
        self._choose(list(PANELS)[event.cursor_row])

    def _choose(self, key: str) -> None:
        self._shown = key
        self.keep(_SHOWN, key)
        if key in self._computed:
            self.show_view("figure")
            return

        def compute(job: Job) -> object:
            study, panel = self._results, PANELS[key]
            if panel.kind == "amplitude":
                study.prepare(panel.scenes(), job.report)
            data = study.table(key)
            if not job.report(1.0):
                raise Cancelled
            return key, data

        self.start(compute)

    # Computing

    def begin(self) -> None:
        """Check the claims one by one."""
        from fivtui.paper import check_claims

        if self.view == "figure":
            self.show_view("claims")

        def compute(job: Job) -> object:
            return check_claims(self._results, progress=job.report)

        self.start(compute)

    def show_result(self, result: object) -> None:
        """Display a figure, or the verdicts."""
        if isinstance(result, tuple):
            key, data = result
            self._computed[key] = data
            self.show_status(f"figure {key} computed")
            if self.view == "figure":
                self.draw()
            else:
                self.show_view("figure")
        elif isinstance(result, list):
            self.session.studies[_CLAIMS] = DisplayedStudy(result, _CLAIMS)
            self._count()
            self.draw()

    # A figure

    def _draw_figure(self) -> None:
        from fivtui.paper import figure_charts

        if self._shown not in self._computed:
            return
        charts = figure_charts(PANELS[self._shown], self._computed[self._shown])
        changed, self._drawn = self._drawn != self._shown, self._shown
        second = self.query_one("#figure-2", ChartView)
        second.display = len(charts) > 1
        first = self.query_one("#figure-1", ChartView)
        for view, chart in zip((first, second), charts, strict=False):
            if changed:
                view.view.reset()
                view.view.hidden.clear()
            view.show(chart)

    @property
    def _chosen(self) -> str:
        # Key of the selected figure; empty if none.
        if self.view == "figures":
            return list(PANELS)[self.query_one("#figures", _Table).cursor_row]
        return self._shown

    def export(self, kind: str) -> Export:
        """The displayed chart or the paper's figure, its data, or the claims."""
        if self.view == "claims":
            if kind == FIGURE:
                raise InputError(f"claims have no figure: {KINDS[DATA]} exports them")
            if not self._checked:
                raise InputError("no claims to export yet: press F10")
            return study_export(kind, "claims", list(self._checked.values()), "claims")
        key = self._chosen
        if key not in self._computed:
            which = f"Fig. {key} is not computed yet" if key else "no figure is selected yet"
            raise InputError(f"{which}: Enter in the list of figures computes it")
        panel = self._panel(key)
        if kind == FIGURE:
            number = panel.number
            figure = study_export(kind, "figure", panel, f"fig-{number:02d}", f"Fig. {number}")
            return as_displayed(figure, self.visible_charts())
        return study_export(kind, "figure", panel, study("figure").stem(panel), f"Fig. {key}")

    def command_line(self) -> str:
        """The command for the selected figure, or the claims."""
        if self.view == "claims":
            return study_command("claims", None, self.session.origin)
        if not self._chosen:
            raise InputError("no figure is chosen yet: Enter in the list of figures computes one")
        return study_command("figure", self._panel(self._chosen), self.session.origin)

    def action_open_scene_of(self) -> None:
        """Load the scene of the selected figure."""
        from .requests.paper import panel_scene

        key = self._chosen
        if key:
            self.post_message(SceneLoaded(panel_scene(key), "", f"scene of figure {key}"))

    @on(ChartView.Opened)
    def _point_opened(self, event: ChartView.Opened) -> None:
        from .requests.paper import point_scene

        panel = PANELS[self._shown]
        report = f"figure {panel.key}, {panel.along} = {event.point.x:g}"
        self.post_message(SceneLoaded(point_scene(panel, event.point), "", report))
        self.post_message(RunRequested())
