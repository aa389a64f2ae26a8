"""The form: fields follow keys, mouse and pasted text, and the verdict follows the fields."""

import re

from textual._xterm_parser import XTermParser
from textual.events import Key, Paste
from textual.pilot import Pilot
from textual.widgets import Checkbox, Input, Select

from fivtui.equilibrium.eigenvalues import stability
from fivtui.model.parameters import Parameters
from fivtui.scene.presets import PRESETS
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.form.editors import TextEditor
from fivtui.tui.lab.form.form import FieldList, Form
from fivtui.tui.lab.form.rows import FieldRow
from fivtui.tui.session.fields import FIELDS
from tests.support.laboratory import (
    app_of,
    focus,
    lab_of,
    text_of,
    type_into,
    until,
    until_hidden,
    until_screen,
    until_shown,
)

SIZE = (80, 24)


async def test_the_first_screen_has_scene_fields_verdict_and_keys(pilot: Pilot[None]) -> None:
    await until_shown(pilot, "F5 Run F10 Compute F1 Help")
    screen_text = text_of(pilot)
    assert "UNSTABLE: growth rate +0.6304 1/s, 0.9186 Hz" in screen_text
    await until_shown(pilot, "0 0.439 0.7 1.5")
    # The motion is drawn without a key.
    await until_shown(pilot, "amplitude of y ±4.401 m")
    assert screen_text.splitlines()[-1].startswith("F5 Run F10 Compute F1 Help")
    lines = [" ".join(line.strip("│").split()) for line in screen_text.splitlines()]
    for label in ("k_nl 100 − + N/m^3", "μ 0.7 − +", "c1 0.32 − + N s/m", "t_end 100 − + s"):
        assert any(line.startswith(label) for line in lines), label
    await focus(pilot, "c2")
    await until_shown(pilot, "vertical damping")
    await until_shown(pilot, "from 0 to 1e+09 N s/m")
    await pilot.press("enter")
    assert pilot.app.focused is pilot.app.screen.query_one("#row-F").query_one(Input)


async def test_the_form_shows_the_scene_passed_to_the_app() -> None:
    app = FivtuiApp(PRESETS["stiff-contact"], "stiff-contact")
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        await until_shown(pilot, "stiff-contact")
        assert (await focus(pilot, "k_nl")).value == "300"


async def test_the_verdict_follows_valid_and_invalid_text(pilot: Pilot[None]) -> None:
    await type_into(pilot, "mu", "0.3")
    await until_shown(pilot, "growth rate -0.03")
    await until_hidden(pilot, "UNSTABLE")
    await until_shown(pilot, "base (changed)")
    await until_screen(pilot, lambda text: "\n│•μ   " in text)
    await type_into(pilot, "mu", "0.7")
    await type_into(pilot, "m", "0")
    await until_screen(
        pilot, lambda text: bool(re.search(r"│•m  .*\n.*m = 0: must be from 1e-12", text))
    )
    await until_shown(pilot, "NO VERDICT: invalid input")
    (await focus(pilot, "m")).value = "[bold]5[/bold"
    await until_shown(pilot, "m = '[bold]5[/bold'")
    await type_into(pilot, "m", "5")
    await until_hidden(pilot, "must be from 1e-12")
    await until_shown(pilot, "UNSTABLE")
    await until_hidden(pilot, "(changed)")
    await type_into(pilot, "k3", "0")
    await type_into(pilot, "F", "-5")
    await until_shown(pilot, "NO VERDICT")
    await until_shown(pilot, "no equilibrium")
    await type_into(pilot, "k3", "60")
    await until_hidden(pilot, "NO VERDICT")
    await type_into(pilot, "F", "0")
    await until_shown(pilot, "NO VERDICT")
    await until_shown(pilot, "no verdict at F = 0")
    await type_into(pilot, "F", "80")
    await until_shown(pilot, "UNSTABLE")


