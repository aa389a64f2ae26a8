"""A branch in a file, in a figure, and what it warns of."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from fivtui import branch
from fivtui.io.tables import read_columns, read_header
from fivtui.model.parameters import Parameters
from fivtui.orbits.curves.events import End
from fivtui.results.tables import save_result


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_a_branch_in_a_file_has_its_cycles_and_its_events(tmp_path: Path, suffix: str) -> None:
    result = branch(None, "mu", low=0.25, high=0.6)
    path = tmp_path / f"b{suffix}"
    save_result(result, path)
    columns, header = read_columns(path, "branch"), read_header(path, "branch")
    for name, values in result.to_columns().items():
        np.testing.assert_array_equal(columns[name], values)
    kinds = [header["event_kinds"][int(place)] for place in columns["event"] if place]
    assert kinds == ["touch", "fold"]
    assert header["events"] == ["hopf, subcritical", *kinds]
    assert header["event_periods"] == [event.period for event in result.events]
    assert header["parameters"] == {
        name: value for name, value in Parameters().as_dict().items() if name != "mu"
    }
    (fold,) = np.flatnonzero(columns["mu"] == header["event_values"][2])
    last = [result.points[fold].multipliers[-1].real, columns["multiplier_3_re"][fold]]
    assert last[0] == last[1]


def test_a_branch_is_drawn_full_where_it_is_stable_and_dashed_where_it_is_not() -> None:
    result = branch(None, "mu", low=0.25, high=0.6)
    axes, orbits, multipliers = result.figure().axes
    lines = {str(line.get_label()): line for line in axes.lines if str(line.get_label())[0] != "_"}
    assert set(lines) == {"unstable", "stable", "hopf", "touch", "fold"}
    fold = result.events[-1].value
    drawn = 0
    for name, style in (("stable", "-"), ("unstable", "--")):
        line = lines[name]
        assert line.get_linestyle() == style
        cycles = {(p.value, p.half_range) for p in result.points if p.stable == (name == "stable")}
        seen = set(zip(*np.array(line.get_data()).tolist(), strict=True))
        assert {one for one in cycles if one[0] != fold} <= seen
        assert fold in {value for value, _ in seen}
        drawn += len(seen)
    assert drawn == len(result.points) + 1
    for event in result.events:
        x, y = np.array(lines[str(event.kind)].get_data())[:, 0].tolist()
        assert (x, y) == (event.value, 0.5 * (event.y_max - event.y_min))
    for event in result.events[1:]:
        (orbit,) = (
            line for line in orbits.lines if f"= {event.value:.4g}" in str(line.get_label())
        )
        ys = np.array(orbit.get_xdata())
        assert [ys.min(), ys.max()] == pytest.approx([event.y_min, event.y_max], abs=1e-3)
        assert ys[0] == pytest.approx(ys[-1], abs=1e-5)
    found = [value for point in result.points for value in point.multipliers]
    parts = [np.array(line.get_data()) for line in multipliers.lines[1:]]
    shown = [complex(x, y) for part in parts for x, y in part.T.tolist()]
    assert sorted(shown, key=abs) == sorted(found, key=abs)


def test_a_branch_that_grows_without_bounds_leaves_the_figure_and_not_the_rest() -> None:
    result = branch(None, "mu")
    assert max(point.half_range for point in result.points) > 1000.0
    stable = max(point.half_range for point in result.points if point.stable)
    axes = result.figure().axes[0]
    assert axes.get_ylim() == pytest.approx((-0.1 * stable, 2.1 * stable))


def test_a_branch_that_was_cut_short_warns_of_it() -> None:
    whole = branch(None, "mu", low=0.25, high=0.6)
    assert whole.warning is None
    cut = dataclasses.replace(whole, ends=(whole.ends[0], End.LOST))
    assert cut.warning == "the branch cannot be followed farther at mu = 0.6"
