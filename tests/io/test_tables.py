"""What the program writes is read again: sweeps and their pieces, maps, trade-offs, columns."""

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fivtui.equilibrium.eigenvalues import stability
from fivtui.io.tables import FORMATS, read_columns, read_header
from fivtui.maps import stability_map
from fivtui.maps.files import load_map
from fivtui.model.errors import Cancelled, InputError
from fivtui.model.parameters import Parameters
from fivtui.results.tables import save_result
from fivtui.scene.presets import PRESETS
from fivtui.studies import save_study
from fivtui.sweeps.files import read_sweep, save_sweep
from fivtui.sweeps.provenance import study_from_dict, study_to_dict
from fivtui.sweeps.request import parse_design, study_of
from fivtui.sweeps.run import Sweep, local_engine, sweep_in_memory, sweep_to_file
from fivtui.sweeps.study import Study
from fivtui.tradeoffs import measure as tradeoff
from fivtui.tradeoffs.files import load_tradeoff, save_tradeoff, tradeoff_to_dict
from fivtui.tradeoffs.measure import Tradeoff, measure_tradeoff

BASE = PRESETS["base"]
SHORT = dataclasses.replace(BASE.with_values({"F": 70.0}), t_end=5.0)


def study(*texts: str, kind: str = "product", **more: object) -> Study:
    design = parse_design(texts, kind, **more)  # type: ignore[arg-type]
    return study_of(SHORT, design, cases=(True, False), outputs=("y_abs", "separations", "stable"))


@pytest.fixture(scope="module")
def swept() -> Sweep:
    return sweep_in_memory(study("F=20:80:4"), local_engine(1))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_sweep_written_from_memory_is_the_file_of_the_command_line(
    suffix: str, swept: Sweep, tmp_path: Path
) -> None:
    ours, theirs = tmp_path / f"ours{suffix}", tmp_path / f"theirs{suffix}"
    save_sweep(swept, ours)
    sweep_to_file(swept.study, theirs, local_engine(1), size=3)
    if suffix == ".csv":
        assert ours.read_bytes() == theirs.read_bytes()
    for path in (ours, theirs):
        read = read_sweep(path)
        assert read.study == swept.study
        assert read.rows == swept.rows
    assert sweep_to_file(swept.study, ours, local_engine(1)).failed is None


@pytest.mark.parametrize(
    "design",
    [
        study("F=1:100:5:log", "x0=-1,0.25"),
        study("F=20:80", "mu=0.1:1:log", kind="sobol", count=9, seed=3),
        study("F=20,30", "mu=1,2", kind="list"),
        dataclasses.replace(study("F=20,30"), accuracy=(("peak", 1e-4), ("final", 1e-3))),
        dataclasses.replace(study("y0=-1:0:3"), start=[0.0, 0.5, -0.25, 0.0], cases=(False,)),
    ],
)
def test_a_study_is_read_as_it_was_written(design: Study) -> None:
    assert study_from_dict(json.loads(json.dumps(study_to_dict(design)))) == design


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_the_errors_of_a_sweep_are_read_again(suffix: str, tmp_path: Path) -> None:
    asked = dataclasses.replace(study("F=20,30"), accuracy=(("peak", 1e-4),))
    result = sweep_in_memory(asked, local_engine(1))
    path = tmp_path / f"sweep{suffix}"
    save_sweep(result, path)
    again = read_sweep(path)
    assert again.columns[-3:] == ["peak_error", "status", "reason"]
    assert again.rows == result.rows


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_what_is_stored_of_a_sweep_under_way_is_read_and_left_alone(
    suffix: str, swept: Sweep, tmp_path: Path
) -> None:
    path = tmp_path / f"out{suffix}"
    with pytest.raises(Cancelled):
        sweep_to_file(
            swept.study, path, local_engine(1), size=2, progress=lambda fraction: fraction < 0.5
        )
    folder = path.with_name(f"{path.name}.parts")
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    read = read_sweep(folder)
    assert read.study == swept.study
    assert read.rows == swept.rows[: len(read.rows)]
    assert 0 < len(read.rows) < len(swept.rows)
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    with pytest.raises(InputError, match="are computed, not all"):
        save_sweep(read, tmp_path / f"part{suffix}")
    with pytest.raises(InputError, match="not the folder of a sweep"):
        read_sweep(tmp_path)


