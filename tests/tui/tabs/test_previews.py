"""A tab without a result shows a sketch, its question and its key; the key gives a result."""

import re
from threading import Event
from typing import Any

import pytest
from textual.pilot import Pilot

from fivtui.maps import safety
from fivtui.reliability import means
from fivtui.safety import verdict
from fivtui.scene import PRESETS
from fivtui.tradeoffs import measure
from fivtui.tui.session.report import Attractors
from fivtui.tui.tabs.messages import SceneLoaded
from fivtui.tui.tabs.preview import Preview, about
from fivtui.tui.tabs.studies import uncertainty
from fivtui.tui.tabs.studies.map import EXAMPLES
from fivtui.tui.tabs.studies.study_pane import StudyPane
from fivtui.tui.tabs.tab_book import TABS
from tests.support.laboratory import (
    app_of,
    lab_of,
    run_to_end,
    show_tab,
    until,
    until_hidden,
    until_notice,
    until_screen,
    until_shown,
)

SIZE = (80, 24)
STUDIES = [tab for tab in TABS if getattr(tab.import_pane_class(), "SKETCH", None)]


async def preview_of(pilot: Pilot[None], key: str) -> tuple[StudyPane, Preview]:
    """The pane of a tab before its first result, and its preview."""
    await show_tab(pilot, key)
    pane: Any = lab_of(pilot).tab_book.pane
    preview = pane.query_one(Preview)
    await until(pilot, lambda: preview.display and preview.size.height > 0)
    return pane, preview


@pytest.mark.parametrize("tab", STUDIES, ids=lambda tab: tab.id)
async def test_one_key_after_that_of_the_tab_gives_a_result(
    tab: Any, pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measure, "QUICK_S", 0.2)
    monkeypatch.setattr(uncertainty, "SAMPLES", 16)
    monkeypatch.setitem(EXAMPLES, "safe-mu", "F=60:80:2 k_nl=50:100:2")
    # The other tests of the laboratory do without safe friction.
    for module in (means, safety):
        monkeypatch.setattr(module, "safe_friction", verdict.safe_friction)
    pane, preview = await preview_of(pilot, tab.key)
    assert pane.sketch is not None
    lines = preview.render().plain.splitlines()
    # At 80 columns and 24 rows the texts fit beside a sketch, whose axes have no numbers.
    assert len(lines) <= preview.size.height
    assert max(map(len, lines)) <= preview.size.width
    sketch_end = lines.index(" ")
    assert sketch_end > 3
    assert not re.search(r"\d", "".join(lines[:sketch_end]).replace("rk4", ""))
    texts = " ".join(lines[sketch_end + 1 :])
    assert texts.startswith(pane.sketch.question)
    assert re.search(r"F10 .* usually (within|in about) \d+ s\.", texts)
    await until_screen(pilot, lambda text: lines[-1] in text)
    await pilot.press("f10")
    await until(pilot, lambda: tab.id in app_of(pilot).session.studies)
    await until(pilot, lambda: not preview.display)
    assert pane.query_one(".views").display
    logged = re.compile(r"\d\d:\d\d:\d\d [\w' -]+ done in \d+\.\d s(; |$)")
    await until(pilot, lambda: any(map(logged.match, app_of(pilot).session.reports)))


async def test_the_key_of_a_computation_that_runs_without_result_stops_it(
    pilot: Pilot[None],
) -> None:
    pane, _ = await preview_of(pilot, "alt+5")
    released = Event()
    pane.start(lambda _: released.wait())
    await until_shown(pilot, "F10 stops the computation.")
    assert pane.job is not None
    pane.job.note = "half of it is safe"
    await until_shown(pilot, pane.job.note)
    await pilot.press("f10")
    released.set()
    await until_shown(pilot, "F10 maps")
    await until_hidden(pilot, "half of it is safe")


