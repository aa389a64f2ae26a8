"""Entries of the command palette: what applies to the current state, found by search terms.

The paper is "Nonlinear friction-induced vibration of a slider-belt system". A slot is a numbered
place for a saved session, with its files.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final, cast

from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.fuzzy import Matcher

from fivtui.model import InputError
from fivtui.scene import PRESETS, Scene
from fivtui.tui.persistence import Slot, load_session
from fivtui.tui.session import FIELDS, Run
from fivtui.tui.tabs import (
    EXPORT_KINDS,
    TABS,
    FieldEdited,
    RunActionRequested,
    SceneLoaded,
    SessionRequested,
    TabSpec,
    ViewsPane,
    paper_scenes,
)

from .screen import LabScreen

# Scores if all words of a search match the title or the search terms. An entry that contains only
# the letters of the search scores less: below `_LETTERS_SCORE`.
_TITLE_SCORE: Final = 2.0
_TERMS_SCORE: Final = 1.0
_LETTERS_SCORE: Final = 0.5
_EXPORT_TERMS: Final = {
    "figure": "plot picture image pdf png svg save export write graph print",
    "data": "csv npz parquet json table numbers save export write excel",
}
_BELT_EXPORT_TERMS: Final = {
    "figure": "film movie video animation gif mp4 plot picture image save export write",
    "data": "sound wav audio noise csv npz parquet save export write",
}
# Search terms of tabs and views, by identifier.
_SEARCH_TERMS: Final = {
    "stability": "squeal verdict critical linear modes unstable stable",
    "over-mu": "frequency growth rate critical friction mode coupling",
    "plane": "root locus poles complex",
    "facts": "verdict equilibrium frequency",
    "transient": "run simulation vibration motion result",
    "time": "history displacement force velocity oscillation vibration",
    "phase": "portrait trajectory orbit velocity path",
    "spectrum": "frequency fft fourier harmonics noise hz",
    "difference": "compare baseline error",
    "belt": "animation film movie video gif mp4 sound wav noise slider stick lift-off play",
    "measured": "import csv experiment test data validate tolerance band overlay shift",
    "sweep": "parameter study amplitude vary scan",
    "map": "stability regions safe critical boundary plane",
    "trade-off": "accuracy error cost cpu time speed tolerance method benchmark solver",
    "paper": "figures claims article verify",
    "figures": "paper",
    "claims": "paper verify check statements",
    "uncertainty": "uncertainty probability scatter sobol monte carlo reliability sensitivity",
    "growth_rate": "histogram probability distribution scatter",
    "indices": "sobol sensitivity importance",
    "samples": "scatter points",
    "result": "numbers values table peak summary compare",
    "safe-mu": "safety friction coexistence regions knock map",
    "growth-rate": "stability eigenvalues",
    "critical-mu": "critical friction",
    "coexistence": "regions basins knock",
    "log": "messages errors history",
    "identification": "identify fit measured data parameters least squares estimate calibrate",
    "branch": "bifurcation continuation limit cycles hopf fold attractors coexistence",
}
# Search terms of the commands of every Textual application, by title.
_SYSTEM_COMMAND_TERMS: Final = {
    "Theme": "dark light colours colors appearance",
    "Quit": "exit leave close end",
    "Screenshot": "picture image svg print screen",
    "Maximize": "full screen zoom enlarge",
}


@dataclass(frozen=True, slots=True)
class PaletteEntry:
    """An entry of the command palette; `search_terms` find it besides its title and help."""

    title: str
    help: str
    run: Callable[[], object]
    search_terms: str = ""

    def score(self, matcher: Matcher, query: str) -> float:
        """Score of the match with a search; 0 if nothing matches."""
        query_terms, title = query.lower().split(), self.title.lower()
        match = matcher.match(self.title)
        # `match` has no upper limit.
        letters_score = _LETTERS_SCORE * match / (1.0 + match)
        if all(term in title for term in query_terms):
            return _TITLE_SCORE + letters_score
        terms = re.split(r"[^\w+-]+", f"{title} {self.search_terms} {self.help}".lower())
        if all(any(term.startswith(prefix) for term in terms) for prefix in query_terms):
            return _TERMS_SCORE + letters_score
        return letters_score


def _lab_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    session, keys = lab.session, lab.session.key_names
    if session.runs.active is None:
        yield PaletteEntry(
            "Run the transient",
            keys["run"],
            lab.action_run,
            "simulate compute start calculate solve",
        )
        yield PaletteEntry(
            "Run with native solver and FMU",
            f"{keys['both']}: native solver, then FMU, then compare",
            lab.action_compare_engines,
            "check verify compare",
        )
    else:
        yield PaletteEntry("Stop the run", keys["stop"], lab.action_stop, "cancel abort break")
    yield from _tab_entries(lab)
    yield PaletteEntry(
        f"Engine: {session.next_engine}",
        f"{keys['engine']}; now {session.engine}",
        lab.action_switch_engine,
        "fmu solver co-simulation switch",
    )
    yield PaletteEntry(
        "Help: keys that work now",
        keys["help"],
        lab.action_help,
        "shortcuts manual equations keymap config",
    )
    yield PaletteEntry(
        f"Live curve {'off' if session.live_enabled else 'on'}",
        f"{keys['live']}: the transient follows every edit; its runs are not kept",
        lab.action_switch_live,
        "ghost redraw preview background",
    )
    for title, key, action, terms in (
        ("Open a scene or result…", "open", lab.action_open_scene, "load file toml"),
        ("Edit the scene in your editor", "edit", lab.action_edit_scene, "text toml vim nano"),
        ("Save the scene", "save", lab.action_save_scene, "write file toml"),
        ("Save the scene as…", "save-as", lab.action_save_scene_as, "write file toml"),
    ):
        yield PaletteEntry(title, keys[key], action, terms)
    if lab.check_action("reload_scene", ()):
        yield PaletteEntry(
            f"Read {session.source} again",
            keys["reload"],
            lab.action_reload_scene,
            "reload scene file changed on disk revert",
        )
    for path in session.recent:
        open_scene = partial(lab.files.open_path, Path(path))
        yield PaletteEntry(f"Recent: {path}", "Open again", open_scene)
    yield PaletteEntry(
        "Read a result…",
        f"{keys['read']}: a run, sweep, map, trade-off, branch",
        lab.action_read_result,
        "import load open csv npz json parquet",
    )
    if session.can_undo:
        yield PaletteEntry("Undo", keys["undo"], lab.action_undo, "back revert restore deleted run")
    if session.can_redo:
        yield PaletteEntry("Redo", keys["redo"], lab.action_redo)
    if session.changed_fields:
        yield PaletteEntry(
            "Reset all fields",
            "To the values of the loaded scene",
            lab.action_reset_all,
            "default original revert",
        )
    # The entry offers the other kind of belt: of finite speed, or always faster than the slider.
    is_finite = session.belt_is_finite
    stick_help = "Fields v_belt, μ_s and v_s: the slider sticks"
    yield PaletteEntry(
        "Belt faster than the slider" if is_finite else "Belt of finite speed",
        "As in the paper: no stick" if is_finite else stick_help,
        lab.action_switch_belt,
        "belt speed stick slip static friction Stribeck v_belt mu_s v_s",
    )
    table_terms = "preload friction belt speed course csv measured brake application ramp"
    yield PaletteEntry(
        "Parameters over time from a file…",
        "CSV: time, F, mu, v_belt, k2, c1, …",
        lab.files.read_tables,
        table_terms,
    )
    if session.over_time:
        yield PaletteEntry(
            "Drop the tables over time", "Values at t = 0 stay", lab.action_drop_tables, table_terms
        )
    yield from _field_entries(lab)
    for tab in TABS:
        show = partial(lab.action_show_tab, tab.id)
        yield PaletteEntry(
            f"Tab {tab.title}", keys[f"tab-{tab.id}"], show, _SEARCH_TERMS.get(tab.id, "")
        )
        yield from _view_entries(lab, tab)
    yield from _scene_entries(lab)
    yield from _run_entries(lab)


def _tab_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    # Entries that act on the current tab.
    pane = lab.pane
    if pane is None:
        return
    for kind in EXPORT_KINDS:
        # A tab without content to export raises `InputError`.
        with suppress(InputError):
            export = pane.export(kind)
            is_belt = not {".gif", ".wav"}.isdisjoint(export.suffixes)
            yield PaletteEntry(
                f"Export the {export.kind} of {export.subject}…",
                f"{lab.session.key_names[kind]}: {', '.join(export.suffixes)}",
                partial(lab.action_export, kind),
                (_BELT_EXPORT_TERMS if is_belt else _EXPORT_TERMS)[kind],
            )
    with suppress(InputError):
        yield PaletteEntry(
            "Copy the command line",
            pane.command_line(),
            partial(lab.files.copy_command, pane),
            "clipboard shell script cli",
        )
    if isinstance(pane, ViewsPane) and pane.visible_charts() is not None:
        yield from _plot_entries(lab, pane)


def _plot_entries(lab: LabScreen, pane: ViewsPane) -> Iterator[PaletteEntry]:
    # Entries that act on the first visible plot.
    plot = next(view for view in pane.shown_chart_views() if view.chart is not None)

    def entry(title: str, key: str, action: Callable[[], object], terms: str) -> PaletteEntry:
        def focus_and_run() -> None:
            plot.focus()
            action()

        return PaletteEntry(title, f"In the plot: {key}", focus_and_run, terms)

    yield entry("Limits of the axes…", "i", plot.action_limits, "range zoom scale")
    yield entry("Fit the axes", "r", plot.action_fit, "reset zoom limits all")
    yield entry("Zoom in", "+", partial(plot.action_zoom, -1), "enlarge magnify")
    yield entry("Zoom out", "-", partial(plot.action_zoom, 1), "shrink")
    for number, (key, title) in enumerate((("c", "First cursor"), ("C", "Second cursor"))):
        set_cursor = partial(plot.action_cursor, number)
        yield entry(title, key, set_cursor, "read value point crosshair measure difference delta")
    for axis in "xy":
        toggle_log = partial(plot.action_log, axis)
        yield entry(f"Logarithmic {axis} axis", axis, toggle_log, "log linear scale")
    yield PaletteEntry(
        "Copy the plot as text",
        "To the clipboard",
        partial(lab.files.copy_plot, pane),
        "picture image copy characters",
    )
    yield PaletteEntry(
        "Copy the picture",
        "To the clipboard, as PNG",
        partial(lab.files.copy_picture, pane),
        "plot figure image png clipboard",
    )


def _view_entries(lab: LabScreen, tab: TabSpec) -> Iterator[PaletteEntry]:
    # Entries that show a view of a tab.
    def show(view: str) -> None:
        lab.action_show_tab(tab.id)
        lab.tab_book.when_ready(lambda pane: cast("ViewsPane", pane).show_view(view))

    views = getattr(tab.import_pane_class(), "VIEWS", {})
    if len(views) < 2:
        return
    for view, title in views.items():
        yield PaletteEntry(
            f"{tab.title}: {title}",
            f"{lab.session.key_names[f'tab-{tab.id}']}, v",
            partial(show, view),
            f"plot {_SEARCH_TERMS.get(view, '')}",
        )


def _scene_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    def entry(title: str, help_text: str, scene: Scene, source: str, report: str) -> PaletteEntry:
        load = partial(lab.post_message, SceneLoaded(scene, source, report))
        return PaletteEntry(title, help_text, load, "load example scene case")

    for name, scene in PRESETS.items():
        yield entry(f"Preset {name}", scene.description, scene, name, f"preset {name}")
    for scene, caption in paper_scenes():
        title = f"Scene of {scene.name.replace('fig-', 'Fig. ')}"
        yield entry(title, caption, scene, "", f"scene {scene.name}: {caption}")


def _run_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    runs = lab.session.runs

    def entry(title: str, help_text: str, run: Run, action: str) -> PaletteEntry:
        return PaletteEntry(
            title, help_text, partial(lab.post_message, RunActionRequested(run.number, action))
        )

    for run in runs:
        yield entry(f"Load the scene of run {run.number}", "In the run list: Enter", run, "load")
        yield entry(f"Delete run {run.number}", "In the run list: x; remove", run, "delete")
        if run.result is None:
            continue
        if run is not runs.displayed:
            yield entry(f"Show run {run.number}", "Plots and results of this run", run, "show")
            title = f"{'Hide' if run.overlaid else 'Overlay'} run {run.number}"
            yield entry(title, "In the run list: Space; overlay", run, "overlay")
        title = "Clear the baseline" if run is runs.baseline else f"Baseline: run {run.number}"
        yield entry(title, "In the run list: b; compare", run, "baseline")


def _saved_session_entries(lab: LabScreen, slots: Iterable[Slot]) -> Iterator[PaletteEntry]:
    for slot in slots:
        last_used = datetime.fromtimestamp(slot.last_used)
        yield PaletteEntry(
            f"Open session {slot.number}: {_contents_text(slot)}",
            f"last used {last_used:%Y-%m-%d %H:%M}; saves the current session",
            partial(lab.post_message, SessionRequested(slot.number)),
        )


def _contents_text(slot: Slot) -> str:
    # The contents of a saved session, or why it cannot be read.
    try:
        session = load_session(slot.path)
    except InputError as error:
        return str(error)
    if session is None:
        return "empty"
    contents, run_count = [f"scene {session.name}"], len(list(session.runs))
    if run_count:
        contents.append(f"{run_count} run{'s' * (run_count > 1)}")
    studies = [key for key in session.unread_results if not key.startswith("run-")]
    return ", ".join([*contents, *studies])


def _field_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    for field in FIELDS.values():
        focus = partial(lab.focus_field, field.name)
        yield PaletteEntry(f"Edit {field.symbol or field.name}", field.meaning, focus, field.name)
        for text, meaning in (field.choices or {}).items():
            if text != lab.session.texts[field.name]:
                choose = partial(lab.post_message, FieldEdited(field.name, text, from_editor=False))
                yield PaletteEntry(f"{field.name.capitalize()}: {text}", meaning, choose)


class LabCommands(Provider):
    """Palette entries of the laboratory, followed by those of every Textual application."""

    async def startup(self) -> None:
        """List the other sessions once, because listing them reads files."""
        self._other_sessions: list[PaletteEntry] = []
        if isinstance(self.screen, LabScreen):
            self._other_sessions += _saved_session_entries(
                self.screen, self.screen.other_sessions()
            )

    def _all_entries(self) -> Iterator[PaletteEntry]:
        if isinstance(self.screen, LabScreen):
            yield from _lab_entries(self.screen)
        yield from self._other_sessions
        for title, help_text, run, _ in self.app.get_system_commands(self.screen):
            # Omit Textual's list of keys: the laboratory has its own.
            if title != "Keys":
                yield PaletteEntry(title, help_text, run, _SYSTEM_COMMAND_TERMS.get(title, ""))

    async def discover(self) -> Hits:
        """All entries, while the search is empty."""
        for entry in self._all_entries():
            yield DiscoveryHit(entry.title, entry.run, help=entry.help)

    async def search(self, query: str) -> Hits:
        """The entries that match the search."""
        matcher = self.matcher(query)
        for entry in self._all_entries():
            score = entry.score(matcher, query)
            if score > 0:
                title = matcher.highlight(entry.title)
                yield Hit(score, title, entry.run, help=entry.help)
