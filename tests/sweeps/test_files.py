"""Sweeps are written and read back: complete ones, and the stored pieces of an unfinished one."""

import dataclasses
import json
from pathlib import Path

import pytest

from fivtui.model.errors import Cancelled, InputError
from fivtui.scene.presets import PRESETS
from fivtui.sweeps import parse_design, scene_study
from fivtui.sweeps.files import read_sweep, save_sweep
from fivtui.sweeps.provenance import study_from_dict, study_to_dict
from fivtui.sweeps.run import Sweep, local_engine, sweep_in_memory, sweep_to_file
from fivtui.sweeps.study import Study

BASE = PRESETS["base"]
SHORT = dataclasses.replace(BASE.with_values({"F": 70.0}), t_end=5.0)


def make_study(*texts: str, kind: str = "product", **settings: object) -> Study:
    design = parse_design(texts, kind, **settings)  # type: ignore[arg-type]
    # Cases with separation considered and ignored.
    return scene_study(
        SHORT, design, cases=(True, False), outputs=("y_abs", "separations", "stable")
    )


@pytest.fixture(scope="module")
def computed() -> Sweep:
    return sweep_in_memory(make_study("F=20:80:4"), local_engine(1))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_sweep_written_from_memory_is_the_file_of_the_command_line(
    suffix: str, computed: Sweep, tmp_path: Path
) -> None:
    saved, written = tmp_path / f"saved{suffix}", tmp_path / f"written{suffix}"
    save_sweep(computed, saved)
    sweep_to_file(computed.study, written, local_engine(1), size=3)
    if suffix == ".csv":
        assert saved.read_bytes() == written.read_bytes()
    for path in (saved, written):
        read = read_sweep(path)
        assert read.study == computed.study
        assert read.rows == computed.rows
    # The saved file counts as complete: nothing is computed, and no failed members are counted.
    assert sweep_to_file(computed.study, saved, local_engine(1)).failed is None


@pytest.mark.parametrize(
    "study",
    [
        make_study("F=1:100:5:log", "x0=-1,0.25"),
        make_study("F=20:80", "mu=0.1:1:log", kind="sobol", count=9, seed=3),
        make_study("F=20,30", "mu=1,2", kind="list"),
        dataclasses.replace(make_study("F=20,30"), accuracy=(("peak", 1e-4), ("final", 1e-3))),
        dataclasses.replace(make_study("y0=-1:0:3"), start=[0.0, 0.5, -0.25, 0.0], cases=(False,)),
    ],
)
def test_a_study_is_read_as_it_was_written(study: Study) -> None:
    assert study_from_dict(json.loads(json.dumps(study_to_dict(study)))) == study


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_the_errors_of_a_sweep_are_read_back(suffix: str, tmp_path: Path) -> None:
    with_errors = dataclasses.replace(make_study("F=20,30"), accuracy=(("peak", 1e-4),))
    result = sweep_in_memory(with_errors, local_engine(1))
    path = tmp_path / f"sweep{suffix}"
    save_sweep(result, path)
    reread = read_sweep(path)
    assert reread.columns[-3:] == ["peak_error", "status", "reason"]
    assert reread.rows == result.rows


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_pieces_of_a_running_sweep_are_read_and_not_changed(
    suffix: str, computed: Sweep, tmp_path: Path
) -> None:
    path = tmp_path / f"out{suffix}"
    with pytest.raises(Cancelled):
        sweep_to_file(
            computed.study, path, local_engine(1), size=2, progress=lambda fraction: fraction < 0.5
        )
    folder = path.with_name(f"{path.name}.parts")
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    read = read_sweep(folder)
    assert read.study == computed.study
    assert read.rows == computed.rows[: len(read.rows)]
    assert 0 < len(read.rows) < len(computed.rows)
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    with pytest.raises(InputError, match="are computed, not all"):
        save_sweep(read, tmp_path / f"part{suffix}")
    with pytest.raises(InputError, match="not the folder of an incomplete sweep"):
        read_sweep(tmp_path)
