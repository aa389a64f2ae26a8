"""Whether motions end in vibration: against attractors, and in cases that are known."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from fivtui.model import Parameters, System
from fivtui.model.errors import Cancelled
from fivtui.orbits import Explorer, vibration_flags
from fivtui.orbits.explorer import AT_REST, Kind
from fivtui.safety import START_DIMENSIONS, disturbed_states

# Least μ of the limit cycles of the base set.
FOLD_MU = 0.277876613


@dataclass(frozen=True, slots=True)
class Motion:
    """A system and a start."""

    system: System
    start: np.ndarray


def draw_motions(seed: int, count: int, *, belt: bool = False) -> list[Motion]:
    """Random systems around the base set, with starts in the box of the search."""
    rng = np.random.default_rng(seed)
    motions = []
    for _ in range(count):
        values = {
            name: value * 10.0 ** rng.uniform(-0.4, 0.4)
            for name, value in Parameters().as_dict().items()
        }
        values |= {"mu": rng.uniform(0.0, 1.0), "c1": values["c1"] * 2.0}
        if belt:
            values |= {"v_belt": rng.uniform(0.0, 20.0) * (rng.random() < 0.8), "mu_s": 1.2}
        system = System(Parameters().with_values(values), bool(rng.random() < 0.8))
        (start,) = disturbed_states(system, rng.random((1, START_DIMENSIONS)))
        motions.append(Motion(system, start))
    return motions


def flags_of(*motions: Motion, t_end: float = 1.0) -> list[float]:
    starts = np.array([motion.start for motion in motions])
    explorers = [Explorer(motion.system) for motion in motions]
    flags: list[float] = vibration_flags(explorers, starts, t_end=t_end, tol=1e-12).tolist()
    return flags


def assert_agrees_with_attractors(motions: list[Motion], most_undecided: float) -> None:
    flags = flags_of(*motions)
    for motion, flag in zip(motions, flags, strict=True):
        kind = Explorer(motion.system).reach(motion.start.tolist()).kind
        if kind is not Kind.UNSETTLED and not math.isnan(flag):
            assert flag == float(kind not in AT_REST), (motion, kind)
    assert np.isnan(flags).mean() <= most_undecided


def test_no_decision_contradicts_the_attractor_of_the_motion() -> None:
    assert_agrees_with_attractors(draw_motions(1, 60), 0.0)


@pytest.mark.whole
def test_no_decision_contradicts_the_attractor_of_any_of_a_thousand_motions() -> None:
    assert_agrees_with_attractors(draw_motions(2, 1000), 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("count", [12, pytest.param(100, marks=pytest.mark.whole)])
def test_no_decision_contradicts_the_attractor_on_a_belt(count: int) -> None:
    assert_agrees_with_attractors(draw_motions(3, count, belt=True), 0.05)


@pytest.mark.parametrize(("offset", "flag"), [(-1e-6, 0.0), (0.0, math.nan), (1e-6, 1.0)])
def test_slow_decay_just_below_a_fold_is_not_taken_for_vibration(
    offset: float, flag: float
) -> None:
    system = System(Parameters(mu=FOLD_MU + offset))
    # Above the fold the cycle attracts this start; just below, motions take long to leave its
    # place. At the fold, where they would take for ever, nothing is decided.
    x, _, y, _ = Explorer(system).rest
    assert flags_of(Motion(system, np.array([x, 0.0, y + 3.0, 0.0]))) == pytest.approx(
        [flag], nan_ok=True
    )


def test_any_start_but_the_unstable_equilibrium_itself_ends_in_vibration() -> None:
    system = System(Parameters())
    rest = np.array(Explorer(system).rest)
    assert flags_of(Motion(system, rest + np.array([0.0, 0.0, 1e-9, 0.0]))) == [1.0]
    assert math.isnan(flags_of(Motion(system, rest))[0])


def test_without_damping_nothing_is_decided() -> None:
    system = System(Parameters(c1=0.0, c2=0.0, mu=0.1))
    (flag,) = flags_of(Motion(system, np.array([0.1, 0.0, -0.6, 0.0])))
    assert math.isnan(flag)


def test_decay_that_takes_too_long_is_undecided() -> None:
    system = System(Parameters(c1=1e-6, c2=1e-6, mu=0.0))
    (flag,) = flags_of(Motion(system, np.array([1.0, 0.0, -1.0, 0.0])))
    assert math.isnan(flag)


def test_unbounded_growth_about_a_stable_equilibrium_is_vibration() -> None:
    system = System(Parameters(F=1000.0, mu=2.0))
    explorer = Explorer(system)
    assert explorer.equilibrium_attracts
    x, _, y, _ = explorer.rest
    assert explorer.reach((x, 0.0, y + 30.0, 0.0)).kind is Kind.UNBOUNDED
    assert flags_of(Motion(system, np.array([x, 0.0, y + 30.0, 0.0]))) == [1.0]


def test_a_belt_at_rest_stops_the_slider() -> None:
    system = System(Parameters(v_belt=0.0, mu_s=0.9))
    assert flags_of(Motion(system, np.array([0.5, 1.0, -0.5, 0.0]))) == [0.0]


def test_a_decision_does_not_depend_on_other_motions() -> None:
    motions = draw_motions(4, 20)
    assert flags_of(*motions) == [flag for motion in motions for flag in flags_of(motion)]


def test_it_can_be_cancelled() -> None:
    (motion,) = draw_motions(4, 1)
    with pytest.raises(Cancelled):
        vibration_flags(
            [Explorer(motion.system)],
            motion.start[np.newaxis],
            t_end=1.0,
            tol=1e-12,
            progress=lambda _fraction: False,
        )
