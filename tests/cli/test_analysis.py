"""The commands map, attractors and stability --attractors, run as a process."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from fivtui import Parameters, stability
from fivtui.cli import run
from fivtui.orbits import coexistence
from fivtui.scene.presets import PRESETS

from .test_cli import fivtui


def rows_of(path: Path) -> list[dict[str, str]]:
    lines = path.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def test_a_map_is_printed_as_one_object() -> None:
    done = fivtui("map", "--over=F=20:100:3", "--over=mu=0:1:2", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    data = json.loads(done.stdout)
    assert set(data) == {"parameters", "separation", "over", "value", "unit", "values"}
    assert data["values"][1][1] == pytest.approx(
        stability(Parameters(F=60.0, mu=1.0)).growth_rate, abs=1e-9
    )


def test_a_map_is_written_and_drawn(tmp_path: Path) -> None:
    done = fivtui(
        "map", "linear", "--over", "k1=50:150:3", "--over", "k2=10:1000:5:log",
        "--value", "critical-mu", "--out", "m.csv", "--plot", "m.png", cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "wrote m.csv" in done.stderr
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")
    rows = rows_of(tmp_path / "m.csv")
    assert len(rows) == 15
    p = Parameters(k_nl=0.0, k1=100.0, k2=100.0)
    row = next(r for r in rows if r["k1"] == "100.0" and abs(float(r["k2"]) - 100.0) < 1e-9)
    assert float(row["critical_mu"]) == pytest.approx(stability(p).critical_mu[0].mu)


@pytest.mark.parametrize("name", ["m.npz", "m.parquet"])
def test_a_map_is_written_in_the_format_of_its_suffix(name: str, tmp_path: Path) -> None:
    done = fivtui("map", "--over=F=-1:1:2", "--over=k3=0:60:3", "--out", name, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    if name.endswith(".npz"):
        values = np.load(tmp_path / name, allow_pickle=False)["growth_rate"]
    else:
        import pyarrow.parquet as pq

        values = pq.read_table(tmp_path / name)["growth_rate"].to_numpy()
    assert np.isnan(values).tolist() == [True, False, False, False, False, False]


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


def test_stability_in_words_shows_modes_and_margins() -> None:
    done = fivtui("stability")
    assert done.returncode == 0
    assert "0.918633 Hz" in done.stdout
    assert "-0.260612" in done.stdout
    assert (
        "stable to small disturbances below μ = 0.4394; to all disturbances found below μ = 0.2779"
        in done.stdout
    )
    assert done.stderr == ""


def test_stability_without_the_search_has_eigenvalues_alone() -> None:
    done = fivtui("stability", "--no-search", "--json")
    assert "safe_mu" not in json.loads(done.stdout)


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


def test_what_a_start_reaches() -> None:
    done = fivtui("attractors", "coexistence", "--start=0.29,0,-0.7,0", "--json")
    assert json.loads(done.stdout) == {"kind": "equilibrium", "half_range": 0.0}


def test_a_branch_is_printed_written_and_drawn(tmp_path: Path) -> None:
    line = ("branch", "--set=F=120", "--vary=mu=0.2:1", "--out=b.csv", "--plot=b.svg")
    done = fivtui(*line, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["parameter"] == "mu"
    keys = {"value", "period", "y_min", "y_max", "stable", "multipliers"}
    assert all(keys <= set(point) for point in data["points"])
    assert [event["kind"] for event in data["events"]] == ["hopf", "touch", "fold"]
    assert data["events"][2]["value"] == pytest.approx(0.277935093, abs=1e-8)
    rows = rows_of(tmp_path / "b.csv")
    assert [float(row["mu"]) for row in rows] == [point["value"] for point in data["points"]]
    assert (tmp_path / "b.svg").read_text(encoding="utf-8").count("<svg") == 1
    again = fivtui("branch", "--set=F=120", "--vary=mu=0.2:1", "--from=b.csv", cwd=tmp_path)
    assert "0.2779350934" in again.stdout
    told = fivtui(*line[:3])
    assert "hopf, subcritical" in told.stdout
    assert "0.2779350934" in told.stdout
    assert told.stderr == ""


def test_a_curve_of_folds_is_printed_written_and_drawn(tmp_path: Path) -> None:
    line = ("branch", "--set=F=30", "--curve=fold", "--over=F=28:40", "--over=mu=0.2:0.6")
    done = fivtui(*line, "--out=b.csv", "--plot=b.svg", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (curve,) = json.loads(done.stdout)["curves"]
    assert [event["kind"] for event in curve["events"]] == ["cusp"]
    rows = rows_of(tmp_path / "b.csv")
    assert [float(row["F"]) for row in rows] == [point["values"][0] for point in curve["points"]]
    assert (tmp_path / "b.svg").read_text(encoding="utf-8").count("<svg") == 1
    told = fivtui(*line)
    assert "36.5101643" in told.stdout


def test_a_branch_that_does_not_begin_is_exit_3() -> None:
    done = fivtui("branch", "--vary=mu=1:2")
    assert (done.returncode, done.stdout) == (3, "")
    assert len(done.stderr.splitlines()) == 1


def test_branches_are_written_and_drawn(tmp_path: Path) -> None:
    done = fivtui(
        "attractors", "--vary=mu=0.2:0.5:4", "--out=b.csv", "--plot=b.svg", "--json", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["coexisting"] == pytest.approx([0.3, 0.4])
    rows = rows_of(tmp_path / "b.csv")
    assert len(rows) == len(data["points"]) == 6
    assert [row["kind"] for row in rows] == ["0", "0", "2", "0", "2", "2"]
    assert "coexistence" in (tmp_path / "b.svg").read_text(encoding="utf-8")


def test_basins_are_written_and_drawn(tmp_path: Path) -> None:
    done = fivtui(
        "attractors", "coexistence", "--basin=y0=-0.9:-0.6:4", "--basin=vy0=0:2:2",
        "--out=b.npz", "--plot=b.pdf", cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "of 8 starts" in done.stdout
    with np.load(tmp_path / "b.npz", allow_pickle=False) as data:
        assert data["attractor"].shape == (8,)
        assert {"equilibrium"} < {str(text).partition(",")[0] for text in data["attractors"]}
    assert (tmp_path / "b.pdf").read_bytes().startswith(b"%PDF")
