"""Results: their summary lines, data, columns and figures; results can be pickled."""

import copy
import json
import math
import pickle
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from matplotlib.figure import Figure

import fivtui
from fivtui.measured.reading import Measurement
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.parameters import Parameters
from fivtui.results import Result, equal_values, scene_text
from fivtui.tradeoffs import measure
from fivtui.transient.result import Transient

_PARAMETERS: Final = Parameters(F=120.0, mu=0.5)


def _fmu_run() -> Result:
    with tempfile.TemporaryDirectory() as folder:
        fmu = fivtui.build_fmu(Path(folder) / "belt.fmu")
        return fivtui.run_fmu(fmu, t_end=2.0, output_interval=0.1)


def _trajectory(run: Transient) -> Result:
    assert run.trajectory is not None
    return run.trajectory


def _tradeoff() -> Result:
    with pytest.MonkeyPatch.context() as patch:
        # CPU time of the trade-off, s.
        patch.setattr(measure, "QUICK_S", 1.0)
        return fivtui.tradeoff(t_end=1.0)


def _uncertainty() -> Result:
    return fivtui.uncertainty(
        vary={"mu": "uniform:0.2:0.8"}, samples=32, repeats=4, outputs=["critical_mu"]
    )


def _validation() -> Result:
    t = np.linspace(0.0, 3.0, 64)
    run = fivtui.simulate(t_end=3.0, samples="dense")
    assert run.solution is not None
    measured = Measurement("measured.csv", "t", "y", t, run.solution(t).y + 0.01)
    return fivtui.validate(run, measured, tolerances=fivtui.Tolerances(frequency=0.1))


def _identification() -> Result:
    columns = fivtui.simulate(_PARAMETERS, t_end=3.0, samples=64).to_columns()
    noise = np.random.default_rng(1).normal(0.0, 0.01, 64)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.csv"
        np.savetxt(path, np.column_stack([columns["t"], columns["y"] + noise]), delimiter=",")
        return fivtui.identify(_PARAMETERS, path, fit=["mu", "c1"])


# Results by name: the study whose files hold the result, empty if none does, and its computation.
RESULTS: Final[dict[str, tuple[str, Callable[[], Result]]]] = {
    "transient": ("run", lambda: fivtui.simulate(_PARAMETERS, t_end=20.0, samples=201)),
    "dense": ("", lambda: fivtui.simulate(t_end=20.0, samples="dense")),
    "trajectory": ("", lambda: _trajectory(fivtui.simulate(t_end=20.0, samples=5))),
    "stability": ("stability", lambda: fivtui.stability(_PARAMETERS)),
    "modes": ("", lambda: fivtui.stability(_PARAMETERS).modes_over_mu()),
    "map": (
        "map",
        lambda: fivtui.stability_map(
            None, {"F": [-500.0, 20.0, 80.0], "k_nl": [50.0, 100.0]}, "critical-mu"
        ),
    ),
    "regions": (
        "map",
        lambda: fivtui.safety_map(None, {"F": [60.0, 120.0], "mu": [0.3, 0.7]}, "coexistence"),
    ),
    "batch": ("", lambda: fivtui.simulate_batch({"F": [60.0, 80.0]}, t_end=5.0)),
    "sweep": (
        "sweep",
        lambda: fivtui.sweep(
            vary={"F": [20.0, 80.0, 100.0]}, t_end=10.0, outputs=["y_abs", "separations", "stable"]
        ),
    ),
    "uncertainty": ("uncertainty", _uncertainty),
    "validation": ("validation", _validation),
    "identification": ("identification", _identification),
    "attractors": ("attractors", lambda: fivtui.attractors(Parameters(mu=0.2))),
    "continuation": ("branches", lambda: fivtui.continuation(None, "mu", [0.2, 0.5])),
    "branch": ("branch", lambda: fivtui.branch(None, "mu", low=0.25, high=0.6)),
    "boundary": (
        "boundary",
        lambda: fivtui.boundary(None, "hopf", {"F": (60.0, 120.0), "mu": (0.3, 0.8)}),
    ),
    "basin": ("basin", lambda: fivtui.basin(_PARAMETERS, {"y0": [-0.8, 0.0], "vy0": [0.0, 1.0]})),
    "accuracy": ("accuracy", lambda: fivtui.accuracy(_PARAMETERS, t_end=10.0)),
    "tradeoff": ("trade-off", _tradeoff),
    "fmu": ("", _fmu_run),
}
# Results with `to_dict`, with columns, and with a figure.
WITH_DATA: Final = [name for name in RESULTS if name not in ("trajectory", "modes")]
TABULAR: Final = [name for name in RESULTS if name not in ("dense", "stability", "attractors")]
DRAWN: Final = [
    name for name, (kind, _) in RESULTS.items() if kind and kind not in ("attractors", "accuracy")
]


