"""Key bindings of the laboratory, the most important first, and all active keys.

The laboratory is the screen of the terminal program in which a scene, a parameter set with the
settings of its run, is edited and run.
"""

from collections.abc import Mapping
from typing import Any, Final

from textual.app import App
from textual.binding import ActiveBinding, Binding
from textual.screen import Screen
from textual.widgets import Input

from fivtui.results import Row
from fivtui.tui.tabs import TABS


def _key(
    name: str, keys: str, action: str, description: str, label: str = "", *, priority: bool = False
) -> Binding:
    # `name`: that of the key in the configuration file. `label`: its text in the key bar.
    return Binding(
        keys,
        action,
        label or description,
        show=bool(label),
        key_display=keys.partition(",")[0].upper() if label else None,
        priority=priority,
        tooltip=description,
        id=name,
    )


LAB_KEYS: Final = (
    # "stop" has the keys of "run": `LabActions.check_action` enables it only during a run.
    _key("run", "f5,ctrl+r", "run", "Run the scene and keep the run", "Run"),
    _key("stop", "f5,ctrl+r", "stop", "Stop the run", "Stop"),
    _key(
        "compute",
        "f10,ctrl+g",
        "toggle_computation",
        "Start or stop the computation of the tab",
        "Compute",
    ),
    _key("help", "f1,question_mark", "help", "Help: keys that work now", "Help", priority=True),
    _key("next-tab", "f2", "switch_tab(1)", "Next tab", "Tab"),
    _key("previous-tab", "shift+f2", "switch_tab(-1)", "Previous tab"),
    _key("runs", "f3", "toggle_runs", "Go to the run list, or back", "Runs"),
    _key("figure", "f6", "export('figure')", "Write the figure", "Figure"),
    _key("data", "f7", "export('data')", "Write the data", "Data"),
    _key("engine", "f4", "switch_engine", "Next engine: native solver, Python FMU, native FMU"),
    _key("both", "f9", "compare_engines", "Compare with the FMU"),
    # The live curve is the motion of the edited scene, run in the background after every edit.
    _key("live", "alt+l", "switch_live", "Live curve on or off", priority=True),
    _key("reset", "f8", "reset", "Reset the field"),
    _key("reset-all", "shift+f8", "reset_all", "Reset all fields"),
    _key("open", "ctrl+o", "open_scene", "Open a scene or result"),
    _key("save", "ctrl+s", "save_scene", "Save the scene"),
    _key("save-as", "alt+s", "save_scene(True)", "Save the scene as"),
    # Like "open", but its dialog accepts only results.
    _key("read", "alt+o", "read_result", "Read a result"),
    _key("edit", "e", "edit_scene", "Edit the scene in your editor"),
    _key("reload", "alt+d", "reload_scene", "Read the scene's file again", priority=True),
    _key("undo", "ctrl+z", "undo", "Undo an edit or a deleted run"),
    _key("redo", "ctrl+y", "redo", "Redo"),
    _key("go-fields", "alt+f", "focus_part('fields')", "Go to the fields", priority=True),
    _key("go-tabs", "alt+t", "focus_part('tabs')", "Go to the titles of the tabs", priority=True),
    # The bar of a tab has its primary action and the inputs of its ranges.
    _key("go-bar", "alt+i", "focus_part('bar')", "Go to the action and ranges", priority=True),
    _key("go-plot", "alt+p", "focus_part('plot')", "Go to the plot or table", priority=True),
    _key("go-runs", "alt+r", "focus_part('runs')", "Go to the run list", priority=True),
    _key(
        "go",
        "ctrl+w",
        "ask_part",
        "Go to the fields (then h), the plot (l), the titles (k) or the runs (j)",
        priority=True,
    ),
    *(
        _key(f"tab-{tab.id}", tab.key, f"show_tab('{tab.id}')", f"Tab {tab.title}", priority=True)
        for tab in TABS
    ),
)
KEY_IDS: Final = tuple(str(binding.id) for binding in LAB_KEYS)
# Keys that edit the text of an input.
_TYPING_KEYS: Final = {binding.key for binding in Binding.make_bindings(Input.BINDINGS)}
# Prefixes of Textual's actions that scroll.
_SCROLLING_ACTIONS: Final = ("scroll_", "page_")


def active_keys(screen: Screen[Any]) -> list[Row]:
    """Rows of the active keys: of the focused widget, the laboratory, typing and scrolling."""

    def rank(active: ActiveBinding) -> int:
        is_typing = isinstance(active.node, Input) and active.binding.key in _TYPING_KEYS
        if is_typing or active.binding.action.startswith(_SCROLLING_ACTIONS):
            return 2
        return int(active.node in (screen, screen.app))

    # One row per purpose lists all keys that serve it.
    keys: dict[str, list[str]] = {}
    for active in sorted(screen.active_bindings.values(), key=rank):
        binding = active.binding
        purpose = active.tooltip or binding.description
        if binding.id is None and purpose.istitle():
            # Textual capitalizes every word of its own descriptions.
            purpose = purpose.capitalize()
        if active.enabled and purpose:
            keys.setdefault(purpose, []).append(key_text(screen.app, binding.key))
    return [Row(" ".join(dict.fromkeys(names)), purpose) for purpose, names in keys.items()]


def key_names(app: App[Any], configured_keys: Mapping[str, str]) -> dict[str, str]:
    """The first key of each binding as displayed, by identifier."""
    keys = {str(binding.id): binding.key for binding in LAB_KEYS} | dict(configured_keys)
    return {name: key_text(app, key.split(",")[0]) for name, key in keys.items()}


def key_text(app: App[Any], key: str) -> str:
    """A key as displayed, such as Alt+F, Shift+F2, Esc or ↑."""
    *modifiers, base = key.split("+")
    text = app.get_key_display(Binding(base, ""))
    if modifiers or len(text) > 1:
        text = text[:1].upper() + text[1:]
    return "+".join([*(name.capitalize() for name in modifiers), text])
