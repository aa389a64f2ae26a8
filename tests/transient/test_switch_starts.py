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

T_END = 0.7
# A normal run takes at most 40 steps; one with tiny steps reaches the limit.
MOST_STEPS = 400
Case = tuple[Parameters, State]


def cases(seed: int, count: int) -> list[Case]:
    """Parameter sets with a start at or near y = 0, where the forces nearly balance."""
    rng = np.random.default_rng(seed)

    def one_of(*values: float) -> float:
        return float(rng.choice(values))

    def tiny(scale: float = 1.0) -> float:
        return one_of(-1.0, 1.0) * scale * math.pow(10.0, rng.uniform(-17.0, -14.0))

    chosen_cases = []
    for _ in range(count):
        p = Parameters(
            m=rng.uniform(1.0, 10.0),
            k1=rng.uniform(20.0, 200.0),
            k2=rng.uniform(20.0, 200.0),
            k3=one_of(0.0, 60.0, 60.0, *rng.uniform(1.0, 150.0, 4)),
            c1=one_of(0.0, 0.32, rng.uniform(0.0, 2.0)),
            c2=one_of(0.0, 0.32, rng.uniform(0.0, 2.0)),
            F=one_of(0.0, 5.0, 80.0, 80.0, *rng.uniform(0.0, 150.0, 3)),
            k_nl=one_of(0.0, 100.0, rng.uniform(0.0, 500.0)),
            mu=one_of(0.0, 0.7, rng.uniform(0.0, 1.5)),
        )
        x = p.F / (0.5 * p.k3) if p.k3 > 0.0 else rng.normal()
        for _ in range(int(rng.integers(0, 4))):
            x = math.nextafter(x, one_of(-1.0, 1.0) * math.inf)
        x = one_of(x, x, x, x, x, x * (1.0 + tiny(10.0)), rng.normal())
        vx = one_of(0.0, rng.normal(), 1e-3 * rng.normal(), tiny())
        y = one_of(0.0, 0.0, 0.0, tiny(), tiny(1e-10))
        vy = one_of(0.0, 0.0, tiny(), tiny(1e-8), rng.normal())
        chosen_cases.append((p, (x, vx, y, vy)))
    return chosen_cases


# Regressions: the sign of a vanishing acceleration, and a search without progress.
FOUND: list[Case] = [
    (Parameters(F=5.0, k_nl=0.0), (5.0 / 30.0, 2.2246481529443, 0.0, 0.0)),
    (Parameters(F=80.0, k_nl=0.0, mu=0.0), (8.0 / 3.0, 0.00207, 0.0, 4.65e-16)),
]


def assert_all_go_on_alike(chosen: list[Case]) -> None:
    table = np.array([p.values() for p, _ in chosen])
    starts = np.array([start for _, start in chosen])
    batch = simulate_batch(table, start=starts, t_end=T_END, max_steps=MOST_STEPS)
    assert (batch.status == Status.DONE).all()
    for index, (p, start) in enumerate(chosen):
        options = {"start": start, "t_end": T_END, "max_steps": MOST_STEPS}
        run, twin = (
            simulate(p, kernel=kernel, **options)  # type: ignore[arg-type]
            for kernel in ("compiled", "interpreted")
        )
        length = max(run.peak.x_abs, run.peak.y_abs, abs(p.F) / (p.k1 + p.k2 + p.k3))
        speed = length * math.sqrt((p.k1 + p.k2 + p.k3) / p.m)
        sizes = np.array([length, speed, length, speed])
        final = np.array([run.final.x, run.final.vx, run.final.y, run.final.vy])
        twin_state = (twin.final.x, twin.final.vx, twin.final.y, twin.final.vy)
        assert (batch.final[index] == final).all(), (p, start)
        assert (np.abs(twin_state - final) <= 1e-9 * sizes).all(), (p, start)
        # What is lost in the rounding of y lasts for the root of rounding; from a start next to
        # the switch, where the forces balance, for its fourth root, times the step.
        separated, lost = run.events.separated_time, 1e-7 if start[2] == 0.0 else 1e-3
        assert batch.events.separated_time[index] == separated
        assert twin.events.separated_time == pytest.approx(separated, abs=lost)


def test_past_failures_agree_between_kernels() -> None:
    assert_all_go_on_alike(FOUND)
    p, start = FOUND[0]
    # Compare with an integrator of independent step sizes.
    slow = simulate(p, start=start, t_end=1.5, method="rk4", step=1e-3)
    assert slow.events.separated_time == pytest.approx(0.97137, abs=1e-5)


def test_starts_within_rounding_of_the_switch_go_on_alike() -> None:
    assert_all_go_on_alike(cases(11, 250))


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(4))
def test_thousands_of_starts_within_rounding_of_the_switch_go_on_alike(seed: int) -> None:
    assert_all_go_on_alike(cases(seed, 2000))


def test_the_mode_at_the_switch_is_the_sign_that_y_takes() -> None:
    # From y = 0, y keeps its sign until the first switch, and no switch is skipped.
    for p, (x, vx, _, vy) in cases(12, 300):
        start = (x, vx, 0.0, vy)
        stepper = TaylorStepper(System(p), start)
        segment = stepper.advance()
        assert segment.mode is mode_of(p, start, separation=True)
        size = sum(map(abs, segment.y))
        side = 1.0 if segment.mode is Mode.SEPARATED else -1.0
        for part in (0.25, 0.5, 0.75, 1.0):
            y = segment.state(segment.start + part * segment.duration)[2]
            assert side * y >= -1e-13 * size
