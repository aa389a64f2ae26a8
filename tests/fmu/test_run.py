"""Runs of any FMU: requests are checked first; a run gives complete results or an error."""

import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui import Parameters
from fivtui.fmu.run import run_fmu, save_fmu_events, save_fmu_run
from fivtui.model.errors import Cancelled, ComputationError, InputError
from tests.support.fmu_tools import build_accumulator, modified_copy, simulate_interpreted


@pytest.fixture
def table(tmp_path: Path) -> Path:
    return tmp_path / "inputs.csv"


def test_start_values_may_be_text_and_a_run_has_the_units_of_its_columns(fmu: Path) -> None:
    run = run_fmu(fmu, t_end=5.0, start_values={"F": "60", "separation": "false", "k1": 90})
    final = simulate_interpreted(Parameters(F=60.0, k1=90.0), t_end=5.0, separation=False).final
    assert run.columns["y"][-1] == final.y
    assert run.columns["time"].size == 501
    assert (run.units["y"], run.units["P"], run.units["time"]) == ("m", "N", "s")
    assert (run.model, run.fmi_version) == ("SliderBelt", "2.0")


def test_outputs_and_output_interval_can_be_chosen(fmu: Path) -> None:
    run = run_fmu(fmu, t_end=1.0, output_interval=0.25, outputs=["P", "mode_integer"])
    assert list(run.columns) == ["time", "P", "mode_integer"]
    assert run.columns["time"].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_inputs_from_a_table_jump_at_repeated_times(fmu: Path, table: Path) -> None:
    table.write_text("# preload\ntime, F\n0, 80\n2, 80\n2, 120\n5, 120\n")
    run = run_fmu(fmu, t_end=5.0, input_csv=table, output_interval=0.5)
    before_jump = simulate_interpreted(t_end=2.0).final
    after_jump = simulate_interpreted(
        Parameters(F=120.0),
        t_end=3.0,
        start=(before_jump.x, before_jump.vx, before_jump.y, before_jump.vy),
    ).final
    assert run.columns["y"][-1] == pytest.approx(after_jump.y, rel=1e-10)


def test_inputs_that_the_table_leaves_out_keep_their_start_value(
    fmu: Path, table: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    table.write_text("time,F\n0,80\n")
    run = run_fmu(fmu, t_end=3.0, input_csv=table, start_values={"mu": 0.9})
    final = simulate_interpreted(Parameters(mu=0.9), t_end=3.0).final
    assert run.columns["y"][-1] == final.y
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,G\n0,1\n", "unknown input"),
        ("t,F\n0,1\n", "unknown input"),
        ("F\n1\n", "there is no column time"),
        ("time,F\n1,80\n0,80\n", "the times must ascend"),
        ("time,F\n0,eighty\n", "line 2: F = 'eighty' is not a number"),
        ("time,F\n0,nan\n", "not a finite number"),
        ("time,F\n0\n", "line 2: 1 values under 2 columns"),
        ("time,F\n", "at least one row"),
        ("", "at least one row"),
        ("time,F\n0,1e12\n", "F = 1e+12: must be from"),
    ],
)
def test_an_invalid_table_of_inputs_is_refused(
    fmu: Path, table: Path, text: str, message: str
) -> None:
    table.write_text(text)
    with pytest.raises(InputError, match=re.escape(message)):
        run_fmu(fmu, t_end=1.0, input_csv=table)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start_values": {"Mu": 0.5}}, "did you mean mu?"),
        ({"start_values": {"y": 0.5}}, "unknown variable to be set 'y'"),
        ({"start_values": {"mu": -0.5}}, "mu = -0.5: must be from 0 to 100"),
        ({"start_values": {"mu": "high"}}, "mu = 'high': not a number"),
        ({"start_values": {"separation": "perhaps"}}, "must be true or false"),
        ({"start_values": {"m": 0.0}}, "m = 0: must be from 1e-12 to 1e+09 kg"),
        ({"tol": 0.5}, "tolerance = 0.5: must be from 1e-13 to 0.01"),
        ({"tol": "tight"}, "tolerance = 'tight': not a number"),
        ({"outputs": ["p"]}, "did you mean P?"),
        ({"t_end": 0.0}, "t_end = 0"),
        ({"t_end": float("nan")}, "t_end = nan"),
        ({"output_interval": 0.0}, "output interval = 0"),
        ({"t_end": 10.0, "output_interval": 20.0}, "output interval = 20"),
        ({"t_end": 1e9, "output_interval": 1e-3}, "at most 20000000 intervals"),
        ({"input_csv": Path("absent.csv")}, "absent.csv: there is no such file"),
    ],
)
def test_an_invalid_request_is_refused(fmu: Path, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        run_fmu(fmu, **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start_values": {"F": -1.0, "k3": 0.0}}, "no equilibrium"),
        (
            {
                "t_end": 1e5,
                "output_interval": 100.0,
                "start_values": {"k2": 186.0, "k_nl": 0.0, "mu": 3.0, "separation": False},
            },
            "the motion grows beyond the floating-point range",
        ),
    ],
)
def test_an_error_contains_the_message_of_the_fmu(
    fmu: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ComputationError, match=re.escape(message)):
        run_fmu(fmu, **options)


