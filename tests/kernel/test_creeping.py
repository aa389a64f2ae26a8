"""No run creeps: steps keep to the time scale of the motion, over millions of them."""

from collections.abc import Iterator

import numpy as np
import pytest

from fivtui.kernel import Kernel, Status, load_kernel
from fivtui.model import Parameters, State, time_scale
from tests.kernel.test_same_bits import members
from tests.references import random_scenes
from tests.transient.test_switch_starts import FOUND, cases

# Steps between two looks, and the least mean step there over √(m/stiffness) at the deepest contact;
# half of it is the least that was seen.
WINDOW, LEAST = 256, 0.25
ENDLESS = 1e12
Watched = tuple[Parameters, bool, State]


def watched(seed: int, count: int) -> Iterator[Watched]:
    """Random motions; some start within rounding of the switch, some differ widely in x and y."""
    names = list(Parameters().as_dict())
    for values, separation, start in zip(*members(count, seed), strict=True):
        p = Parameters(**dict(zip(names, values.tolist(), strict=True)))
        x, vx, y, vy = start.tolist()
        yield p, bool(separation), (x, vx, y, vy)
    for p, state in [*FOUND, *cases(seed, count)]:
        yield p, True, state
    for scene in random_scenes()[seed::10]:
        yield scene.parameters, scene.separation, scene.start


def steps_of(kernel: Kernel, motion: Watched, order: int, step_limit: int) -> int:
    """Count the steps of a run that may only overflow; check the mean step of each `WINDOW`."""
    p, separation, start = motion
    run = kernel.begin_run(
        np.array(p.values()),
        np.array(start),
        separation=separation,
        t_end=ENDLESS,
        tol=10.0 ** (-0.75 * order),
        order=order,
    )
    t, steps = 0.0, 0
    while steps < step_limit:
        status = run.advance(WINDOW)
        outcome = run.outcome
        if status is Status.OVERFLOW:
            break
        assert status is Status.RUNNING, motion
        deepest = min(outcome.y_min, 0.0) if separation else max(outcome.y_max, -outcome.y_min)
        assert outcome.t - t > LEAST * WINDOW * time_scale(p, deepest), (motion, t)
        t, steps = outcome.t, int(outcome.steps)
    return steps


@pytest.mark.parametrize("order", [12, 20])
def test_steps_keep_to_the_time_scale_of_the_motion(order: int) -> None:
    kernel = load_kernel()
    total = sum(steps_of(kernel, motion, order, 2000) for motion in watched(order, 60))
    assert total > 200_000


@pytest.mark.whole
@pytest.mark.parametrize("order", [8, 12, 16, 20])
def test_millions_of_steps_keep_to_the_time_scale_of_the_motion(order: int) -> None:
    kernel = load_kernel()
    total = sum(
        steps_of(kernel, motion, order, 20_000)
        for seed in range(3)
        for motion in watched(seed, 150)
    )
    assert total > 5_000_000
