"""Values, bounds and names of parameters.

The paper is "Nonlinear friction-induced vibration of a slider-belt system".
"""

import math

import pytest

from fivtui import Parameters
from fivtui.model.errors import InputError
from fivtui.model.numbers import Interval
from fivtui.model.parameters import PARAMETERS, parameter_spec
from fivtui.transient.settings.checks import (
    T_END_INTERVAL,
    check_horizon,
    check_tolerance,
    tolerance_interval,
)
from tests.support.paper_model import BASE


def test_defaults_are_the_base_set_of_the_paper() -> None:
    # `BASE` belongs to a model of the paper that is independent of fivtui.
    assert Parameters().as_dict() == BASE


def test_every_default_lies_in_its_own_bounds() -> None:
    for spec in PARAMETERS.values():
        assert spec.check(spec.default) == spec.default


@pytest.mark.parametrize("name", PARAMETERS)
@pytest.mark.parametrize("bad", ["", "two", "1,5", None, True, [1.0], math.nan, math.inf, "nan"])
def test_numbers_that_are_not_finite_are_refused_in_one_line(name: str, bad: object) -> None:
    with pytest.raises(InputError) as caught:
        Parameters().with_values({name: bad})
    message = str(caught.value)
    assert message.startswith(name)
    assert parameter_spec(name).allowed in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("name", "bad"), [("m", 0.0), ("m", -1.0), ("k2", 0.0), ("k3", -1e-9), ("c1", -0.1), ("mu", -1)]
)
def test_values_out_of_bounds_are_refused_with_the_allowed_range(name: str, bad: float) -> None:
    with pytest.raises(InputError, match="must be"):
        Parameters(**{name: bad})


def test_bounds_themselves_are_allowed() -> None:
    for name, spec in PARAMETERS.items():
        assert spec.check(spec.upper) == spec.upper
        assert Parameters().with_values({name: spec.lower}).as_dict()[name] == spec.lower


INTERVALS = {name: (spec, spec.check) for name, spec in PARAMETERS.items()} | {
    "t_end": (T_END_INTERVAL, check_horizon),
    "tol": (tolerance_interval(), check_tolerance),
}


@pytest.mark.parametrize("name", INTERVALS)
def test_the_first_number_beyond_a_bound_is_refused(name: str) -> None:
    interval, check = INTERVALS[name]
    is_open = isinstance(interval, Interval) and interval.lower_open
    lowest = math.nextafter(interval.lower, math.inf) if is_open else interval.lower
    for bound, direction in ((lowest, -math.inf), (interval.upper, math.inf)):
        assert check(bound) == bound
        with pytest.raises(InputError, match="must be"):
            check(math.nextafter(bound, direction))


def test_text_of_a_number_is_accepted() -> None:
    assert Parameters().with_values({"F": " 1.2e2 "}).F == 120.0


@pytest.mark.parametrize(("wrong", "near"), [("knl", "k_nl"), ("f", "F"), ("K1", "k1")])
def test_an_unknown_name_suggests_the_nearest(wrong: str, near: str) -> None:
    with pytest.raises(InputError, match=rf"did you mean {near}\?"):
        parameter_spec(wrong)


@pytest.mark.parametrize("far", ["foo", "fo", "preload", "kg", "mass", "x"])
def test_a_name_unlike_any_parameter_gets_no_suggestion(far: str) -> None:
    with pytest.raises(InputError, match=rf"^unknown parameter '{far}' \(known: m, k1, "):
        parameter_spec(far)
