"""Random scenes keep the error that `tol` promises, against solutions with 25 digits.

An error is at most tol·max(1, G/10)·max(1, N/100) times the scale of its variable, as
`docs/explanation/tolerance.md` explains. The scale is about the greatest size of the variable in
the run. G, `growth`, is the greatest factor by which the motion magnifies a small error between two
times of the run. N, `fast_periods`, is the length of the run in periods of its fastest vibration.
Tests marked `whole` run only by `pytest -m whole`.
"""

import numpy as np
import pytest

from fivtui import simulate
from fivtui.transient.request import Kernel
from tests.references import RandomScene, random_scenes

SCENES = random_scenes()
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13)


def error_ratio(scene: RandomScene, tol: float, kernel: Kernel) -> float:
    """Ratio of the greatest error of a run to the promised error."""
    p, options = scene.parameters, {"start": scene.start, "separation": scene.separation}
    run = simulate(p, t_end=scene.t_end, tol=tol, kernel=kernel, **options)  # type: ignore[arg-type]
    values = (run.final.x, run.final.vx, run.final.y, run.final.vy, run.peak.x_abs, run.peak.y_abs)
    true_values = (*scene.final, *scene.peaks)
    # The scales of x, ẋ, y and ẏ, and of the peaks of x and y.
    x_scale, _, y_scale, _ = scene.scales
    scales = np.array([*scene.scales, x_scale, y_scale])
    promised = tol * max(1.0, scene.growth / 10.0) * max(1.0, scene.fast_periods / 100.0) * scales
    errors = np.abs(np.subtract(values, true_values))
    # A variable that stays zero has the scale zero and must be exact: any error is a huge ratio.
    return float(np.max(errors / np.where(promised > 0.0, promised, np.finfo(float).tiny)))


def test_the_hundreds_of_scenes_vary_in_scales_growth_and_duration() -> None:
    assert len(SCENES) >= 300
    scales = [scene.scales for scene in SCENES]
    ratios = np.array([x_scale / y_scale for x_scale, _, y_scale, _ in scales if y_scale])
    assert (ratios > 100.0).sum() > 10
    assert (ratios < 0.01).sum() > 10
    assert sum(scene.growth < 10.0 for scene in SCENES) > 100
    assert sum(scene.fast_periods > 100.0 for scene in SCENES) > 20


@pytest.mark.parametrize("tol", TOLERANCES)
def test_errors_are_below_the_promised_bound(tol: float) -> None:
    assert max(error_ratio(scene, tol, "compiled") for scene in SCENES) < 1.0


@pytest.mark.parametrize("tol", [1e-4, 1e-12])
def test_errors_of_interpreted_runs_are_below_the_promised_bound(tol: float) -> None:
    assert max(error_ratio(scene, tol, "interpreted") for scene in SCENES[::20]) < 1.0


@pytest.mark.whole
@pytest.mark.parametrize("tol", TOLERANCES)
def test_errors_of_all_interpreted_runs_are_below_the_promised_bound(tol: float) -> None:
    assert max(error_ratio(scene, tol, "interpreted") for scene in SCENES) < 1.0
