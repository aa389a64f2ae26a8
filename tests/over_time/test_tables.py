"""Tables of parameters over time: values, slopes, jumps, and errors.

A course is the parameters as functions of time: constants, and tables for those that change.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui.model import InputError, Parameters, TimeTable, build_course, time_table

times = st.lists(st.integers(0, 100_000), min_size=1, max_size=8).map(sorted)


@given(times, st.data())
def test_a_table_is_the_linear_interpolation_of_its_rows(
    milliseconds: list[int], data: st.DataObject
) -> None:
    row_times = [0.001 * t for t in sorted(set(milliseconds))]
    values = data.draw(
        st.lists(st.floats(0.0, 9.0), min_size=len(row_times), max_size=len(row_times))
    )
    table = time_table("F", list(zip(row_times, values, strict=True)))
    query_time = data.draw(st.floats(0.0, 110.0))
    assert table.after(query_time)[0] == pytest.approx(
        float(np.interp(query_time, row_times, values)), abs=1e-12
    )
    assert min(values) <= table.after(query_time)[0] <= max(values)
    assert table.before(query_time) == pytest.approx(table.after(query_time)[0], abs=1e-12)


def test_a_repeated_time_is_a_jump() -> None:
    table = time_table("F", [(1.0, 10.0), (2.0, 20.0), (2.0, 60.0), (4.0, 40.0)])
    assert [table.before(t) for t in (0.0, 1.0, 1.5, 2.0, 3.0, 9.0)] == [10, 10, 15, 20, 50, 40]
    assert [table.after(t) for t in (0.0, 1.0, 1.5)] == [(10, 0), (10, 10), (15, 10)]
    assert [table.after(t) for t in (2.0, 3.0, 4.0)] == [(60, -10), (50, -10), (40, 0)]


def test_stiffness_is_held_until_the_next_row() -> None:
    table = time_table("k2", [(1.0, 50.0), (2.0, 50.0), (3.0, 90.0), (3.0, 80.0)])
    assert [table.after(t) for t in (0.0, 1.5, 2.9)] == [(50.0, 0.0)] * 3
    assert (table.before(3.0), table.after(3.0), table.after(9.0)) == (
        50.0,
        (80.0, 0.0),
        (80.0, 0.0),
    )
    # Rows of a checked table, as in stored files, are the same table.
    assert time_table("k2", table.rows()) == table


def test_a_course_gives_parameters_rates_and_the_time_of_the_next_row() -> None:
    course = build_course(
        Parameters(mu_s=0.9, v_s=0.1), {"mu": [(0, 0.5), (10, 0.7)], "v_belt": [(5, 2), (6, 0)]}
    )
    p, rates = course.after(5.5)
    assert [p.mu, p.v_belt, p.mu_s, p.F] == pytest.approx([0.61, 1.0, 0.9, 80.0])
    assert rates._asdict() == pytest.approx(
        {"F": 0.0, "mu": 0.02, "mu_static": 0.0, "v_belt": -2.0}
    )
    assert [course.next_row_time(t) for t in (0.0, 5.0, 9.9, 10.0)] == [5.0, 6.0, 10.0, np.inf]
    assert course.speed_before(6.0) == 0.0


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"m": [(0, 1)]}, "unknown parameter over time 'm'"),
        ({"k1": [(0, 100), (1, 0)]}, "k1 = 0: must be from 1e-12"),
        ({"F": []}, "F over time: there are no rows"),
        ({"F": [(1, 2), (0, 3)]}, "times must ascend"),
        ({"F": [(0, 1, 2)]}, "must be pairs of time"),
        ({"F": [(0, float("nan"))]}, "F = nan"),
        ({"F": [(float("inf"), 1)]}, "time of F = inf"),
        ({"F": [(0, 1), (1e-310, 2)]}, "a jump needs the same time twice"),
        ({"mu": [(0, -0.1)]}, "mu = -0.1: must be from 0"),
        ({"v_belt": [(0, 1), (1, -2e9)]}, "v_belt = -2e+09: must be from -1e+09"),
        ({"mu": [(0, 0.5), (1, 0.95)]}, "reaches 0.95: must be at most mu_s = 0.9"),
    ],
)
def test_invalid_tables_are_refused(tables: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        build_course(Parameters(mu_s=0.9), tables)
    assert message in str(caught.value)


def test_tables_are_described_in_one_phrase() -> None:
    assert time_table("F", [(0, 10), (4, 60)]).describe("F") == "10 (0 s) → 60 (4 s)"
    long_table = TimeTable(tuple(range(9)), tuple(range(9)))
    assert long_table.describe("F") == "0 to 8, 9 rows over 0 to 8 s"
    jump = time_table("F", [(0, 10), (1, 10), (1, 60)])
    assert jump.describe("F") == "10 (0 s) → 10 (1 s) → 60 (1 s)"


def test_a_description_has_only_the_rows_that_were_given() -> None:
    table = time_table("k2", [(0, 50), (6, 40), (8, 30)])
    assert table.describe("k2") == "50 (0 s) → 40 (6 s) → 30 (8 s)"
    long_table = time_table("k2", [(t, 50 - t) for t in range(5)])
    assert long_table.describe("k2") == "46 to 50, 5 rows over 0 to 4 s"