@cache
def result_named(name: str) -> Any:
    return RESULTS[name][1]()


class _Cells(HTMLParser):
    # The texts of all cells of a table, and the tags that are open.
    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_prints_in_a_few_lines(name: str) -> None:
    lines = repr(result_named(name)).splitlines()
    assert lines[0] == type(result_named(name)).__name__
    assert 2 <= len(lines) <= 16
    assert max(map(len, lines)) <= 180
    assert str(result_named(name)) == repr(result_named(name))
    assert "array(" not in repr(result_named(name))


@pytest.mark.parametrize("name", RESULTS)
def test_a_notebook_shows_the_same_as_a_table(name: str) -> None:
    cells = _Cells()
    cells.feed(result_named(name)._repr_html_())
    assert not cells.open
    title, *rows = repr(result_named(name)).splitlines()
    assert cells.texts[0] == title
    shown = list(zip(cells.texts[1::2], cells.texts[2::2], strict=True))
    assert [row.split() for row in rows] == [f"{key} {text}".split() for key, text in shown]


def test_a_transient_prints_its_results() -> None:
    run = result_named("transient")
    text = repr(run)
    share = run.events.separated_time / run.t_end
    assert f"{run.peak.y_abs:.6g} m" in text
    assert f"{run.events.separations}, " in text
    assert f"({share:.1%})" in text
    assert "F=120, mu=0.5" in text
    assert "201 samples" in text


def test_a_sweep_of_many_columns_prints_few_lines() -> None:
    lines = repr(fivtui.sweep(vary={"F": [20.0, 80.0]}, t_end=5.0)).splitlines()
    assert len(lines) <= 16
    assert lines[-1].split() == ["and", "8", "more", "columns"]
    assert repr(result_named("sweep")).splitlines()[-1].split() == ["stable", "0", "of", "3"]


def test_the_scene_is_described_by_its_differences_from_the_base_set() -> None:
    assert scene_text(System(Parameters())) == "base set"
    assert scene_text(System(_PARAMETERS), without=("mu",)) == "base set with F=120"
    assert scene_text(System(Parameters(), separation=False)) == "base set; separation ignored"


@pytest.mark.parametrize("name", WITH_DATA)
def test_to_dict_returns_json_data(name: str) -> None:
    data = result_named(name).to_dict()
    assert data
    assert json.loads(json.dumps(data, allow_nan=False)) is not None


@pytest.mark.parametrize("name", TABULAR)
@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_columns_are_arrays_of_one_length_that_data_frames_take(name: str, package: str) -> None:
    columns = result_named(name).to_columns()
    frame = pytest.importorskip(package).DataFrame(columns)
    assert list(frame.columns) == list(columns)
    assert len({values.shape for values in columns.values()}) == 1
    for key, values in columns.items():
        assert values.ndim == 1
        assert values.dtype.kind in "biufU"
        assert equal_values(frame[key].to_numpy().astype(values.dtype), values)


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize(
    "duplicate", [lambda result: pickle.loads(pickle.dumps(result)), copy.copy, copy.deepcopy]
)
def test_a_result_can_be_pickled_and_copied(name: str, duplicate: Callable[[Any], Any]) -> None:
    copied = duplicate(result_named(name))
    assert type(copied) is type(result_named(name))
    assert repr(copied) == repr(result_named(name))
    assert copied == result_named(name)
    assert hash(copied) == hash(result_named(name))
    if name in WITH_DATA:
        assert equal_values(copied.to_dict(), result_named(name).to_dict())
    if name in TABULAR:
        assert equal_values(copied.to_columns(), result_named(name).to_columns())


