"""The registry of studies: files of every study, and adding a study by one entry.

The laboratory is the terminal interface, which stores its results when it is closed.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from fivtui.cli.deliver import Outputs
from fivtui.io import output_path
from fivtui.io.tables import read_columns, read_header, write_table
from fivtui.model.columns import Column
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.results import (
    Result,
    Storage,
    StudyKind,
    command_for,
    equal_values,
    list_printer,
)
from fivtui.scene.presets import PRESETS
from fivtui.studies import (
    STUDIES,
    build_command,
    check_study_path,
    kind_of,
    load_study,
    restore_study,
    save_study,
    store_study,
    studies,
    study,
)
from fivtui.tui.persistence.results import ResultStore
from fivtui.tui.session.command_lines import study_command
from fivtui.tui.session.editing import Editing
from fivtui.tui.session.session import DisplayedStudy
from fivtui.tui.tabs.export import DATA, FIGURE, study_export

from .test_results import RESULTS, TABULAR, result_named


@dataclass(frozen=True, repr=False)
class Bounce(Result):
    """A small study: heights of bounces."""

    parameters: Parameters
    separation: bool
    heights: tuple[float, ...]

    def _summary(self) -> list[tuple[str, str]]:
        return [("greatest height", f"{max(self.heights):g} m")]

    def to_dict(self) -> dict[str, Any]:
        return {"heights": list(self.heights)}

    def figure(self) -> Figure:
        figure = Figure()
        figure.subplots().plot(self.heights)
        return figure


def save_bounce(result: Bounce, path: Path) -> None:
    header = {"bounce_of": result.parameters.as_dict(), "separation": result.separation}
    heights = {"height": np.array(result.heights)}
    write_table(path, "bounce", [Column("height", "m", "of a bounce")], heights, header)


def load_bounce(path: Path) -> Bounce:
    header = read_header(path, "bounce")
    heights = tuple(read_columns(path, "bounce")["height"].tolist())
    return Bounce(Parameters(**header["bounce_of"]), header["separation"], heights)


BOUNCE = StudyKind(
    contents_name="bounce",
    show=list_printer("Bounce"),
    warning=lambda result: "high" if max(result.heights) > 1.0 else None,
    suffixes=(".csv", ".npz", ".parquet"),
    save=save_bounce,
    as_json=True,
    stem=lambda _: "bounce",
    load=load_bounce,
    header_keys=frozenset({"bounce_of"}),
    command=lambda result: command_for("bounce", result),
    storage=Storage(".npz"),
)
BOUNCE_RESULT = Bounce(Parameters(F=60.0), True, (0.5, 0.25, 1.0 / 3.0))


@pytest.fixture
def bounce(monkeypatch: pytest.MonkeyPatch) -> None:
    package = ModuleType("bounces")
    package.BOUNCE = BOUNCE  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "bounces", package)
    # The only registration that a study needs.
    monkeypatch.setitem(STUDIES, "bounce", "bounces:BOUNCE")


@pytest.mark.usefixtures("bounce")
@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_a_new_study_is_written_recognised_and_read(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"b{suffix}"
    save_study("bounce", BOUNCE_RESULT, path)
    assert kind_of(path) == "bounce"
    assert load_study("bounce", path) == BOUNCE_RESULT


@pytest.mark.usefixtures("bounce")
def test_a_new_study_is_written_drawn_and_printed_by_a_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, plot = tmp_path / "b.csv", tmp_path / "b.svg"
    outputs = Outputs(out, plot)
    outputs.check("bounce")
    outputs.write("bounce", BOUNCE_RESULT)
    assert load_bounce(out) == BOUNCE_RESULT
    assert "<svg" in plot.read_text()
    with pytest.raises(InputError, match="exists already"):
        outputs.check("bounce")
    with pytest.raises(InputError, match="the suffix of a bounce file"):
        Outputs(tmp_path / "b.xls").check("bounce")
    capsys.readouterr()
    Outputs(as_json=True).show("bounce", BOUNCE_RESULT)
    assert json.loads(capsys.readouterr().out) == {"heights": list(BOUNCE_RESULT.heights)}
    Outputs().show("bounce", BOUNCE_RESULT)
    assert "greatest height  0.5 m" in capsys.readouterr().out


@pytest.mark.usefixtures("bounce")
def test_a_new_study_is_exported_stored_and_shown_by_the_laboratory(tmp_path: Path) -> None:
    data = study_export(DATA, "bounce", BOUNCE_RESULT, "mine-bounce")
    assert (data.file_name, data.subject) == ("mine-bounce.csv", "the bounce")
    assert tuple(data.writers) == (".csv", ".npz", ".parquet", ".json")
    for suffix in data.writers:
        data.write(tmp_path / f"b{suffix}")
    assert json.loads((tmp_path / "b.json").read_text()) == BOUNCE_RESULT.to_dict()
    figure = study_export(FIGURE, "bounce", BOUNCE_RESULT, "mine-bounce")
    figure.write(tmp_path / "b.png")
    assert (tmp_path / "b.png").is_file()
    store = ResultStore(tmp_path / "kept")
    files, notes = store.save({"bounce": DisplayedStudy(BOUNCE_RESULT, "mine", "here")})
    assert notes == {}
    reread = ResultStore(tmp_path / "kept").read(files)[0]["bounce"]
    assert (reread.value, reread.name, reread.source) == (BOUNCE_RESULT, "mine", "here")
    store.remove_unused({})
    assert list((tmp_path / "kept").iterdir()) == []
    # The base scene has no name on the command line.
    line = study_command("bounce", BOUNCE_RESULT, Editing(PRESETS["base"], ""))
    assert line == "fivtui bounce --set F=60"


def test_every_study_declares_its_files_and_reads_stored_ones() -> None:
    for name, kind in studies():
        assert kind.contents_name, name
        assert callable(kind.show)
        # `stem` is part of the name of an exported file; files of runs have the number of the run.
        if kind.suffixes and name != "run":
            assert kind.stem is not str, name
    stored_only = {name for name, kind in studies() if kind.storage is not None and not kind.load}
    # Files of claims, statements of the paper with verdicts, are not opened: they are recomputed.
    # The file of a fit is the fitted scene.
    assert stored_only == {"claims", "identification"}
    names = [name for name, kind in studies() if kind.header_keys]
    # The header of a map has the fewest keys, so other kinds must be recognised before it.
    assert names[-1] == "map"


def test_studies_without_reader_or_command_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="stress tests cannot be read"):
        load_study("extremes", tmp_path / "a.csv")
    with pytest.raises(InputError, match="no command"):
        build_command("attractor", None)


# Files of every study

WRITTEN = [
    (name, suffix)
    for name, (kind, _) in RESULTS.items()
    if kind
    for suffix in (*study(kind).suffixes, *([".json"] if study(kind).as_json else []))
    # A fitted scene is not a table.
    if suffix != ".toml"
]
READABLE = [name for name, kind in studies() if kind.load is not None]
STORED = [name for name, (kind, _) in RESULTS.items() if kind and study(kind).storage is not None]


@pytest.mark.parametrize(("name", "suffix"), WRITTEN)
def test_a_result_is_written_twice_with_the_same_bytes_and_with_its_columns(
    name: str, suffix: str, tmp_path: Path
) -> None:
    kind, result = RESULTS[name][0], result_named(name)
    path = tmp_path / f"result{suffix}"
    if suffix in study(kind).suffixes:
        check_study_path(kind, path)
    save_study(kind, result, path)
    content = path.read_bytes()
    with pytest.raises(InputError, match="exists already"):
        save_study(kind, result, path)
    save_study(kind, result, output_path(path, force=True))
    assert path.read_bytes() == content
    if suffix == ".json":
        assert json.loads(content) == json.loads(json.dumps(study(kind).to_dict(result)))
        return
    assert {*read_header(path, kind)} & {"fivtui", "fivtui_sweep"}
    # Files of stability hold the modes of vibration over the friction coefficient.
    table = result.modes_over_mu() if kind == "stability" else result
    for column, values in table.to_columns().items():
        if values.dtype.kind in "biuf":
            # `missing` allows cells that are empty, true or false.
            (stored,) = read_columns(path, kind, [column], missing=True).values()
            np.testing.assert_array_equal(stored.astype(float), values.astype(float))


@pytest.mark.parametrize(("name", "suffix"), WRITTEN)
def test_a_file_is_recognised_and_read_or_refused_with_the_reason(
    name: str, suffix: str, tmp_path: Path
) -> None:
    kind, result = RESULTS[name][0], result_named(name)
    entry, path = study(kind), tmp_path / f"result{suffix}"
    save_study(kind, result, path)
    if entry.load is None or (suffix == ".json" and entry.json_refusal):
        # Without a specific refusal the message lists the kinds that can be read.
        with pytest.raises(InputError, match=entry.json_refusal or "not a run, uncertainty"):
            kind_of(path)
        return
    assert kind_of(path) == kind
    if kind == "branch" and suffix != ".json":
        with pytest.raises(InputError, match="from JSON alone"):
            load_study(kind, path)
        return
    loaded = load_study(kind, path)
    assert type(loaded) is type(result)
    assert equal_values(loaded.to_columns(), result.to_columns())
    if kind != "run":
        # A trajectory file lacks some entries of a run, such as peaks, which are then from samples.
        assert loaded.to_dict() == result.to_dict()
    if kind == "map":
        # The zero of the excess is the stability boundary.
        assert equal_values(loaded.excess, result.excess)


@pytest.mark.parametrize("name", STORED)
def test_results_stored_by_the_laboratory_are_restored_completely(
    name: str, tmp_path: Path
) -> None:
    kind, result = RESULTS[name][0], result_named(name)
    storage = study(kind).storage
    assert storage is not None
    assert storage.reason_not_to_store(result) == ""
    path = tmp_path / f"result{storage.suffix}"
    store_study(kind, result, path)
    restored = restore_study(kind, path)
    assert restored.to_dict() == result.to_dict()
    assert equal_values(restored.to_columns(), result.to_columns())
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(InputError, match=f"{path}: "):
        restore_study(kind, path)


@pytest.mark.parametrize("kind", READABLE)
@pytest.mark.parametrize("suffix", [".csv", ".json", ".parquet", ".npz", ".txt"])
@pytest.mark.parametrize(
    "content", [b"", b"[1]", b"# a: [\nx\n", b"\xff\xfe", b"a,b,c\n1,2,3\n", b"PAR1"]
)
def test_wrong_and_missing_files_are_refused(
    kind: str, suffix: str, content: bytes, tmp_path: Path
) -> None:
    path = tmp_path / f"other{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_study(kind, path)
    assert str(caught.value).count("other") == 1
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError):
        load_study(kind, tmp_path / f"missing{suffix}")


@pytest.mark.parametrize("name", TABULAR)
def test_datasets_have_the_columns_with_their_units(name: str) -> None:
    result = result_named(name)
    pytest.importorskip("xarray")
    dataset, table = result.to_xarray(), result._table()
    assert list(dataset.variables) == list(dataset.data_vars) + list(dataset.coords)
    for column, values in table.items():
        assert dataset[column.name].attrs == {"units": column.unit, "long_name": column.meaning}
        if column.name not in dataset.coords:
            np.testing.assert_array_equal(dataset[column.name].values.ravel(), values)
    assert dataset.attrs == result._header()


def test_a_dataset_of_a_grid_has_two_dimensions() -> None:
    result = result_named("map")
    dataset = result.to_xarray()
    assert dataset["critical_mu"].dims == ("F", "k_nl")
    np.testing.assert_array_equal(dataset["critical_mu"].values, result.values)
    np.testing.assert_array_equal(dataset["F"].values, result.axes[0])


def test_without_xarray_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fivtui.results.tables.find_spec", lambda _name: None)
    with pytest.raises(InputError, match=r"install fivtui\[xarray\]"):
        result_named("map").to_xarray()