async def test_values_change_by_keys_mouse_and_lists(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    editor = await focus(pilot, "mu")
    await pilot.press("up")
    assert editor.value == "0.71"
    await pilot.press("down", "down", "shift+down")
    assert editor.value == "0.689"
    growth = stability(Parameters(mu=0.689)).growth_rate
    await until_shown(pilot, f"growth rate {growth:+.4g}")
    editor = await focus(pilot, "F")
    await pilot.press(*["up"] * 10)
    await until(pilot, lambda: editor.value == "90")
    assert session.texts["F"] == "90"
    force_line = next(line for line in text_of(pilot).splitlines() if line.startswith("│•F "))
    await pilot.click("#row-F", offset=(force_line.index("+") - 1, 0))
    await until(pilot, lambda: session.texts["F"] == "91")
    assert editor.value == "91"
    pilot.app.screen.query_one(Checkbox).focus()
    await pilot.press("space")
    await until_shown(pilot, "ignored")
    assert not session.scene().separation
    pilot.app.screen.query_one(Select).focus()
    await pilot.press("enter", "down", "enter")
    await until(pilot, lambda: session.texts["method"] == "rk4")


async def test_enter_after_a_focused_check_box_edits_the_row_moved_to(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    # The row below μ has the check box of separation.
    await focus(pilot, "mu")
    await pilot.press("escape", "down", "enter", "space")
    assert not session.scene().separation
    await pilot.press("up", "enter", *"0.27", "enter")
    assert session.texts["mu"] == "0.27"
    assert not session.scene().separation


async def test_edits_are_reset_undone_and_redone(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    await type_into(pilot, "F", "90")
    await type_into(pilot, "mu", "0.3")
    await pilot.press("f8")
    await until_shown(pilot, "base (changed)")
    assert session.changed_fields == ["F"]
    await pilot.press("shift+f8")
    await until_hidden(pilot, "(changed)")
    editor = await focus(pilot, "F")
    assert editor.value == "80"
    # Undo the reset of all fields, that of μ, the edit of μ, and that of F; then nothing is left.
    await pilot.press("ctrl+z")
    assert editor.value == "90"
    await pilot.press("ctrl+z")
    assert session.texts["mu"] == "0.3"
    await pilot.press("ctrl+z")
    assert session.changed_fields == ["F"]
    await pilot.press("ctrl+z", "ctrl+z", "ctrl+z")
    await until_hidden(pilot, "(changed)")
    await pilot.press("ctrl+y", "ctrl+y")
    assert (session.texts["F"], session.texts["mu"]) == ("90", "0.3")
    await until_shown(pilot, "STABLE")
    # Text that is typed and undone at once does not reappear.
    await pilot.press("9", "ctrl+z")
    await pilot.pause()
    assert editor.value == session.texts["F"] == "90"
    # Ctrl+Z in an input of a tab does not change the scene.
    await pilot.press("alt+6", "alt+i")
    await until(pilot, lambda: pilot.app.screen.query_one("#sweep-input").has_focus)
    await pilot.press("ctrl+z")
    await pilot.pause()
    assert session.texts["F"] == "90"


async def test_letters_select_and_change_fields_outside_an_editor(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    await focus(pilot, "k1")
    await pilot.press("escape")
    assert pilot.app.screen.query_one(FieldList).has_focus
    # Next field, three steps of 1 N/m: up, up and down, and a fine step up.
    await pilot.press("j", "l", "l", "h", "L")
    await until(pilot, lambda: session.texts["k2"] == "51.1")
    await until_shown(pilot, "linear contact stiffness")
    await pilot.press("f1")
    await until_shown(pilot, "Keys that work now")
    while "k2: linear contact stiffness" not in text_of(pilot):
        previous_page = text_of(pilot)
        await pilot.press("pagedown")
        assert text_of(pilot) != previous_page
    await pilot.press("escape", "f8")
    await until(pilot, lambda: not session.changed_fields)
    await pilot.press("G", "g", "k", "i")
    assert pilot.app.focused is pilot.app.screen.query_one("#row-m").query_one(Input)


async def test_letters_leave_a_number_and_v_and_n_are_keys_of_the_tab(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    editor = await focus(pilot, "mu")
    # At the start of a number, e is no exponent; j and h are keys of the list around the editor.
    await pilot.press(*"abejhNo", "space", "slash")
    assert (editor.value, session.changed_fields) == ("0.7", [])
    await until_shown(pilot, "amplitude of y ±4.401 m")
    stored = session.settings.setdefault("transient", {})
    await pilot.press("n")
    await until(pilot, lambda: len(stored) == 1)
    await pilot.press("v")
    await until(pilot, lambda: stored.get("view") not in {None, "time"})
    assert editor.has_focus
    assert not session.changed_fields
    await pilot.press(*"7,5e-1v")
    await until(pilot, lambda: session.texts["mu"] == "7.5e-1")
    # A field of text accepts letters, and an optional one the word for its absence.
    await focus(pilot, "start")
    await pilot.press("ctrl+u", *"static")
    await until(pilot, lambda: session.texts["start"] == "static")
    assert FIELDS["v_belt"].accepts("no", "n")
    assert not FIELDS["v_belt"].accepts("", "v")


async def send_sequences(pilot: Pilot[None], *sequences: str) -> None:
    """Send key sequences as a terminal does."""
    for sequence in sequences:
        for event in XTermParser().feed(sequence):
            pilot.app.post_message(event)
    await pilot.pause()


async def test_keys_with_alt_insert_no_text(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    for selector in ("#row-m Input", "#row-start Input"):
        pilot.app.screen.query_one(selector).focus()
        # The last characters are those that Option types on a Mac.
        await send_sequences(pilot, *(f"\x1b{sign}" for sign in "1234567890-=x"), *"¡™£¢∞§¶•ªº–")
        assert not session.changed_fields
    # Also without a pause between two keys.
    await send_sequences(pilot, "\x1b2\x1b6")
    await until(pilot, lambda: session.tab == "sweep")
    await until_shown(pilot, "computes 112 runs")
    range_input = pilot.app.screen.query_one("#sweep-input", Input)
    range_input.focus()
    initial_range = range_input.value
    await send_sequences(pilot, "\x1b7", "\x1b-", "§")
    await until(pilot, lambda: session.tab == "sweep")
    assert range_input.value == initial_range
    await send_sequences(pilot, "\x1b2")
    await until(pilot, lambda: session.tab == "stability")
    await send_sequences(pilot, "\x1bs")
    await until_shown(pilot, "Save the scene as")
    path_input = pilot.app.screen.query_one("#path", Input)
    # A path may contain £, unlike a number or a range.
    await send_sequences(pilot, "\x1b3", "\x1bq", "£")
    assert path_input.value == "base.toml£"
    assert session.tab == "stability"


DECIMAL_COMMAS = (
    ("mu", "0,7", "0.7"),
    ("F", "-,5e-1", "-.5e-1"),
    ("start", "0.1,0,-5e-1 ,1.e3", "0.1,0,-5e-1 ,1.e3"),
    ("start", "1, 0, 0, 0,5", "1, 0, 0, 0.5"),
    ("accuracy", "peak=0,1, half_range=1e-3", "peak=0.1, half_range=1e-3"),
)
INVALID_TEXTS = (
    ("mu", "1.2,3"),
    ("mu", "200"),
    ("start", "0,0,0,0,0"),
    ("accuracy", "peak=1e-4 ü"),
)
# Texts that can be pasted, but not typed.
INVALID_PASTES = (("mu", "0.7kg m_ µ٣;:=é"), ("mu", "0.4 0.5"))


async def replace_text(
    pilot: Pilot[None], name: str, typed: str, text: str, *, paste: bool
) -> Input:
    """Type or paste over the text of a field, and wait until it is `text`."""
    editor = await focus(pilot, name)
    await pilot.press("end", "ctrl+u")
    await until(pilot, lambda: not app_of(pilot).session.texts[name])
    # Pasted line breaks are blanks; test this where no comma is replaced at the same time.
    pasted = typed.replace(" ", "\n", 1) if typed == text else typed
    await send_sequences(pilot, *([f"\x1b[200~{pasted}\n\x1b[201~"] if paste else typed))
    await until(pilot, lambda: editor.value == app_of(pilot).session.texts[name] == text)
    return editor


async def test_a_decimal_comma_is_a_point_and_invalid_text_stays_and_is_marked(
    pilot: Pilot[None],
) -> None:
    for name, typed, text in DECIMAL_COMMAS:
        FIELDS[name].check(text)
        for paste in (False, True):
            editor = await replace_text(pilot, name, typed, text, paste=paste)
            await until(pilot, lambda: editor.cursor_position == len(text))  # noqa: B023
    fields = pilot.app.screen.query_one(FieldList)
    for name, text in (*INVALID_TEXTS, *INVALID_PASTES):
        row = fields.query_one(f"#row-{name}", FieldRow)
        for paste in (True,) if (name, text) in INVALID_PASTES else (False, True):
            editor = await replace_text(pilot, name, text, text, paste=paste)
            await until(pilot, lambda: row.region.height > 1)  # noqa: B023
            # The reason, including the allowed range, is visible.
            await until(pilot, lambda: "must be" in " ".join(row.render().plain.split()))  # noqa: B023
            await until(pilot, lambda: fields.region.contains_region(row.region))  # noqa: B023
            await until(pilot, lambda: editor.has_class("-invalid"))  # noqa: B023


async def test_a_row_accepts_clicks_anywhere_and_a_long_paste(
    pilot: Pilot[None],
) -> None:
    row = pilot.app.screen.query_one("#row-k2", FieldRow)
    editor = row.query_one(TextEditor)
    for column in (1, row.size.width - 1):
        await focus(pilot, "F")
        await pilot.click("#row-k2", offset=(column, 0))
        await until(pilot, lambda: editor.has_focus)
    await pilot.press("end", *["backspace"] * 5)
    editor.post_message(Paste("1" * 20_000))
    await until(pilot, lambda: editor.value == "1" * 20_000)
    await until_shown(pilot, "k2 = inf: not a finite number; must be from 1e-12")
    await until_shown(pilot, "F5 Run")
    width = pilot.app.screen.query_one(Form).size.width
    await pilot.resize_terminal(160, 40)
    await until(pilot, lambda: pilot.app.screen.size.width == 160)
    assert pilot.app.screen.query_one(Form).size.width == width


async def test_keys_in_one_burst_are_handled_in_order(pilot: Pilot[None]) -> None:
    def post_keys(*keys: tuple[str, str | None]) -> None:
        for key, character in keys:
            pilot.app.post_message(Key(key, character))

    editor = await focus(pilot, "mu")
    texts = app_of(pilot).session.texts
    # A step changes the text that was typed before it.
    post_keys(("ctrl+u", None), ("0", "0"), ("full_stop", "."), ("6", "6"), ("down", None))
    await until(pilot, lambda: texts["mu"] == editor.value == "0.59")
    post_keys(("end", None), ("ctrl+u", None), ("0", "0"), ("full_stop", "."))
    post_keys(("8", "8"), ("9", "9"))
    await until(pilot, lambda: texts["mu"] == "0.89")
    # The run uses text typed before F5; later keys go to the newly focused field.
    post_keys(("end", None), ("backspace", None), ("f5", None), ("shift+tab", None))
    post_keys(("ctrl+u", None), ("0", "0"), ("backspace", None))
    pilot.app.post_message(Paste("12"))
    post_keys(("5", "5"))
    runs = app_of(pilot).session.runs
    await until(pilot, lambda: runs.newest is not None and runs.active is None)
    assert runs.newest is not None
    assert runs.newest.scene.parameters.mu == 0.8
    await until(pilot, lambda: texts["k_nl"] == "125")
    # A dialog receives keys that are typed while it opens.
    post_keys(("ctrl+o", None), *((letter, letter) for letter in "abc"))
    await until(
        pilot,
        lambda: [view.value for view in pilot.app.screen.query("#path").results(Input)] == ["abc"],
    )


async def test_an_edit_that_is_not_yet_in_the_session_is_not_overwritten(
    pilot: Pilot[None],
) -> None:
    editor = await focus(pilot, "mu")
    editor.value = "0.85"
    lab_of(pilot).show_inputs()
    assert editor.value == "0.85"
    await until(pilot, lambda: app_of(pilot).session.texts["mu"] == "0.85")
    await pilot.press("f8")
    await until(pilot, lambda: editor.value == "0.7")
