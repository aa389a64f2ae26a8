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

from textual.binding import Binding
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.fuzzy import Matcher

from fivtui.model import InputError
from fivtui.paper import PANELS
from fivtui.scene import PRESETS, Scene
from fivtui.tui.chart import ChartView
from fivtui.tui.persistence import Slot, load_session
from fivtui.tui.session import FIELDS
from fivtui.tui.tabs import (
    EXPORT_KINDS,
    TABS,
    FieldEdited,
    RunActionRequested,
    SceneLoaded,
    SessionRequested,
    TabSpec,
    ViewsPane,
    panel_scene,
)

from .keys import LAB_KEYS, key_text
from .run_list import RunsTable
from .screen import LabScreen

# Scores if all words of a search match the title or the search terms. An entry that contains only
# the letters of the search scores less: below `_LETTERS_SCORE`.
_TITLE_SCORE: Final = 2.0
_TERMS_SCORE: Final = 1.0
_LETTERS_SCORE: Final = 0.5
_BELT_EXPORT_TERMS: Final = {
    "figure": "film movie video animation gif mp4 plot picture image save export write",
    "data": "sound wav audio noise csv npz parquet save export write",
}
# Search terms of keys, tabs and views, by identifier; other keys are not in the palette.
_SEARCH_TERMS: Final = {
    "run": "simulate transient compute start calculate solve",
    "both": "native solver check verify compare",
    "stop": "cancel abort break",
    "engine": "fmu solver co-simulation switch",
    "help": "shortcuts manual equations keymap config",
    "live": "ghost redraw preview background",
    "open": "load file toml",
    "edit": "text toml vim nano",
    "save": "write file toml",
    "save-as": "write file toml",
    "reload": "reload disk revert",
    "read": "import load open csv npz json parquet",
    "compute": "study start calculate",
    "figure": "plot picture image pdf png svg save export write graph print",
    "data": "csv npz parquet json table numbers save export write excel",
    "undo": "back revert restore",
    "redo": "again",
    "reset": "default original revert",
    "reset-all": "default original revert",
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
    "trade-off": "accuracy error cost cpu time tolerance method benchmark solver",
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
# Search terms of the actions of a plot that are in the palette.
_CURSOR_TERMS: Final = "read value point crosshair measure difference delta"
_PLOT_TERMS: Final = {
    "limits": "range zoom scale",
    "fit": "reset zoom limits all",
    "zoom(-1)": "enlarge magnify",
    "zoom(1)": "shrink",
    "cursor(0)": _CURSOR_TERMS,
    "cursor(1)": _CURSOR_TERMS,
    "log('x')": "linear scale",
    "log('y')": "linear scale",
}
# Search terms of actions on runs.
_RUN_TERMS: Final = {
    "load": "scene",
    "overlay": "hide draw beside",
    "baseline": "compare difference",
    "show": "plots results",
    "delete": "remove",
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
    session = lab.session
    for binding in LAB_KEYS:
        name = str(binding.id)
        terms = _SEARCH_TERMS.get(name.removeprefix("tab-"), "")
        if name in EXPORT_KINDS:
            yield from _export_entries(lab, name)
        elif terms and lab.check_action(binding.action, ()):
            run = partial(lab.run_action, binding.action)
            title = binding.tooltip or binding.description
            yield PaletteEntry(title, session.key_names[name], run, terms)
    yield from _tab_entries(lab)
    for path in session.recent:
        yield PaletteEntry(f"Recent: {path}", "Open again", partial(lab.open_path, Path(path)))
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
        lab.read_tables,
        table_terms,
    )
    if session.over_time:
        yield PaletteEntry(
            "Drop the tables over time", "Values at t = 0 stay", lab.action_drop_tables, table_terms
        )
    yield from _field_entries(lab)
    for tab in TABS:
        yield from _view_entries(lab, tab)
    yield from _scene_entries(lab)
    yield from _run_entries(lab)


def _export_entries(lab: LabScreen, kind: str) -> Iterator[PaletteEntry]:
    # A tab without content to export raises `InputError`.
    with suppress(InputError):
        if lab.pane is not None:
            export = lab.pane.export(kind)
            is_belt = not {".gif", ".wav"}.isdisjoint(export.writers)
            yield PaletteEntry(
                f"Export the {export.kind} of {export.subject}…",
                f"{lab.session.key_names[kind]}: {', '.join(export.writers)}",
                partial(lab.action_export, kind),
                _BELT_EXPORT_TERMS[kind] if is_belt else _SEARCH_TERMS[kind],
            )


def _tab_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    # Entries that act on the current tab.
    pane = lab.pane
    if pane is None:
        return
    with suppress(InputError):
        yield PaletteEntry(
            "Copy the command line",
            pane.command_line(),
            partial(lab.copy_command, pane),
            "clipboard shell script cli",
        )
    if isinstance(pane, ViewsPane) and pane.visible_charts() is not None:
        yield from _plot_entries(lab, pane)


def _plot_entries(lab: LabScreen, pane: ViewsPane) -> Iterator[PaletteEntry]:
    # Entries that act on the first visible plot.
    plot = next(view for view in pane.shown_chart_views() if view.chart is not None)

    async def focus_and_run(action: str) -> None:
        plot.focus()
        await plot.run_action(action)

    for binding in ChartView.BINDINGS:
        if isinstance(binding, Binding) and binding.action in _PLOT_TERMS:
            yield PaletteEntry(
                binding.tooltip or binding.description,
                f"In the plot: {key_text(lab.app, binding.key.split(',')[0])}",
                partial(focus_and_run, binding.action),
                _PLOT_TERMS[binding.action],
            )
    for title, help_text, copy, terms in (
        ("Copy the plot as text", "", lab.copy_plot, "picture image characters"),
        ("Copy the picture", ", as PNG", lab.copy_picture, "plot figure image png"),
    ):
        yield PaletteEntry(
            title, f"To the clipboard{help_text}", partial(copy, pane), f"{terms} clipboard"
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
    for key, panel in PANELS.items():
        scene, report = panel_scene(panel), f"scene fig-{key}: {panel.caption}"
        yield entry(f"Scene of Fig. {key}", panel.caption, scene, "", report)


def _run_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    bindings = [binding for binding in RunsTable.BINDINGS if isinstance(binding, Binding)]
    for run in lab.session.runs:
        for binding in bindings:
            action = next((name for name in _RUN_TERMS if f"'{name}'" in binding.action), "")
            if action and (run.result is not None or action in ("load", "delete")):
                request = RunActionRequested(run.number, action)
                yield PaletteEntry(
                    f"{binding.description} run {run.number}",
                    f"In the run list: {key_text(lab.app, binding.key.split(',')[0])}",
                    partial(lab.post_message, request),
                    _RUN_TERMS[action],
                )


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
