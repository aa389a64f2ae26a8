"""Rows and summaries of results agree with a model that is programmed in the tests."""

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fivtui.equilibrium import stability_rows
from fivtui.equilibrium.eigenvalues import stability
from fivtui.model.parameters import Parameters
from fivtui.simulation import simulate
from fivtui.transient import transient_rows
from fivtui.transient.result import Transient
from fivtui.tui.session.comparison import change_rows, percent_text
from fivtui.tui.session.report import result_summary, stability_summary
from tests.support import paper_model


@pytest.fixture(scope="module")
def runs() -> tuple[Transient, Transient]:
    times = np.linspace(0.0, 3.0, 1501)
    with_separation, without_separation = (
        simulate(t_end=3.0, separation=separation, samples=times, tol=1e-9)
        for separation in (True, False)
    )
    return with_separation, without_separation


def number_of(text: str) -> float:
    return float(re.findall(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", text)[0])


def test_rows_of_the_equilibrium_have_labels_values_and_units() -> None:
    rows = {row.label: row for row in stability_rows(stability(Parameters()))}
    x, y, force = paper_model.equilibrium()
    eigenvalues = paper_model.eigenvalues()
    eigenvalues_above_axis = sorted(
        (value for value in eigenvalues.tolist() if value.imag > 0.0), key=lambda value: value.imag
    )
    expected = {
        "growth rate": (eigenvalues.real.max(), "1/s"),
        "critical μ": (paper_model.critical_mu(), "(unstable above)"),
        "critical μ, linear": (paper_model.critical_mu(k_nl=0.0), ""),
        "equilibrium x": (x, "m"),
        "equilibrium y": (y, "m"),
        "contact force": (force, "N"),
    }
    for label, (number, unit) in expected.items():
        assert number_of(rows[label].value) == pytest.approx(number, rel=5e-4), label
        assert rows[label].value.endswith(unit)
    assert rows["verdict"].value == "UNSTABLE"
    doubling = np.log(2.0) / eigenvalues.real.max()
    assert rows["growth rate"].note == f"amplitude doubles every {doubling:.4g} s"
    for mode_number in (1, 2):
        eigenvalue_row, mode_row = rows[f"eigenvalue {mode_number}"], rows[f"mode {mode_number}"]
        real, imaginary = map(
            float, re.findall(r"[-+]?\d+\.\d+", eigenvalue_row.value.replace("± ", ""))
        )
        equal_eigenvalues = [
            value
            for value in eigenvalues_above_axis
            if abs(value.real - real) < 1e-5 and abs(value.imag - imaginary) < 1e-4
        ]
        assert len(equal_eigenvalues) == 1
        assert eigenvalue_row.value.endswith("1/s")
        damping = number_of(mode_row.note)
        nearest = min(
            eigenvalues_above_axis, key=lambda value: abs(-value.real / abs(value) - damping)
        )
        assert damping == pytest.approx(-nearest.real / abs(nearest), rel=5e-3)
        assert number_of(mode_row.value) == pytest.approx(nearest.imag / (2.0 * np.pi), rel=1e-5)
        assert mode_row.value.endswith(" Hz")
    # The base scene's modes have merged at μ = 0.7; at 0.2 they are separate.
    stable_parameters = Parameters(mu=0.2)
    distance_row = {row.label: row for row in stability_rows(stability(stable_parameters))}[
        "frequency distance"
    ]
    undamped_frequencies = [
        value.imag
        for value in paper_model.eigenvalues(mu=0.2, c1=0.0, c2=0.0).tolist()
        if value.imag > 0
    ]
    assert number_of(distance_row.value) == pytest.approx(
        abs(undamped_frequencies[0] - undamped_frequencies[1]) / 2 / np.pi, rel=1e-3
    )
    assert distance_row.value.endswith(" Hz")


def test_the_short_verdict_has_numbers_and_units() -> None:
    parameters = Parameters()
    first, second, third, fourth = stability_summary(stability(parameters))
    eigenvalues = paper_model.eigenvalues()
    leading = max(
        (eigenvalue for eigenvalue in eigenvalues.tolist() if eigenvalue.imag > 0.0),
        key=lambda eigenvalue: eigenvalue.real,
    )
    rate, frequency = f"{leading.real:+.4g} 1/s", f"{leading.imag / 2 / np.pi:.4g} Hz"
    assert first.startswith("UNSTABLE")
    assert rate in first
    assert frequency in first
    percent_above = 100.0 * (0.7 / paper_model.critical_mu() - 1.0)
    assert "0.4394" in second
    assert f"{percent_above:.3g} % above" in second
    x, y, force = paper_model.equilibrium()
    for symbol, value, unit in (("x_e", x, "m"), ("y_e", y, "m"), ("P_e", force, "N")):
        match = re.search(rf"{symbol} (\S+) {unit}\b", third)
        assert match is not None
        assert float(match[1]) == pytest.approx(value, rel=5e-4)
    assert frequency in fourth
    stable_parameters = Parameters(mu=0.2)
    stable_summary = stability_summary(stability(stable_parameters))
    assert stable_summary[0].startswith("STABLE")
    assert f"{100.0 * (1.0 - 0.2 / paper_model.critical_mu()):.3g} % below" in stable_summary[1]


# Results of a run


def test_rows_of_a_run_have_labels_values_and_units(runs: tuple[Transient, Transient]) -> None:
    rows = transient_rows(runs[0], method_note="asked")
    t, motion = paper_model.motion(3.0, separation=True)
    x, vx, y, vy, force = motion.T
    second_half = y[t >= 1.5]
    relative_tolerances = {"m": 2e-3, "m/s": 5e-3, "N": 5e-3, "s": 5e-3}
    expected = {
        "peak |y|": (np.abs(y).max(), "m"),
        "peak |x|": (np.abs(x).max(), "m"),
        "max ẋ": (vx.max(), "m/s"),
        "final x": (x[-1], "m"),
        "final ẋ": (vx[-1], "m/s"),
        "final y": (y[-1], "m"),
        "final ẏ": (vy[-1], "m/s"),
    }
    by_label = {row.label: row for row in rows}
    for label, (value, unit) in expected.items():
        assert number_of(by_label[label].value) == pytest.approx(
            value, rel=relative_tolerances[unit]
        ), label
        assert by_label[label].value.split()[-1] == unit
    (half_range_row,) = [row for row in rows if "half" in row.label]
    assert number_of(half_range_row.value) == pytest.approx(0.5 * np.ptp(second_half), rel=2e-3)
    low, high = by_label["range of y"].value.split(" to ")
    assert (float(low), number_of(high)) == pytest.approx((y.min(), y.max()), rel=2e-3)
    low, high = by_label["contact force"].value.split(" to ")
    assert float(low) == pytest.approx(0.0, abs=1e-9)
    assert number_of(high) == pytest.approx(force.max(), rel=2e-3)
    assert high.endswith(" N")
    crossing_times = t[1:][np.diff(y > 0.0)]
    separation_count = int((np.diff((y > 0.0).astype(int)) > 0).sum())
    assert number_of(by_label["first switch"].value) == pytest.approx(crossing_times[0], abs=5e-3)
    assert number_of(by_label["last switch"].value) == pytest.approx(crossing_times[-1], abs=5e-3)
    assert by_label["reattachments"].value == str(crossing_times.size - separation_count)
    separated_share = float(np.mean(y > 0.0))
    assert by_label["separations"].value == str(separation_count)
    separated_time_row = by_label["time off the belt"]
    assert separated_time_row.value.endswith(" s")
    assert number_of(separated_time_row.value) == pytest.approx(3.0 * separated_share, rel=2e-2)
    assert number_of(separated_time_row.note) == pytest.approx(100.0 * separated_share, rel=2e-2)
    assert separated_time_row.note.endswith("% of the run")
    assert by_label["method"] == ("method", "taylor", "asked")
    assert by_label["steps"].value == str(runs[0].stats.steps)


def test_the_short_summary_of_a_run_has_numbers_and_units(
    runs: tuple[Transient, Transient],
) -> None:
    t, motion = paper_model.motion(3.0, separation=True)
    first, _, third, fourth, *_ = result_summary(runs[0])
    half_range = 0.5 * np.ptp(motion[t >= 1.5, 2])
    assert number_of(first.partition("±")[2]) == pytest.approx(half_range, rel=2e-3)
    assert re.search(r"\d m\b", first)
    force_range, peaks = third.split(" · ")
    peak_y, peak_x = peaks.split(", ")
    assert number_of(peak_y.replace("|y|", "")) == pytest.approx(
        np.abs(motion[:, 2]).max(), rel=2e-3
    )
    assert peak_y.endswith(" m")
    assert number_of(force_range.partition(" to ")[2]) == pytest.approx(
        motion[:, 4].max(), rel=2e-3
    )
    assert force_range.endswith(" N")
    assert number_of(peak_x.partition("|x| ")[2]) == pytest.approx(
        np.abs(motion[:, 0]).max(), rel=2e-3
    )
    assert number_of(fourth) == pytest.approx(motion[:, 1].max(), rel=5e-3)
    assert fourth.endswith(" m/s")


def test_a_run_with_a_baseline_shows_differences_of_the_same_quantities(
    runs: tuple[Transient, Transient],
) -> None:
    with_separation, without_separation = (
        paper_model.motion(3.0, separation=separation)[1] for separation in (True, False)
    )
    rows = {row.label: row for row in change_rows(*runs)}
    quantities: Sequence[tuple[str, str, Callable[[NDArray[np.float64]], Any]]] = (
        ("peak |y|", "m", lambda motion: np.abs(motion[:, 2]).max()),
        ("peak |x|", "m", lambda motion: np.abs(motion[:, 0]).max()),
        ("greatest contact force", "N", lambda motion: motion[:, 4].max()),
        ("max ẋ", "m/s", lambda motion: motion[:, 1].max()),
        ("final x", "m", lambda motion: motion[-1, 0]),
        ("final ẋ", "m/s", lambda motion: motion[-1, 1]),
        ("final y", "m", lambda motion: motion[-1, 2]),
        ("final ẏ", "m/s", lambda motion: motion[-1, 3]),
    )
    for label, unit, compute in quantities:
        row = rows[label]
        difference, baseline = number_of(row.value), number_of(row.note)
        assert row.value.endswith(f" {unit}")
        assert row.note.startswith("from ")
        assert (baseline + difference, baseline) == pytest.approx(
            (float(compute(with_separation)), float(compute(without_separation))), rel=5e-3
        )
        assert float(percent_text(baseline + difference, baseline)) == pytest.approx(
            100.0 * difference / abs(baseline), rel=6e-3
        )
    (half_range_row,) = [row for label, row in rows.items() if "half" in label]
    assert number_of(half_range_row.note) + number_of(half_range_row.value) == pytest.approx(
        0.5 * np.ptp(with_separation[750:, 2]), rel=5e-3
    )
