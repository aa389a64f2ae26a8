"""Rows of results in the laboratory: numbers and units under their labels."""

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
from fivtui.tui.session.comparison import change_rows, changes, percent_text
from fivtui.tui.session.report import result_summary, stability_summary
from tests.support import own_slider


@pytest.fixture(scope="module")
def runs() -> tuple[Transient, Transient]:
    times = np.linspace(0.0, 3.0, 1501)
    considered, ignored = (
        simulate(t_end=3.0, separation=case, samples=times, tol=1e-9) for case in (True, False)
    )
    return considered, ignored


def number_of(text: str) -> float:
    return float(re.findall(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", text)[0])


def test_rows_of_the_equilibrium_have_labels_values_and_units() -> None:
    rows = {row.label: row for row in stability_rows(stability(Parameters()))}
    x, y, force = own_slider.equilibrium()
    eigenvalues = own_slider.eigenvalues()
    upper = sorted((v for v in eigenvalues.tolist() if v.imag > 0.0), key=lambda v: v.imag)
    expected = {
        "growth rate": (eigenvalues.real.max(), "1/s"),
        "critical μ": (own_slider.critical_mu(), "(unstable above)"),
        "critical μ, linear": (own_slider.critical_mu(k_nl=0.0), ""),
        "equilibrium x": (x, "m"),
        "equilibrium y": (y, "m"),
        "contact force": (force, "N"),
    }
    for label, (value, unit) in expected.items():
        assert number_of(rows[label].value) == pytest.approx(value, rel=5e-4), label
        assert rows[label].value.endswith(unit)
    assert rows["verdict"].value == "UNSTABLE"
    doubling = np.log(2.0) / eigenvalues.real.max()
    assert rows["growth rate"].note == f"amplitude doubles every {doubling:.4g} s"
    for number in (1, 2):
        eigenvalue, mode = rows[f"eigenvalue {number}"], rows[f"mode {number}"]
        real, imaginary = map(
            float, re.findall(r"[-+]?\d+\.\d+", eigenvalue.value.replace("± ", ""))
        )
        (match,) = [
            v for v in upper if abs(v.real - real) < 1e-5 and abs(v.imag - imaginary) < 1e-4
        ]
        assert eigenvalue.value.endswith("1/s")
        damping = number_of(mode.note)
        match = min(upper, key=lambda v: abs(-v.real / abs(v) - damping))
        assert damping == pytest.approx(-match.real / abs(match), rel=5e-3)
        assert number_of(mode.value) == pytest.approx(match.imag / (2.0 * np.pi), rel=1e-5)
        assert mode.value.endswith(" Hz")
    # The base scene's modes have merged at μ = 0.7; at 0.2 they are separate.
    low = Parameters(mu=0.2)
    distance = {row.label: row for row in stability_rows(stability(low))}["frequency distance"]
    free = [v.imag for v in own_slider.eigenvalues(mu=0.2, c1=0.0, c2=0.0).tolist() if v.imag > 0]
    assert number_of(distance.value) == pytest.approx(abs(free[0] - free[1]) / 2 / np.pi, rel=1e-3)
    assert distance.value.endswith(" Hz")


def test_the_short_verdict_has_numbers_and_units() -> None:
    p = Parameters()
    first, second, third, fourth = stability_summary(stability(p))
    eigenvalues = own_slider.eigenvalues()
    leading = max((v for v in eigenvalues.tolist() if v.imag > 0.0), key=lambda v: v.real)
    rate, hertz = f"{leading.real:+.4g} 1/s", f"{leading.imag / 2 / np.pi:.4g} Hz"
    assert first.startswith("UNSTABLE")
    assert rate in first
    assert hertz in first
    above = 100.0 * (0.7 / own_slider.critical_mu() - 1.0)
    assert "0.4394" in second
    assert f"{above:.3g} % above" in second
    x, y, force = own_slider.equilibrium()
    for part, value, unit in (("x_e", x, "m"), ("y_e", y, "m"), ("P_e", force, "N")):
        match = re.search(rf"{part} (\S+) {unit}\b", third)
        assert match is not None
        assert float(match[1]) == pytest.approx(value, rel=5e-4)
    assert hertz in fourth
    calm = Parameters(mu=0.2)
    brief = stability_summary(stability(calm))
    assert brief[0].startswith("STABLE")
    assert f"{100.0 * (1.0 - 0.2 / own_slider.critical_mu()):.3g} % below" in brief[1]


# Results of a run


def test_rows_of_a_run_have_labels_values_and_units(runs: tuple[Transient, Transient]) -> None:
    rows = transient_rows(runs[0], "asked")
    t, motion = own_slider.motion(3.0, separation=True)
    x, vx, y, vy, force = motion.T
    second = y[t >= 1.5]
    units = {"m": 2e-3, "m/s": 5e-3, "N": 5e-3, "s": 5e-3}
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
        assert number_of(by_label[label].value) == pytest.approx(value, rel=units[unit]), label
        assert by_label[label].value.split()[-1] == unit
    (half,) = [row for row in rows if "half" in row.label]
    assert number_of(half.value) == pytest.approx(0.5 * np.ptp(second), rel=2e-3)
    low, high = by_label["range of y"].value.split(" to ")
    assert (float(low), number_of(high)) == pytest.approx((y.min(), y.max()), rel=2e-3)
    low, high = by_label["contact force"].value.split(" to ")
    assert float(low) == pytest.approx(0.0, abs=1e-9)
    assert number_of(high) == pytest.approx(force.max(), rel=2e-3)
    assert high.endswith(" N")
    changes_ = t[1:][np.diff(y > 0.0)]
    lifted = int((np.diff((y > 0.0).astype(int)) > 0).sum())
    assert number_of(by_label["first switch"].value) == pytest.approx(changes_[0], abs=5e-3)
    assert number_of(by_label["last switch"].value) == pytest.approx(changes_[-1], abs=5e-3)
    assert by_label["reattachments"].value == str(changes_.size - lifted)
    off = float(np.mean(y > 0.0))
    assert by_label["separations"].value == str(lifted)
    time = by_label["time off the belt"]
    assert time.value.endswith(" s")
    assert number_of(time.value) == pytest.approx(3.0 * off, rel=2e-2)
    assert number_of(time.note) == pytest.approx(100.0 * off, rel=2e-2)
    assert time.note.endswith("% of the run")
    assert by_label["method"] == ("method", "taylor", "asked")
    assert by_label["steps"].value == str(runs[0].stats.steps)


def test_the_short_summary_of_a_run_has_numbers_and_units(
    runs: tuple[Transient, Transient],
) -> None:
    t, motion = own_slider.motion(3.0, separation=True)
    first, _, third, fourth, *_ = result_summary(runs[0])
    peak, steady = first.split(" · ")
    assert number_of(peak.replace("|y|", "")) == pytest.approx(np.abs(motion[:, 2]).max(), rel=2e-3)
    assert peak.endswith(" m")
    half = 0.5 * np.ptp(motion[t >= 1.5, 2])
    assert number_of(steady.partition("±")[2]) == pytest.approx(half, rel=2e-3)
    assert re.search(r"\d m\b", steady)
    force, across = third.split(" · ")
    assert number_of(force.partition(" to ")[2]) == pytest.approx(motion[:, 4].max(), rel=2e-3)
    assert force.endswith(" N")
    assert number_of(across.partition("|x| ")[2]) == pytest.approx(
        np.abs(motion[:, 0]).max(), rel=2e-3
    )
    assert number_of(fourth) == pytest.approx(motion[:, 1].max(), rel=5e-3)
    assert fourth.endswith(" m/s")


def test_a_run_with_a_baseline_shows_differences_of_the_same_quantities(
    runs: tuple[Transient, Transient],
) -> None:
    considered, ignored = (own_slider.motion(3.0, separation=case)[1] for case in (True, False))
    differences = {change.label: change for change in changes(*runs)}
    figures: Sequence[tuple[str, str, Callable[[NDArray[np.float64]], Any]]] = (
        ("peak |y|", "m", lambda r: np.abs(r[:, 2]).max()),
        ("peak |x|", "m", lambda r: np.abs(r[:, 0]).max()),
        ("contact force max", "N", lambda r: r[:, 4].max()),
        ("max ẋ", "m/s", lambda r: r[:, 1].max()),
        ("final x", "m", lambda r: r[-1, 0]),
        ("final ẋ", "m/s", lambda r: r[-1, 1]),
        ("final y", "m", lambda r: r[-1, 2]),
        ("final ẏ", "m/s", lambda r: r[-1, 3]),
    )
    for label, unit, of in figures:
        change = differences[label]
        assert change.unit == unit
        assert (change.value, change.baseline) == pytest.approx(
            (float(of(considered)), float(of(ignored))), rel=5e-3
        )
        assert change.difference == change.value - change.baseline
        assert float(percent_text(change)) == pytest.approx(
            100.0 * (change.value - change.baseline) / abs(change.baseline), rel=6e-3
        )
    (half,) = [change for label, change in differences.items() if "half" in label]
    assert half.value == pytest.approx(0.5 * np.ptp(considered[750:, 2]), rel=5e-3)
    row = next(row for row in change_rows(*runs) if row.label == "peak |y|")
    assert number_of(row.value) == pytest.approx(differences["peak |y|"].difference, rel=1e-3)
    assert row.note.startswith("from ")
    assert number_of(row.note) == pytest.approx(differences["peak |y|"].baseline, rel=1e-3)
