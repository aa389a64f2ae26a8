"""Messages seen by a script that drives the FMU through fmpy alone, without debug logging."""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import fmpy
import pytest

from fivtui.fmu.run import run_fmu
from fivtui.model.errors import ComputationError
from tests.support.fmu_tools import simulate_interpreted

# With k_nl < 0 a parameter is out of range. A preload F < 0 pulls the slider off the belt; without
# the coupling stiffness k3 nothing holds it there, so there is no equilibrium.
SCRIPT = """
import json, sys
import fmpy

def run(**options):
    print("--", file=sys.stderr, flush=True)
    table = fmpy.simulate_fmu(folder, output_interval=0.1, **options)
    return {name: table[name].tolist() for name in table.dtype.names}

def resident():
    status = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))

def refuse(steps):
    for step in steps:
        try:
            instance.doStep(*step)
        except Exception as error:
            assert error.status == 2
        else:
            raise AssertionError(step)

folder = fmpy.extract(sys.argv[1])
runs = [
    run(stop_time=1.0, start_values={"k_nl": -1.0}),
    run(stop_time=1.0, start_values={"F": -1.0, "k3": 0.0}),
    run(stop_time=20.0, relative_tolerance=0.0),
    run(stop_time=20.0, relative_tolerance=1.0),
]
# Steps that are refused: of negative size, and from a time that the FMU has not reached.
backward_steps = [(0.0, -1.0)] * 5000
later_steps = [(1.0 + k, 0.1) for k in range(5000)]
print("--", file=sys.stderr, flush=True)
instance = fmpy.instantiate_fmu(folder, fmpy.read_model_description(folder))
instance.setupExperiment(startTime=0.0)
instance.enterInitializationMode()
instance.exitInitializationMode()
grown = []
for steps in (backward_steps, later_steps):
    refuse(steps[:2000])
    before = resident()
    refuse(steps[2000:])
    grown.append(resident() - before)
instance.doStep(0.0, 1.0)
print(json.dumps([runs, grown]))
"""


@pytest.fixture(scope="module")
def script_output(
    fmu: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Any, list[list[str]]]:
    """Results of the script, and its standard error for each run."""
    process = subprocess.run(
        [sys.executable, "-I", "-c", SCRIPT, str(fmu)],
        cwd=tmp_path_factory.mktemp("elsewhere"),
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    _, *parts = process.stderr.split("--\n")
    return json.loads(process.stdout), [part.splitlines() for part in parts]


@pytest.mark.parametrize(
    ("run_index", "reason", "prefixes"),
    # k_nl is refused when it is set, then by the initialization because of that refusal. Only the
    # initialization finds that there is no equilibrium.
    [
        (0, "k_nl = -1: must be from 0", ["", "not initialized: ", "the step is refused: "]),
        (1, "no equilibrium: F = -1 N", ["", "the step is refused: "]),
    ],
)
def test_a_refused_start_is_printed_and_its_outputs_are_nan(
    script_output: tuple[Any, list[list[str]]], run_index: int, reason: str, prefixes: list[str]
) -> None:
    (runs, _), errors = script_output
    # fmpy samples the start, and again the time at which the refused first step ends the run.
    assert runs[run_index].pop("time") == [0.0, 0.0]
    # An integer cannot be NaN.
    assert runs[run_index].pop("mode_enumeration") == [0, 0]
    assert all(math.isnan(value) for column in runs[run_index].values() for value in column)
    for line, prefix in zip(errors[run_index], prefixes, strict=True):
        assert line.startswith(f"SliderBelt: {prefix}{reason}")


@pytest.mark.parametrize(("run_index", "requested", "used"), [(2, "0", 1e-13), (3, "1", 1e-2)])
def test_a_tolerance_out_of_range_is_the_nearest_possible_and_printed(
    script_output: tuple[Any, list[list[str]]], run_index: int, requested: str, used: float
) -> None:
    (runs, _), errors = script_output
    assert errors[run_index] == [
        f"SliderBelt: tolerance = {requested}: must be from 1e-13 to 0.01, {used:g} is used"
    ]
    # The Python FMU has the interpreted kernel.
    assert runs[run_index]["y"][-1] == simulate_interpreted(t_end=20.0, tol=used).final.y
    assert runs[run_index]["y"][-1] != simulate_interpreted(t_end=20.0).final.y


def test_thousands_of_refused_steps_take_no_memory_and_log_few_lines(
    script_output: tuple[Any, list[list[str]]],
) -> None:
    (_, memory_growth), errors = script_output
    # A leak of 100 bytes for each step would be 300 kB.
    assert max(memory_growth) < 200
    # The FMU prints 20 messages, then that it prints no more.
    assert len(errors[4]) == 20 + 1
    assert "step size = -1.0" in errors[4][0]
    assert "enable the FMU's debug logging" in errors[4][-1]


def test_a_run_of_the_project_reports_a_refusal_only_in_its_error(
    fmu: Path, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(ComputationError, match="no equilibrium"):
        run_fmu(fmu, t_end=1.0, start_values={"F": -1.0, "k3": 0.0})
    assert caplog.record_tuples == []
    assert capfd.readouterr() == ("", "")
    # Messages of other instances in the process still appear. Here pytest handles their log
    # records; in the script nothing does, and so Python prints them to standard error.
    fmpy.simulate_fmu(str(fmu), stop_time=1.0, start_values={"k_nl": -1.0})
    assert "k_nl = -1" in caplog.text
    assert {record[0] for record in caplog.record_tuples} == {"fivtui.fmu"}
