"""The FMU variables of the slider-belt model, and what each depends on.

FMI asks for these dependencies; they are given as names of variables.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import starmap
from typing import Any, Final

from fivtui.model.columns import COLUMNS
from fivtui.model.modes import Mode
from fivtui.model.over_time import LINEAR_OVER_TIME
from fivtui.model.parameters import BELT_PARAMETERS, PARAMETERS, ParameterSpec

from .variable import DIMENSIONLESS, Role, Type, Variable, VariableTable

SUMMARY: Final = (
    "Slider pressed on a moving belt: friction-induced vibration by mode coupling, "
    "with a cubic contact stiffness and separation"
)
_COLUMNS: Final = {column.name: column for column in COLUMNS}
# Inputs, which may change at every communication point, as may all other parameters but the mass.
INPUTS: Final = LINEAR_OVER_TIME
_FIXED: Final = ("m",)
STATES: Final = ("x", "vx", "y", "vy")
_START_NAMES: Final = tuple(f"{name}_start" for name in STATES)
# Variables that the equilibrium for μ = 0 depends on.
_EQUILIBRIUM: Final = ("k1", "k2", "k3", "k_nl", "F", "separation")
# Variables that decide, together with the contact force, between stick and slip. Friction depends
# on them and on v_s.
_FRICTION: Final = ("c1", "mu", "finite_belt", "v_belt", "mu_s")
# Variables on which the initial position, contact force and mode depend.
_STATIC_START: Final = ("start_static", *_EQUILIBRIUM)
_INITIAL_FORCE: Final = (*_STATIC_START, *_START_NAMES)
_INITIAL_MODE: Final = (*_INITIAL_FORCE, *_FRICTION, "m", "c2")
# Variables of a belt of finite speed; the flag finite_belt enables them. An FMI Real always has a
# value, so 0 stands for an unset mu_s or v_s. An unset v_s is also the limit of small v_s.
_BELT_MEANINGS: Final = {
    "v_belt": "speed of the belt, used if finite_belt is true; negative if it runs backward",
    "mu_s": "static friction coefficient, used if finite_belt is true: at least mu, or 0 to use mu",
    "v_s": "sliding speed over which friction falls from mu_s to mu, used if finite_belt is true; "
    "with 0 it falls at once",
}
# Typical sizes by unit, under the default parameters.
_NOMINAL: Final = {
    "m": 1.0,
    "m/s": 10.0,
    "m/s^2": 50.0,
    "N": 100.0,
    "s": 1.0,
    DIMENSIONLESS: 1.0,
}


def _parameter(spec: ParameterSpec) -> Variable:
    return Variable(
        spec.name,
        Role.INPUT if spec.name in INPUTS else Role.PARAMETER,
        spec.meaning,
        spec.unit or DIMENSIONLESS,
        start=spec.default,
        lower=spec.lower,
        upper=spec.upper,
        tunable=spec.name not in (*INPUTS, *_FIXED),
        nominal=abs(spec.default) or None,
    )


def _belt_parameter(name: str, meaning: str) -> Variable:
    # 0 means unset, except for the speed.
    variable = replace(_parameter(BELT_PARAMETERS[name]), meaning=meaning)
    return variable if variable.role is Role.INPUT else replace(variable, start=0.0, lower=0.0)


def _flag(name: str, meaning: str, *, start: bool) -> Variable:
    return Variable(name, Role.PARAMETER, meaning, type=Type.BOOLEAN, start=start)


def _start_value(name: str) -> Variable:
    column = _COLUMNS[name]
    meaning = f"{column.meaning} at the start, if start_static is false"
    nominal = _NOMINAL[column.unit]
    return Variable(f"{name}_start", Role.PARAMETER, meaning, column.unit, nominal=nominal)


def _output(
    name: str,
    initial_names: Sequence[str],
    meaning: str = "",
    unit: str = "",
    role: Role = Role.OUTPUT,
    **properties: Any,
) -> Variable:
    # `initial_names` are the variables on which the initial value depends. Meaning and unit default
    # to those of the trajectory column of the same name.
    if name in _COLUMNS:
        meaning, unit = _COLUMNS[name].meaning, _COLUMNS[name].unit
    nominal = _NOMINAL[unit]
    return Variable(
        name, role, meaning, unit, nominal=nominal, start_depends_on=initial_names, **properties
    )


def _counter(name: str, meaning: str, initial_names: Sequence[str] = ()) -> Variable:
    return _output(name, initial_names, meaning, DIMENSIONLESS, discrete=True, lower=0.0)


def _velocity(axis: str) -> Variable:
    name = f"v{axis}"
    initial_names = ("start_static", f"{name}_start")
    return _output(name, initial_names, derivative_of=axis, rate_depends_on=(name,))


def _friction(name: str, meaning: str) -> Variable:
    initial_names = (*_INITIAL_FORCE, *_FRICTION, "v_s")
    meaning = f"{meaning}; if finite_belt is true, it depends on the mode"
    return _output(name, initial_names, meaning, "N", depends_on=("mu", "v_belt"))


def _acceleration(
    axis: str, adjective: str, initial_names: Sequence[str], rate_names: Sequence[str]
) -> Variable:
    return _output(
        f"a{axis}",
        ("start_static", "separation", *initial_names, "x_start", "y_start"),
        f"{adjective} acceleration",
        "m/s^2",
        Role.LOCAL,
        derivative_of=f"v{axis}",
        rate_depends_on=rate_names,
    )


def _mode(role: Role, kind: Type, value_names: Sequence[str] = ()) -> Variable:
    # The mode again, in another type. The integer is local, so that hosts do not record it by
    # default: each type costs them one more call per sample.
    name = kind.value.lower()
    return Variable(
        f"mode_{name}",
        role,
        f"mode as an {name}: {_COLUMNS['mode'].meaning}",
        type=kind,
        lower=int(min(Mode)),
        upper=int(max(Mode)),
        discrete=True,
        value_names=value_names,
        depends_on=("mu", "v_belt"),
        start_depends_on=_INITIAL_MODE,
    )


def _total(name: str, initial_names: Sequence[str], meaning: str, unit: str) -> Variable:
    return _output(name, initial_names, f"{meaning} so far", unit, total=True)


# Add new variables at the end: value references are indices in the table.
SLIDER_BELT_TABLE: Final = VariableTable(
    [
        *map(_parameter, PARAMETERS.values()),
        # Cases 1 and 2 are those of the paper "Nonlinear friction-induced vibration of a
        # slider-belt system".
        _flag(
            "separation",
            "true: the slider may separate from the belt (Case 1); false: it may not (Case 2)",
            start=True,
        ),
        _flag(
            "start_static",
            "true: start at rest at the equilibrium for mu = 0 under F; "
            "false: start from the start values",
            start=True,
        ),
        *map(_start_value, STATES),
        _output("x", (*_STATIC_START, "x_start")),
        _velocity("x"),
        _output("y", (*_STATIC_START, "y_start")),
        _velocity("y"),
        _output("P", _INITIAL_FORCE),
        _friction("friction_slider", "friction force of the belt on the slider, mu P"),
        _friction("friction_belt", "friction force of the slider on the belt, -mu P"),
        _output(
            "mode",
            _INITIAL_MODE,
            discrete=True,
            depends_on=("mu", "v_belt"),
            lower=float(min(Mode)),
            upper=float(max(Mode)),
        ),
        _output(
            "switching",
            (*_STATIC_START, "y_start"),
            "switching function y: negative in contact, positive when separated",
            "m",
        ),
        _counter("separations", "number of separations so far"),
        _counter("reattachments", "number of reattachments so far"),
        _output(
            "last_event",
            (),
            "time of the last change of the mode; before the first change, the start time",
            "s",
            discrete=True,
        ),
        _mode(Role.LOCAL, Type.INTEGER),
        _mode(Role.OUTPUT, Type.ENUMERATION, tuple(mode.name.lower() for mode in Mode)),
        _acceleration(
            "x",
            "horizontal",
            ("m", "k1", "k2", "k3", "k_nl", "F", "vx_start", *_FRICTION, "v_s"),
            ("x", "vx", "y", "mu", "v_belt"),
        ),
        # k1 acts on this acceleration only through the equilibrium, where it is zero. k2, k3 and
        # k_nl act directly at other starts.
        _acceleration(
            "y",
            "vertical",
            ("m", "k2", "k3", "k_nl", "c2", "F", "vy_start"),
            ("x", "y", "vy", "F"),
        ),
        _flag(
            "finite_belt",
            "true: the belt has the speed v_belt; false: the belt is always faster than the slider",
            start=False,
        ),
        *starmap(_belt_parameter, _BELT_MEANINGS.items()),
        _counter("switches", "number of changes of the mode so far"),
        _counter(
            "sticks",
            "number of times that the slider began to stick so far, including a start in stick",
            _INITIAL_MODE,
        ),
        _total("x_peak", (*_STATIC_START, "x_start"), "greatest |x|", "m"),
        _total("y_peak", (*_STATIC_START, "y_start"), "greatest |y|", "m"),
        # A belt that is always faster than the slider (finite_belt = false) is faster than this.
        _total("vx_max", ("start_static", "vx_start"), "greatest horizontal velocity", "m/s"),
        _total("P_min", _INITIAL_FORCE, "least contact force", "N"),
        _total("P_max", _INITIAL_FORCE, "greatest contact force", "N"),
        _total("separated_time", (), "time for which the slider was off the belt", "s"),
    ]
)
VARIABLES: Final = SLIDER_BELT_TABLE.variables
TOTALS: Final = tuple(v.name for v in VARIABLES if v.total)
REFERENCES: Final = SLIDER_BELT_TABLE.references
