"""The laboratory reports attractors beside a stable equilibrium, as far as they were searched."""

import threading
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from textual.pilot import Pilot

from fivtui.model import System
from fivtui.model.errors import Cancelled, ComputationError
from fivtui.model.parameters import Parameters
from fivtui.orbits.attractor_search import Coexistence
from fivtui.orbits.basins import EscapeOffset
from fivtui.orbits.explorer import Attractor, Kind
from fivtui.orbits.report import coexistence_phrase, print_coexistence
from fivtui.orbits.shooting import PeriodicOrbit, Section
from fivtui.safety.verdict import SafeFriction, safe_friction as compute_safe_friction
from fivtui.tui.app import FivtuiApp
from fivtui.tui.session.report import Attractors
from tests.support.laboratory import (
    HANG_S,
    app_of,
    click_view,
    lab_of,
    until,
    until_screen,
    until_shown,
)

P = Parameters(F=120.0)
REST, UNSETTLED = Attractor(Kind.EQUILIBRIUM), Attractor(Kind.UNSETTLED)
UNBOUNDED = Attractor(Kind.UNBOUNDED)


def cycle(half_range: float) -> Attractor:
    orbit = PeriodicOrbit(
        start=(0.0, 0.0, 0.0, 1.0),
        period=1.25,
        section=Section.LIFT_OFF,
        y_min=-half_range,
        y_max=half_range,
        x_abs=1.0,
        vx_max=1.0,
        force_max=1.0,
        separations=1,
        separated_time=0.5,
        multipliers=np.zeros(3, dtype=complex),
        residual=0.0,
    )
    return Attractor(Kind.SEPARATING_CYCLE, orbit)


SMALL, LARGE = cycle(1.5), cycle(7.25)


