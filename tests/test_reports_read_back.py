"""Printed and written reports: their numbers agree with independent equations.

Equations are numbered as in the paper *Nonlinear friction-induced vibration of a slider-belt
system*. `tests/net` compares the whole text of reports with recorded text.
"""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui.equilibrium.eigenvalues import stability
from fivtui.equilibrium.report import print_stability
from fivtui.maps import stability_map
from fivtui.model.parameters import Parameters
from fivtui.results.tables import save_result
from fivtui.scene.presets import PRESETS
from fivtui.scene.report import print_run
from fivtui.scene.run import SceneTransient, Verified
from fivtui.simulation import simulate
from fivtui.studies import save_study, study
from fivtui.sweeps.report import print_sweep, progress_text
from fivtui.sweeps.study import DEFAULT_OUTPUTS
from fivtui.tradeoffs.files import tradeoff_to_dict
from fivtui.tradeoffs.measure import Feature, Tradeoff
from fivtui.tradeoffs.report import print_tradeoff
from fivtui.tradeoffs.settings import MeasuredSetting, Setting
from fivtui.transient.errors import Deviation
from fivtui.transient.result import Transient

from .support import paper_model
from .test_figures_read_back import invented_sweep, output_value

Printed = pytest.CaptureFixture[str]


def printed_text(printed: Printed) -> str:
    """Printed text without trailing blanks."""
    return re.sub(r" +$", "", printed.readouterr().out, flags=re.MULTILINE)


def read_list(printed: Printed) -> list[tuple[str, str]]:
    """Rows of a list: name and text."""
    lines = printed.readouterr().out.splitlines()
    rows = [re.split(r"\s{2,}", line.strip(), maxsplit=1) for line in lines]
    return [(row[0], row[1]) for row in rows if len(row) == 2]


def read_table(text: str) -> list[dict[str, str]]:
    """Rows of a table by column names; all columns but the first are right-aligned."""
    header, *lines = [line.rstrip() for line in text.splitlines()]
    cell = re.compile(r"\S+(?: \S+)*")
    names_by_end = {match.end(): match[0] for match in cell.finditer(header)}
    rows = []
    for line in lines:
        row = dict.fromkeys(names_by_end.values(), "")
        for index, match in enumerate(cell.finditer(line)):
            # Only the first column is left-aligned: its cells may end anywhere.
            ends = [end for end in names_by_end if index == 0 or match.end() <= end]
            name = names_by_end[ends[0]]
            row[name] = f"{row[name]} {match[0]}".strip()
        rows.append(row)
    return rows


def numbers(text: str) -> list[float]:
    return [
        float(literal) for literal in re.findall(r"(?<![\w.])[-+]?\d+\.?\d*(?:e[-+]?\d+)?", text)
    ]


# The equilibrium


