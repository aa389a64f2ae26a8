"""The compiled kernel over tables against the interpreted one.

A course is the parameters as functions of time: constants, and tables for those that change.
"""

import math
import random
from collections import Counter
from typing import Any

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.kernel import Kernel, course_table, load_kernel
from fivtui.model import Course, TimeTable, build_course
from fivtui.model.modes import MODES, Mode, transition_name
from fivtui.transient import KernelChoice, Transient

T_END = 6.0  # s
Rows = list[tuple[float, float]]


def draw_table(rng: random.Random, high: float) -> Rows:
    """A table with ramps and jumps, sometimes with zero as the last value."""
    table: Rows = []
    for t in sorted(rng.uniform(0.0, T_END) for _ in range(rng.randint(1, 4))):
        table.append((t, rng.uniform(0.0, high)))
        if rng.random() < 0.3:
            table.append((t, rng.uniform(0.0, high)))
    if rng.random() < 0.3:
        table[-1] = (table[-1][0], 0.0)
    return table


def draw_scene(seed: int) -> tuple[Parameters, dict[str, Any]]:
    """Random parameters and options with tables, of always faster belts and of finite speeds."""
    rng = random.Random(seed)
    limits = {"m": (1.0, 1.0), "k1": (1.0, 30.0), "k2": (5.0, 30.0), "k3": (0.0, 40.0)}
    limits |= {"c1": (0.0, 0.5), "c2": (0.0, 0.5), "F": (1.0, 80.0), "mu": (0.0, 0.8)}
    values = {name: rng.uniform(*limit) for name, limit in limits.items()}
    values["k_nl"] = rng.choice([0.0, rng.uniform(1.0, 50.0)])
    tables = {"F": draw_table(rng, 90.0)}
    if rng.random() < 0.6:
        tables["mu"] = draw_table(rng, 0.9)
    if seed % 4:
        values["v_belt"] = rng.choice([0.0, rng.uniform(0.05, 3.0)])
        if rng.random() < 0.8:
            tables["v_belt"] = draw_table(rng, 2.5)
        if rng.random() < 0.6:
            values["mu_s"] = rng.uniform(0.9, 1.5)
            if rng.random() < 0.6:
                values["v_s"] = rng.uniform(0.1, 1.0)
    speed = rng.choice([values.get("v_belt", 0.0), rng.uniform(-2.0, 2.0)])
    start = (rng.uniform(-1, 1), speed, rng.uniform(-2, 0.5), rng.uniform(-1, 1))
    options = {
        "over_time": tables,
        "separation": rng.random() < 0.8,
        "start": rng.choice(["static", start]),
    }
    return Parameters(**values), options


# A slider that moves up and down on a belt at rest separates while it sticks.
SEPARATING_WHILE_STICKING = (
    Parameters(m=1.0, k1=1.0, k2=1.0, k3=0.0, c1=0.0, c2=0.0, k_nl=5.0, mu_s=1.0, v_belt=0.0),
    {"start": (0.0, 0.0, -0.5, 3.0), "over_time": {"F": [(0.0, 1.0), (4.0, 2.0), (6.0, 1.0)]}},
)


def simulate_with_both_kernels(
    p: Parameters, options: dict[str, Any]
) -> tuple[Transient, Transient]:
    interpreted = simulate(p, t_end=T_END, samples=21, kernel="interpreted", **options)
    compiled = simulate(p, t_end=T_END, samples=21, kernel="compiled", **options)
    assert (interpreted.stats.kernel, compiled.stats.kernel) == ("interpreted", "compiled")
    return interpreted, compiled


