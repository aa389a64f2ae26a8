"""``fivtui figures`` draws the figures of the paper, ``fivtui claims`` checks its statements."""

import json
from pathlib import Path

import pytest

from fivtui.cli import run

from .test_cli import run_fivtui


def test_figures_are_written_with_their_data(tmp_path: Path) -> None:
    process = run_fivtui("figures", "2", "10", "--out", "figs", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert process.stdout == ""
    assert sorted(path.name for path in (tmp_path / "figs").iterdir()) == [
        "fig-02.pdf",
        "fig-02.png",
        "fig-02a.csv",
        "fig-02b.csv",
        "fig-10.csv",
        "fig-10.pdf",
        "fig-10.png",
    ]
    # One line for each figure, which names all of its files.
    assert [line.split()[0] for line in process.stderr.splitlines()] == ["wrote", "wrote"]


@pytest.mark.slow
def test_amplitudes_are_drawn_in_the_requested_formats(tmp_path: Path) -> None:
    process = run_fivtui("figures", "16", "--out", ".", "--format", "svg", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fig-16.csv", "fig-16.svg"]
    rows = [
        line.split(",")
        for line in (tmp_path / "fig-16.csv").read_text(encoding="utf-8").splitlines()
        if not line.startswith("#")
    ]
    header, *values = rows
    considered = [row for row in values if row[header.index("separation")] == "1.0"]
    half_range = float(considered[-1][header.index("y_half_range")])
    assert half_range == pytest.approx(8.1367, abs=1e-3)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["figures"], "--out"),
        (["figures", "1", "--out", "new"], "must be 2 to 16"),
        (["figures", "17", "--out", "new"], "must be 2 to 16"),
        (["figures", "five", "--out", "new"], "figure 'five'"),
        (["figures", "9-3", "--out", "new"], "figure '9-3'"),
        (["figures", "2", "--out", "new", "--format", "pgn"], "did you mean png?"),
        (["figures", "2", "--out", "taken"], "taken"),
        (["figures", "2", "--out", "."], "fig-02b.csv: exists"),
        (["figuers"], "did you mean figures?"),
        (["claims", "--json", "--markdown"], "--markdown: must be given without --json"),
        (["claims", "5"], "unexpected"),
        (["claims", "--verdict", "true"], "'true' is not one of 'holds', 'does-not-hold'"),
        (["claim"], "did you mean claims?"),
    ],
    ids=str,
)
def test_wrong_input_prints_one_line_exits_with_2_and_leaves_no_files(
    args: list[str], message: str, tmp_path: Path
) -> None:
    for name in ("taken", "fig-02b.csv"):
        (tmp_path / name).write_text("mine")
    process = run_fivtui(*args, cwd=tmp_path)
    assert process.returncode == 2, process.stderr
    assert process.stdout == ""
    assert message in process.stderr
    assert process.stderr.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fig-02b.csv", "taken"]
    assert (tmp_path / "fig-02b.csv").read_text() == "mine"


def test_force_replaces_figures(tmp_path: Path) -> None:
    (tmp_path / "fig-06.png").write_text("mine")
    process = run_fivtui("figures", "6", "--out", ".", "--format", "png", "--force", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert (tmp_path / "fig-06.png").read_bytes().startswith(b"\x89PNG")


def test_claims_are_selected_by_their_verdict(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["claims", "--verdict", "not-testable", "--json"]) == 0
    verdicts = {claim["verdict"] for claim in json.loads(capsys.readouterr().out)}
    assert verdicts == {"not testable"}
