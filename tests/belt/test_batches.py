"""Batches and sweeps on belts of finite speed."""

import json

import numpy as np
import pytest

from fivtui import Parameters, simulate, simulate_batch, sweep
from fivtui.batch import run as batch_run
from fivtui.cli import run
from fivtui.model.errors import InputError
from fivtui.scene.presets import PRESETS
from fivtui.sweeps import local_engine, sweep_chart, sweep_in_memory
from fivtui.tui.tabs.studies.sweep import SweepPane

SPEEDS = [0.0, 0.2, 1.0, 30.0]
FRICTION = {"mu_s": 0.9, "v_s": 0.4}


def test_an_interpreted_batch_equals_the_compiled_one(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = simulate_batch({"v_belt": SPEEDS}, t_end=3.0)
    monkeypatch.setattr(batch_run, "why_interpreted", lambda: "no compiler")
    interpreted = simulate_batch({"v_belt": SPEEDS}, t_end=3.0)
    assert interpreted.final == pytest.approx(compiled.final, abs=1e-11)


def test_belts_faster_than_the_slider_have_the_peak_of_a_run_without_belt_speed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    study = SweepPane.parse(PRESETS["base"], "peak-over-belt-speed")
    assert study.outputs[-1] == "vx_max"
    assert run(["sweep", "--preset", "peak-over-belt-speed", "--both", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert len(data["rows"]) == study.members == 36
    fast_runs = {case: simulate(separation=case) for case in (True, False)}
    # The peak of y falls from 10.5 m to a third at 1 m/s; on slower belts nothing separates.
    rows = [dict(zip(data["columns"], row, strict=True)) for row in data["rows"]]
    peaks = {row["v_belt"]: row["y_max"] for row in rows if row["separation"]}
    assert peaks[30.0] == fast_runs[True].peak.y_max == pytest.approx(10.503, abs=1e-3)
    assert peaks[1.0] == pytest.approx(3.3446, abs=1e-3)
    assert max(peaks[0.1], peaks[0.2]) < 0.0
    result = sweep_in_memory(study, local_engine(1))
    assert result.rows[0][2] == next(row["y_abs"] for row in rows)
    for case, least_speed in ((True, 26.0), (False, 24.0)):
        row_index = result.fast_belt(case)
        assert row_index is not None
        v_belt, _, y_abs, *_ = result.rows[row_index]
        assert v_belt == least_speed > fast_runs[case].peak.vx_max
        assert y_abs == fast_runs[case].peak.y_abs
    chart = sweep_chart(result)
    assert {guide.value: guide.label for guide in chart.guides} == {
        fast_runs[True].peak.y_abs: "always faster, separation considered",
        fast_runs[False].peak.y_abs: "always faster, separation ignored",
    }
    (axes,) = result.figure().axes
    assert axes.get_xlabel() == r"Speed of the belt $v_{\mathrm{belt}}$ (m/s)"
    lines = [line for line in axes.lines if line.get_linestyle() == ":"]
    levels = [np.unique(line.get_ydata()).tolist() for line in lines]
    assert levels == [[fast_runs[case].peak.y_abs] for case in (True, False)]


def test_only_belts_faster_than_the_slider_throughout_a_run_are_always_faster(
    capsys: pytest.CaptureFixture[str],
) -> None:
    slow_belts = sweep(vary={"v_belt": [0.2, 1.0]}, t_end=10.0)
    assert slow_belts.fast_belt(True) is None
    # Friction that falls with the sliding speed depends on the belt speed at any speed.
    falling = Parameters(mu_s=0.9, v_s=0.4)
    assert sweep(falling, vary={"v_belt": [50.0]}, t_end=10.0).fast_belt(True) is None
    assert sweep(vary={"F": [20.0]}, t_end=1.0).fast_belt(True) is None
    # Only the output vx_max shows whether the slider reaches the belt speed.
    assert sweep(vary={"v_belt": [50.0]}, outputs=["y_abs"], t_end=1.0).fast_belt(True) is None
    assert run(["sweep", "--vary", "v_belt=1,50", "--t-end", "10"]) == 0
    message = "from v_belt = 50 m/s on the belt is always faster than the slider: y_abs = "
    assert message in capsys.readouterr().err
    for arguments, message in (
        ([], "--vary: must be given, or --preset"),
        (["--preset", "peak"], "unknown sweep 'peak' (known: peak-over-belt-speed)"),
        (["--preset", "peak-over-belt-speed", "--vary", "F=1,2"], "must be given without --vary"),
    ):
        assert run(["sweep", *arguments]) == 2
        assert message in capsys.readouterr().err


def test_parameters_without_effect_or_out_of_range_are_refused() -> None:
    with pytest.raises(InputError, match="mu_s has no effect without v_belt"):
        simulate_batch({"mu_s": [1.0]})
    with pytest.raises(InputError, match=r"member 1: mu_s = 0\.5: must be at least mu = 0\.7"):
        simulate_batch({"mu_s": [1.0, 0.5], "v_belt": np.ones(2)})
    # Without a belt speed, the base's other friction parameters are ignored, as in a single run.
    base = Parameters().with_values(FRICTION)
    assert simulate_batch({"F": [80.0]}, base=base, t_end=1.0).failed.size == 0
    with pytest.raises(InputError, match=r"v_belt = -2e\+09"):
        simulate_batch({"v_belt": [-2e9]})
