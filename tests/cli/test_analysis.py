"""The commands map, attractors and stability --attractors, run as a process."""

import json
from pathlib import Path

import numpy as np
import pytest

from fivtui.cli import run
from fivtui.orbits import coexistence
from fivtui.scene.presets import PRESETS

from .test_cli import fivtui


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["map"], "--over"),
        (["map", "--over=F=1:2:3"], "two different ones"),
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
def test_wrong_input_is_one_line_and_exit_2(args: list[str], said: str, tmp_path: Path) -> None:
    done = fivtui(*args, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_a_lifted_slider_that_nothing_holds_is_exit_3() -> None:
    done = fivtui("attractors", "--set=F=-10", "--set=k3=0")
    assert done.returncode == 3
    assert "no equilibrium" in done.stderr


def test_stability_warns_of_the_attractor_that_eigenvalues_do_not_see() -> None:
    done = fivtui("stability", "--set=F=120", "--attractors", "--json")
    assert done.returncode == 0
    data = json.loads(done.stdout)
    assert data["stable"] is True
    assert data["coexistence"] is True
    assert data["warning"] in done.stderr
    rest, cycle = data["attractors"]
    assert rest == {"kind": "equilibrium", "half_range": 0.0}
    assert cycle["kind"] == "separating limit cycle"
    assert cycle["half_range"] == pytest.approx(7.44, abs=5e-3)
    assert np.array(cycle["floquet_multipliers"]).shape == (3, 2)
    assert 0.1 < data["escape_offset"]["up"] < 0.3


def test_stability_on_a_belt_of_finite_speed_says_what_transients_reach() -> None:
    done = fivtui("stability", "--set=v_belt=1", "--json")
    assert done.returncode == 0
    data = json.loads(done.stdout)
    assert data["safe_mu"] is None
    basis = data["safe_mu_basis"]
    assert "transients from 11 starts at μ = 0.7: a limit cycle attracts" in basis["verdict"]
    assert "not searched on a belt of finite speed" in basis["verdict"]
    assert [one["kind"] for one in basis["attractors"]] == ["stick-slip limit cycle"]


def test_a_map_of_the_critical_friction_over_friction_is_refused() -> None:
    done = fivtui("map", "--over=F=1:2:3", "--over=mu=0:1:3", "--value=critical-mu")
    assert done.returncode == 2
    assert "critical-mu over mu: must be over two other parameters" in done.stderr


def test_attractors_in_words_show_what_leaves_the_equilibrium(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["attractors", "coexistence"]) == 0
    said = capsys.readouterr()
    assert "1.3241539" in said.out
    assert "above that leaves the equilibrium" in said.out
    assert said.err == f"warning: {coexistence(PRESETS['coexistence'].system).warning}\n"


def test_a_branch_that_does_not_begin_is_exit_3() -> None:
    done = fivtui("branch", "--vary=mu=1:2")
    assert (done.returncode, done.stdout) == (3, "")
    assert len(done.stderr.splitlines()) == 1


def test_a_branch_is_drawn_over_a_fold(tmp_path: Path) -> None:
    done = fivtui("branch", "--set=F=120", "--vary=mu=0.2:1", "--plot=b.svg", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "0.2779350934" in done.stdout