@pytest.mark.parametrize("name", DRAWN)
def test_a_result_draws_itself(name: str) -> None:
    figure = result_named(name).figure()
    assert isinstance(figure, Figure)
    assert figure.axes
    assert figure.axes[0].has_data()


def test_columns_of_a_sweep_have_the_values_of_its_rows() -> None:
    table = result_named("sweep")
    columns = table.to_columns()
    rows = zip(*(columns[name].tolist() for name in table.columns), strict=True)
    assert list(map(list, rows)) == table.rows
    assert columns["separations"].dtype == np.int64
    assert columns["stable"].dtype == np.bool_


def test_a_failed_row_of_a_sweep_has_no_numbers_in_the_columns() -> None:
    # Without load the slider stays at rest; under load its linear motion grows until it overflows.
    table = fivtui.sweep(
        Parameters(k_nl=0.0, mu=3.0),
        vary={"F": [0.0, 80.0]},
        separation=False,
        t_end=1e4,
        outputs=["y_abs", "separations"],
    )
    assert table.to_columns()["status"].tolist() == ["done", "failed"]
    assert math.isnan(table.to_columns()["separations"][1])


def test_columns_of_a_map_are_its_points() -> None:
    result = result_named("map")
    columns = result.to_columns()
    assert list(columns) == ["F", "k_nl", "critical_mu"]
    selected = (columns["F"] == 80.0) & (columns["k_nl"] == 100.0)
    assert columns["critical_mu"][selected] == result.values[2, 1]


def test_columns_of_a_batch_are_the_required_ones() -> None:
    batch = fivtui.simulate_batch({"F": [60.0, 80.0]}, t_end=5.0, require={"amplitude"})
    assert list(batch.to_columns()) == ["status", "t", "steps", "y_abs", "y_max", "y_min"]


def test_without_samples_there_are_no_columns_and_no_figure() -> None:
    run = fivtui.simulate(t_end=1.0)
    for export in (run.to_columns, run.figure):
        with pytest.raises(InputError, match="compute it with sample times"):
            export()


def test_non_finite_numbers_are_not_exported() -> None:
    run = fivtui.simulate(t_end=1.0)
    broken = replace(run, peak=run.peak._replace(y_abs=math.nan))
    with pytest.raises(ComputationError, match="not a finite number"):
        broken.to_dict()


@pytest.mark.parametrize("method", ["taylor", "rk4", "scipy-dop853", "fmu"])
def test_a_number_of_samples_is_that_many_evenly_spaced_times(method: str) -> None:
    run = fivtui.simulate(t_end=3.0, samples=7, method=method)
    assert run.trajectory is not None
    assert run.trajectory.t.tolist() == np.linspace(0.0, 3.0, 7).tolist()
    listed = fivtui.simulate(t_end=3.0, samples=np.linspace(0.0, 3.0, 7), method=method)
    assert listed.trajectory is not None
    assert np.allclose(run.trajectory.y, listed.trajectory.y, rtol=1e-9, atol=0.0)


@pytest.mark.parametrize("count", [-3, 0, 1, 10**12])
def test_a_number_of_samples_is_two_or_more(count: int) -> None:
    with pytest.raises(InputError, match=r"samples = -?\d+: must be 2 to 100000000$"):
        fivtui.simulate(t_end=3.0, samples=count)


