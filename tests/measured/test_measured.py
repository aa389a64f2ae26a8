"""Measured data: read from files of any kind, shifted, compared, drawn, on the command line."""

import dataclasses
import itertools
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui.charts.figure_style import save_figure
from fivtui.cli import run as command
from fivtui.io import read_columns, read_header
from fivtui.measured.comparison import validate
from fivtui.measured.reading import Measurement, read_measurement
from fivtui.measured.tolerances import Tolerance, Tolerances, read_tolerance
from fivtui.model import InputError, Parameters
from fivtui.simulation import simulate

# The run that is compared with signals made of itself.
RUN = simulate(t_end=40.0, samples="dense")


def signal(
    start: float = 20.0, length: float = 10.0, count: int = 1001
) -> tuple[np.ndarray, np.ndarray]:
    """Times from 0 and y of the run from `start`."""
    t = np.linspace(0.0, length, count)
    assert RUN.solution is not None
    return t, RUN.solution(t + start).y


def measurement(t: np.ndarray, values: np.ndarray) -> Measurement:
    return Measurement("test.csv", "t", "y", t, values)


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("t,y\n0,1\n0.5,-2\n1,3\n", {}),
        ("0,1\n0.5,-2\n1,3\n", {}),
        ("# rig 7\nScope 3000\nt;u;y\n0;9;1\n0,5;9;-2,0\n1;9;3\n", {"signal": "y"}),
        ("t\ty\n0\t1\n0.5\t-2\n1\t3\n", {"time": "1", "signal": "2"}),
        (
            '"t (ms)","y (mm)","note"\n0,1000,a\n500,-2000,b\n1000,3000,c\n',
            {"signal": "y (mm)", "scale": 1e-3, "time_scale": 1e-3},
        ),
        ("y,t\n11,0\n8,0.5\n13,1\n", {"time": "t", "signal": "y", "offset": -10.0}),
        ("t,x,vx,y\n0,9,8,1\n0.5,9,8,-2\n1,9,8,3\n", {"quantity": "y"}),
        ("Y_mm,Time (s)\n1,0\n-2,0.5\n3,1\n", {"quantity": "y"}),
        # No column is named t or x: the first one has the times, the second one the signal.
        ("y,s\n0,1\n0.5,-2\n1,3\n", {"quantity": "x"}),
        ("u,t\n1,0\n-2,0.5\n3,1\n", {"quantity": "y"}),
    ],
)  # fmt: skip
def test_columns_are_read_whatever_program_wrote_them(
    text: str, options: dict[str, float], tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="latin-1")
    columns = read_measurement(path, **options)  # type: ignore[arg-type]
    assert columns.t == pytest.approx([0.0, 0.5, 1.0])
    assert columns.values == pytest.approx([1.0, -2.0, 3.0])


@pytest.mark.parametrize(
    ("text", "options", "refusal"),
    [
        ("", {}, "two columns of numbers"),
        ("a b\nc d\n", {}, "two columns of numbers"),
        ("t,y\n0,1\n1,x\n", {}, "line 3: y = 'x' is not a number"),
        ("t,\n0,1\n1,\n", {}, "line 3: column 2 = '' is not a number"),
        ("t,y\n0,1\n1\n", {}, "line 3: 1 values under 2 columns"),
        ("t,y\n0,1\n0,2\n", {}, "t: must be ascending times"),
        ("t,y\n0,1\n1,2\n", {"signal": "z"}, "signal column"),
        ("t,y\n0,1\n1,2\n", {"signal": "3"}, "signal column"),
        ("t,y\n0,1\n1,2\n", {"scale": 0.0}, "must be a number other than 0"),
        ("t,y\n0,1\n1,2\n", {"time_scale": -1.0}, "must be above 0"),
    ],
)
def test_invalid_measurements_are_refused(
    text: str, options: dict[str, float], refusal: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=refusal):
        read_measurement(path, **options)  # type: ignore[arg-type]


def test_the_run_itself_agrees_and_its_shift_is_found() -> None:
    t, y = signal()
    result = validate(
        RUN,
        measurement(t, 2.0 * y + 5.0),
        shift="auto",
        tolerances=Tolerances(Tolerance(0.01, relative=True), frequency=0.01, amplitude=0.1),
    )
    assert result.shift == pytest.approx(20.0, abs=1e-6)
    assert result.correlation == pytest.approx(1.0)
    measured_spectrum, computed_spectrum = result.spectra
    assert measured_spectrum.fundamental == pytest.approx(computed_spectrum.fundamental)
    # At twice the amplitude only the frequency agrees.
    assert [criterion.passed for criterion in result.criteria] == [False, True, False]
    assert result.passed is False
    repeated = validate(RUN, measurement(t + 20.0, y), tolerances=Tolerances(Tolerance(1e-6)))
    assert repeated.greatest < 1e-9
    assert repeated.passed is True
    assert validate(RUN, measurement(t, y)).passed is None