def test_printed_numbers_of_stability_agree_with_independent_equations(capsys: Printed) -> None:
    p = Parameters(F=100.0, k_nl=500.0, mu=1.1, c1=0.8)
    changes = {"F": 100.0, "k_nl": 500.0, "mu": 1.1, "c1": 0.8}
    print_stability(stability(p))
    rows = read_list(capsys)
    values = dict(rows)
    base = paper_model.BASE
    x, y, force = paper_model.equilibrium(**changes)
    assert values["equilibrium x"] == f"{x:.6g} m  Eq. 6 of the paper"
    assert values["equilibrium y"] == f"{y:.6g} m  negative: contact is compressed"
    assert values["contact force"] == f"{force:.6g} N  in contact"
    eigenvalues = paper_model.eigenvalues(**changes).tolist()
    rate = max(value.real for value in eigenvalues)
    halving = f"amplitude halves every {np.log(2.0) / -rate:.4g} s"
    assert values["growth rate"] == f"{rate:+.6g} 1/s  {halving}"
    assert values["verdict"] == "STABLE  small disturbances die out"
    assert values["parameters"].split()[0:2] == ["m=5", "k1=100"]
    assert values["parameters"].endswith("F=100  k_nl=500  mu=1.1")
    shown = [text for name, text in rows if name.startswith("eigenvalue ")]
    assert len(shown) == 2
    for text in shown:
        real, imaginary = re.fullmatch(r"(\S+) ± (\S+)i 1/s", text).groups()  # type: ignore[union-attr]
        assert (
            min(abs(value - complex(float(real), float(imaginary))) for value in eigenvalues) < 1e-4
        )
    modes = [text for name, text in rows if name.startswith("mode ")]
    assert len(modes) == 2
    for text in modes:
        match = re.fullmatch(r"(\S+) Hz  damping ratio (\S+), y/x (\S+), (\S+)°", text)
        assert match is not None
        hertz, damping, ratio, degrees = map(float, match.groups())
        angular = 2.0 * np.pi * hertz
        value = min(eigenvalues, key=lambda eigenvalue: abs(eigenvalue.imag - angular))
        assert value.imag == pytest.approx(angular, rel=1e-5)
        assert damping == pytest.approx(-value.real / abs(value), rel=1e-3)
        # y/x by the vertical equation of motion, (m λ² + c2 λ + k_t + h) y = h x, with h = k3/2.
        m, c2, k2, h = base["m"], base["c2"], base["k2"], base["k3"] / 2.0
        tangent_stiffness = k2 + 3.0 * changes["k_nl"] * y * y
        shape = h / ((m * value + c2) * value + tangent_stiffness + h)
        assert ratio == pytest.approx(abs(shape), rel=1e-3)
        assert degrees == pytest.approx(np.degrees(np.angle(shape)), abs=0.02)
    critical = paper_model.critical_mu(
        **{name: value for name, value in changes.items() if name != "mu"}
    )
    linear = paper_model.critical_mu(F=100.0, c1=0.8, k_nl=0.0)
    percent_below = 100.0 * (1.0 - 1.1 / critical)
    margin = f"μ {percent_below:.3g} % below, margin {critical - 1.1:+.6g}"
    assert values["critical μ"] == f"{critical:.6g} (unstable above)  {margin}"
    assert numbers(values["critical μ, linear"])[0] == pytest.approx(linear, rel=1e-5)
    # The friction at which undamped modes coalesce, by bisection of eigenvalues.
    undamped = {name: value for name, value in changes.items() if name != "mu"} | {
        "c1": 0.0,
        "c2": 0.0,
    }
    low, high = 0.0, 4.0
    for _ in range(40):
        middle = (low + high) / 2.0
        flutters = paper_model.growth_rate(**undamped, mu=middle) > 1e-5
        low, high = (low, middle) if flutters else (middle, high)
    distance, coalescence_mu = values["frequency distance"].split(
        "  undamped, the modes coalesce at μ "
    )
    assert float(coalescence_mu) == pytest.approx(high, rel=1e-4)
    frequencies = sorted(value.imag for value in eigenvalues if value.imag > 0.0)
    assert distance.endswith(" Hz")
    assert numbers(distance)[0] == pytest.approx(
        (frequencies[1] - frequencies[0]) / 2 / np.pi, rel=1e-2
    )


def test_stability_as_data_has_frequencies_in_hertz_and_in_radians() -> None:
    data = stability(Parameters()).to_dict()
    eigenvalues = paper_model.eigenvalues().tolist()
    for pair in data["eigenvalues"]:
        assert min(abs(complex(*pair) - value) for value in eigenvalues) < 1e-6
    for mode in data["modes"]:
        assert mode["angular_frequency"] == pytest.approx(2.0 * np.pi * mode["frequency"])
        value = complex(mode["growth_rate"], mode["angular_frequency"])
        assert min(abs(value - eigenvalue) for eigenvalue in eigenvalues) < 1e-6
    x, y, force = paper_model.equilibrium()
    assert data["equilibrium"] == pytest.approx({"x": x, "y": y, "P": force})
    assert data["linear_critical_mu"] == pytest.approx(paper_model.critical_mu(k_nl=0.0))


