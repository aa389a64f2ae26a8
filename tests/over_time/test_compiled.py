"""The compiled kernel over tables against the interpreted one."""

import math
import random
from collections import Counter
from typing import Any

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.kernel import Kernel, legs_of, load_kernel
from fivtui.model import Course, TimeTable, course_of
from fivtui.model.modes import MODES, Mode, transition_name
from fivtui.transient import KernelChoice, Transient

T_END = 6.0
Rows = list[tuple[float, float]]


def rows(given: random.Random, high: float) -> Rows:
    """A table with ramps, jumps and, now and then, an end at rest."""
    found: Rows = []
    for t in sorted(given.uniform(0.0, T_END) for _ in range(given.randint(1, 4))):
        found.append((t, given.uniform(0.0, high)))
        if given.random() < 0.3:
            found.append((t, given.uniform(0.0, high)))
    if given.random() < 0.3:
        found[-1] = (found[-1][0], 0.0)
    return found


def drawn(seed: int) -> tuple[Parameters, dict[str, Any]]:
    """Random parameters and options with tables: of belts that are always faster, and others."""
    given = random.Random(seed)
    limits = {"m": (1.0, 1.0), "k1": (1.0, 30.0), "k2": (5.0, 30.0), "k3": (0.0, 40.0)}
    limits |= {"c1": (0.0, 0.5), "c2": (0.0, 0.5), "F": (1.0, 80.0), "mu": (0.0, 0.8)}
    values = {name: given.uniform(*limit) for name, limit in limits.items()}
    values["k_nl"] = given.choice([0.0, given.uniform(1.0, 50.0)])
    tables = {"F": rows(given, 90.0)}
    if given.random() < 0.6:
        tables["mu"] = rows(given, 0.9)
    if seed % 4:
        values["v_belt"] = given.choice([0.0, given.uniform(0.05, 3.0)])
        if given.random() < 0.8:
            tables["v_belt"] = rows(given, 2.5)
        if given.random() < 0.6:
            values["mu_s"] = given.uniform(0.9, 1.5)
            if given.random() < 0.6:
                values["v_s"] = given.uniform(0.1, 1.0)
    speed = given.choice([values.get("v_belt", 0.0), given.uniform(-2.0, 2.0)])
    place = (given.uniform(-1, 1), speed, given.uniform(-2, 0.5), given.uniform(-1, 1))
    options = {
        "over_time": tables,
        "separation": given.random() < 0.8,
        "start": given.choice(["static", place]),
    }
    return Parameters(**values), options


# A slider that moves up and down on a belt at rest separates while it sticks.
UPRIGHT = (
    Parameters(m=1.0, k1=1.0, k2=1.0, k3=0.0, c1=0.0, c2=0.0, k_nl=5.0, mu_s=1.0, v_belt=0.0),
    {"start": (0.0, 0.0, -0.5, 3.0), "over_time": {"F": [(0.0, 1.0), (4.0, 2.0), (6.0, 1.0)]}},
)


def both(p: Parameters, options: dict[str, Any]) -> tuple[Transient, Transient]:
    one = simulate(p, t_end=T_END, samples=21, kernel="interpreted", **options)
    other = simulate(p, t_end=T_END, samples=21, kernel="compiled", **options)
    assert (one.stats.kernel, other.stats.kernel) == ("interpreted", "compiled")
    return one, other


def test_random_tables_give_what_the_interpreted_kernel_gives_with_every_transition() -> None:
    found: Counter[str] = Counter()
    for scene in (*map(drawn, range(32)), UPRIGHT):
        one, other = both(*scene)
        found += Counter(other.events.transitions)
        assert other.events.transitions == one.events.transitions
        for change, expected in zip(other.mode_changes, one.mode_changes, strict=True):
            assert (change.first, change.then) == (expected.first, expected.then)
            assert change.t == pytest.approx(expected.t, abs=1e-10)
        assert other.switch_times == pytest.approx(one.switch_times, abs=1e-10)
        assert other.final == pytest.approx(one.final, abs=1e-10)
        assert other.peak == pytest.approx(one.peak, abs=1e-10)
        assert other.steady == pytest.approx(one.steady, abs=1e-10)
        for name, values in one.to_columns().items():
            assert other.to_columns()[name] == pytest.approx(values, abs=1e-9), name
    expected_ones = {
        transition_name(mode, then)
        for mode, row in MODES.items()
        for transition in row.ends
        for then in transition.to
        if Mode.CONTACT not in (mode, then)
    }
    assert set(found) >= expected_ones


