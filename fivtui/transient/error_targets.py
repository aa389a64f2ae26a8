"""Accuracy as a wish: the errors that may be asked for, and the tolerances tried for them."""

from collections.abc import Mapping
from typing import Final

from fivtui.model.errors import InputError
from fivtui.model.parameters import parse_number, unknown_name

from .deviation import QUANTITIES
from .request import TOL_RANGE

# What the first tolerance is below the least error asked for: errors of one run are up to twenty
# times its tolerance.
_MARGIN: Final = 100.0
_FINER: Final = 100.0
_APART: Final = 10.0


def check_accuracy(asked: Mapping[str, object]) -> dict[str, float]:
    """Check errors that are asked for.

    Parameters
    ----------
    asked : mapping of str to float or str
        Error allowed, above 0 and at most 1, by quantity: ``final``, ``peak`` and ``half_range``
        relative, ``events`` in s.

    Returns
    -------
    dict
        The same as numbers.

    Raises
    ------
    InputError
        If a quantity is unknown or an error not allowed.
    """
    return {check_quantity(name): check_error(name, value) for name, value in asked.items()}


def first_tol(asked: Mapping[str, float]) -> float:
    """The tolerance of the first run.

    Parameters
    ----------
    asked : mapping of str to float
        Errors allowed, by quantity.

    Returns
    -------
    float
        A hundredth of the least error, and not the finest tolerance, so that there is a finer one.
    """
    wish = min(asked.values(), default=TOL_RANGE[1])
    return min(max(wish / _MARGIN, TOL_RANGE[0] * _FINER), TOL_RANGE[1])


def finer_tol(tol: float) -> float:
    """The tolerance of the run that verifies another.

    Parameters
    ----------
    tol : float
        Of the other.

    Returns
    -------
    float
        A hundredth of it; the finest that is allowed if that is next to it, or beyond: two runs
        at nearly the same tolerance tell nothing of each other.
    """
    finer, least = tol / _FINER, TOL_RANGE[0]
    return finer if finer > _APART * least else least


def check_quantity(name: str) -> str:
    """Check the name of a quantity that has an error.

    Parameters
    ----------
    name : str
        The name.

    Returns
    -------
    str
        The same.

    Raises
    ------
    InputError
        If it is not in `QUANTITIES`; the nearest is suggested.
    """
    if name not in QUANTITIES:
        raise unknown_name("quantity", name, QUANTITIES)
    return name


def check_error(name: str, value: object) -> float:
    """Check an error that is asked for.

    Parameters
    ----------
    name : str
        The quantity it is of, for the message.
    value : float or str
        The error.

    Returns
    -------
    float
        The same as a number.

    Raises
    ------
    InputError
        If it is not above zero and at most 1.
    """
    allowed = "0 < error <= 1"
    number = parse_number(f"error of {name}", value, allowed)
    if not 0.0 < number <= 1.0:
        raise InputError(f"error of {name} = {number:g}: allowed is {allowed}")
    return number