def read_csv(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray[Any, Any]]]:
    """Comments and columns of a CSV file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    comments = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    names = lines[len(comments)].split(",")
    columns = np.loadtxt(lines[len(comments) + 1 :], delimiter=",").T
    header = {key: json.loads(text) for key, _, text in comments}
    return header, dict(zip(names, columns, strict=True))


def test_written_modes_and_maps_have_every_number_in_its_column(tmp_path: Path) -> None:
    p = Parameters()
    save_study("stability", stability(p), tmp_path / "modes.csv")
    header, columns = read_csv(tmp_path / "modes.csv")
    # The first, a middle and the last of 241 friction coefficients.
    for index in (0, 100, 240):
        eigenvalues = paper_model.eigenvalues(mu=float(columns["mu"][index]))
        for number in "1234":
            value = columns[f"sigma_{number}"][index] + 1j * columns[f"omega_{number}"][index]
            assert np.abs(eigenvalues - value).min() < 1e-6
    assert {header["units"][f"sigma_{n}"] for n in "1234"} == {"1/s"}
    assert {header["units"][f"omega_{n}"] for n in "1234"} == {"rad/s"}
    assert header["critical_mu"] == [pytest.approx(paper_model.critical_mu())]
    over = {"F": np.array([20.0, 50.0, 90.0]), "mu": np.array([0.2, 0.9])}
    result = stability_map(p, over)
    save_result(result, tmp_path / "map.csv")
    header, columns = read_csv(tmp_path / "map.csv")
    assert [header["units"][name] for name in ("F", "growth_rate")] == ["N", "1/s"]
    for force, mu, rate in zip(*(columns[n] for n in ("F", "mu", "growth_rate")), strict=True):
        assert rate == pytest.approx(paper_model.growth_rate(F=force, mu=mu), abs=1e-7)
    data = result.to_dict()
    assert [(axis["name"], axis["unit"]) for axis in data["over"]] == [("F", "N"), ("mu", "")]
    assert data["values"][2][0] == pytest.approx(paper_model.growth_rate(F=90.0, mu=0.2), abs=1e-7)
    assert data["unit"] == "1/s"


def test_a_printed_map_has_ranges_and_the_unstable_share(capsys: Printed) -> None:
    forces, frictions = np.linspace(20.0, 100.0, 5), np.linspace(0.1, 1.0, 4)
    study("map").show(stability_map(Parameters(), {"F": forces, "mu": frictions}))
    rows = dict(read_list(capsys))
    rates = np.array(
        [[paper_model.growth_rate(F=force, mu=mu) for mu in frictions] for force in forces]
    )
    assert rows["F"] == "20 to 100 N, 5"
    assert rows["mu"] == "0.1 to 1, 4"
    assert rows["points"] == "20"
    low, high = numbers(rows["growth rate"])[:2]
    assert (low, high) == pytest.approx((rates.min(), rates.max()), rel=1e-5)
    assert rows["growth rate"].endswith(" 1/s")
    assert rows["unstable"] == f"{float(np.mean(rates > 0.0)):.1%} of the points"
    assert rows["points without value"] == "0"


# Transients


@pytest.fixture(scope="module")
def run() -> Transient:
    return simulate(t_end=3.0, tol=1e-9)


def test_printed_numbers_of_a_transient_agree_with_independent_equations(
    run: Transient, capsys: Printed
) -> None:
    estimate = Deviation(final=1e-3, peak=2e-4, half_range=3e-5, events=4e-6, separations=0)
    # A run without error targets, with the estimates of three runs.
    print_run(SceneTransient(run, Verified(run, targets={}, estimate=estimate, runs=3)))
    rows = dict(read_list(capsys))
    t, motion = paper_model.motion(3.0, separation=True)
    x, vx, y, _, force = motion.T
    peak = rows["peak |y|"]
    assert numbers(peak)[0] == pytest.approx(np.abs(y).max(), rel=3e-3)
    assert peak.endswith(" m  ± 0.0002 relative")
    assert numbers(rows["range of y"])[:2] == pytest.approx([y.min(), y.max()], rel=3e-3)
    assert numbers(rows["peak |x|"]) == [pytest.approx(np.abs(x).max(), rel=3e-3)]
    assert rows["peak |x|"].endswith(" m")
    (half,) = [text for name, text in rows.items() if "half" in name]
    assert numbers(half)[0] == pytest.approx(0.5 * np.ptp(y[t >= 1.5]), rel=3e-3)
    assert "over the second half of the run, ± 3e-05 relative; not settled: " in half
    assert numbers(rows["contact force"]) == pytest.approx([0.0, force.max()], rel=3e-3, abs=1e-9)
    assert rows["contact force"].endswith(" N")
    switches = np.diff((y > 0.0).astype(int))
    separation_count, reattachment_count = int((switches > 0).sum()), int((switches < 0).sum())
    assert rows["separations"] == f"{separation_count}  ± 4e-06 s in their times"
    assert rows["reattachments"] == str(reattachment_count)
    separated_share = float(np.mean(y > 0.0))
    time, share = numbers(rows["time off the belt"])
    assert time == pytest.approx(3.0 * separated_share, rel=3e-2)
    assert share == pytest.approx(100.0 * separated_share, abs=0.1)
    assert re.fullmatch(r"\S+ s  \S+% of the run", rows["time off the belt"])
    assert numbers(rows["max ẋ"]) == [pytest.approx(vx.max(), rel=3e-3)]
    # Without `v_belt` the model holds for belts that are always faster than the slider.
    assert rows["max ẋ"].endswith(" m/s  valid for faster belts")
    final = [rows[f"final {name}"].split() for name in ("x", "ẋ", "y", "ẏ")]
    assert [float(text[0]) for text in final] == pytest.approx(motion[-1, :4].tolist(), rel=5e-3)
    assert [text[1] for text in final] == ["m", "m/s", "m", "m/s"]
    assert rows["final x"].endswith(" m  ± 0.001 relative, t = 3 s")
    assert rows["separation"] == "considered"
    assert rows["method"] == "taylor  verified by 3 runs"
    assert rows["steps"] == str(run.stats.steps)


# Sweeps


def test_only_the_ends_and_some_outputs_of_a_long_sweep_are_printed(capsys: Printed) -> None:
    is_separation_considered = True
    cases = (is_separation_considered,)
    result = invented_sweep({"F": tuple(range(1, 101))}, DEFAULT_OUTPUTS, cases)
    print_sweep(result)
    printed = capsys.readouterr()
    rows = read_table(printed.out.partition("\n")[2])
    assert [float(row["F (N)"]) for row in rows] == [*range(1, 21), *range(81, 101)]
    assert "P_max (N)" not in rows[0]
    output_index = DEFAULT_OUTPUTS.index("y_abs")
    expected = output_value(output_index, is_separation_considered, 100.0)
    assert float(rows[-1]["y_abs (m)"]) == pytest.approx(expected)
    assert "first and last 20" in printed.err


def test_the_progress_of_a_sweep_counts_members_rate_and_time_left() -> None:
    assert progress_text(200, 0.25, 0.0, 0.0) == "50 of 200 members (25.0%)"
    # 40 members in 8 s are 5 per second; 150 remain.
    assert progress_text(200, 0.25, 0.2, 8.0) == "50 of 200 members (25.0%), 5/s, 30 s left"
    assert progress_text(10**5, 0.5, 0.5, 1e4).endswith("5/s, 2.8 h left")
    assert progress_text(10**6, 0.5, 0.5, 1e5).endswith("5/s, 1.2 d left")
    assert progress_text(3000, 0.5, 0.5, 300.0).endswith("5/s, 5.0 min left")


# Trade-offs


def test_a_printed_trade_off_has_milliseconds_and_every_error_in_its_column(
    capsys: Printed,
) -> None:
    rows = [
        MeasuredSetting(
            Setting("taylor", "", "step", 0.01),
            0.02,
            17,
            Deviation(1e-6, 2e-7, 3e-8, float("inf"), separations=2),
        ),
        MeasuredSetting(
            Setting("rk4", "", "step", 0.01),
            0.3,
            17,
            Deviation(5e-4, 6e-5, 7e-6, 8e-3, separations=2),
        ),
        MeasuredSetting(Setting("lost", "", "step", 1.0), 0.5, 7, None, "gave up"),
    ]
    floor = Deviation(1e-13, 2e-14, 3e-15, 4e-12, separations=0)
    features = [
        Feature("events", without_s=0.001, with_s=0.004, without_steps=10, with_steps=12),
        Feature("rest", without_s=None, with_s=0.004, without_steps=None, with_steps=12),
    ]
    targets = {"peak": 1e-4}
    result = Tradeoff(
        PRESETS["base"], reference=None, floor=floor, rows=rows, features=features, targets=targets
    )
    print_tradeoff(result)
    parts = re.split(r"\n(?=Cost of features|Cheapest)", printed_text(capsys))
    title, table = parts[0].split("\n", 1)
    assert title == "Trade-off: base, 100 s"
    shown = read_table(table.partition("\n\n")[0].partition("\nbest for")[0])
    first, second = shown[0], shown[1]
    for line, source in ((first, rows[0]), (second, rows[1])):
        assert (line["method"], line["setting"]) == (source.setting.label, "step=0.01")
        assert float(line["CPU ms"]) == 1e3 * source.cpu_s
        assert (line["steps"], line["separations"]) == ("17", "+2")
        assert source.error is not None
        assert float(line["final state"]) == source.error.final
        assert float(line["peak |y|"]) == source.error.peak
        (half,) = [value for key, value in line.items() if "half" in key]
        assert float(half) == source.error.half_range
    assert (first["events s"], second["events s"]) == ("missed", "8.0e-03")
    # Final state, peak and half range; events.
    assert (first["best for"], second["best for"]) == ("FPH", "E")
    assert "final 1e-13, peak 2e-14" in parts[0]
    assert "events 4e-12" in parts[0]
    costs = read_table(parts[1][parts[1].index("feature ") :].rstrip())
    assert (costs[0]["without"], costs[0]["with"], costs[0]["ratio"]) == ("1.000", "4.000", "4.00")
    assert costs[1]["with"] == "4.000"
    assert "peak to 0.0001" in parts[2]
    assert "taylor, step=0.01: error 2.0e-07, 20 ms" in parts[2]
    data = tradeoff_to_dict(result)
    assert data["rows"][0]["error_events"] is None
    assert data["rows"][1]["error_events"] == 8e-3
    assert [entry["cpu_s"] for entry in data["rows"]] == [0.02, 0.3, 0.5]
    assert data["rows"][1]["pareto"] == ["events"]
    assert [entry["failure"] for entry in data["rows"]] == [None, None, "gave up"]
    assert [entry["error_final"] for entry in data["rows"]] == [1e-6, 5e-4, None]
    assert [entry["error_half_range"] for entry in data["rows"]] == [3e-8, 7e-6, None]
    assert data["floor"] == {"final": 1e-13, "peak": 2e-14, "half_range": 3e-15, "events": 4e-12}
    assert data["features"][0]["with_s"] == 0.004
