import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui.model.errors import InputError
from fivtui.model.parameters import PARAMETERS
from fivtui.ranges import NamedRange, parse_range, parse_ranges


def test_a_range_is_evenly_spaced_and_holds_both_ends() -> None:
    found = parse_range("--vary", " F = 10 : 120 : 23 ")
    assert found == NamedRange("F", 10.0, 120.0, 23)
    assert np.diff(found.values()) == pytest.approx(np.full(22, 5.0))


def test_a_logarithmic_range_has_equal_ratios() -> None:
    values = parse_range("--vary", "k_nl=1:1e4:5:log").values()
    assert values == pytest.approx([1.0, 10.0, 100.0, 1e3, 1e4])


def test_a_range_may_fall_and_may_be_negative() -> None:
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
    ("text", "said"),
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
def test_a_wrong_range_is_named_with_what_is_allowed(text: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_range("--vary", text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_several_ranges_are_of_different_names() -> None:
    first, second = parse_ranges("--over", ["F=1:2:3", "mu=0:1:2"])
    assert (first.name, second.name) == ("F", "mu")
    with pytest.raises(InputError, match=r"--over F=…: given twice"):
        parse_ranges("--over", ["F=1:2:3", "F=3:4:3"])


def test_other_quantities_than_parameters_may_vary() -> None:
    specs = {"F": PARAMETERS["F"]}
    assert parse_range("--over", "F=1:2:3", specs).name == "F"
    with pytest.raises(InputError, match="unknown parameter 'mu'"):
        parse_range("--over", "mu=1:2:3", specs)