def test_an_fmu_of_another_model_runs_with_inputs_of_all_types(tmp_path: Path, table: Path) -> None:
    table.write_text("time,rate,on\n0,1,1\n1,1,0\n2,1,1\n3,1,1\n")
    run = run_fmu(
        build_accumulator(tmp_path),
        t_end=3.0,
        output_interval=0.5,
        start_values={"gain": "3"},
        input_csv=table,
    )
    # The gain 3 times a rate of 1/s, for the 2 s in which the input is on.
    assert run.columns["total"][-1] == pytest.approx(6.0)
    # The accumulator counts its communication steps of 0.5 s.
    assert run.columns["count"][-1] == 6


@pytest.mark.parametrize(
    ("behaviour", "message"),
    [
        ("return False", "the FMU stops at t = 0 s: it logged no reason"),
        ("raise ValueError('broken inside')", "broken inside"),
        ("self.total = float('inf')", "the FMU's variable total is not finite"),
    ],
)
def test_an_fmu_that_fails_raises_an_error(tmp_path: Path, behaviour: str, message: str) -> None:
    with pytest.raises(ComputationError, match=re.escape(message)):
        run_fmu(build_accumulator(tmp_path, behaviour), t_end=3.0)


def test_fmus_of_fmi_1_or_for_model_exchange_only_are_refused(fmu: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        xml = archive.read("modelDescription.xml")
    for old, new, message in (
        (b'fmiVersion="2.0"', b'fmiVersion="1.0"', "FMU"),
        (b"CoSimulation", b"ModelExchange", "is not for co-simulation"),
        (b"<fmiModelDescription", b"<nonsense", "is not an FMU"),
    ):
        changed_members = {"modelDescription.xml": xml.replace(old, new)}
        with pytest.raises(InputError, match=message):
            run_fmu(modified_copy(fmu, tmp_path / "m.fmu", changed_members))


def test_a_run_reports_progress_and_can_be_cancelled(fmu: Path) -> None:
    fractions: list[float] = []

    def store_fraction(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    run_fmu(fmu, t_end=10.0, progress=store_fraction)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert len(fractions) > 3
    with pytest.raises(Cancelled):
        run_fmu(fmu, t_end=10.0, progress=lambda fraction: fraction < 0.5)


def test_events_are_changes_of_discrete_outputs(fmu: Path, tmp_path: Path) -> None:
    run = run_fmu(fmu, t_end=8.0)
    native = simulate_interpreted(t_end=8.0)
    events = run.events()
    assert [t for t, _, _ in events] == sorted(t for t, _, _ in events)
    switches = [(t, value) for t, name, value in events if name == "last_event"]
    assert [value for _, value in switches] == native.switch_times.tolist()
    # An event appears at the next output, at most one interval of 0.01 s later.
    assert all(0.0 <= t - value < 0.01 + 1e-9 for t, value in switches)
    assert [value for _, name, value in events if name == "mode"][:2] == [0.0, 1.0]
    save_fmu_events(run, tmp_path / "events.csv")
    lines = (tmp_path / "events.csv").read_text().splitlines()
    assert lines[0] == "time,name,value"
    assert len(lines) == 1 + len(events)
    t, name, value = lines[1].split(",")
    assert (float(t), name, float(value)) == events[0]
    assert any(name == "mode" for _, name, _ in events)
    only_y = run_fmu(fmu, t_end=8.0, outputs=["y"])
    assert list(only_y.columns) == ["time", "y"]
    assert only_y.events() == events


def test_a_saved_run_reads_back_exactly(fmu: Path, tmp_path: Path) -> None:
    run = run_fmu(fmu, t_end=1.0)
    path = tmp_path / "run.csv"
    save_fmu_run(run, path)
    lines = path.read_text().splitlines()
    table_lines = [line for line in lines if not line.startswith("#")]
    assert table_lines[0].split(",") == list(run.columns)
    saved_values = np.array([[float(text) for text in line.split(",")] for line in table_lines[1:]])
    assert np.array_equal(saved_values, np.array(list(run.columns.values())).T)
    assert '"P": "N"' in path.read_text()
    with pytest.raises(InputError, match="exists"):
        save_fmu_run(run, path)
    with pytest.raises(InputError, match="suffix"):
        save_fmu_run(run, tmp_path / "run.txt")
