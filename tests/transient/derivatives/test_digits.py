"""The printed digits of a final state are correct, against 25 digits and finer runs."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.model import time_scale
from fivtui.transient import Request, Transient, transient_rows
from fivtui.transient.derivatives.digits import final_digits
from tests.references import RandomScene, random_scenes

UNDAMPED = Parameters(c1=0.0, c2=0.0)


def final_state(run: Transient) -> list[float]:
    return [run.final.x, run.final.vx, run.final.y, run.final.vy]


def excess_digits(scene: RandomScene, tol: float) -> list[float]:
    """Reported minus correct digits of each component of the final state."""
    run = simulate(
        scene.parameters,
        t_end=scene.t_end,
        start=scene.start,
        separation=scene.separation,
        tol=tol,
        kernel="compiled",
    )
    digits = final_digits(run)
    assert digits is not None
    excess = []
    for count, value, true in zip(digits, final_state(run), scene.final, strict=True):
        # Skip components without reliable digits, and those without a finite relative error.
        if count and true not in (0.0, value):
            correct_digits = math.log10(abs(true / (value - true)))
            excess.append(count - correct_digits)
    return excess


@pytest.mark.parametrize("tol", [1e-4, 1e-8, 1e-12])
def test_digits_of_random_scenes_are_correct(tol: float) -> None:
    excess = np.concatenate([excess_digits(scene, tol) for scene in random_scenes()[::2]])
    assert excess.max() < 1.0
    assert (excess > 0.0).mean() < 0.005
    # The reported digits are not too few.
    assert np.median(excess) > -4.0


@pytest.mark.parametrize("t_end", [100.0, 5000.0])
def test_digits_of_short_and_long_runs_are_correct(t_end: float) -> None:
    run, finer = simulate(t_end=t_end), simulate(t_end=t_end, tol=1e-13)
    digits = final_digits(run)
    assert digits is not None
    for count, value, finer_value in zip(digits, final_state(run), final_state(finer), strict=True):
        assert 8 <= count <= 13
        assert abs(value - finer_value) < abs(value) * 10.0**-count


@pytest.mark.parametrize("p", [Parameters(), Parameters(c1=200.0), Parameters(F=0.0)])
def test_growth_of_errors_is_computed_only_over_part_of_a_long_run(
    p: Parameters, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = simulate(p, t_end=20_000.0)
    durations: list[float] = []

    def record_duration(request: Request, seeds: Any) -> Any:
        durations.append(request.t_end)
        return SimpleNamespace(derivatives=np.eye(4), final=request.initial)

    monkeypatch.setattr("fivtui.transient.derivatives.digits.compute_variation", record_duration)
    assert final_digits(run) is not None
    fraction = sum(durations) / run.t_end
    fastest_rate = max(1.0 / time_scale(p), p.c1 / p.m, p.c2 / p.m)
    assert fraction < 1.0
    # Limits of `final_digits`, up to rounding: in steps, and in units of the shortest time scale.
    assert fraction * run.stats.steps <= 20_000.0 * (1.0 + 1e-12)
    assert sum(durations) * fastest_rate <= 12_000.0 * (1.0 + 1e-12)


@pytest.mark.parametrize("t_end", [1000.0, 5000.0])
def test_no_digit_is_reliable_where_errors_grow_exponentially(t_end: float) -> None:
    run = simulate(UNDAMPED, t_end=t_end)
    assert final_digits(run) == (0, 0, 0, 0)
    rows = {row.label: row for row in transient_rows(run)}
    for name in ("x", "ẋ", "y", "ẏ"):
        assert rows[f"final {name}"].note == "no reliable digit"
        assert len(rows[f"final {name}"].value.split()[0].lstrip("-")) <= 5


def test_reports_and_data_give_the_reliable_digits() -> None:
    run = simulate()
    digits = final_digits(run)
    assert digits is not None
    rows = {row.label: row for row in transient_rows(run)}
    assert rows["final x"].value == f"{run.final.x:.{digits.x}g} m"
    assert rows["final x"].note == "t = 100 s, reliable digits only"
    data = run.to_dict()
    assert data["final_digits"] == digits._asdict()
    assert data["final"]["x"] == run.final.x


@pytest.mark.parametrize(
    "options",
    [{"method": "rk4"}, {"kernel": "interpreted"}, {"method": "scipy-dop853"}],
)
def test_unknown_digits_are_not_printed(options: dict[str, Any]) -> None:
    run = simulate(t_end=2.0, **options)
    assert final_digits(run) is None
    assert run.to_dict()["final_digits"] is None
    rows = {row.label: row for row in transient_rows(run)}
    assert rows["final x"].value == f"{run.final.x:.13g} m"


def test_all_digits_of_rest_are_reliable() -> None:
    run = simulate(Parameters(F=0.0), t_end=5.0, start=(0.0,) * 4)
    assert final_digits(run) == (13, 13, 13, 13)