def test_friction_falls_with_the_speed_where_a_table_takes_it_below_the_static_one() -> None:
    p = Parameters(v_belt=1.0, mu_s=0.8, v_s=0.3)
    options = {"over_time": {"mu": [(0.0, 0.8), (4.0, 0.2)]}, "separation": True}
    one, other = both(p, options)
    assert other.final == pytest.approx(one.final, abs=1e-10)
    assert other.events.transitions == one.events.transitions


@pytest.mark.parametrize("kernel", ["interpreted", "compiled"])
def test_a_hold_that_is_lost_within_a_step_is_seen(kernel: KernelChoice) -> None:
    # c1 v + m v̇ + k1 x = 1/2 + t/2 − t²/4 exceeds μ_s P = 0.6 for a while, not at 0 nor at 2 s.
    p = Parameters(m=1.0, k1=1.0, k2=1.0, k3=0.0, c1=1.0, c2=0.0, F=1.0, k_nl=0.0, mu=0.3, mu_s=0.6)
    run = simulate(
        p,
        t_end=2.0,
        start=(0.0, 1.0, -1.0, 0.0),
        over_time={"v_belt": [(0.0, 1.0), (2.0, 0.0)]},
        kernel=kernel,
    )
    assert (run.mode_changes[0].first, run.mode_changes[0].then) == (Mode.STICK, Mode.FORWARD)
    assert run.mode_changes[0].t == pytest.approx(1.0 - math.sqrt(0.6), abs=1e-14)


@pytest.mark.parametrize("kernel", ["interpreted", "compiled"])
def test_a_belt_that_brakes_hard_leaves_no_error_in_the_friction_law(kernel: KernelChoice) -> None:
    p = Parameters(v_belt=1.0, mu=0.2, mu_s=1.2, v_s=0.1)
    speed, times = 400.0, np.linspace(0.0, 2.0, 2001)
    rows = [(t, speed * (1.0 - 0.5 * t)) for t in times.tolist()]
    coarse, fine = (
        simulate(p, t_end=2.0, over_time={"v_belt": given}, kernel=kernel)
        for given in ((rows[0], rows[-1]), rows)
    )
    assert list(coarse.final) == pytest.approx(list(fine.final), abs=1e-13)


def test_dense_output_is_that_of_the_interpreted_kernel() -> None:
    p, options = drawn(7)
    runs = [
        simulate(p, t_end=T_END, samples="dense", kernel=kernel, **options)
        for kernel in ("interpreted", "compiled")
    ]
    times = np.linspace(0.0, T_END, 301)
    one, other = (run.solution(times) for run in runs if run.solution is not None)
    assert other.y == pytest.approx(one.y, abs=1e-10)
    assert other.vx == pytest.approx(one.vx, abs=1e-9)


def test_legs_follow_the_tables() -> None:
    tables = {"F": [(1.0, 10.0), (3.0, 20.0)], "v_belt": [(0.0, 2.0), (2.0, 1.0), (2.0, 0.5)]}
    course = course_of(Parameters(mu=0.3), tables)
    expected = [
        [0.0, 10.0, 0.0, 0.3, 0.0, 0.3, 0.0, 2.0, -0.5, 1.5],
        [1.0, 10.0, 5.0, 0.3, 0.0, 0.3, 0.0, 1.5, -0.5, 1.0],
        [2.0, 15.0, 5.0, 0.3, 0.0, 0.3, 0.0, 0.5, 0.0, 0.5],
    ]
    found = legs_of(course, 2.5)
    assert found.rows.tolist() == expected
    assert found.greatest_load == 20.0
    follows = Course(Parameters(mu_s=0.9), {"mu": TimeTable((0.0, 1.0), (0.1, 0.5))})
    assert legs_of(follows, 0.5).rows[0, 3:7].tolist() == [0.1, 0.4, 0.9, 0.0]


@pytest.mark.parametrize("seed", range(1, 7))
def test_the_least_and_the_best_instruction_set_give_the_same_bits(seed: int) -> None:
    outcomes = []
    for kernel in (Kernel("baseline"), load_kernel()):
        p, options = drawn(seed)
        course = course_of(p, options["over_time"])
        p, _ = course.after(0.0)
        belt = None if p.v_belt is None else (p.v_belt, p.mu_static, p.speed_law or 0.0)
        run = kernel.begin(
            p.values(),
            (0.1, 0.3, -1.0, 0.5),
            separation=True,
            t_end=60.0,
            tol=1e-15,
            order=20,
            belt=belt,
            legs=legs_of(course, 60.0),
        )
        while run.advance(1000).name == "RUNNING":
            pass
        outcomes.append(np.array(run.outcome).tobytes())
    assert outcomes[0] == outcomes[1]
