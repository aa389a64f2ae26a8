"""Dialogs for exports, scenes and help, the command palette, and copies of plots."""

import os
from functools import partial
from pathlib import Path

import pytest
from textual.pilot import Pilot

from fivtui.model.errors import InputError
from fivtui.scene.files import load_scene
from fivtui.transient.files import load_trajectory
from fivtui.tui.lab.commands import LabCommands
from fivtui.tui.lab.keys import active_keys, key_text
from fivtui.tui.tabs.export import clipboard_command
from tests.support.laboratory import (
    answer,
    app_of,
    chart_of,
    choose,
    click_view,
    command_line,
    endless_simulate,
    flat_text_of,
    focus,
    lab_of,
    palette,
    run_to_end,
    show_tab,
    type_into,
    until,
    until_hidden,
    until_key_bar,
    until_notice,
    until_shown,
)

SIZE = (100, 30)


async def test_exports_overwrite_files_only_after_a_confirmation(
    pilot: Pilot[None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await pilot.press("alt+1", "alt+l", "f6")
    await until_notice(pilot, "no run to export yet: press Run")
    assert not pilot.app.screen.query("#path")
    await run_to_end(pilot)
    await pilot.press("f7")
    await until_shown(pilot, "Export the data of run 1")
    await until_shown(pilot, "base-1.csv")
    await pilot.press("enter")
    await until_notice(pilot, f"data written to base-1.csv in {tmp_path}")
    assert load_trajectory(tmp_path / "base-1.csv").t.size == 10_001

    await pilot.press("f6")
    await answer(pilot, tmp_path / "run.png")
    await until_notice(pilot, f"figure written to run.png in {tmp_path}")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")

    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("mine")
    await pilot.press("f7")
    await answer(pilot, "a.csv")
    await until_shown(pilot, "a.csv exists. Overwrite it?")
    # Another path resets the confirmation.
    await answer(pilot, "b.csv")
    await until_shown(pilot, "b.csv exists. Overwrite it?")
    for path, message in (
        ("a.doc", "suffix of a trajectory file must be one of"),
        ("missing/a.csv", "there is no folder"),
        (".", "suffix"),
        ("", "type a path"),
    ):
        await answer(pilot, path)
        await until_shown(pilot, message)
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.csv").read_text() == "mine"
    await answer(pilot, "a.csv")
    await until_shown(pilot, "a.csv exists. Overwrite it?")
    await pilot.press("enter")
    await until_notice(pilot, "data written to a.csv")
    assert load_trajectory(tmp_path / "a.csv").t.size == 10_001

    def raise_memory_error(*_: object, **__: object) -> str:
        raise MemoryError("too large")

    monkeypatch.setattr("fivtui.tui.tabs.export.save_study", raise_memory_error)
    await pilot.press("f7")
    await answer(pilot, "c.csv")
    await until_notice(pilot, "data: unexpected MemoryError: too large")
    assert not (tmp_path / "c.csv").exists()


async def test_help_describes_the_focused_field_and_the_keys(pilot: Pilot[None]) -> None:
    await focus(pilot, "k_nl")
    await pilot.press("question_mark")
    await until_shown(pilot, "Keys that work now")
    page = flat_text_of(pilot)
    for phrase in ("F5 Ctrl+R Run the scene", "F1 ? Help: keys", "↑ Increase", "Shift+F2"):
        assert phrase in page, phrase
    pages = []
    while "Eq. 4" not in page:
        pages.append(page)
        await pilot.press("pagedown")
        page = flat_text_of(pilot)
        assert page not in pages
    help_text = " ".join([*pages, page])
    assert help_text.index("Go to the plot") < help_text.index("k_nl: cubic contact stiffness")
    for phrase in ("symbol k_nl", "unit N/m^3", "from 0 to 1e+24 N/m^3", "default 100"):
        assert phrase in help_text, phrase
    assert "Eq. 1 P = −k2 y − k_nl y³" in help_text
    await pilot.press("escape")
    await until(pilot, lambda: not pilot.app.screen.query("#dialog"))
    await pilot.press("alt+p", "question_mark")
    await until_shown(pilot, "Zoom in along y")
    await pilot.press("q")
    await until(pilot, lambda: not pilot.app.screen.query("#dialog"))


async def test_the_help_lists_every_active_key_of_every_part_with_what_it_does(
    pilot: Pilot[None],
) -> None:
    screen = pilot.app.screen
    await run_to_end(pilot)
    for keys in (
        ("alt+f", "escape"),
        ("alt+t",),
        ("alt+r",),
        ("alt+1", "alt+p"),
        ("alt+minus", "alt+p"),
    ):
        await pilot.press(*keys)
        await pilot.pause()
        rows = {row.label: row.value for row in active_keys(screen)}
        listed = " ".join(rows).split()
        for key, active in screen.active_bindings.items():
            assert key_text(pilot.app, key) in listed, (keys, key)
            name = active.binding.action.partition("(")[0].removeprefix("app.")
            name = name.removeprefix("screen.")
            nodes = (active.node, screen, pilot.app)
            assert any(
                hasattr(node, f"{prefix}action_{name}") for node in nodes for prefix in ("", "_")
            ), active
    for phrase in ("Search", "Half a page down"):
        assert phrase in rows.values()


async def test_the_help_lists_no_key_that_a_field_types_or_that_has_no_effect(
    pilot: Pilot[None],
) -> None:
    screen = pilot.app.screen
    for keys, selector in (
        (("alt+f",), "#row-mu TextEditor"),
        # Before the first result a chart is empty.
        (("alt+6", "alt+p"), "#sweep-chart"),
        (("alt+i",), "#sweep-input"),
        # The numbers of a view hide its charts.
        (("alt+2", "alt+p", "v", "v", "alt+p"), "RowsView#facts"),
    ):
        await pilot.press(*keys)
        widget = screen.query_one(selector)
        await until(pilot, partial(getattr, widget, "has_focus"))
        listed = {row.value for row in active_keys(screen)}
        assert listed.isdisjoint({"Zoom in", "Zoom out", "Fit the axes"}), keys
        assert ("Search" in listed) is (selector == "RowsView#facts")
        assert "Go to the plot or table" in listed


async def test_keys_focus_every_part_and_follow_in_the_key_bar(
    pilot: Pilot[None],
) -> None:
    screen = pilot.app.screen
    await pilot.press("alt+6")
    for key, selector in (
        ("alt+p", "#sweep-chart"),
        ("alt+i", "#sweep-input"),
        ("alt+t", "TabLine"),
        ("alt+r", "RunsTable"),
        ("alt+f", "#row-mu TextEditor"),
    ):
        await pilot.press(key)
        widget = screen.query_one(selector)
        await until(pilot, partial(getattr, widget, "has_focus"))
    # Vi's keys of windows go to the part in a direction, also from a number; others are ignored.
    for key, selector in (
        ("l", "#sweep-chart"),
        ("k", "TabLine"),
        ("j", "RunsTable"),
        ("x", "RunsTable"),
        ("ctrl+h", "#row-mu TextEditor"),
    ):
        await pilot.press("ctrl+w", key)
        widget = screen.query_one(selector)
        await until(pilot, partial(getattr, widget, "has_focus"))
    await pilot.resize_terminal(140, 24)
    for tab, selector, label in (
        ("alt+2", "#growth", "v View"),
        ("alt+1", "#plot-y", "i Limits"),
        ("alt+3", "#map-chart", "v View"),
        ("alt+0", "#figures", "o Load scene"),
        ("f3", "RunsTable", "x Delete"),
    ):
        await show_tab(pilot, tab)
        screen.query_one(selector).focus()
        await until_shown(pilot, f" {label} ")
        await until_key_bar(pilot, "F5 Run F10 Compute F1 Help F2 Tab ")


TITLE_BY_QUERY = {
    "csv": "Export the data", "phase": "Run: Phase", "plot": "Export the figure",
    "help": "Help: keys", "save": "Save the scene", "load": "Load run", "import": "Read a",
    "picture": "Copy the picture", "pdf": "Export the figure", "exit": "Quit", "dark": "Theme",
    "fft": "Run: Spectrum", "film": "Run: Belt", "wav": "Run: Belt",
    "measured": "Run: Measured", "validate": "Run: Measured", "log": "Logarithmic x",
    "compare": "Run: Difference", "tolerance": "Edit tol", "speed": "Edit v_belt",
    "calibrate": "Tab Fit",
    "preload": "Edit F", "bifurcation": "Tab Branch", "probability": "Tab Risk",
    "zoom": "Zoom in", "cursor": "First cursor", "clipboard": "Copy the command",
    "remove": "Delete run", "keymap": "Help: keys", "limit cycle": "Tab Branch",
    "abort": "", "ffff": "",
}  # fmt: skip


async def test_the_palette_finds_by_meaning_focuses_fields_and_acts_on_plots(
    pilot: Pilot[None],
) -> None:
    await run_to_end(pilot)
    for query, title in (
        ("csv", "Export the data of run 1"),
        ("plot", "Export the figure of run 1"),
        ("phase", "Run: Phase"),
        ("help", "Help: keys that work now"),
    ):
        await palette(pilot, query)
        await until_shown(pilot, title)
        if query != "phase":
            await pilot.press("escape")
            await until(pilot, lambda: pilot.app.screen is pilot.app.screen_stack[0])
        else:
            await pilot.press("enter")
            await until(pilot, lambda: pilot.app.screen.query_one("#phase-y").display)
            await until_shown(pilot, "ẏ")
    provider = LabCommands(pilot.app.screen)
    await provider.startup()
    for query, title in TITLE_BY_QUERY.items():
        hits = sorted([hit async for hit in provider.search(query)], key=lambda hit: -hit.score)
        titles = [str(getattr(hit, "match_display", "")) for hit in hits[:3]]
        assert any(candidate.startswith(title) for candidate in titles) if title else not titles, (
            query
        )
    await click_view(pilot, "time")
    await choose(pilot, "mass", "Edit m")
    editor = pilot.app.screen_stack[0].query_one("#row-m TextEditor")
    await until(pilot, lambda: editor.has_focus)
    await choose(pilot, "logarithmic y", "Logarithmic y axis")
    chart = chart_of(pilot, "plot-y")
    await until(pilot, lambda: chart.view.log_y)


async def test_plots_are_copied_as_text_and_as_pictures(
    pilot: Pilot[None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab = lab_of(pilot)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.delenv("DISPLAY", raising=False)
    await run_to_end(pilot)
    # `when_ready`: as soon as the pane of the tab exists.
    lab.tab_book.when_ready(lab.copy_plot)
    await until(pilot, lambda: "off belt" in pilot.app.clipboard)
    assert "⢕" in pilot.app.clipboard
    assert "t (s)" in pilot.app.clipboard
    lab.tab_book.when_ready(lab.copy_picture)
    await until_notice(pilot, "a picture cannot be copied without a desktop")
    program_folder = tmp_path / "bin"
    program_folder.mkdir()
    # The sixth argument is the picture: xclip -selection clipboard -target image/png -in PICTURE.
    (program_folder / "xclip").write_text('#!/bin/sh\ncp "$6" "$COPIED"\n')
    (program_folder / "xclip").chmod(0o755)
    monkeypatch.setenv("PATH", f"{program_folder}:{os.environ['PATH']}")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("COPIED", str(tmp_path / "copied.png"))
    lab.tab_book.when_ready(lab.copy_picture)
    await until_notice(pilot, "the figure of run 1 is copied")
    assert (tmp_path / "copied.png").read_bytes().startswith(b"\x89PNG")
    (program_folder / "xclip").write_text("#!/bin/sh\nexit 1\n")
    lab.tab_book.when_ready(lab.copy_picture)
    await until_notice(pilot, "the picture is not copied: xclip failed")


def test_each_desktop_copies_pictures_by_its_own_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.png"
    assert clipboard_command(path, "darwin", {})[0] == "osascript"
    assert clipboard_command(path, "win32", {})[0] == "powershell"
    monkeypatch.setattr("shutil.which", lambda name: name)
    wayland = clipboard_command(path, "linux", {"WAYLAND_DISPLAY": "wayland-0", "DISPLAY": ":0"})
    assert "wl-copy --type image/png" in " ".join(wayland)
    with pytest.raises(InputError, match="the plot can be copied as text"):
        clipboard_command(path, "linux", {})


async def test_the_palette_lists_and_runs_applicable_commands(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    session = app_of(pilot).session
    provider = LabCommands(pilot.app.screen)
    await provider.startup()
    # All commands, of which the palette shows the first.
    titles = " ".join([str(hit.text) async for hit in provider.discover()])
    assert "Run the scene and keep the run" in titles
    for phrase in ("of run", "Undo", "Stop the run"):
        assert phrase not in titles
    with monkeypatch.context() as patched:
        patched.setattr("fivtui.scene.run.compute", endless_simulate)
        await pilot.press("f5")
        await choose(pilot, "stop", "Stop the run")
        await until(pilot, lambda: session.runs.active is None)

    await choose(pilot, "stiff-c", "Preset stiff-contact")
    await until(pilot, lambda: session.texts["k_nl"] == "300")
    assert (await focus(pilot, "k_nl")).value == "300"
    assert command_line(session) == "fivtui simulate stiff-contact"
    await choose(pilot, "undo", "Undo")
    await until(pilot, lambda: session.texts["k_nl"] == "100")

    # The scene of a figure of the paper.
    await choose(pilot, "fig. 13", "Scene of Fig. 13")
    await until_shown(pilot, "scene fig-13")
    assert command_line(session) == ("fivtui simulate --set k_nl=20 --set mu=0.5 --tol=1e-09")
    await choose(pilot, "undo", "Undo")
    await until(pilot, lambda: session.texts["k_nl"] == "100")

    await choose(pilot, "rk4", "Method: rk4")
    await until_shown(pilot, "method rk4")
    await pilot.press("shift+f8", "alt+1")
    await type_into(pilot, "F", "90")
    await choose(pilot, "copy", "Copy the command line")
    await until(pilot, lambda: pilot.app.clipboard == "fivtui simulate --set F=90")
    await until_notice(pilot, "copied: fivtui simulate --set F=90")
    await run_to_end(pilot)
    await pilot.press("ctrl+p")
    await until_shown(pilot, "Export the figure of run 2")


async def test_a_scene_is_saved_and_opened_again(pilot: Pilot[None], tmp_path: Path) -> None:
    session = app_of(pilot).session
    await type_into(pilot, "F", "-")
    await pilot.press("ctrl+s")
    await until_notice(pilot, "F = '-': not a number")
    assert not pilot.app.screen.query("#path")
    await type_into(pilot, "F", "90")
    await pilot.press("ctrl+s")
    await until_shown(pilot, "base.toml")
    await answer(pilot, "mine.toml")
    await until(pilot, (tmp_path / "mine.toml").is_file)
    await until(pilot, lambda: session.name == "mine")
    assert load_scene(tmp_path / "mine.toml").parameters.F == 90.0
    await until_hidden(pilot, "(changed)")
    await pilot.press("up")
    await until_shown(pilot, "mine (changed)")
    await pilot.press("ctrl+o")
    await answer(pilot, "mine.toml")
    await until(pilot, lambda: not session.changed_fields)
    (tmp_path / "other.toml").write_text("[tool]\n")
    await pilot.press("ctrl+o")
    await answer(pilot, "~no-user/other.toml")
    await until_shown(pilot, "~no-user/other.toml: ")
    await answer(pilot, "other.toml")
    await until_shown(pilot, "not a scene")
    await pilot.press("escape", "alt+s")
    await until_shown(pilot, "Save the scene as")
    assert session.name == "mine"
