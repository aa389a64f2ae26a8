"""Starts on the switch and within rounding of it: all kernels agree, and steps stay large."""

import math

import numpy as np
import pytest

from fivtui import Parameters, simulate, simulate_batch
from fivtui.kernel import Status
from fivtui.model import System
from fivtui.model.modes import Mode
from fivtui.model.slider_belt import State, mode_of
from fivtui.taylor.stepper import TaylorStepper

T_END = 0.7  # s
# A normal run takes at most 40 steps; one that creeps with very small steps reaches the limit.
STEP_LIMIT = 400
Case = tuple[Parameters, State]


def draw_cases(seed: int, count: int) -> list[Case]:
    """Parameter sets with a start at or near y = 0, where the forces nearly balance."""
    rng = np.random.default_rng(seed)

    def choose(*values: float) -> float:
        return float(rng.choice(values))

    def draw_tiny(scale: float = 1.0) -> float:
        # About a rounding error, times `scale`.
        return choose(-1.0, 1.0) * scale * math.pow(10.0, rng.uniform(-17.0, -14.0))

    drawn_cases = []
    for _ in range(count):
        p = Parameters(
            m=rng.uniform(1.0, 10.0),
            k1=rng.uniform(20.0, 200.0),
            k2=rng.uniform(20.0, 200.0),
            k3=choose(0.0, 60.0, 60.0, *rng.uniform(1.0, 150.0, 4)),
            c1=choose(0.0, 0.32, rng.uniform(0.0, 2.0)),
            c2=choose(0.0, 0.32, rng.uniform(0.0, 2.0)),
            F=choose(0.0, 5.0, 80.0, 80.0, *rng.uniform(0.0, 150.0, 3)),
            k_nl=choose(0.0, 100.0, rng.uniform(0.0, 500.0)),
            mu=choose(0.0, 0.7, rng.uniform(0.0, 1.5)),
        )
        # At this x the coupling force, k3·x/2, balances the preload F; then move x by a few floats.
        x = p.F / (0.5 * p.k3) if p.k3 > 0.0 else rng.normal()
        for _ in range(int(rng.integers(0, 4))):
            x = math.nextafter(x, choose(-1.0, 1.0) * math.inf)
        x = choose(x, x, x, x, x, x * (1.0 + draw_tiny(10.0)), rng.normal())
        vx = choose(0.0, rng.normal(), 1e-3 * rng.normal(), draw_tiny())
        y = choose(0.0, 0.0, 0.0, draw_tiny(), draw_tiny(1e-10))
        vy = choose(0.0, 0.0, draw_tiny(), draw_tiny(1e-8), rng.normal())
        drawn_cases.append((p, (x, vx, y, vy)))
    return drawn_cases


# Regressions: a wrong sign of a vanishing acceleration, and a root search without progress.
PAST_FAILURES: list[Case] = [
    (Parameters(F=5.0, k_nl=0.0), (5.0 / 30.0, 2.2246481529443, 0.0, 0.0)),
    (Parameters(F=80.0, k_nl=0.0, mu=0.0), (8.0 / 3.0, 0.00207, 0.0, 4.65e-16)),
]


def assert_kernels_agree(cases: list[Case]) -> None:
    table = np.array([p.values() for p, _ in cases])
    starts = np.array([start for _, start in cases])
    batch = simulate_batch(table, start=starts, t_end=T_END, max_steps=STEP_LIMIT)
    assert (batch.status == Status.DONE).all()
    for index, (p, start) in enumerate(cases):
        options = {"start": start, "t_end": T_END, "max_steps": STEP_LIMIT}
        runs = [
            simulate(p, kernel=kernel, **options)  # type: ignore[arg-type]
            for kernel in ("compiled", "interpreted")
        ]
        compiled, interpreted = runs
        length = max(compiled.peak.x_abs, compiled.peak.y_abs, abs(p.F) / (p.k1 + p.k2 + p.k3))
        speed = length * math.sqrt((p.k1 + p.k2 + p.k3) / p.m)
        sizes = np.array([length, speed, length, speed])
        compiled_final, interpreted_final = (np.array(run.final[1:]) for run in runs)
        assert (batch.final[index] == compiled_final).all(), (p, start)
        assert (np.abs(interpreted_final - compiled_final) <= 1e-9 * sizes).all(), (p, start)
        # Rounding of y, ε = 1e-16 of the motion, can hide a separation as long as √ε of a step. Off
        # y = 0, where the drawn forces nearly balance, it may last the fourth root of ε.
        _, _, start_y, _ = start
        starts_on_switch = start_y == 0.0
        time_tolerance = 1e-7 if starts_on_switch else 1e-3
        separated_time = compiled.events.separated_time
        assert batch.events.separated_time[index] == separated_time
        assert interpreted.events.separated_time == pytest.approx(
            separated_time, abs=time_tolerance
        )


def test_past_failures_agree_between_kernels() -> None:
    assert_kernels_agree(PAST_FAILURES)
    p, start = PAST_FAILURES[0]
    # Compare with an integrator of independent step sizes.
    slow = simulate(p, start=start, t_end=1.5, method="rk4", step=1e-3)
    assert slow.events.separated_time == pytest.approx(0.97137, abs=1e-5)


def test_starts_within_rounding_of_the_switch_agree_between_kernels() -> None:
    assert_kernels_agree(draw_cases(11, 250))


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(4))
def test_thousands_of_starts_within_rounding_of_the_switch_agree_between_kernels(seed: int) -> None:
    assert_kernels_agree(draw_cases(seed, 2000))


def test_the_mode_at_the_switch_is_the_sign_of_y_after_the_start() -> None:
    # From y = 0, y keeps its sign until the first switch, and no switch is skipped.
    for p, (x, vx, _, vy) in draw_cases(12, 300):
        start = (x, vx, 0.0, vy)
        stepper = TaylorStepper(System(p), start)
        segment = stepper.advance()
        assert segment.mode is mode_of(p, start, separation=True)
        size = sum(map(abs, segment.y))
        expected_sign = 1.0 if segment.mode is Mode.SEPARATED else -1.0
        for fraction in (0.25, 0.5, 0.75, 1.0):
            _, _, y, _ = segment.state(segment.start + fraction * segment.duration)
            assert expected_sign * y >= -1e-13 * size
