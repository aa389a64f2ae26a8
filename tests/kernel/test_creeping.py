"""No run creeps: over millions of steps, their mean keeps to the time scale of the motion.

A run creeps if its steps become so small that it never reaches its end. The danger is at the
switch, y = 0, where the slider leaves or meets the belt.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from fivtui.kernel import Kernel, Status, load_kernel
from fivtui.model import Parameters, State, time_scale
from tests.kernel.test_same_bits import random_members
from tests.references import random_scenes
from tests.transient.test_switch_starts import PAST_FAILURES, draw_cases

# After every WINDOW steps their mean is checked: it must be above MIN_MEAN_STEP √(m/stiffness),
# with the stiffness at the deepest contact. The least measured mean step is twice as large.
WINDOW, MIN_MEAN_STEP = 256, 0.25
NEVER_REACHED = 1e12
# Parameters, whether the slider can leave the belt (separation), and the start.
Motion = tuple[Parameters, bool, State]


def random_motions(seed: int, count: int) -> Iterator[Motion]:
    """Random motions: some start within rounding of y = 0, some differ widely in x and y."""
    names = list(Parameters().as_dict())
    for values, separation, start in zip(*random_members(count, seed), strict=True):
        p = Parameters(**dict(zip(names, values.tolist(), strict=True)))
        x, vx, y, vy = start.tolist()
        yield p, bool(separation), (x, vx, y, vy)
    # Starts that once failed, and random ones at or near y = 0 where the forces nearly balance.
    for p, state in [*PAST_FAILURES, *draw_cases(seed, count)]:
        yield p, True, state
    # Every tenth of the stored random scenes, from the one whose index is the seed.
    for scene in random_scenes()[seed::10]:
        yield scene.parameters, scene.separation, scene.start


def count_steps(kernel: Kernel, motion: Motion, order: int, step_limit: int) -> int:
    """Number of steps until the limit or an overflow; checks the mean step of each `WINDOW`."""
    p, separation, start = motion
    # 1e-9 at order 12, 1e-15 at order 20: tighter than any tolerance for which a run has the order.
    tol = 10.0 ** (-0.75 * order)
    run = kernel.begin_run(
        np.array(p.values()),
        np.array(start),
        separation=separation,
        t_end=NEVER_REACHED,
        tol=tol,
        order=order,
    )
    t, steps = 0.0, 0
    while steps < step_limit:
        status = run.advance(WINDOW)
        outcome = run.outcome
        if status is Status.OVERFLOW:
            break
        assert status is Status.RUNNING, motion
        # The y at which the contact was stiffest: stiffness grows with y², but a slider that can
        # leave the belt has no contact at y > 0.
        deepest = min(outcome.y_min, 0.0) if separation else max(outcome.y_max, -outcome.y_min)
        assert outcome.t - t > MIN_MEAN_STEP * WINDOW * time_scale(p, deepest), (motion, t)
        t, steps = outcome.t, int(outcome.steps)
    return steps


@pytest.mark.parametrize("order", [12, 20])
def test_steps_keep_to_the_time_scale_of_the_motion(order: int) -> None:
    kernel = load_kernel()
    motions = random_motions(seed=order, count=60)
    total = sum(count_steps(kernel, motion, order, step_limit=2000) for motion in motions)
    assert total > 200_000


# Only `pytest -m whole` runs so many steps.
@pytest.mark.whole
@pytest.mark.parametrize("order", [8, 12, 16, 20])
def test_millions_of_steps_keep_to_the_time_scale_of_the_motion(order: int) -> None:
    kernel = load_kernel()
    total = sum(
        count_steps(kernel, motion, order, step_limit=20_000)
        for seed in range(3)
        for motion in random_motions(seed, count=150)
    )
    assert total > 5_000_000
