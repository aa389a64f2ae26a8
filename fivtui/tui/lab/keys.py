"""Key bindings of the laboratory, the most important first."""

from typing import Final

from textual.binding import Binding

from fivtui.tui.tabs import TABS

LAB_KEYS: Final = (
    Binding("f5,ctrl+r", "run", "Run", key_display="F5"),
    Binding("f5,ctrl+r", "stop", "Stop", key_display="F5"),
    Binding("f1", "help", "Help", key_display="F1"),
    Binding("f2", "turn_tab(1)", "Tab", key_display="F2"),
    Binding("shift+f2", "turn_tab(-1)", "Previous tab", show=False),
    Binding("f3", "list_runs", "Runs", key_display="F3"),
    Binding("f4", "switch_engine", "Engine", key_display="F4"),
    Binding("f9", "run_both", "Compare with the FMU", show=False),
    Binding("f10,ctrl+g", "work", "Compute", key_display="F10", show=False),
    Binding("f6", "export('figure')", "Figure…", key_display="F6"),
    Binding("f7", "export('data')", "Data…", key_display="F7"),
    Binding("f8", "reset", "Reset", show=False),
    Binding("shift+f8", "reset_all", "Reset all", show=False),
    Binding("ctrl+o", "open_scene", "Open a scene or result", show=False),
    Binding("ctrl+s", "save_scene", "Save the scene", show=False),
    Binding("alt+s", "save_scene_as", "Save the scene as", show=False),
    Binding("alt+o", "read_result", "Read a result", show=False),
    Binding("ctrl+z", "undo", "Undo", show=False),
    Binding("ctrl+y", "redo", "Redo", show=False),
    *(
        Binding(tab.key, f"show_tab('{tab.id}')", tab.title, show=False, priority=True)
        for tab in TABS
    ),
)