@pytest.mark.parametrize(
    # `reached` has an index of `attractors` for each start, the static one first.
    ("attractors", "reached", "stable", "phrase"),
    [
        ((REST,), (0,) * 11, True, "no limit cycle found from 11 starts"),
        (
            (REST, LARGE), (0, 0, 1), True,
            "a limit cycle coexists: half peak-to-peak 7.250 m (after a knock)",
        ),
        (
            (REST, LARGE), (1, 0, 1), True,
            "a limit cycle coexists: half peak-to-peak 7.250 m (from the static start)",
        ),
        (
            (LARGE,), (0, 0), True,
            "a limit cycle coexists: half peak-to-peak 7.250 m (from the static start)",
        ),
        (
            (REST, SMALL, LARGE), (0, 1, 2), True,
            "2 limit cycles coexist: half peak-to-peak 1.500 m and 7.250 m (after a knock)",
        ),
        ((REST, UNBOUNDED), (0, 1), True, "motion grows without bounds (after a knock)"),
        (
            (REST, UNSETTLED), (0, 1, 1), True,
            "no limit cycle found from 3 starts; from 2 of 3 starts motion did not settle",
        ),
        ((LARGE,), (0, 0), False, "a limit cycle attracts: half peak-to-peak 7.250 m"),
    ],
)  # fmt: skip
def test_the_verdict_claims_only_the_search_results(
    attractors: tuple[Attractor, ...],
    reached: tuple[int, ...],
    stable: bool,
    phrase: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = Coexistence(System(P), attractors, reached, stable, None)
    assert coexistence_phrase(result) == phrase
    print_coexistence(result)
    assert phrase in " ".join(capsys.readouterr().out.split())


Search = Callable[..., Coexistence]


class Searches:
    """A replacement of the search: each call waits for an answer or is cancelled."""

    def __init__(self) -> None:
        self.started: list[Parameters] = []
        self.cancelled: list[Parameters] = []
        self.answers: dict[float, Coexistence | Exception] = {}
        self.answered = threading.Event()
        # Released once for each cancelled search.
        self.ended = threading.Semaphore(0)

    def __call__(self, system: System, *, progress: Callable[[float], bool], **options: Any) -> Any:
        p = system.parameters
        self.started.append(p)
        while p.F not in self.answers:
            self.answered.wait(0.005)
            if not progress(0.0):
                self.cancelled.append(p)
                self.ended.release()
                raise Cancelled
        answer = self.answers[p.F]
        if isinstance(answer, Exception):
            raise answer
        # As the search does: report the attractors before the escape offset is known.
        options["on_found"](replace(answer, escape=None))
        return answer


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> Searches:
    searches = Searches()
    monkeypatch.setattr("fivtui.orbits.coexistence", searches)
    return searches


@pytest.fixture
async def pilot(searches: Searches) -> AsyncIterator[Pilot[None]]:
    async with FivtuiApp().run_test(size=(80, 24)) as running:
        await running.pause()
        yield running


def current_search(pilot: Pilot[None]) -> Attractors:
    attractors = app_of(pilot).session.attractors
    assert attractors is not None
    return attractors


async def until_headline(pilot: Pilot[None], phrase: str) -> None:
    await until_screen(pilot, lambda text: phrase in text.splitlines()[1])


async def edit_preload(pilot: Pilot[None], preload: str) -> None:
    # Set the text at once: typing would start searches for the intermediate preloads.
    lab = lab_of(pilot)
    lab.session.set_text("F", preload)
    lab.show_inputs()
    await pilot.pause()


async def test_a_stable_verdict_names_the_cycle_once_it_is_found(
    pilot: Pilot[None], searches: Searches
) -> None:
    await edit_preload(pilot, "120")
    await until_headline(pilot, f"STABLE, {Attractors().text}")
    await until(pilot, lambda: searches.started == [P])
    # A release 0.25 m above the equilibrium leads to the cycle; no tested one below it does.
    escape = EscapeOffset(up=0.25, down=None)
    searches.answers[120.0] = Coexistence(System(P), (REST, LARGE), (0, 1), True, escape)
    await until_shown(pilot, "STABLE, but a limit cycle coexists: ±")
    await until_shown(pilot, "±7.250 m (after a knock)")
    await until(pilot, lambda: current_search(pilot).searched)
    # The row shows the whole warning of the command line.
    await pilot.press("alt+2")
    await click_view(pilot, "facts")
    await until_shown(pilot, "release at rest 0.25 m")
    answer = searches.answers[120.0]
    assert isinstance(answer, Coexistence)
    assert current_search(pilot).note == answer.warning


async def test_a_search_without_result_or_with_an_error_is_reported(
    pilot: Pilot[None], searches: Searches
) -> None:
    searches.answers[120.0] = Coexistence(System(P), (REST, LARGE), (0, 1), True, None)
    searches.answers[125.0] = ComputationError("too many steps", "another step")
    searches.answers[130.0] = Coexistence(System(P), (REST,), (0,) * 11, True, None)
    await edit_preload(pilot, "130")
    await until_shown(pilot, "STABLE, no limit cycle found from 11 starts")
    await edit_preload(pilot, "125")
    await until_shown(pilot, "STABLE, search for limit cycles failed:")
    assert "too many steps" in current_search(pilot).text
    await edit_preload(pilot, "120")
    await until(pilot, lambda: current_search(pilot).searched)
    assert [p.F for p in searches.started] == [130.0, 125.0, 120.0]
    # Results of earlier searches are reused after an undo.
    for preload, phrase in (("130", "no limit cycle found"), ("120", "a limit cycle coexists")):
        await edit_preload(pilot, preload)
        await until_headline(pilot, phrase)


async def test_on_a_belt_of_finite_speed_attractors_are_searched_and_safe_friction_is_not(
    pilot: Pilot[None], searches: Searches
) -> None:
    app_of(pilot).session.set_text("v_belt", "10")
    searches.answers[120.0] = Coexistence(System(P), (REST, LARGE), (0, 1), True, None)
    await edit_preload(pilot, "120")
    await until_shown(pilot, "STABLE, but a limit cycle coexists")
    await until(pilot, lambda: current_search(pilot).searched)
    assert current_search(pilot).safe is None
    assert searches.started == [P.with_values({"v_belt": 10.0})]


async def test_an_edit_or_the_end_cancels_the_search(searches: Searches) -> None:
    async with FivtuiApp().run_test(size=(80, 24)) as pilot:
        await edit_preload(pilot, "120")
        await until(pilot, lambda: searches.started == [P])
        # Keys are handled during the search.
        await edit_preload(pilot, "125")
        await until(pilot, lambda: searches.cancelled == [P])
        searches.answers[120.0] = Coexistence(System(P), (REST, LARGE), (0, 1), True, None)
        await until(pilot, lambda: len(searches.started) == 2)
        assert searches.started[1].F == 125.0
        await until_headline(pilot, f"STABLE, {Attractors().text}")
        # The equilibrium is unstable: no search runs.
        await edit_preload(pilot, "80")
        await until_headline(pilot, "UNSTABLE: growth rate")
        await until(pilot, lambda: len(searches.cancelled) == 2)
        await edit_preload(pilot, "130")
        await until(pilot, lambda: len(searches.started) == 3)
    for _ in range(3):
        assert searches.ended.acquire(timeout=HANG_S)
    assert [p.F for p in searches.cancelled] == [120.0, 125.0, 130.0]


@pytest.fixture(scope="module")
def safe_friction() -> SafeFriction:
    return compute_safe_friction(P)


@pytest.fixture
def safe_searches(monkeypatch: pytest.MonkeyPatch, safe_friction: SafeFriction) -> list[Parameters]:
    """Searches for safe friction: each returns the result at F = 120 N for its parameters."""
    started: list[Parameters] = []

    def compute(p: Parameters, **_: object) -> SafeFriction:
        started.append(p)
        return replace(safe_friction, system=System(p))

    monkeypatch.setattr("fivtui.safety.safe_friction", compute)
    return started


async def test_the_verdict_gives_the_friction_from_which_a_cycle_coexists(
    searches: Searches, safe_searches: list[Parameters]
) -> None:
    searches.answers[120.0] = Coexistence(System(P), (REST, LARGE), (0, 1), True, None)
    async with FivtuiApp().run_test(size=(120, 40)) as pilot:
        await edit_preload(pilot, "120")
        await until_shown(
            pilot, "a limit cycle coexists from μ = 0.2779: half peak-to-peak 7.250 m"
        )
        await until_shown(pilot, "safe below 0.2779")
        await pilot.press("alt+2")
        await click_view(pilot, "facts")
        # Motions from all these starts decay: 128 at each μ.
        await until_shown(pilot, "all 2048 starts at 16 values of μ")
        # The search for the first scene may have started before the edit.
        assert safe_searches.count(P) == 1


async def test_continuation_reports_cycles_that_transients_missed(
    searches: Searches, safe_searches: list[Parameters]
) -> None:
    searches.answers[120.0] = Coexistence(System(P), (REST,), (0, 0), True, None)
    async with FivtuiApp().run_test(size=(120, 40)) as pilot:
        await until_shown(pilot, "UNSTABLE: growth rate")
        await until_shown(pilot, "a limit cycle attracts: ±7.443 m")
        await until_shown(pilot, "safe below 0.2779")
        await edit_preload(pilot, "120")
        await until_shown(pilot, "STABLE, but a limit cycle coexists from μ = 0.2779: half")
        await until_shown(pilot, "7.443 m")
        assert [p.F for p in safe_searches] == [80.0, 120.0]
