"""The registry of studies: what is in it, and that one entry more is one study more everywhere."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from fivtui.cli.deliver import check_outputs, show, write
from fivtui.console.printing import print_list
from fivtui.io.tables import read_columns, read_header, write_table
from fivtui.model.columns import Column
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.results import Command, Result, Stored, StudyKind, scene_fields
from fivtui.scene.presets import PRESETS
from fivtui.studies import STUDIES, command_of, kind_of, load_study, save_study, studies, study
from fivtui.tui.persistence.results import ResultStore
from fivtui.tui.session.command_lines import Origin, study_line
from fivtui.tui.session.studies import DisplayedStudy
from fivtui.tui.tabs.exports.export import DATA, FIGURE, scene_study_export, write_export


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


def save(result: Bounce, path: Path, *, force: bool = False) -> None:
    header = {"bounce_of": result.parameters.as_dict(), "separation": result.separation}
    heights = {"height": np.array(result.heights)}
    write_table(
        path, "bounce", [Column("height", "m", "of a bounce")], heights, header, force=force
    )


def load(path: Path) -> Bounce:
    said = read_header(path, "bounce")
    heights = tuple(read_columns(path, "bounce")["height"].tolist())
    return Bounce(Parameters(**said["bounce_of"]), said["separation"], heights)


BOUNCE = StudyKind(
    data="bounce",
    show=lambda result: print_list("Bounce", [row[:2] for row in study("bounce").rows(result)]),
    warning=lambda result: "high" if max(result.heights) > 1.0 else None,
    suffixes=(".csv", ".npz", ".parquet"),
    save=save,
    as_json=True,
    stem=lambda _: "bounce",
    load=load,
    header=frozenset({"bounce_of"}),
    command=lambda result: Command("bounce", scene_fields(result, ("F", "separation"))),
    stored=Stored(".npz"),
)
RESULT = Bounce(Parameters(F=60.0), True, (0.5, 0.25, 1.0 / 3.0))


@pytest.fixture
def bounce(monkeypatch: pytest.MonkeyPatch) -> None:
    package = ModuleType("bounces")
    package.BOUNCE = BOUNCE  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "bounces", package)
    # The one line.
    monkeypatch.setitem(STUDIES, "bounce", "bounces:BOUNCE")


@pytest.mark.usefixtures("bounce")
@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_an_entry_more_is_written_recognised_and_read(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"b{suffix}"
    save_study("bounce", RESULT, path)
    assert kind_of(path) == "bounce"
    assert load_study("bounce", path) == RESULT


@pytest.mark.usefixtures("bounce")
def test_an_entry_more_is_written_drawn_and_printed_by_a_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, plot = tmp_path / "b.csv", tmp_path / "b.svg"
    check_outputs("bounce", out, plot, force=False)
    write("bounce", RESULT, out, plot, force=False)
    assert load(out) == RESULT
    assert "<svg" in plot.read_text()
    with pytest.raises(InputError, match="exists already"):
        check_outputs("bounce", out, None, force=False)
    with pytest.raises(InputError, match="the suffix of a bounce file"):
        check_outputs("bounce", tmp_path / "b.xls", None, force=False)
    capsys.readouterr()
    show("bounce", RESULT, as_json=True)
    assert json.loads(capsys.readouterr().out) == {"heights": list(RESULT.heights)}
    show("bounce", RESULT)
    assert "greatest height  0.5 m" in capsys.readouterr().out


@pytest.mark.usefixtures("bounce")
def test_an_entry_more_is_exported_kept_and_said_by_the_laboratory(tmp_path: Path) -> None:
    data = scene_study_export(DATA, "bounce", RESULT, "mine")
    assert (data.proposal, data.of) == ("mine-bounce.csv", "the bounce")
    assert data.suffixes == (".csv", ".npz", ".parquet", ".json")
    for suffix in data.suffixes:
        assert write_export(data, tmp_path / f"b{suffix}", force=False) == ""
    assert json.loads((tmp_path / "b.json").read_text()) == RESULT.to_dict()
    figure = scene_study_export(FIGURE, "bounce", RESULT, "mine")
    assert write_export(figure, tmp_path / "b.png", force=False) == ""
    store = ResultStore(tmp_path / "kept")
    files, notes = store.put({"bounce": DisplayedStudy(RESULT, "mine", "here")})
    assert notes == {}
    again = ResultStore(tmp_path / "kept").get("bounce", files["bounce"])
    assert (again.value, again.name, again.source) == (RESULT, "mine", "here")
    store.remove_others({})
    assert list((tmp_path / "kept").iterdir()) == []
    line = study_line("bounce", RESULT, Origin(PRESETS["base"], ""))
    assert line == "fivtui bounce --set F=60"


def test_every_entry_says_what_its_files_are_called_and_can_be_read_where_it_is_kept() -> None:
    for name, kind in studies():
        assert kind.data, name
        assert callable(kind.show)
        if kind.suffixes:
            assert kind.stem is not str or kind.load is not None, name
    kept_alone = {name for name, kind in studies() if kind.stored is not None and not kind.load}
    # What is kept between two starts can be opened from a file, too; claims are computed anew.
    assert kept_alone == {"claims"}
    names = [name for name, kind in studies() if kind.header]
    # A map says least: whatever has its keys and more must be recognised before it.
    assert names[-1] == "map"


def test_a_kind_that_is_not_read_or_said_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="stress tests cannot be read"):
        load_study("extremes", tmp_path / "a.csv")
    with pytest.raises(InputError, match="no command"):
        command_of("attractor", None)