def test_random_tables_agree_with_the_interpreted_kernel_and_reach_every_transition() -> None:
    transitions: Counter[str] = Counter()
    for scene in (*map(draw_scene, range(32)), SEPARATING_WHILE_STICKING):
        interpreted, compiled = simulate_with_both_kernels(*scene)
        transitions += Counter(compiled.events.transitions)
        assert compiled.events.transitions == interpreted.events.transitions
        for change, expected in zip(compiled.mode_changes, interpreted.mode_changes, strict=True):
            assert (change.first, change.then) == (expected.first, expected.then)
            assert change.t == pytest.approx(expected.t, abs=1e-10)
        assert compiled.switch_times == pytest.approx(interpreted.switch_times, abs=1e-10)
        assert compiled.final == pytest.approx(interpreted.final, abs=1e-10)
        assert compiled.peak == pytest.approx(interpreted.peak, abs=1e-10)
        assert compiled.steady == pytest.approx(interpreted.steady, abs=1e-10)
        for name, values in interpreted.to_columns().items():
            assert compiled.to_columns()[name] == pytest.approx(values, abs=1e-9), name
    # All of the table of modes, except those of CONTACT, the mode on belts that are always faster.
    # A mode has transitions that end it, each with the modes that may follow.
    expected_transitions = {
        transition_name(mode, successor)
        for mode, row in MODES.items()
        for transition in row.ends
        for successor in transition.next_modes
        if Mode.CONTACT not in (mode, successor)
    }
    assert set(transitions) >= expected_transitions


def test_friction_falls_with_the_speed_where_a_table_lowers_it_below_static_friction() -> None:
    p = Parameters(v_belt=1.0, mu_s=0.8, v_s=0.3)
    options = {"over_time": {"mu": [(0.0, 0.8), (4.0, 0.2)]}, "separation": True}
    interpreted, compiled = simulate_with_both_kernels(p, options)
    assert compiled.final == pytest.approx(interpreted.final, abs=1e-10)
    assert compiled.events.transitions == interpreted.events.transitions


@pytest.mark.parametrize("kernel", ["interpreted", "compiled"])
def test_a_slip_within_a_step_is_found(kernel: KernelChoice) -> None:
    # The slider sticks to the belt: v = 1 − t/2, x = t − t²/4. The force that this needs,
    # c1 v + m v̇ + k1 x = 1/2 + t/2 − t²/4, exceeds μ_s P = 0.6 for 1 − √0.6 < t < 1 + √0.6.
    # A step that contains this interval has no excess at its ends.
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
@pytest.mark.parametrize("preload", [-30.0, 0.0, 30.0])
@pytest.mark.parametrize("rate", [-600.0, 600.0])
def test_where_y_begins_with_its_fourth_derivative_its_sign_decides_on_contact(
    rate: float, preload: float, kernel: KernelChoice
) -> None:
    # With h x = F and h ẋ = Ḟ the first three derivatives of y are zero at y = 0, and the fourth
    # is −h (c1 ẋ + a x)/m².
    p = Parameters(m=5.0, k1=100.0, k3=60.0, c1=13.0, F=preload)
    h, a = 30.0, 130.0
    x, vx = preload / h, rate / h
    tables = {"F": [(0.0, preload), (1.0, preload + rate)]}
    fourth = -h * (p.c1 * vx + a * x) / p.m**2
    short_run = simulate(p, t_end=1e-3, start=(x, vx, 0.0, 0.0), over_time=tables, kernel=kernel)
    assert short_run.first_mode is (Mode.SEPARATED if fourth > 0.0 else Mode.CONTACT)
    assert short_run.final.y == pytest.approx(fourth * 1e-12 / 24.0, rel=0.01)
    run, near = (
        simulate(p, t_end=0.5, start=(x, speed, 0.0, 0.0), over_time=tables, kernel=kernel)
        for speed in (vx, vx * (1.0 + 1e-11))
    )
    assert run.final.y == pytest.approx(near.final.y, rel=1e-9)
    assert run.final.x == pytest.approx(near.final.x, rel=1e-9)