def test_a_linear_scene_is_sampled_the_same_way() -> None:
    linear = Parameters(k_nl=0.0)
    run = fivtui.simulate(linear, t_end=3.0, separation=False, samples=4)
    assert run.stats.kernel == "exact"
    assert run.trajectory is not None
    assert run.trajectory.t.tolist() == [0.0, 1.0, 2.0, 3.0]


def test_a_solution_is_called_with_times_as_in_scipy() -> None:
    run = result_named("dense")
    states = run.solution(np.array([0.0, 7.5, 20.0]))
    assert states.y.shape == (3,)
    assert states.y[-1] == pytest.approx(run.final.y, rel=1e-12)
    assert run.solution(20.0).x[0] == pytest.approx(run.final.x, rel=1e-12)
    assert re.fullmatch(r"<DenseSolution, 0 to 20[.\d]* s, \d+ segments>", repr(run.solution))


def test_matplotlib_is_imported_where_a_result_is_drawn() -> None:
    code = """
import sys, fivtui
run = fivtui.simulate(t_end=1.0, samples=11)
repr(run), run.to_dict(), run.to_columns(), repr(fivtui.stability())
print("matplotlib" in sys.modules)
run.figure()
print("matplotlib" in sys.modules)
"""
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert process.stdout.split() == ["False", "True"]


COMPARED: dict[str, Callable[[float], object]] = {
    "transient": lambda F: fivtui.simulate(Parameters(F=F), t_end=3.0, samples=7),
    "dense": lambda F: fivtui.simulate(Parameters(F=F), t_end=3.0, samples="dense"),
    "exact": lambda F: fivtui.simulate(Parameters(F=F, k_nl=0.0), t_end=3.0, separation=False),
    "sensitivities": lambda F: fivtui.simulate(Parameters(F=F), t_end=3.0, sensitivities=["mu"]),
    "solution": lambda F: fivtui.simulate(Parameters(F=F), t_end=3.0, samples="dense").solution,
    "batch": lambda F: fivtui.simulate_batch({"F": [F, 2.0 * F]}, t_end=3.0),
    "events": lambda F: fivtui.simulate_batch({"F": [F, 2.0 * F]}, t_end=3.0).events,
    "sweep": lambda F: fivtui.sweep(vary={"F": [F, 2.0 * F]}, t_end=3.0),
    "stability": lambda F: fivtui.stability(Parameters(F=F)),
}


@pytest.mark.parametrize("name", COMPARED)
def test_results_are_equal_only_for_the_same_computation(name: str) -> None:
    make = COMPARED[name]
    first, equal, different = make(80.0), make(80.0), make(90.0)
    assert first == equal
    assert hash(first) == hash(equal)
    assert first != different
    assert (first == 1) is False


@pytest.mark.parametrize(
    ("first", "second", "equal"),
    [
        (np.array([1.0, np.nan]), np.array([1.0, np.nan]), True),
        (np.array([1.0, 2.0]), np.array([1.0, 2.5]), False),
        (np.array([1.0, 2.0]), np.array([1.0]), False),
        (np.array([1, 2]), np.array([1.0, 2.0]), False),
        (np.array(["a"]), np.array(["a"]), True),
        (np.array([1.0]), 1.0, False),
        ({"a": np.zeros(2)}, {"a": np.zeros(2)}, True),
        ({"a": np.zeros(2)}, {"a": np.ones(2)}, False),
        ({"a": 1}, {"b": 1}, False),
        ((np.zeros(2), "a"), (np.zeros(2), "a"), True),
        ((np.zeros(2), "a"), (np.zeros(2), "b"), False),
        ([1], [1, 2], False),
        (math.nan, math.nan, True),
        (1, 1.0, True),
        (None, 0.0, False),
    ],
)
def test_values_are_equal_element_by_element(first: object, second: object, equal: bool) -> None:
    assert equal_values(first, second) is equal
    assert equal_values(second, first) is equal
