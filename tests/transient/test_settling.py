"""Unsettled runs are recognized by the motion after their end."""

import pytest

from fivtui import cli
from fivtui.model.parameters import Parameters
from fivtui.simulation import simulate
from fivtui.transient.native import later_amplitude
from fivtui.tui.session.report import result_summary


def test_the_amplitude_after_the_end_is_that_of_a_longer_run(
    capsys: pytest.CaptureFixture[str],
) -> None:
    run = simulate()
    amplitude_after_end = later_amplitude(run)
    assert amplitude_after_end is not None
    # The amplitude is that in the second half of the time `after` the end, s.
    end, after = run.t_end, amplitude_after_end.after
    longer = simulate(t_end=end + after, samples="dense")
    assert longer.solution is not None
    times = [end + after * (0.5 + index / 40_000) for index in range(20_001)]
    y = longer.solution(times).y
    assert amplitude_after_end.y_half_range == pytest.approx(0.5 * (y.max() - y.min()), rel=1e-6)
    assert run.steady.y_half_range > 1.1 * amplitude_after_end.y_half_range
    first, *_, last_line = result_summary(run)
    assert first == "amplitude of y ±4.401 m, still falling"
    assert last_line == "not settled: ±3.861 m 24.6 s after the end"
    assert cli.run(["simulate"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "over the second half of the run; not settled: 3.86103 m 24.6447 s later" in printed


@pytest.mark.parametrize(
    ("p", "t_end"),
    [
        (Parameters(), 1000.0),
        (Parameters(mu=0.2), 3000.0),
        (Parameters(v_belt=1.0), 1000.0),
        (Parameters(F=0.0), 100.0),
    ],
    ids=["cycle", "rest", "belt of finite speed", "never moves"],
)
def test_a_run_on_its_cycle_or_at_rest_has_settled(p: Parameters, t_end: float) -> None:
    run = simulate(p, t_end=t_end)
    assert later_amplitude(run) is None
    assert "still" not in result_summary(run)[0]


def test_parameters_over_time_have_no_amplitude_to_settle_on() -> None:
    run = simulate(over_time={"mu": [(0.0, 0.2), (100.0, 0.9)]})
    assert later_amplitude(run) is None


def test_a_motion_that_overflows_after_its_end_is_not_called_unsettled() -> None:
    # The motion grows without bounds and overflows soon after the end of the run.
    p = Parameters(k_nl=0.0, mu=5.0)
    run = simulate(p, separation=False, t_end=440.0)
    assert run.peak.y_abs > 1e200
    assert later_amplitude(run) is None
