"""Trade-offs: errors and CPU times of settings, the best settings, and the measurement itself."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui.cli import run
from fivtui.model import Progress, System
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.model.parameters import Parameters
from fivtui.scene.presets import PRESETS
from fivtui.tradeoffs import measure
from fivtui.tradeoffs.measure import Tradeoff, measure_tradeoff
from fivtui.tradeoffs.settings import MeasuredSetting, Setting, cheapest, ladders, pareto_front
from fivtui.transient import integrate
from fivtui.transient.errors import (
    QUANTITIES,
    Deviation,
    Observation,
    deviation,
    observation,
)
from fivtui.transient.request import Request
from tests.references import REFERENCES
from tests.support.kernels import INTERPRETED

SHORT = replace(PRESETS["base"], t_end=4.0)
# Only the method taylor has a choice of kernels.
RK4 = Setting("rk4", kernel="", knob="step", value=0.1)


def row(cpu_s: float, error: float | None) -> MeasuredSetting:
    """A setting with the same error in all quantities; a failed run without an error."""
    errors = (
        None
        if error is None
        else Deviation(final=error, peak=error, half_range=error, events=error, separations=0)
    )
    return MeasuredSetting(RK4, cpu_s, steps=1, error=errors)


row_lists = st.lists(
    st.builds(row, st.floats(1e-6, 10.0), st.none() | st.floats(0.0, 1.0)), max_size=12
)


@given(row_lists)
def test_the_front_holds_exactly_the_settings_that_no_other_beats(
    rows: list[MeasuredSetting],
) -> None:
    front = pareto_front(rows, "peak")

    def beats(first: MeasuredSetting, second: MeasuredSetting) -> bool:
        assert first.error is not None
        assert second.error is not None
        return first.cpu_s <= second.cpu_s and first.error.peak <= second.error.peak

    for entry in rows:
        if entry.error is not None:
            assert not any(beats(entry, best) and not beats(best, entry) for best in front)
            assert any(beats(best, entry) for best in front)


@given(row_lists, st.floats(1e-9, 1.0))
def test_the_cheapest_setting_has_the_error_and_no_cheaper_one_has(
    rows: list[MeasuredSetting], error: float
) -> None:
    accurate = [entry for entry in rows if entry.error is not None and entry.error.peak <= error]
    best = cheapest(rows, "peak", error)
    assert (best is None) == (not accurate)
    if best is not None:
        assert best.cpu_s == min(entry.cpu_s for entry in accurate)


def test_errors_within_the_uncertainty_are_equal() -> None:
    rows = [row(1.0, 3e-15), row(2.0, 1e-16)]
    assert pareto_front(rows, "final") == rows
    assert pareto_front(rows, "final", floor=1e-14) == rows[:1]


def test_an_unknown_quantity_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="peak"):
        pareto_front([], "peek")


def test_a_deviation_is_the_error_against_a_stored_reference() -> None:
    reference = REFERENCES["base"]
    fine = integrate(
        Request(System(reference.parameters), t_end=reference.t_end, kernel="interpreted")
    )
    coarse = integrate(
        Request(System(reference.parameters), t_end=reference.t_end, method="rk4", step=0.02)
    )
    result = deviation(observation(coarse), observation(fine))
    assert result.peak == pytest.approx(
        abs(coarse.peak.y_abs / reference.peak_y_abs - 1.0), rel=1e-6
    )
    delays = np.subtract(coarse.switch_times, reference.switch_times)
    assert result.events == pytest.approx(np.abs(delays).max(), rel=1e-6)
    assert deviation(observation(fine), observation(fine)) == Deviation(
        final=0.0, peak=0.0, half_range=0.0, events=0.0, separations=0
    )


def test_missed_switches_have_no_finite_error() -> None:
    p = Parameters()
    result = deviation(
        observation(integrate(Request(System(p, separation=False), t_end=20.0))),
        observation(integrate(Request(System(p), t_end=20.0))),
    )
    assert result.separations < 0
    assert math.isinf(result.events)


def test_rk4_across_the_switch_converges_at_lower_order() -> None:
    truth = observation(integrate(Request(System(Parameters()), t_end=10.0, kernel="interpreted")))

    def order(method: str) -> float:
        coarse, fine = (
            deviation(
                observation(
                    integrate(Request(System(Parameters()), t_end=10.0, method=method, step=step))
                ),
                truth,
            ).final
            for step in (0.01, 0.0025)
        )
        return math.log(coarse / fine) / math.log(4.0)

    assert order("rk4") > 3.5
    assert 1.0 < order("rk4-across") < 3.5


def test_ladders_go_from_coarse_to_fine_within_bounds() -> None:
    for ladder in ladders(time_scale=0.15, t_end=0.05):
        values = [setting.value for setting in ladder.settings()]
        assert values == sorted(values, reverse=True)
        assert values[0] == ladder.coarsest
        assert values[-1] == pytest.approx(ladder.finest, rel=1e-5)
        assert ladder.knob == "tol" or max(values) <= 0.05


def test_methods_of_a_kind_are_measured_at_the_same_steps() -> None:
    steps = {
        ladder.method: [setting.value for setting in ladder.settings()]
        for ladder in ladders(time_scale=0.15, t_end=10.0)
        if ladder.knob == "step"
    }
    assert steps["rk4"] == steps["rk4-across"]
    assert steps["fmu"] == steps["fmu-native"]


# Another run begins while at most 0.02 s and at most the budget have passed, up to 15 runs.
@pytest.mark.parametrize(
    ("cost", "budget", "runs"),
    [(0.001, 1.0, 15), (0.015, 1.0, 2), (0.03, 1.0, 1), (0.004, 0.006, 2)],
)
def test_a_quick_setting_is_measured_several_times_and_its_least_time_counts(
    cost: float, budget: float, runs: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    observed = observation(integrate(Request(System(Parameters()), t_end=1.0)))
    clock = [100.0]
    costs: list[float] = []

    def pretend_run(*_: object) -> tuple[Observation, int, float]:
        # Measured times vary a little around the time on the clock: by −2, −1, 0 or 1 in 1000.
        thousandths = len(costs) % 2 - len(costs) % 3
        costs.append(cost * (1.0 + 1e-3 * thousandths))
        clock[0] += cost
        return observed, 7, costs[-1]

    monkeypatch.setattr(measure._Benchmark, "_run", pretend_run)
    monkeypatch.setattr("time.thread_time", lambda: clock[0])
    benchmark = measure._Benchmark(
        SHORT, observed, deviation(observed, observed), {}, Progress(None)
    )
    result = benchmark.measure(RK4, budget)
    assert len(costs) == runs
    assert result.cpu_s == min(costs)


def test_the_cost_in_a_batch_is_that_of_a_member(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]

    def batch(parameters: dict[str, np.ndarray], **_: object) -> SimpleNamespace:
        clock[0] += 1e-3 * parameters["F"].size
        return SimpleNamespace(failed=np.empty(0), steps=np.array([17]))

    monkeypatch.setattr(measure, "simulate_batch", batch)
    monkeypatch.setattr("time.process_time", lambda: clock[0])
    cost, steps = measure._batch_cost(SHORT, required=(), monitor=Progress(None))
    assert cost == pytest.approx(1e-3)
    assert steps == 17


@pytest.fixture(scope="module")
def short_tradeoff() -> Tradeoff:
    return measure_tradeoff(SHORT)


@pytest.mark.whole
def test_without_a_compiled_kernel_the_interpreted_one_is_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # CPU time of a whole measurement, s.
    monkeypatch.setattr(measure, "QUICK_S", 0.1)
    with INTERPRETED:
        result = measure_tradeoff(replace(SHORT, t_end=2.0))
    assert {entry.setting.kernel for entry in result.rows} == {"", "interpreted"}


@pytest.mark.slow
def test_every_method_is_measured_and_the_finer_setting_has_less_error(
    short_tradeoff: Tradeoff,
) -> None:
    by_method: dict[str, list[MeasuredSetting]] = {}
    for entry in short_tradeoff.rows:
        by_method.setdefault(entry.setting.label, []).append(entry)
    assert len(by_method) == 9
    for method, rows in by_method.items():
        errors = [entry.error.peak for entry in rows if entry.error is not None]
        assert errors, method
        assert errors[-1] <= errors[0] or errors[-1] <= short_tradeoff.floor.peak
        assert all(
            entry.cpu_s > 0.0 and entry.steps > 0 for entry in rows if entry.error is not None
        )
    assert short_tradeoff.floor.final < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fmu", "fmu-native"])
def test_the_fmu_has_the_final_state_at_any_communication_step_and_samples_its_peak(
    short_tradeoff: Tradeoff, method: str
) -> None:
    rows = [entry for entry in short_tradeoff.rows if entry.setting.method == method]
    errors = [entry.error for entry in rows if entry.error is not None]
    assert len(errors) > 1
    assert all(error.final < 1e-10 and error.events < 1e-10 for error in errors)
    assert errors[0].peak > errors[-1].peak > 0.0


@pytest.mark.slow
def test_a_tradeoff_is_drawn(short_tradeoff: Tradeoff) -> None:
    figure = short_tradeoff.figure()
    assert [axes.get_xscale() for axes in figure.axes] == ["log"] * 3
    legend = {text.get_text() for text in figure.legends[0].get_texts()}
    assert legend == {
        entry.setting.label for entry in short_tradeoff.rows if entry.error is not None
    }


def test_a_reference_that_cannot_be_verified_is_refused_with_the_time() -> None:
    undamped = replace(SHORT, t_end=1000.0).with_values({"c1": 0.0, "c2": 0.0})
    with pytest.raises(ComputationError, match="diverge at t = "):
        measure_tradeoff(undamped)


def test_a_tradeoff_can_be_cancelled() -> None:
    with pytest.raises(Cancelled):
        measure_tradeoff(SHORT, progress=lambda _fraction: False)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--error", "peek=1e-3"], "peak"),
        (["--error", "peak=0"], "must be above 0 and at most 1"),
        (["--error", "peak"], "NAME=VALUE"),
        (["--out", "t.txt"], ".csv"),
    ],
)
def test_a_wrong_request_for_a_tradeoff_is_one_line(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["tradeoff", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert set(QUANTITIES) == {"final", "peak", "half_range", "events"}