@pytest.mark.parametrize("kernel", ["interpreted", "compiled"])
def test_friction_that_depends_on_speed_is_accurate_on_a_belt_that_brakes_hard(
    kernel: KernelChoice,
) -> None:
    # The expansion of exp(−v/v_s) fails where braking changes the sliding speed v by too many v_s
    # in a step. Rows every millisecond enforce short steps.
    p = Parameters(v_belt=1.0, mu=0.2, mu_s=1.2, v_s=0.1)
    speed, times = 400.0, np.linspace(0.0, 2.0, 2001)
    fine_rows = [(t, speed * (1.0 - 0.5 * t)) for t in times.tolist()]
    coarse, fine = (
        simulate(p, t_end=2.0, over_time={"v_belt": table}, kernel=kernel)
        for table in ((fine_rows[0], fine_rows[-1]), fine_rows)
    )
    assert list(coarse.final) == pytest.approx(list(fine.final), abs=1e-13)


def test_dense_output_is_that_of_the_interpreted_kernel() -> None:
    p, options = draw_scene(7)
    runs = [
        simulate(p, t_end=T_END, samples="dense", kernel=kernel, **options)
        for kernel in ("interpreted", "compiled")
    ]
    times = np.linspace(0.0, T_END, 301)
    interpreted, compiled = (run.solution(times) for run in runs if run.solution is not None)
    assert compiled.y == pytest.approx(interpreted.y, abs=1e-10)
    assert compiled.vx == pytest.approx(interpreted.vx, abs=1e-9)


def test_rows_for_the_kernel_follow_the_tables() -> None:
    tables = {"F": [(1.0, 10.0), (3.0, 20.0)], "v_belt": [(0.0, 2.0), (2.0, 1.0), (2.0, 0.5)]}
    course = build_course(Parameters(mu=0.3), tables)
    # Time, then value and slope of F, μ, μ_s and the belt's speed, and its speed at the next row.
    expected = [
        [0.0, 10.0, 0.0, 0.3, 0.0, 0.3, 0.0, 2.0, -0.5, 1.5],
        [1.0, 10.0, 5.0, 0.3, 0.0, 0.3, 0.0, 1.5, -0.5, 1.0],
        [2.0, 15.0, 5.0, 0.3, 0.0, 0.3, 0.0, 0.5, 0.0, 0.5],
    ]
    table = course_table(course, t_end=2.5)
    assert table.rows[:, :10].tolist() == expected
    # Then the parameters from that time on.
    assert table.rows[:, 10:-2].tolist() == [
        list(Parameters(mu=0.3, F=force).values()) for force in (10.0, 10.0, 15.0)
    ]
    # It includes rows of F after the end of the run.
    assert table.greatest_load == 20.0
    friction_course = Course(Parameters(mu_s=0.9), {"mu": TimeTable((0.0, 1.0), (0.1, 0.5))})
    mu_columns = slice(3, 7)
    mu_and_mu_static = course_table(friction_course, 0.5).rows[0, mu_columns]
    assert mu_and_mu_static.tolist() == [0.1, 0.4, 0.9, 0.0]


@pytest.mark.parametrize("seed", range(1, 7))
def test_the_baseline_and_the_best_instruction_set_give_the_same_bits(seed: int) -> None:
    outcomes = []
    for kernel in (Kernel("baseline"), load_kernel()):
        p, options = draw_scene(seed)
        course = build_course(p, options["over_time"])
        p_at_start, _rates = course.after(0.0)
        # Speed, static friction, and v_s: 0 where friction does not depend on the sliding speed.
        belt = (
            None
            if p_at_start.v_belt is None
            else (p_at_start.v_belt, p_at_start.mu_static, p_at_start.speed_law or 0.0)
        )
        run = kernel.begin_run(
            p_at_start.values(),
            (0.1, 0.3, -1.0, 0.5),
            separation=True,
            t_end=60.0,
            tol=1e-15,
            order=20,
            belt=belt,
            table=course_table(course, 60.0),
        )
        while run.advance(1000).name == "RUNNING":
            pass
        outcomes.append(np.array(run.outcome).tobytes())
    assert outcomes[0] == outcomes[1]
