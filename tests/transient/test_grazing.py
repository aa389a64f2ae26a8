"""Switches are never missed: grazing, two crossings in a step, starts on the switch."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from fivtui import Parameters, simulate, simulate_batch
from fivtui.model import System
from fivtui.model.slider_belt import State
from fivtui.taylor.stepper import TaylorStepper
from fivtui.transient.request import KernelChoice

DEPTHS = [10.0**-n for n in range(2, 13)]
TOLERANCES = (1e-12, 1e-6)


class Seen(NamedTuple):
    """Result of a run, for either kernel."""

    separations: int
    reattachments: int
    separated_time: float
    first: float
    y: float
    vy: float


Way = Callable[[Sequence[Parameters], Sequence[State], float, float], list[Seen]]


def single(kernel: KernelChoice) -> Way:
    def run(
        sets: Sequence[Parameters], starts: Sequence[State], t_end: float, tol: float
    ) -> list[Seen]:
        runs_observed = []
        for p, start in zip(sets, starts, strict=True):
            r = simulate(p, start=start, t_end=t_end, tol=tol, kernel=kernel)
            e = r.events
            first = math.nan if e.first is None else e.first
            runs_observed.append(
                Seen(e.separations, e.reattachments, e.separated_time, first, r.final.y, r.final.vy)
            )
        return runs_observed

    return run


def batch(
    sets: Sequence[Parameters], starts: Sequence[State], t_end: float, tol: float
) -> list[Seen]:
    table = np.array([p.values() for p in sets])
    r = simulate_batch(table, start=np.array(starts), t_end=t_end, tol=tol)
    assert r.failed.size == 0
    e = r.events
    columns = (e.separations, e.reattachments, e.separated_time, e.first, *r.final.T[2:])
    return [Seen(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


WAYS: dict[str, Way] = {
    "interpreted": single("interpreted"),
    "compiled": single("compiled"),
    "batch": batch,
}
run_methods = pytest.mark.parametrize("integrate", WAYS.values(), ids=WAYS)
tolerances = pytest.mark.parametrize("tol", TOLERANCES)


# An undamped slider without coupling: y is a sine in contact and a parabola off the belt.
FREE = Parameters(m=1.0, k2=4.0, k3=0.0, c1=0.0, c2=0.0, F=8.0, k_nl=0.0, mu=0.7)
OMEGA, SAG = 2.0, 2.0


def from_below(depth: float, lead: float) -> State:
    """A start from which y rises to its only maximum, `depth`, in the time `lead`."""
    amplitude = SAG + depth
    return (
        0.0,
        0.0,
        -SAG + amplitude * math.cos(OMEGA * lead),
        amplitude * OMEGA * math.sin(OMEGA * lead),
    )


LEADS = np.linspace(0.02, 1.4, 9).tolist()


@run_methods
@tolerances
def test_a_contact_that_nearly_opens_stays_closed(integrate: Way, tol: float) -> None:
    # At the loose tolerance errors exceed the smallest depths.
    depths = [depth for depth in DEPTHS if depth > 100.0 * tol or tol < 1e-9]
    starts = [from_below(-d, lead) for d, lead in itertools.product(depths[:-1], LEADS)]
    for motion in integrate([FREE] * len(starts), starts, 1.6, tol):
        assert (motion.separations, motion.reattachments, motion.separated_time) == (0, 0, 0.0)


@run_methods
def test_a_contact_that_opens_by_a_hair_opens_and_closes(integrate: Way) -> None:
    cases = list(itertools.product(DEPTHS, LEADS))
    # With a shorter lead the contact would have opened before the start.
    cases = [(depth, lead) for depth, lead in cases if lead > 2.0 * math.sqrt(depth)]
    starts = [from_below(depth, lead) for depth, lead in cases]
    for (depth, lead), motion in zip(
        cases, integrate([FREE] * len(cases), starts, 1.6, 1e-12), strict=True
    ):
        speed = OMEGA * math.sqrt(depth * (2.0 * SAG + depth))
        flight = 2.0 * speed * FREE.m / FREE.F
        opening = lead - math.asin(speed / (OMEGA * (SAG + depth))) / OMEGA
        # Depths are accurate only to rounding.
        close = 1e-10 + 2e-15 / depth
        assert (motion.separations, motion.reattachments) == (1, 1)
        assert motion.separated_time == pytest.approx(flight, rel=close)
        assert motion.first == pytest.approx(opening, abs=close * flight + 1e-14)


@run_methods
def test_a_contact_that_is_touched_exactly_is_left_for_no_time(integrate: Way) -> None:
    for lead, motion in zip(
        LEADS,
        integrate([FREE] * len(LEADS), [from_below(0.0, at) for at in LEADS], 1.6, 1e-12),
        strict=True,
    ):
        assert motion.separations == motion.reattachments <= 1
        assert motion.separated_time < 1e-6
        assert motion.y == pytest.approx(SAG * (math.cos(OMEGA * (1.6 - lead)) - 1.0), abs=1e-11)


# The preload pulls the slider off the belt; the slow mode swings y down to it.
HELD = Parameters(m=1.0, k1=3.0, k2=4.0, k3=4.0, c1=0.0, c2=0.0, F=-1.2, k_nl=50.0, mu=0.7)


def from_above(depth: float, lead: float) -> tuple[State, float]:
    """A start from which y falls to its first minimum, -`depth`; and its frequency there."""
    h, a = 0.5 * HELD.k3, HELD.k1 + 0.5 * HELD.k3
    squares, shapes = np.linalg.eigh([[a, -h], [-h, h]])
    omega, (x_part, y_part) = math.sqrt(squares[0]), shapes[:, 0]
    y_rest = -HELD.F / (h * HELD.k1 / a)
    x_rest, amplitude = h * y_rest / a, y_rest + depth
    x_part /= y_part
    swing, speed = math.cos(omega * lead), -omega * math.sin(omega * lead)
    y_state = (y_rest - amplitude * swing, amplitude * speed)
    x_state = (x_rest - amplitude * x_part * swing, amplitude * x_part * speed)
    return (*x_state, *y_state), omega


@run_methods
def test_a_fall_that_nearly_lands_does_not_land(integrate: Way) -> None:
    starts = [from_above(-d, lead)[0] for d, lead in itertools.product(DEPTHS[:-1], LEADS)]
    for motion in integrate([HELD] * len(starts), starts, 3.0, 1e-12):
        assert (motion.separations, motion.reattachments) == (0, 0)
        assert motion.separated_time == pytest.approx(3.0, rel=1e-14)


@run_methods
def test_a_fall_that_lands_by_a_hair_lands_and_leaves(integrate: Way) -> None:
    y_rest = -HELD.F / (0.5 * HELD.k3 * HELD.k1 / (HELD.k1 + 0.5 * HELD.k3))
    cases = list(itertools.product(DEPTHS, LEADS))
    cases = [(depth, lead) for depth, lead in cases if lead > 3.0 * math.sqrt(2.0 * depth)]
    cases_started = [from_above(depth, lead) for depth, lead in cases]
    motions = integrate([HELD] * len(cases), [start for start, _ in cases_started], 2.0, 1e-12)
    for (depth, lead), (_, omega), motion in zip(cases, cases_started, motions, strict=True):
        amplitude = y_rest + depth
        speed = omega * math.sqrt(depth * (2.0 * y_rest + depth))
        before = math.asin(speed / (omega * amplitude)) / omega
        close = 1e-10 + 1e-14 / depth
        assert (motion.separations, motion.reattachments) == (1, 1)
        assert motion.first == pytest.approx(lead - before, abs=close * before + 1e-14)
        # Free fall, with a correction by the contact force of the order of the depth.
        contact = 2.0 - motion.separated_time
        assert contact == pytest.approx(2.0 * before, rel=close + 10.0 * depth, abs=1e-14)


def test_a_grazing_of_the_nonlinear_scene_is_seen_alike() -> None:
    # The height to which the base scene would rise decides, whichever kernel looks.
    p = Parameters(mu=0.3)
    t_end = 0.45

    def start(speed: float) -> State:
        return (0.3, 0.1, -0.7, speed)

    def height(speed: float) -> float:
        r = simulate(p, start=start(speed), t_end=t_end, separation=False, kernel="interpreted")
        return r.peak.y_max

    touching = brentq(height, 1.0, 6.0, xtol=1e-15, rtol=1e-15)
    gain = (height(touching + 1e-3) - height(touching - 1e-3)) / 2e-3
    speeds = [touching + sign * depth / gain for depth in DEPTHS for sign in (1.0, -1.0)]
    heights = [height(speed) for speed in speeds]
    starts = [start(speed) for speed in speeds]
    everything = [integrate([p] * len(starts), starts, t_end, 1e-12) for integrate in WAYS.values()]
    for reached, *motions in zip(heights, *everything, strict=True):
        for switches in motions:
            assert switches.separations == (reached > 0.0)
            assert switches.reattachments == switches.separations
            close = 1e-10 + 1e-14 / abs(reached)
            assert switches.separated_time == pytest.approx(motions[0].separated_time, rel=close)
            assert switches.first == pytest.approx(motions[0].first, rel=1e-6, nan_ok=True)


@run_methods
def test_leaving_and_landing_lie_in_one_step(integrate: Way) -> None:
    # With separation ignored a step can span both crossings; both its ends are then in contact.
    spanned = 0
    for lead in LEADS:
        start = from_below(1e-4, lead)
        stepper = TaylorStepper(System(FREE, separation=False), start)
        around = next(step for step in iter(stepper.advance, None) if step.end > lead)
        spanned += around.y[0] < 0.0 and around.final[2] < 0.0
        if lead > 0.02:
            motion = integrate([FREE], [start], 1.6, 1e-12)[0]
            assert (motion.separations, motion.reattachments) == (1, 1)
    assert spanned >= 6


# Starts at y = 0: state, F, and order and value of the first nonzero derivative of y.
ON = Parameters(m=2.0, k1=10.0, k2=5.0, k3=8.0, c1=0.5, c2=0.3, k_nl=20.0, mu=0.6)
H, A = 4.0, 14.0
STARTS: dict[str, tuple[State, float, int, float]] = {
    "moving out": ((0.1, 0.2, 0.0, 0.3), 1.0, 1, 0.3),
    "moving in": ((0.1, 0.2, 0.0, -0.3), 1.0, 1, -0.3),
    "pulled out": ((0.5, 0.2, 0.0, 0.0), 1.0, 2, (H * 0.5 - 1.0) / 2.0),
    "pressed in": ((0.1, 0.2, 0.0, 0.0), 1.0, 2, (H * 0.1 - 1.0) / 2.0),
    "balanced, pulled out": ((0.25, 0.2, 0.0, 0.0), 1.0, 3, H * 0.2 / 2.0),
    "balanced, pressed in": ((0.25, -0.2, 0.0, 0.0), 1.0, 3, -H * 0.2 / 2.0),
    "at rest, pressed in": ((0.25, 0.0, 0.0, 0.0), 1.0, 4, -H / 2.0 * A * 0.25 / 2.0),
    "at rest, pulled out": ((-0.25, 0.0, 0.0, 0.0), -1.0, 4, H / 2.0 * A * 0.25 / 2.0),
}


@run_methods
def test_rest_at_the_switch_lasts(integrate: Way) -> None:
    motion = integrate([Parameters(F=0.0)], [(0.0, 0.0, 0.0, 0.0)], 100.0, 1e-12)[0]
    assert motion[:3] == (0, 0, 0.0)
    assert (motion.y, motion.vy) == (0.0, 0.0)


@run_methods
def test_a_decay_towards_the_switch_ends(integrate: Way) -> None:
    # F = 0: the equilibrium lies on the switch, and every half period crosses it.
    p = Parameters(F=0.0, c1=3.0, c2=3.0)
    motion = integrate([p], [(0.0, 0.0, 0.0, 1.0)], 60.0, 1e-12)[0]
    exact = WAYS["interpreted"]([p], [(0.0, 0.0, 0.0, 1.0)], 60.0, 1e-13)[0]
    assert motion.separations == exact.separations > 20
    assert motion.reattachments == exact.reattachments
    assert motion.separated_time == pytest.approx(exact.separated_time, rel=1e-9)
