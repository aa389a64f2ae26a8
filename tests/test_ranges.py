"""Ranges of values: parsing, spacing, and messages about wrong ones."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui.model.errors import InputError
from fivtui.model.parameters import PARAMETERS
from fivtui.ranges import NamedRange, log_spaced, parse_range, parse_ranges, range_text


def test_a_range_is_evenly_spaced_and_holds_both_ends() -> None:
    parsed = parse_range("--vary", " F = 10 : 120 : 23 ")
    assert parsed == NamedRange("F", 10.0, 120.0, 23)
    assert np.diff(parsed.values()) == pytest.approx(np.full(22, 5.0))


def test_a_logarithmic_range_has_equal_ratios() -> None:
    values = parse_range("--vary", "k_nl=1e-3:1e3:7:log").values()
    assert values.tolist() == [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3]


@given(
    st.floats(1e-300, 1e300),
    st.floats(1e-300, 1e300),
    st.integers(1, 1000),
    st.integers(0, 2**32 - 1),
)
def test_values_spaced_logarithmically_are_rounded_to_the_last_bit(
    start: float, stop: float, parts: int, seed: int
) -> None:
    positions = np.random.default_rng(seed).integers(0, parts, 5, endpoint=True).astype(float)
    values = log_spaced(start, stop, positions, parts)
    with mpmath.workdps(60):
        ratio = mpmath.mpf(stop) / mpmath.mpf(start)
        for position, value in zip(positions.tolist(), values.tolist(), strict=True):
            exact = mpmath.mpf(start) * ratio ** (mpmath.mpf(position) / parts)
            assert abs(exact - value) <= 0.51 * math.ulp(value)


def test_a_range_spaced_by_numpy_is_recognised() -> None:
    assert range_text("k_nl", np.geomspace(1.0, 500.0, 1001)) == "1:500:1001:log"
    with pytest.raises(InputError, match="not evenly spaced"):
        range_text("k_nl", np.geomspace(1.0, 500.0, 1001) * (1.0 + 1e-9 * np.arange(1001)))


def test_a_range_may_descend_and_may_be_negative() -> None:
    assert parse_range("--over", "F=50:-50:3").values().tolist() == [50.0, 0.0, -50.0]


@given(st.floats(1e-3, 99.0), st.floats(1e-3, 99.0), st.integers(2, 500), st.booleans())
def test_the_ends_are_exact_and_every_value_is_allowed(
    start: float, stop: float, count: int, log: bool
) -> None:
    if start == stop:
        return
    text = f"mu={start!r}:{stop!r}:{count}{':log' if log else ''}"
    values = parse_range("--over", text).values()
    assert values.shape == (count,)
    assert (values[0], values[-1]) == (start, stop)
    assert all(PARAMETERS["mu"].check(value) == value for value in values.tolist())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("F", "NAME=START:STOP:COUNT"),
        ("=1:2:3", "NAME=START:STOP:COUNT"),
        ("F=1:2", "NAME=START:STOP:COUNT"),
        ("F=1:2:3:log:5", "NAME=START:STOP:COUNT"),
        ("f_nl=1:2:3", "did you mean k_nl?"),
        ("F=a:2:3", "F = 'a': not a number"),
        ("mu=-1:2:3", "must be from 0 to 100"),
        ("F=1:inf:3", "not a finite number"),
        ("F=1:2:1", "COUNT = 1"),
        ("F=1:2:2.5", "COUNT = 2.5"),
        ("F=1:2:99999999", "COUNT = 99999999"),
        ("F=1:1:3", "must differ"),
        ("F=0:2:3:log", "logarithmic"),
        ("F=1:2:3:cubic", "unknown spacing 'cubic'"),
    ],
)
def test_a_wrong_range_is_reported_with_the_allowed_one(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_range("--vary", text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_several_ranges_must_have_different_names() -> None:
    first, second = parse_ranges("--over", ["F=1:2:3", "mu=0:1:2"])
    assert (first.name, second.name) == ("F", "mu")
    with pytest.raises(InputError, match=r"--over F=…: given twice"):
        parse_ranges("--over", ["F=1:2:3", "F=3:4:3"])


def test_only_quantities_of_the_given_table_may_vary() -> None:
    table = {"F": PARAMETERS["F"]}
    assert parse_range("--over", "F=1:2:3", table).name == "F"
    with pytest.raises(InputError, match="unknown parameter 'mu'"):
        parse_range("--over", "mu=1:2:3", table)
