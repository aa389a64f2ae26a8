"""Error estimates of runs, against references."""

import json
import re

import pytest
from click.testing import CliRunner

from fivtui.assessment.estimate import Estimate, accuracy, reliable_digits
from fivtui.cli import commands
from fivtui.model.errors import Cancelled
from fivtui.scene.presets import PRESETS
from fivtui.scene.scene import Scene
from tests.references import REFERENCES

BASE = PRESETS["base"]


def scene(**changes: object) -> Scene:
    import dataclasses

    return dataclasses.replace(BASE, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize("tol", [1e-4, 1e-7, 1e-10])
def test_true_errors_are_at_most_twice_the_estimates(tol: float) -> None:
    result = accuracy(scene(tol=tol))
    reference = REFERENCES["base"]
    for name, value in zip(("x", "vx", "y", "vy"), reference.final, strict=True):
        estimate = result.estimates[name]
        error = abs(estimate.value - value)
        assert error <= 2.0 * estimate.difference + 1e-12
    peak = result.estimates["peak_y_abs"]
    assert abs(peak.value - reference.peak_y_abs) <= 2.0 * peak.difference + 1e-12


def test_the_comparison_run_has_another_setting() -> None:
    assert accuracy(scene(tol=1e-6, t_end=5.0)).finer == "tol 1e-08"
    # 1e-13 is the least tolerance, so the second run has a greater one.
    assert accuracy(scene(tol=1e-13, t_end=5.0)).finer == "tol 1e-11"
    assert accuracy(scene(method="rk4", step=0.01, t_end=2.0)).finer == "step 0.005 s"


@pytest.mark.parametrize(
    ("value", "difference", "text"),
    [
        (3.14159265, 1e-4, "3.142"),
        # At least one digit is shown.
        (-3.14159265, 5.0, "-3"),
        (0.0, 1e-9, "0"),
        (74.0, 0.0, "74"),
    ],
)
def test_only_reliable_digits_are_shown(value: float, difference: float, text: str) -> None:
    assert reliable_digits(Estimate(value, difference)) == text


def test_the_command_prints_text_and_json() -> None:
    result = CliRunner().invoke(commands, ["accuracy", "--t-end", "20", "--tol", "1e-8"])
    assert result.exit_code == 0
    assert "compared with tol 1e-10" in result.output
    assert "largest Lyapunov exponent" in result.output
    printed = CliRunner().invoke(
        commands, ["accuracy", "--set", "mu=0.2", "--t-end", "300", "--tol", "1e-8", "--json"]
    )
    data = json.loads(printed.stdout)
    assert data["growth"]["fate"] == "decays"
    assert data["estimates"]["separations"] == {"value": 0.0, "difference": 0.0}


def test_runs_that_diverge_have_no_reliable_digits() -> None:
    undamped = ["accuracy", "--set", "c1=0", "--set", "c2=0", "--t-end", "800", "--tol", "1e-8"]
    result = CliRunner().invoke(commands, undamped)
    assert result.exit_code == 0
    for quantity in ("x", "peak_y_abs", "y_half_range"):
        assert re.search(rf"^{quantity} +none ", result.output, flags=re.MULTILINE)
    assert "the runs diverge at" in result.output
    data = json.loads(CliRunner().invoke(commands, [*undamped, "--json"]).stdout)
    assert 0.0 < data["parted"]["t"] < 800.0
    assert "switches differ" in data["parted"]["reason"]
    assert accuracy(scene(tol=1e-8, t_end=20.0)).parted is None


def test_accuracy_can_be_cancelled() -> None:
    with pytest.raises(Cancelled):
        accuracy(BASE, progress=lambda fraction: fraction < 0.5)
