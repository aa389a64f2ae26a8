"""From the values of the FMU's variables to the motion that they describe."""

from collections.abc import Mapping
from typing import Final

from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.model.slider_belt import State, static_start

from .motion import Motion
from .variable import Role
from .variables import REFERENCES, STATES, VARIABLES

Values = Mapping[int, float | bool]
_FIXED: Final = [r for r, v in enumerate(VARIABLES) if v.role is Role.PARAMETER]


def start_state(values: Values) -> State:
    """The state in which the motion begins.

    Parameters
    ----------
    values : mapping of int to float or bool
        Values of all variables by value reference.

    Returns
    -------
    State
        (x, ẋ, y, ẏ), m and m/s.

    Raises
    ------
    ComputationError
        If the start is static and there is no equilibrium.
    """
    if values[REFERENCES["start_static"]]:
        return static_start(parameters_from(values), separation=separation_in(values))
    x, vx, y, vy = (float(values[REFERENCES[f"{name}_start"]]) for name in STATES)
    return (x, vx, y, vy)


def motion_from(values: Values, state: State, *, t: float, tol: float) -> Motion:
    """The motion that the values describe.

    Parameters
    ----------
    values : mapping of int to float or bool
        Values of all variables by value reference.
    state : State
        (x, ẋ, y, ẏ) at `t`, m and m/s.
    t : float
        Time, s.
    tol : float
        Relative error to aim at.

    Returns
    -------
    Motion
        At `t`.
    """
    return Motion(parameters_from(values), state, t=t, separation=separation_in(values), tol=tol)


def fixed_values(values: Values) -> list[float]:
    """What two motions share if one can take up where the other was.

    Parameters
    ----------
    values : mapping of int to float or bool
        Values of all variables by value reference.

    Returns
    -------
    list of float
        The values of the fixed parameters.
    """
    return [values[reference] for reference in _FIXED]


def parameters_from(values: Values) -> Parameters:
    """The parameter set, inputs included.

    Parameters
    ----------
    values : mapping of int to float or bool
        Values of all variables by value reference.

    Returns
    -------
    fivtui.model.parameters.Parameters
        Every value is inside its bounds.
    """
    return Parameters(**{name: float(values[REFERENCES[name]]) for name in PARAMETERS})


def separation_in(values: Values) -> bool:
    """Whether separation is considered.

    Parameters
    ----------
    values : mapping of int to float or bool
        Values of all variables by value reference.

    Returns
    -------
    bool
        True for Case 1.
    """
    return bool(values[REFERENCES["separation"]])