@pytest.mark.parametrize("value", ["growth-rate", "critical-mu", "unstable-modes"])
def test_a_map_is_read_as_it_was_written(value: str, tmp_path: Path) -> None:
    over = {"F": np.linspace(-5.0, 100.0, 7), "k_nl": np.geomspace(1.0, 500.0, 5)}
    written = stability_map(Parameters(c1=0.4), over, value)
    paths = [tmp_path / f"map{suffix}" for suffix in FORMATS]
    for path in paths:
        save_result(written, path)
    paths.append(tmp_path / "map.json")
    paths[-1].write_text(json.dumps(written.to_dict()))
    for path in paths:
        read = load_map(path)
        assert (read.names, read.value, read.separation) == (("F", "k_nl"), value, True)
        assert read.parameters.c1 == 0.4
        np.testing.assert_array_equal(read.values, written.values)
        np.testing.assert_array_equal(read.excess, written.excess)
        for axis, other in zip(read.axes, written.axes, strict=True):
            np.testing.assert_array_equal(axis, other)


@pytest.fixture(scope="module")
def measured() -> Tradeoff:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tradeoff, "QUICK_S", 0.3)
        return measure_tradeoff(dataclasses.replace(SHORT, start=[0.0, 0.0, -0.5, 0.0]))


def test_a_trade_off_is_read_as_it_was_written(measured: Tradeoff, tmp_path: Path) -> None:
    save_tradeoff(measured, tmp_path / "t.csv")
    (tmp_path / "t.json").write_text(json.dumps(tradeoff_to_dict(measured)))
    for path in (tmp_path / "t.csv", tmp_path / "t.json"):
        read = load_tradeoff(path)
        assert read.scene == dataclasses.replace(measured.scene, name="t", description="")
        assert read.floor.final == measured.floor.final
        assert read.rows == measured.rows
        assert read.features == measured.features
        assert tradeoff_to_dict(read) == tradeoff_to_dict(measured)


def test_the_modes_over_mu_are_columns_with_what_they_are_of(tmp_path: Path) -> None:
    p = Parameters(F=60.0)
    found = stability(p)
    scan = found.modes_over_mu()
    for suffix in FORMATS:
        path = tmp_path / f"modes{suffix}"
        save_study("stability", found, path)
        columns = read_columns(path, "table of modes")
        said = read_header(path, "table of modes")
        assert list(columns)[:3] == ["mu", "sigma_1", "omega_1"]
        assert len(columns) == 9
        np.testing.assert_array_equal(columns["omega_4"], scan.eigenvalues[:, 3].imag)
        assert said["parameters"] == p.as_dict()
        assert said["critical_mu"] == pytest.approx([c.mu for c in found.critical_mu])
        growing = columns["mu"][np.argmax(columns["sigma_1"] > 0.0)]
        assert math.isclose(growing, found.critical_mu[0].mu, abs_tol=columns["mu"][1])


@pytest.mark.parametrize("read", [read_sweep, load_map, load_tradeoff])
@pytest.mark.parametrize("suffix", [".csv", ".json", ".parquet", ".npz", ".txt"])
@pytest.mark.parametrize(
    "content", [b"", b"[1]", b"# a: [\nx\n", b"\xff\xfe", b"a,b,c\n1,2,3\n", b"PAR1"]
)
def test_what_is_no_such_file_is_refused(
    read: Callable[[Path], object], suffix: str, content: bytes, tmp_path: Path
) -> None:
    path = tmp_path / f"other{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(caught.value).count("other") == 1
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError):
        read(tmp_path / f"missing{suffix}")
