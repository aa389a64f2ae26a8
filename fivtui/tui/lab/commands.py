"""Entries of the command palette."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Final

from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.fuzzy import Matcher

from fivtui.model import InputError
from fivtui.scene import PRESETS, Scene
from fivtui.tui.persistence import Slot, load_state
from fivtui.tui.session import FIELDS, Run, paper_scenes
from fivtui.tui.tabs import (
    KINDS,
    TABS,
    FieldEdited,
    RunActionRequested,
    SceneLoaded,
    SessionRequested,
    TabSpec,
    ViewsPane,
)

from .screen import LabScreen

# Score of an entry found by its meaning: below those found by their titles.
_BY_MEANING: Final = 0.1
_EXPORTS: Final = {
    "figure": "plot picture image pdf png svg save export write",
    "data": "csv npz parquet json table numbers save export write",
}


@dataclass(frozen=True, slots=True)
class PaletteEntry:
    """An entry of the command palette."""

    title: str
    help: str
    run: Callable[[], object]
    # Words besides the title by which it is found.
    meaning: str = ""

    def score(self, matcher: Matcher, query: str) -> float:
        """How well it fits a search, 0 if not at all: by title, else by what it means or says."""
        found = matcher.match(self.title)
        words = f"{self.meaning} {self.help}".lower()
        if found <= 0 and all(word in words for word in query.lower().split()):
            return _BY_MEANING
        return found


def _commands(lab: LabScreen) -> Iterator[PaletteEntry]:
    if lab.session.runs.active is None:
        yield PaletteEntry("Run the transient", "F5", lab.action_run, "simulate compute start plot")
        both = "F9: native solver, then FMU, then compare"
        yield PaletteEntry("Run with native solver and FMU", both, lab.action_run_both)
    else:
        yield PaletteEntry("Stop the run", "F5", lab.action_stop)
    yield from _tab_commands(lab)
    session = lab.session
    yield PaletteEntry(
        f"Engine: {session.next_engine}", f"F4; now {session.engine}", lab.action_switch_engine
    )
    live = "Alt+L: the transient follows every edit; its runs are not kept"
    switch = f"Live curve {'off' if session.lives else 'on'}"
    yield PaletteEntry(switch, live, lab.action_switch_live, "ghost redraw preview background")
    yield PaletteEntry("Help: keys that work now", "F1, ?", lab.action_help, "shortcuts manual")
    yield PaletteEntry("Open a scene or result…", "Ctrl+O", lab.action_open_scene, "load file toml")
    yield PaletteEntry("Save the scene", "Ctrl+S", lab.action_save_scene)
    yield PaletteEntry("Save the scene as…", "Alt+S", lab.action_save_scene_as)
    for path in session.recent:
        yield PaletteEntry(f"Recent: {path}", "Open again", partial(lab.action_open_recent, path))
    kinds = "Alt+O: a run, sweep, map or trade-off"
    yield PaletteEntry("Read a result…", kinds, lab.action_read_result, "import load csv npz json")
    if session.can_undo:
        yield PaletteEntry("Undo", "Ctrl+Z", lab.action_undo)
    if session.can_redo:
        yield PaletteEntry("Redo", "Ctrl+Y", lab.action_redo)
    if lab.session.changed:
        yield PaletteEntry(
            "Reset all fields", "To the values of the loaded scene", lab.action_reset_all
        )
    yield from _choices(lab)
    for tab in TABS:
        yield PaletteEntry(f"Tab {tab.title}", tab.key, partial(lab.show_tab, tab.id))
        yield from _view_commands(lab, tab)
    yield from _scene_commands(lab)
    yield from _run_commands(lab)


def _tab_commands(lab: LabScreen) -> Iterator[PaletteEntry]:
    pane = lab.pane
    if pane is None:
        return
    for what, key in KINDS.items():
        with suppress(InputError):
            export = pane.export(what)
            title = f"Export the {export.what} of {export.of}…"
            text = f"{key}: {', '.join(export.suffixes)}"
            run = partial(lab.action_export, what)
            yield PaletteEntry(title, text, run, _EXPORTS.get(what, ""))
    with suppress(InputError):
        line = pane.command_line()
        yield PaletteEntry("Copy the command line", line, lab.action_copy_command)


def _view_commands(lab: LabScreen, tab: TabSpec) -> Iterator[PaletteEntry]:
    def show(view: str) -> None:
        lab.show_tab(tab.id)
        lab.when_pane(lambda pane: pane.show_view(view) if isinstance(pane, ViewsPane) else None)

    views = getattr(tab.kind(), "VIEWS", {})
    for view, title in views.items() if len(views) > 1 else ():
        yield PaletteEntry(
            f"{tab.title}: {title}", f"{tab.key}, then v", partial(show, view), "plot"
        )


def _scene_commands(lab: LabScreen) -> Iterator[PaletteEntry]:
    def command(title: str, text: str, scene: Scene, source: str, words: str) -> PaletteEntry:
        return PaletteEntry(
            title, text, partial(lab.post_message, SceneLoaded(scene, source, words))
        )

    for name, scene in PRESETS.items():
        yield command(f"Preset {name}", scene.description, scene, name, f"preset {name}")
    for scene, caption in paper_scenes():
        title = f"Scene of {scene.name.replace('fig-', 'Fig. ')}"
        yield command(title, caption, scene, "", f"scene {scene.name}: {caption}")


def _run_commands(lab: LabScreen) -> Iterator[PaletteEntry]:
    runs = lab.session.runs

    def command(title: str, text: str, run: Run, what: str) -> PaletteEntry:
        return PaletteEntry(
            title, text, partial(lab.post_message, RunActionRequested(run.number, what))
        )

    for run in runs:
        yield command(f"Load the scene of run {run.number}", "In the run list: Enter", run, "load")
        yield command(f"Delete run {run.number}", "In the run list: x", run, "delete")
        if run.result is None:
            continue
        if run is not runs.displayed:
            yield command(f"Show run {run.number}", "Plots and results of this run", run, "show")
            title = f"{'Hide' if run.overlaid else 'Overlay'} run {run.number}"
            yield command(title, "In the run list: Space", run, "overlay")
        title = "Clear the baseline" if run is runs.baseline else f"Baseline: run {run.number}"
        yield command(title, "In the run list: b", run, "baseline")


def _session_commands(lab: LabScreen, others: Iterable[Slot]) -> Iterator[PaletteEntry]:
    for slot in others:
        used = f"last used {datetime.fromtimestamp(slot.used):%Y-%m-%d %H:%M}; this one is saved"
        open_it = partial(lab.post_message, SessionRequested(slot.number))
        yield PaletteEntry(f"Open session {slot.number}: {_content(slot)}", used, open_it)


def _content(slot: Slot) -> str:
    try:
        state = load_state(slot.path)
    except InputError as error:
        return str(error)
    if state is None:
        return "empty"
    names = ["scene " + state.edited.loaded.name]
    count = len(state.runs.runs)
    if count:
        names.append(f"{count} run{'s' * (count > 1)}")
    return ", ".join([*names, *(key for key in state.results if not key.startswith("run-"))])


def _choices(lab: LabScreen) -> Iterator[PaletteEntry]:
    for field in FIELDS.values():
        for text, meaning in (field.choices or {}).items():
            if text != lab.session.texts[field.name]:
                message = partial(lab.post_message, FieldEdited(field.name, text, typed=False))
                yield PaletteEntry(f"{field.name.capitalize()}: {text}", meaning, message)


class LabCommands(Provider):
    """The laboratory's commands, followed by those of every Textual app."""

    async def startup(self) -> None:
        """List the other sessions once, as this reads files."""
        self._sessions: list[PaletteEntry] = []
        if isinstance(self.screen, LabScreen):
            self._sessions += _session_commands(self.screen, self.screen.other_sessions())

    def _all(self) -> Iterator[PaletteEntry]:
        if isinstance(self.screen, LabScreen):
            yield from _commands(self.screen)
        yield from self._sessions
        for command in self.app.get_system_commands(self.screen):
            yield PaletteEntry(*command[:3])

    async def discover(self) -> Hits:
        """All entries, while the search is empty."""
        for command in self._all():
            yield DiscoveryHit(command.title, command.run, help=command.help)

    async def search(self, query: str) -> Hits:
        """The entries that match the search."""
        matcher = self.matcher(query)
        for command in self._all():
            score = command.score(matcher, query)
            if score > 0:
                title = matcher.highlight(command.title)
                yield Hit(score, title, command.run, help=command.help)