@pytest.mark.parametrize(
    ("signal", "quantity", "warned"),
    [
        ("x", "y", True),
        ("vy (m/s)", "y", True),
        ("t", "y", True),
        ("p", "y", True),
        ("y", "y", False),
        ("Y_mm", "y", False),
        ("P (N)", "P", False),
        ("displacement", "y", False),
        ("column 2", "y", False),
    ],
)
def test_a_column_named_like_another_quantity_has_a_warning(
    signal: str, quantity: str, warned: bool
) -> None:
    t = np.linspace(0.0, 5.0, 51)
    result = validate(RUN, Measurement("a.csv", "t", signal, t, np.sin(t)), quantity=quantity)
    message = f"column {signal!r} of the measured data is compared with {quantity}"
    assert result.warning == (message if warned else "")
    assert ("measured", f"{signal} in a.csv") in result._summary()


def test_a_trajectory_is_compared_with_the_column_of_its_quantity(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(tmp_path / "run.csv")
    command(["simulate", "base", "--t-end", "10", "--out", path])
    for options, warned in (
        ([], False),
        (["--quantity", "vx"], False),
        (["--signal", "x"], True),
    ):
        capsys.readouterr()
        command(["validate", "base", "--t-end", "10", "--measured", path, "--json", *options])
        out, err = capsys.readouterr()
        assert (json.loads(out)["deviation"]["rms"] > 1e-9) is warned
        assert ("warning: column 'x' of the measured data is compared with y" in err) is warned


def test_the_band_is_absolute_or_relative_and_a_share_may_be_outside() -> None:
    t, y = signal()
    # Every tenth sample deviates.
    disturbed = y + np.where(np.arange(t.size) % 10 == 0, 0.5, 0.0)
    shifted = measurement(t + 20.0, disturbed)
    for band, least_share, passed in (
        (Tolerance(0.4), 1.0, False),
        (Tolerance(0.4), 0.85, True),
        (Tolerance(0.6), 1.0, True),
        (Tolerance(0.01, relative=True), 0.95, False),
    ):
        result = validate(RUN, shifted, tolerances=Tolerances(band, least_share))
        assert result.passed is passed
        share_within = result.criteria[0].found
        assert share_within == pytest.approx(1.0 if band.value == 0.6 else 0.9, abs=1e-3)
    # A relative band is a share of half peak-to-peak.
    assert result.band == pytest.approx(0.01 * 0.5 * np.ptp(y))
    assert result.rms == pytest.approx(0.5 * np.sqrt(101 / 1001))


def test_quantities_that_a_run_lacks_cannot_be_compared() -> None:
    t, y = signal()
    with pytest.raises(InputError, match="0 samples are within the run"):
        validate(RUN, measurement(t + 100.0, y))
    with pytest.raises(InputError, match="must fit into the run"):
        validate(RUN, measurement(10.0 * t, y), shift="auto")
    with pytest.raises(InputError, match="quantity"):
        validate(RUN, measurement(t, y), quantity="z")
    nothing: Any = None
    with pytest.raises(InputError, match="run = None: must be a Transient"):
        validate(nothing, nothing)
    with pytest.raises(InputError, match="measurement = None: must be a Measurement"):
        validate(RUN, nothing)
    with pytest.raises(InputError, match="shift = nan"):
        validate(RUN, measurement(t, y), shift=float("nan"))
    # Without motion both frequencies are 0, so that they agree.
    rest = simulate(Parameters(mu=0.0), t_end=20.0, samples=3)
    still = validate(rest, measurement(t, np.zeros_like(t)), tolerances=Tolerances(frequency=0.1))
    assert still.passed is True


def test_a_tolerance_is_a_number_or_a_percentage() -> None:
    assert read_tolerance("--band", "0.2") == Tolerance(0.2)
    assert read_tolerance("--band", "5%") == Tolerance(0.05, relative=True)
    for text in ("0", "-1%", "x", "%", "nan"):
        with pytest.raises(InputError, match="--band"):
            read_tolerance("--band", text)


def test_tolerances_are_given_as_on_the_command_line_or_as_numbers() -> None:
    assert Tolerances(band="5%").band == Tolerance(0.05, relative=True)
    assert Tolerances(band="0.05") == Tolerances(band=0.05) == Tolerances(Tolerance(0.05))
    assert Tolerances(frequency="2%", amplitude="10%") == Tolerances(frequency=0.02, amplitude=0.1)
    assert Tolerances(band=1, share="90%").share == 0.9
    refused: list[tuple[dict[str, Any], str]] = [
        ({"band": "x"}, "band = 'x': not a number; must be a number above 0, or a percentage"),
        ({"band": -1.0}, "band = -1: must be a number above 0, or a percentage"),
        ({"band": {"value": 0.1}}, "band = {'value': 0.1}: not a number"),
        ({"frequency": "2"}, "frequency = 2: must be a percentage such as '5%', or a fraction"),
        ({"amplitude": 0.0}, "amplitude = 0: must be a percentage"),
        ({"band": 1.0, "share": 2.0}, "share = 2.0: must be at most 100%"),
        ({"share": 0.9}, "share: must be given with band"),
    ]
    for values, refusal in refused:
        with pytest.raises(InputError, match=re.escape(refusal)):
            Tolerances(**values)
    t, y = signal()
    limits: Any = {"band": "5%"}
    with pytest.raises(InputError, match=r"tolerances = .*must be, say, Tolerances"):
        validate(RUN, measurement(t + 20.0, y), tolerances=limits)


def test_without_tolerances_the_rows_say_that_there_is_no_verdict() -> None:
    t, y = signal()
    result = validate(RUN, measurement(t + 20.0, y))
    assert result.passed is None
    assert "verdict" in repr(result)
    assert "none: give --band, --frequency or --amplitude" in repr(result)


def test_measured_and_computed_signals_are_drawn_with_the_band() -> None:
    t, y = signal()
    result = validate(RUN, measurement(t + 20.0, y), tolerances=Tolerances(Tolerance(0.3)))
    over_time, deviations, lines = result.figure().axes
    computed, measured = over_time.lines
    measured_values, computed_values = (
        np.asarray(line.get_ydata(), dtype=float) for line in (measured, computed)
    )
    np.testing.assert_allclose(measured_values, computed_values, atol=1e-9)
    corners = over_time.patches[0].get_path().vertices
    assert np.ptp(np.asarray(corners)[:, 1]) == pytest.approx(np.ptp(y) + 0.6)
    assert deviations.get_ylim()[1] >= 0.3
    assert lines.get_yscale() == "log"


def test_the_title_of_a_figure_is_the_name_of_the_column_as_it_is(tmp_path: Path) -> None:
    t, y = signal()
    raw = r"$\no{math$ \[here]"
    named = dataclasses.replace(measurement(t, y), signal=raw)
    figure = validate(RUN, named, tolerances=Tolerances(Tolerance(0.3))).figure()
    save_figure(figure, tmp_path / "both.png")
    assert figure.axes[0].get_title() == "FAIL: " + raw.replace("$", r"\$")


def test_the_figure_plots_measured_minus_computed() -> None:
    t, y = signal()
    offset = np.linspace(0.1, 0.3, t.size)
    result = validate(RUN, measurement(t + 20.0, y + offset))
    over_time, difference, _ = result.figure().axes
    assert "measured" in difference.get_ylabel().split("−")[0]
    assert "computed" in difference.get_ylabel().split("−")[1]
    plotted = np.asarray(difference.lines[0].get_ydata(), dtype=float)
    np.testing.assert_allclose(plotted, offset, atol=1e-9)
    signals = {line.get_label(): np.asarray(line.get_ydata()) for line in over_time.lines}
    np.testing.assert_allclose(signals["measured"] - signals["computed"], offset, atol=1e-9)
    assert over_time.get_xlim() == pytest.approx((20.0, 30.0))


def test_the_command_passes_or_fails_and_writes_both_signals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    t, y = signal()
    np.savetxt("rig.csv", np.column_stack([1e3 * t, 1e3 * y]), delimiter=";", header="t;y")
    options = {"--measured": "rig.csv", "--scale": "1e-3", "--time-scale": "1e-3"}
    options |= {"--t-end": "40", "--shift": "auto"}

    def validate_with(*arguments: str) -> int:
        # Run the command; an argument replaces an option of the same name.
        remaining = {name: text for name, text in options.items() if name not in arguments}
        return command(["validate", *itertools.chain(*remaining.items()), *arguments])

    assert validate_with("--band", "2%", "--frequency", "1%", "--out", "a.csv") == 0
    report = capsys.readouterr().out
    assert "verdict" in report
    assert "PASS" in report
    columns = read_columns(tmp_path / "a.csv", "validation")
    np.testing.assert_allclose(columns["measured"], columns["computed"], atol=1e-6)
    assert read_header(tmp_path / "a.csv", "validation")["validation"]["passed"] is True
    assert validate_with("--set", "F=60", "--amplitude", "1%", "--json") == 1
    printed = capsys.readouterr()
    data = json.loads(printed.out)
    assert printed.err == ""
    assert data["passed"] is False
    assert data["criteria"][0]["name"] == "deviation of amplitude"
    for wrong, message in (
        (["--band", "0"], "must be above 0"),
        (["--share", "90%"], "must be given with --band"),
        (["--band", "2%", "--share", "101%"], "--share 101%: must be at most 100%"),
        (["--frequency", "0.1"], "must be a percentage"),
        (["--shift", "x"], "must be a time in s, or auto"),
        (["--scale", "x"], "--scale"),
        (["--quantity", "z"], "quantity"),
    ):
        assert validate_with(*wrong) == 2
        assert message in capsys.readouterr().err
    assert validate_with("--band", "2%", "--share", "100%") == 0
    assert command(["validate"]) == 2
    assert "must be given" in capsys.readouterr().err


def test_a_missing_file_is_named_once(tmp_path: Path) -> None:
    path = tmp_path / "none.csv"
    with pytest.raises(InputError) as refused:
        read_measurement(path)
    assert str(refused.value) == f"{path}: there is no such file"
