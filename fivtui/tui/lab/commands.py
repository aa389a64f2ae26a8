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

from textual.actions import parse
from textual.binding import Binding, BindingType
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.fuzzy import Matcher

from fivtui.model import InputError
from fivtui.paper import PANELS
from fivtui.scene import PRESETS
from fivtui.tui.chart import ChartView
from fivtui.tui.persistence import Slot, load_session
from fivtui.tui.session import FIELDS
from fivtui.tui.tabs import (
    EXPORT_KINDS,
    TABS,
    Pane,
    RunActionRequested,
    SceneLoaded,
    TabSpec,
    ViewsPane,
    panel_scene,
)

from .keys import LAB_KEYS, key_text
from .run_list import RunsTable
from .screen import LabScreen

# Search terms by identifier of a key, tab, view or row of `_KEYLESS`, by action of a plot or run,
# and by title of a command of every Textual application. What has none is not in the palette.
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
    "belts": "belt speed stick slip static friction Stribeck v_belt mu_s v_s",
    "tables": "preload friction belt speed course csv measured brake application ramp",
    "limits": "range zoom scale",
    "fit": "reset zoom limits all",
    "zoom(-1)": "enlarge magnify",
    "zoom(1)": "shrink",
    "cursor(0)": "read value point crosshair measure difference delta",
    "cursor(1)": "read value point crosshair measure difference delta",
    "log('x')": "linear scale",
    "log('y')": "linear scale",
    "request('load')": "scene",
    "request('overlay')": "hide draw beside",
    "request('baseline')": "compare difference",
    "request('show')": "plots results",
    "request('delete')": "remove",
    "Theme": "dark light colours colors appearance",
    "Quit": "exit leave close end",
    "Screenshot": "picture image svg print screen",
    "Maximize": "full screen zoom enlarge",
}
# Commands without a key: identifier, title, help and action.
_KEYLESS: Final = (
    ("belts", "Belt of finite speed", "v_belt, μ_s and v_s: the slider sticks", "set_belt(True)"),
    ("belts", "Belt faster than the slider", "As in the paper: no stick", "set_belt(False)"),
    ("tables", "Parameters over time from a file…", "CSV: time, F, mu, k2, c1, …", "read_tables"),
    ("tables", "Drop the tables over time", "Values at t = 0 stay", "drop_tables"),
)


@dataclass(frozen=True, slots=True)
class PaletteEntry:
    """An entry of the command palette; `search_terms` find it besides its title and help."""

    title: str
    help: str
    run: Callable[[], object]
    search_terms: str = ""

    def score(self, matcher: Matcher, query: str) -> float:
        """Score of the match with a search; 0 if nothing matches."""
        words, title = query.lower().split(), self.title.lower()
        terms = re.split(r"[^\w+-]+", f"{title} {self.search_terms} {self.help}".lower())
        is_title = all(word in title for word in words)
        are_terms = all(any(term.startswith(word) for term in terms) for word in words)
        # Words of the title count more than terms, these more than the letters of the title.
        letters = matcher.match(self.title)
        return max(2.0 * is_title, 1.0 * are_terms) + 0.5 * letters / (1.0 + letters)


def _lab_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    names = lab.session.key_names
    keys = [(str(key.id), str(key.tooltip), names[str(key.id)], key.action) for key in LAB_KEYS]
    for name, title, help_text, action in (*keys, *_KEYLESS):
        terms = _SEARCH_TERMS.get(name.removeprefix("tab-"))
        _, action_name, parameters = parse(action)
        if name in EXPORT_KINDS:
            yield from _export_entries(lab, name)
        elif terms and lab.check_action(action_name, parameters):
            yield PaletteEntry(title, help_text, partial(lab.run_action, action), terms)
    if lab.tab_book.pane is not None:
        yield from _pane_entries(lab, lab.tab_book.pane)
    for path in lab.session.recent:
        yield PaletteEntry(f"Recent: {path}", "Open again", partial(lab.open_path, Path(path)))
    yield from _field_entries(lab)
    for tab in TABS:
        yield from _view_entries(lab, tab)
    yield from _scene_entries(lab)
    yield from _run_entries(lab)


def _export_entries(lab: LabScreen, kind: str) -> Iterator[PaletteEntry]:
    # A tab without content to export raises `InputError`.
    with suppress(InputError):
        if lab.tab_book.pane is not None:
            export = lab.tab_book.pane.export(kind)
            is_belt = not {".gif", ".wav"}.isdisjoint(export.writers)
            yield PaletteEntry(
                f"Export the {export.kind} of {export.subject}…",
                f"{lab.session.key_names[kind]}: {', '.join(export.writers)}",
                partial(lab.action_export, kind),
                f"{_SEARCH_TERMS[kind]} {_SEARCH_TERMS['belt'] if is_belt else ''}",
            )


