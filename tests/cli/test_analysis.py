"""The commands map, attractors, branch and stability, run in this process.

A touch is a cycle that just reaches y = 0, where contact ends; ``--doubled`` follows cycles of
twice the period. Safe μ is the μ below which disturbances of any size die out.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from fivtui.cli import run
from fivtui.orbits import coexistence
from fivtui.scene.presets import PRESETS

from .test_cli import run_fivtui


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["map"], "--over"),
        (["map", "--over=F=1:2:3"], "two different parameters"),
        (["map", "--over=F=1:2:3", "--over=F=1:2:4"], "given twice"),
        (["map", "--over=F=1:2:3", "--over=nu=1:2:4"], "unknown parameter 'nu'"),
        (["map", "--over=F=1:2:3", "--over=mu=1:2"], "START:STOP:COUNT"),
        (["map", "--over=F=1:2:3", "--over=mu=1:200:3"], "must be from 0 to 100"),
        (["map", "--over=F=1:2:3", "--over=mu=1:2:3", "--value=mu"], "unknown map value 'mu'"),
        (["map", "--over=F=1:2:3", "--over=mu=1:2:3", "--out=m.txt"], "suffix of a map file"),
        (["map", "--over=F=1:2:3", "--over=mu=1:2:3", "--plot=m.txt"], "suffix of a figure file"),
        (["attractors", "--vary=F=1:2:1"], "COUNT = 1"),
        (["attractors", "--vary=F=1:2:3", "--start=static"], "without --basin and --start"),
        (["attractors", "--basin=y0=0:1:3"], "--basin: given once; must be given twice"),
        (["attractors", "--basin=y0=0:1:3", "--basin=F=0:1:3"], "unknown parameter 'F'"),
        (["attractors", "--start=1,2"], "start"),
        (["attractors", "--out=a.csv"], "with --vary or --basin"),
        (["attractors", "--vary=F=1:2:3", "--out=a.txt"], "suffix of a attractor file"),
        (["branch"], "--vary"),
        (["branch", "--vary=nu"], "unknown parameter 'nu'"),
        (["branch", "--vary=mu=1"], "must be NAME or NAME=LOW:HIGH"),
        (["branch", "--vary=mu=1:2:3"], "must be NAME or NAME=LOW:HIGH"),
        (["branch", "--vary=mu=1:x"], "must be from 0 to 100"),
        (["branch", "--vary=mu", "--from=file"], "--from file: must be hopf, cycle or a file"),
        (["branch", "--vary=mu", "--out=b.txt"], "suffix of a branch file"),
        (["branch", "--vary=mu", "--over=F"], "--over: must be given with --curve"),
        (["branch", "--curve=torus"], "must be hopf, fold or touch"),
        (["branch", "--curve=fold", "--over=F"], "--over: given once; must be given twice"),
        (["branch", "--curve=fold", "--vary=F"], "--vary: must be given without --curve"),
        (["branch", "--vary=mu", "--from=nothing.csv"], "nothing.csv"),
        (["branch", "--curve=fold", "--doubled"], "--doubled: must be given without --curve"),
        (["branch", "--curve=fold", "--from=hopf"], "--from: must be given without --curve"),
        (["branch", "--curve=fold", "--over=F", "--over=F"], "F is given twice"),
        (["branch", "--vary=mu", f"--from={__file__}"], "the suffix must be one of .csv"),
        (["branch", "--curve=fold", "--over=F", "--over=mu=1"], "must be NAME or NAME=LOW:HIGH"),
    ],
)
def test_wrong_input_is_one_line_and_exit_2(args: list[str], message: str, tmp_path: Path) -> None:
    process = run_fivtui(*args, cwd=tmp_path)
    assert process.returncode == 2
    assert message in process.stderr
    assert len(process.stderr.splitlines()) == 1
    assert process.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_a_slider_without_equilibrium_is_exit_3() -> None:
    process = run_fivtui("attractors", "--set=F=-10", "--set=k3=0")
    assert process.returncode == 3
    assert "no equilibrium" in process.stderr


def test_stability_warns_of_a_limit_cycle_beside_a_stable_equilibrium() -> None:
    process = run_fivtui("stability", "--set=F=120", "--attractors", "--json")
    assert process.returncode == 0
    data = json.loads(process.stdout)
    assert data["stable"] is True
    assert data["coexistence"] is True
    assert data["warning"] in process.stderr
    rest, cycle = data["attractors"]
    assert rest == {"kind": "equilibrium", "half_range": 0.0}
    assert cycle["kind"] == "separating limit cycle"
    assert cycle["half_range"] == pytest.approx(7.44, abs=5e-3)
    assert np.array(cycle["floquet_multipliers"]).shape == (3, 2)
    # The least height, m, from which the slider, released at rest, does not return to equilibrium.
    assert 0.1 < data["escape_offset"]["up"] < 0.3


def test_stability_on_a_belt_of_finite_speed_reports_attractors_of_transients() -> None:
    process = run_fivtui("stability", "--set=v_belt=1", "--json")
    assert process.returncode == 0
    data = json.loads(process.stdout)
    assert data["safe_mu"] is None
    basis = data["safe_mu_basis"]
    # The static start, and releases at rest at ten heights.
    assert "transients from 11 starts at μ = 0.7: a limit cycle attracts" in basis["verdict"]
    assert "not searched on a belt of finite speed" in basis["verdict"]
    assert [attractor["kind"] for attractor in basis["attractors"]] == ["stick-slip limit cycle"]


def test_transients_on_a_belt_of_finite_speed_are_a_result_on_standard_output() -> None:
    process = run_fivtui("stability", "--set=v_belt=1")
    assert "from 11 starts at μ = 0.7: a limit cycle attracts" in process.stdout
    assert "limit cycle" not in process.stderr


def test_a_map_of_the_critical_friction_over_friction_is_refused() -> None:
    process = run_fivtui("map", "--over=F=1:2:3", "--over=mu=0:1:3", "--value=critical-mu")
    assert process.returncode == 2
    assert "critical-mu over mu: must be over two other parameters" in process.stderr


def test_printed_attractors_include_the_escape_offset(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["attractors", "coexistence"]) == 0
    captured = capsys.readouterr()
    assert "1.3241539" in captured.out
    assert "offset above that leaves the equilibrium" in captured.out
    assert captured.err == f"warning: {coexistence(PRESETS['coexistence'].system).warning}\n"


def test_a_branch_without_a_first_orbit_is_exit_3() -> None:
    process = run_fivtui("branch", "--vary=mu=1:2")
    assert (process.returncode, process.stdout) == (3, "")
    assert len(process.stderr.splitlines()) == 1


def test_a_branch_is_drawn_over_a_fold(tmp_path: Path) -> None:
    process = run_fivtui("branch", "--set=F=120", "--vary=mu=0.2:1", "--plot=b.svg", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert "0.2779350934" in process.stdout
