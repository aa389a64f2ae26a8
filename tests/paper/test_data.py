"""Data of the paper's figures, compared with independently computed points.

`tests/data/make_paper_points.py` computes the points; its runs use the paper's method, RK4 with
bisection. A point has the key of its figure, or "base" for the runs of Figs. 10 to 12. Its
"changes" are the values that distinguish it from the other points of the figure.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.model.parameters import Parameters
from fivtui.paper.amplitudes import compute_amplitudes
from fivtui.paper.data import DATA_COLUMNS, FigureData, save_data
from fivtui.paper.panels import PANELS, figure_panels
from fivtui.paper.results import PaperResults
from fivtui.paper.tables import critical_mu
from fivtui.scene.scene import Scene

POINTS: list[dict[str, Any]] = json.loads(
    Path(__file__)
    .parents[1]
    .joinpath("data")
    .joinpath("paper_points.json")
    .read_text(encoding="utf-8")
)
STABILITY_KEYS = ("2a", "2b", "3", "4", "5", "6", "7", "8", "9")


def stored_points_of(*keys: str) -> list[dict[str, Any]]:
    return [point for point in POINTS if point["key"] in keys]


def row_index(data: FigureData, changes: dict[str, float]) -> int:
    matches = np.all(
        [np.isclose(data[name], value, rtol=1e-12) for name, value in changes.items()], axis=0
    )
    (index,) = np.flatnonzero(matches)
    return int(index)


@pytest.fixture(scope="module")
def results() -> PaperResults:
    return PaperResults(workers=1)


@pytest.mark.parametrize("key", STABILITY_KEYS)
def test_equilibria_and_eigenvalues_are_those_of_the_papers_equations(
    key: str, results: PaperResults
) -> None:
    data = results.table(key)
    stored_points = stored_points_of(key)
    assert stored_points
    for point in stored_points:
        index = row_index(data, point["changes"])
        for name in ("x_e", "y_e", "mu_c"):
            if name in point:
                assert data[name][index] == pytest.approx(point[name], rel=1e-9, abs=1e-12)
        if "modes" in point:
            # Growth rate, 1/s, and frequency, rad/s, of both modes by ascending frequency.
            modes = point["modes"]
            (growth_1, frequency_1), (growth_2, frequency_2) = modes
            # Of modes with merged frequencies, the growing one comes first.
            if np.isclose(frequency_1, frequency_2, rtol=1e-9) and growth_2 > growth_1:
                modes = reversed(modes)
            for number, (growth, frequency) in enumerate(modes, start=1):
                assert data[f"sigma_{number}"][index] == pytest.approx(growth, abs=1e-7)
                assert data[f"omega_{number}"][index] == pytest.approx(frequency, abs=1e-7)


def test_runs_are_those_of_the_papers_method(results: PaperResults) -> None:
    for point in stored_points_of("base"):
        for time, (x, _, y, _) in point["states"].items():
            condition = {"separation": point["changes"]["separation"], "t": float(time)}
            for key, name, expected in (("11", "x", x), ("12", "y", y)):
                data = results.table(key)
                assert data[name][row_index(data, condition)] == pytest.approx(expected, abs=1e-6)
            force = results.table("10")
            base = Parameters()
            # If separation is ignored, the contact spring also pulls, where y > 0.
            off_belt = point["changes"]["separation"] and y >= 0.0
            expected = 0.0 if off_belt else -base.k2 * y - base.k_nl * y**3
            assert force["P"][row_index(force, condition)] == pytest.approx(expected, abs=1e-3)


def test_amplitudes_are_those_of_the_papers_method() -> None:
    stored_points = stored_points_of("13", "14", "15", "16")
    scenes = [scene_at(point) for point in stored_points]
    for point, amplitude in zip(stored_points, compute_amplitudes(scenes, workers=1), strict=True):
        assert amplitude.y_peak == pytest.approx(point["y_peak"], rel=2e-5)
        assert amplitude.y_half_range == pytest.approx(point["y_half_range"], rel=2e-5)


def scene_at(point: dict[str, Any]) -> Scene:
    changes = dict(point["changes"])
    separation = bool(changes.pop("separation"))
    (scene,) = (
        candidate
        for candidate in PANELS[point["key"]].scenes()
        if candidate.separation is separation
        and all(getattr(candidate.parameters, name) == value for name, value in changes.items())
    )
    return scene


def test_every_figure_from_2_to_16_has_panels_of_one_kind() -> None:
    assert len(PANELS) == 16
    # Kinds are equilibria, eigenvalues, critical friction coefficients, transients and amplitudes.
    for number in range(2, 17):
        assert len({panel.kind for panel in figure_panels(number)}) == 1


@pytest.mark.parametrize(
    ("key", "by", "values"),
    [
        ("3", "k_nl", (0.0, 50.0, 100.0, 500.0)),
        ("4", "k_nl", (0.0, 50.0, 100.0, 500.0)),
        ("6", "k_nl", (0.0, 50.0, 200.0, 500.0)),
        ("7", "F", (0.0, 5.0, 50.0, 100.0)),
        ("13", "separation", (0.0, 1.0)),
    ],
)
def test_lines_are_in_the_papers_order(key: str, by: str, values: tuple[float, ...]) -> None:
    panel = PANELS[key]
    assert panel.by == by
    holders = [line.scene if by == "separation" else line.scene.parameters for line in panel.lines]
    assert tuple(float(getattr(holder, by)) for holder in holders) == values


@pytest.mark.parametrize(
    ("key", "parameters"),
    [
        ("3", {"F": 20.0, "c1": 0.32, "c2": 0.32}),
        ("4", {"F": 100.0, "c1": 0.32, "c2": 0.32}),
        ("5", {"F": 100.0, "c1": 0.8, "c2": 0.32}),
        ("8", {"k1": 50.0, "k2": 100.0}),
        ("10", {"F": 80.0, "k_nl": 100.0, "mu": 0.7}),
        ("13", {"k_nl": 20.0, "mu": 0.5}),
        ("14", {"k_nl": 100.0, "mu": 0.7}),
        ("15", {"F": 40.0, "mu": 0.7}),
        ("16", {"F": 60.0, "mu": 1.0}),
    ],
)
def test_shared_parameters_are_those_of_the_captions(
    key: str, parameters: dict[str, float]
) -> None:
    for line in PANELS[key].lines:
        line_values = line.scene.parameters.as_dict()
        assert line_values | parameters == line_values


def test_data_are_written_with_units_and_read_back_exactly(
    results: PaperResults, tmp_path: Path
) -> None:
    data = results.table("5")
    path = tmp_path / "fig-05.csv"
    save_data(data, path)
    lines = path.read_text(encoding="utf-8").splitlines()
    comments = [line.removeprefix("# ").partition(": ") for line in lines if line[0] == "#"]
    header = {key: json.loads(text) for key, _, text in comments}
    assert header["parameters"]["c1"] == 0.8
    # Columns have the values of these: μ varies along the lines, k_nl from line to line.
    assert "k_nl" not in header["parameters"]
    assert "mu" not in header["parameters"]
    # What was chosen for the figure because the paper does not say it, such as a range.
    assert header["choice"]
    names = lines[len(comments)].split(",")
    assert names == list(data.columns) == list(header["units"])
    assert header["units"]["omega_1"] == "rad/s"
    values = np.loadtxt(lines[len(comments) + 1 :], delimiter=",")
    for name, column in zip(names, values.T, strict=True):
        np.testing.assert_array_equal(column, data[name])


def test_every_column_that_a_figure_can_have_has_a_unit_and_a_meaning(
    results: PaperResults,
) -> None:
    for key in (*STABILITY_KEYS, "10", "11", "12"):
        for name in results.table(key).columns:
            assert DATA_COLUMNS[name].unit
            assert DATA_COLUMNS[name].meaning


def test_lines_are_the_rows_of_one_value_in_order(results: PaperResults) -> None:
    data = results.table("6")
    lines = dict(data.lines())
    assert list(lines) == [0.0, 50.0, 200.0, 500.0]
    assert sum(line["F"].size for line in lines.values()) == data["F"].size
    for value, line in lines.items():
        assert set(line["k_nl"].tolist()) == {value}


def test_data_that_are_not_finite_are_refused() -> None:
    columns = {"F": np.array([1.0]), "k_nl": np.array([0.0]), "mu_c": np.array([np.nan])}
    with pytest.raises(ComputationError, match="figure 6: mu_c"):
        FigureData("6", caption="", by="k_nl", along="F", columns=columns, provenance={})


def test_an_existing_data_file_is_not_replaced(results: PaperResults, tmp_path: Path) -> None:
    path = tmp_path / "fig-06.csv"
    path.write_text("mine")
    with pytest.raises(InputError, match="exists"):
        save_data(results.table("6"), path)
    assert path.read_text() == "mine"


def test_a_system_without_critical_friction_is_refused() -> None:
    with pytest.raises(ComputationError, match="no friction coefficient"):
        critical_mu(Parameters(k3=0.0))


@pytest.mark.parametrize("key", ["2a", "3", "6", "10"])
def test_a_table_can_be_cancelled_between_scenes_and_within_a_run(key: str) -> None:
    results, checks = PaperResults(), 0

    def should_continue() -> bool:
        nonlocal checks
        checks += 1
        return checks < 3

    results.should_continue = should_continue
    with pytest.raises(Cancelled):
        results.table(key)
    assert checks == 3
    results.should_continue = lambda: True
    assert results.table(key).columns