def _pane_entries(lab: LabScreen, pane: Pane) -> Iterator[PaletteEntry]:
    # Entries that act on the current tab.
    with suppress(InputError):
        line, copy_line = pane.command_line(), partial(lab.copy_command, pane)
        yield PaletteEntry("Copy the command line", line, copy_line, "clipboard shell script cli")
    if not isinstance(pane, ViewsPane) or pane.visible_charts() is None:
        return
    plot = next(view for view in pane.shown_chart_views() if view.chart is not None)

    async def focus_and_run(action: str) -> None:
        plot.focus()
        await plot.run_action(action)

    for binding, key in _described_bindings(lab, ChartView.BINDINGS):
        yield PaletteEntry(
            binding.tooltip or binding.description,
            f"In the plot: {key}",
            partial(focus_and_run, binding.action),
            _SEARCH_TERMS[binding.action],
        )
    copy_plot, copy_picture = partial(lab.copy_plot, pane), partial(lab.copy_picture, pane)
    yield PaletteEntry("Copy the plot as text", "To the clipboard", copy_plot, "picture image")
    yield PaletteEntry("Copy the picture", "To the clipboard, as PNG", copy_picture, "plot figure")


def _described_bindings(
    lab: LabScreen, bindings: Iterable[BindingType]
) -> Iterator[tuple[Binding, str]]:
    # The bindings with search terms, each with its first key as displayed.
    for binding in bindings:
        if isinstance(binding, Binding) and binding.action in _SEARCH_TERMS:
            yield binding, key_text(lab.app, binding.key.split(",")[0])


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
    def entry(title: str, help_text: str, message: SceneLoaded) -> PaletteEntry:
        load = partial(lab.post_message, message)
        return PaletteEntry(title, help_text, load, "load example scene case")

    for name, scene in PRESETS.items():
        message = SceneLoaded(scene, name, f"preset {name}")
        yield entry(f"Preset {name}", scene.description, message)
    for key, panel in PANELS.items():
        message = SceneLoaded(panel_scene(panel), "", f"scene fig-{key}: {panel.caption}")
        yield entry(f"Scene of Fig. {key}", panel.caption, message)


def _run_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    for run in lab.session.runs:
        for binding, key in _described_bindings(lab, RunsTable.BINDINGS):
            action = str(parse(binding.action)[2][0])
            if run.result is not None or action in ("load", "delete"):
                yield PaletteEntry(
                    f"{binding.description} run {run.number}",
                    f"In the run list: {key}",
                    partial(lab.post_message, RunActionRequested(run.number, action)),
                    _SEARCH_TERMS[binding.action],
                )


def _saved_session_entries(lab: LabScreen, slots: Iterable[Slot]) -> Iterator[PaletteEntry]:
    for slot in slots:
        last_used = datetime.fromtimestamp(slot.last_used)
        yield PaletteEntry(
            f"Open session {slot.number}: {_contents_text(slot)}",
            f"last used {last_used:%Y-%m-%d %H:%M}; saves the current session",
            partial(lab.run_action, f"app.open_session({slot.number})"),
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
    studies = [key for key in session.unread_results if isinstance(key, str)]
    return ", ".join([*contents, *studies])


def _field_entries(lab: LabScreen) -> Iterator[PaletteEntry]:
    for field in FIELDS.values():
        focus = partial(lab.focus_field, field.name)
        yield PaletteEntry(f"Edit {field.symbol or field.name}", field.meaning, focus, field.name)
        for text, meaning in (field.choices or {}).items():
            if text != lab.session.texts[field.name]:
                choose = partial(lab.set_text, field.name, text)
                yield PaletteEntry(f"{field.name.capitalize()}: {text}", meaning, choose)


class LabCommands(Provider):
    """Palette entries of the laboratory, followed by those of every Textual application."""

    async def startup(self) -> None:
        """List the other sessions once, because listing them reads files."""
        self._sessions: list[PaletteEntry] = []
        if isinstance(self.screen, LabScreen):
            self._sessions += _saved_session_entries(self.screen, self.screen.other_sessions())

    def _all_entries(self) -> Iterator[PaletteEntry]:
        if isinstance(self.screen, LabScreen):
            yield from _lab_entries(self.screen)
        yield from self._sessions
        for title, help_text, run, _ in self.app.get_system_commands(self.screen):
            # Omit Textual's list of keys: the laboratory has its own.
            if title != "Keys":
                yield PaletteEntry(title, help_text, run, _SEARCH_TERMS.get(title, ""))

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