async def test_previews_follow_keys_inputs_and_views(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    session.reports.clear()
    await show_tab(pilot, "alt+minus")
    await until_shown(pilot, "Reports of runs, files and errors follow.")
    session.key_names = {**session.key_names, "compute": "F12"}
    pane, _ = await preview_of(pilot, "alt+6")
    await until_shown(pilot, "F12 computes 112 runs")
    pane.query_one("#sweep-input").value = "F=20:80:1000"  # type: ignore[attr-defined]
    await until_shown(pilot, "F12 computes 2000 runs")
    pane.query_one("#sweep-input").value = "F=a"  # type: ignore[attr-defined]
    await until_shown(pilot, "F12 runs the scene with each value")
    await preview_of(pilot, "alt+5")
    await until_shown(pilot, "Below which friction coefficient")
    await pilot.press("alt+p", "v")
    await until_shown(pilot, "Where is it safe, where does a knock")
    await until_shown(pilot, "after a knock")
    await until_hidden(pilot, "Below which")
    # The view of a figure of the paper computes the selected one.
    await show_tab(pilot, "alt+0")
    await pilot.press("alt+p", "down", "v", "v")
    await until_shown(pilot, "figure 2b computed")


async def test_space_on_the_shown_run_says_that_it_is_shown(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    await pilot.press("f3", "space")
    await until_notice(pilot, "run 1 is shown already")
    assert not app_of(pilot).session.runs.displayed.overlaid  # type: ignore[union-attr]


async def test_after_a_run_a_line_leads_on_until_its_tab_has_a_result(pilot: Pilot[None]) -> None:
    session = app_of(pilot).session
    await run_to_end(pilot)
    # In a narrow window facts that do not fit are omitted.
    await pilot.resize_terminal(*SIZE)
    await until_shown(pilot, "run 1 done · Alt+4 Branches: safe?")
    await pilot.resize_terminal(140, 40)
    await until_shown(pilot, "Alt+4 Branches: safe? · in 0.0")
    await pilot.press("alt+4")
    await pilot.press("f10")
    await until(pilot, lambda: "branch" in session.studies)
    await pilot.press("alt+1")
    await until_screen(pilot, lambda text: "run 1 done in" in text and "Alt+4" not in text)
    session.set_text("mu", "0.3")
    session.attractors = Attractors(text="a limit cycle", coexists=True)
    assert session.next_step == ("safe-mu", "where?")
    session.attractors = Attractors(text="none", searched=True)
    assert session.next_step == ("uncertainty", "squeal?")
    session.attractors = Attractors()
    assert session.next_step == ("", "")
    session.set_text("mu", "x")
    assert session.next_step == ("", "")


def test_typical_durations_are_rounded() -> None:
    assert [about(seconds) for seconds in (0.3, 7.4, 100.0)] == [
        "usually within 1 s",
        "usually in about 7 s",
        "usually in about 1 min 40 s",
    ]


async def test_tables_over_time_change_examples_and_are_noted_or_refused_before_a_study(
    pilot: Pilot[None],
) -> None:
    await show_tab(pilot, "alt+4")
    pane: Any = lab_of(pilot).tab_book.pane
    assert pane.text == "μ=0.2:1"
    lab_of(pilot).post_message(SceneLoaded(PRESETS["brake-stop"], "brake-stop", "loaded"))
    # μ must not exceed μ_s.
    await until(pilot, lambda: pane.text == "μ=0.2:0.9")
    await until_shown(pilot, "Branch at t = 0")
    for key, refusal in (
        ("alt+7", "must be constant for an uncertainty study"),
        ("alt+8", "must be constant for a trade-off"),
        ("alt+9", "must be constant for a fit"),
    ):
        _, preview = await preview_of(pilot, key)
        assert refusal in " ".join(preview.render().plain.split())
    pane, preview = await preview_of(pilot, "alt+6")
    assert pane.text == "μ=0.2:0.9:41"
    assert "F10 computes 82 runs" in preview.render().plain.replace("\n", " ")
    await preview_of(pilot, "alt+5")
    await until_shown(pilot, "at t = 0")
    lab_of(pilot).action_drop_tables()
    await until_hidden(pilot, "at t = 0")
