"""The table of variables of the slider-belt model."""

import math
from collections.abc import Sequence
from typing import Final

from fivtui.model.columns import COLUMNS
from fivtui.model.modes import Mode
from fivtui.model.numbers import Interval
from fivtui.model.parameters import BELT_PARAMETERS, PARAMETERS, ParameterSpec

from .variable import Role, Type, Variable, VariableTable

SUMMARY: Final = (
    "Slider pressed on a moving belt: friction-induced vibration by mode coupling, "
    "with a cubic contact stiffness and separation"
)
# The range of the mode's numbers.
_MODES: Final = (float(min(Mode)), float(max(Mode)))
# Parameters of the model that may change at every communication point.
INPUTS: Final = ("F", "mu", "v_belt")
STATES: Final = ("x", "vx", "y", "vy")
_STARTS: Final = tuple(f"{name}_start" for name in STATES)
# What an equilibrium under μ = 0 depends on.
_EQUILIBRIUM: Final = ("k1", "k2", "k3", "k_nl", "F", "separation")
_DIMENSIONLESS: Final = "1"
# What friction, and whether the slider sticks, depend on where the belt has a finite speed.
_BELT: Final = ("finite_belt", "v_belt", "mu_s")
_FRICTION: Final = ("c1", "mu", *_BELT)
_AT_REST: Final = ("start_static", *_EQUILIBRIUM)
_FORCE_ORIGIN: Final = (*_AT_REST, *_STARTS)
_MODE_ORIGIN: Final = (*_FORCE_ORIGIN, *_FRICTION, "m", "c2")
# Of a belt of finite speed. No Real can be none: a flag says whether there is a speed, and 0 stands
# for none in the others, which it is in the limit of small values, too.
_BELT_MEANINGS: Final = {
    "v_belt": "speed of the belt, if finite_belt",
    "mu_s": "static friction coefficient, if finite_belt: at least mu, or 0 for mu",
    "v_s": "sliding speed over which friction falls from mu_s to mu, if finite_belt; 0: at once",
}


def _parameters() -> list[Variable]:
    return [
        Variable(
            name=name,
            type=Type.REAL,
            role=Role.INPUT if name in INPUTS else Role.PARAMETER,
            meaning=spec.meaning,
            unit=spec.unit or _DIMENSIONLESS,
            start=spec.default,
            lower=spec.lower,
            upper=spec.upper,
            allowed=spec.allowed,
            nominal=abs(spec.default) or None,
        )
        for name, spec in PARAMETERS.items()
    ]


def _settings() -> list[Variable]:
    columns = {column.name: column for column in COLUMNS}
    flags = [
        Variable(
            name="separation",
            type=Type.BOOLEAN,
            role=Role.PARAMETER,
            meaning="whether the slider may separate from the belt (Case 1) or not (Case 2)",
            start=True,
            allowed="true or false",
        ),
        Variable(
            name="start_static",
            type=Type.BOOLEAN,
            role=Role.PARAMETER,
            meaning="whether to start at rest at the equilibrium of mu = 0 under F, "
            "or from the start values",
            start=True,
            allowed="true or false",
        ),
    ]
    return flags + [
        Variable(
            name=f"{name}_start",
            type=Type.REAL,
            role=Role.PARAMETER,
            meaning=f"{columns[name].meaning} at the start, if start_static is false",
            unit=columns[name].unit,
            allowed=f"a finite number of {columns[name].unit}",
            nominal=_NOMINAL[columns[name].unit],
        )
        for name in STATES
    ]


# Typical sizes in the base scene.
_NOMINAL: Final = {"m": 1.0, "m/s": 10.0, "N": 100.0, "s": 1.0, _DIMENSIONLESS: 1.0}


def _outputs() -> list[Variable]:
    columns = {column.name: column for column in COLUMNS}

    def output(
        name: str,
        meaning: str,
        unit: str,
        starts_from: Sequence[str],
        *,
        discrete: bool = False,
        depends_on: tuple[str, ...] = (),
        bounds: tuple[float, float] = (-math.inf, math.inf),
        derivative_of: str = "",
    ) -> Variable:
        return Variable(
            name=name,
            type=Type.REAL,
            role=Role.OUTPUT,
            meaning=meaning,
            unit=unit,
            lower=bounds[0],
            upper=bounds[1],
            nominal=_NOMINAL[unit],
            discrete=discrete,
            depends_on=depends_on,
            starts_from=tuple(starts_from),
            derivative_of=derivative_of,
            varies_with=(name,) if derivative_of else (),
        )

    origin = {
        "x": (*_AT_REST, "x_start"),
        "vx": ("start_static", "vx_start"),
        "y": (*_AT_REST, "y_start"),
        "vy": ("start_static", "vy_start"),
        "P": _FORCE_ORIGIN,
        "friction": (*_FORCE_ORIGIN, *_FRICTION, "v_s"),
        "mode": _MODE_ORIGIN,
    }
    count = (0.0, math.inf)
    mode, y, force = columns["mode"], columns["y"], columns["P"]
    on_belt = ("mu", "v_belt")
    return [
        output("x", columns["x"].meaning, "m", origin["x"]),
        output("vx", columns["vx"].meaning, "m/s", origin["vx"], derivative_of="x"),
        output("y", y.meaning, "m", origin["y"]),
        output("vy", columns["vy"].meaning, "m/s", origin["vy"], derivative_of="y"),
        output("P", force.meaning, force.unit, origin["P"]),
        output(
            "friction_slider",
            "friction force of the belt on the slider, mu P; if finite_belt, that of the mode",
            force.unit,
            origin["friction"],
            depends_on=on_belt,
        ),
        output(
            "friction_belt",
            "friction force of the slider on the belt, -mu P; if finite_belt, that of the mode",
            force.unit,
            origin["friction"],
            depends_on=on_belt,
        ),
        output(
            "mode",
            mode.meaning,
            mode.unit,
            origin["mode"],
            discrete=True,
            depends_on=on_belt,
            bounds=_MODES,
        ),
        output(
            "switching",
            "switching function y: negative in contact, positive when separated",
            y.unit,
            origin["y"],
        ),
        output(
            "separations",
            "number of separations so far",
            _DIMENSIONLESS,
            (),
            discrete=True,
            bounds=count,
        ),
        output(
            "reattachments",
            "number of reattachments so far",
            _DIMENSIONLESS,
            (),
            discrete=True,
            bounds=count,
        ),
        output(
            "last_event",
            "time of the last separation, reattachment or other change of the mode, "
            "the start time before the first",
            columns["t"].unit,
            (),
            discrete=True,
        ),
    ]


def _locals() -> list[Variable]:
    columns = {column.name: column for column in COLUMNS}
    mode = columns["mode"]

    def mirror(name: str, kind: Type, items: tuple[str, ...] = ()) -> Variable:
        # Local, so that hosts do not record it by default: every type costs a call per sample.
        return Variable(
            name=name,
            type=kind,
            role=Role.LOCAL,
            meaning=f"mode as an {kind.value.lower()}: {mode.meaning}",
            lower=int(min(Mode)),
            upper=int(max(Mode)),
            discrete=True,
            items=items,
        )

    def acceleration(
        axis: str, adjective: str, starts_from: tuple[str, ...], varies_with: tuple[str, ...]
    ) -> Variable:
        return Variable(
            name=f"a{axis}",
            type=Type.REAL,
            role=Role.LOCAL,
            meaning=f"{adjective} acceleration",
            unit="m/s^2",
            nominal=50.0,
            starts_from=("start_static", "separation", *starts_from, "x_start", "y_start"),
            derivative_of=f"v{axis}",
            varies_with=varies_with,
        )

    return [
        mirror("mode_integer", Type.INTEGER),
        mirror("mode_enumeration", Type.ENUMERATION, tuple(m.name.lower() for m in Mode)),
        acceleration(
            "x",
            "horizontal",
            ("m", "k1", "k2", "k3", "k_nl", "F", "vx_start", *_FRICTION, "v_s"),
            ("x", "vx", "y", "mu", "v_belt"),
        ),
        # Without k1: the equilibrium depends on it, but the acceleration is zero there.
        acceleration(
            "y",
            "vertical",
            ("m", "k2", "k3", "k_nl", "c2", "F", "vy_start"),
            ("x", "y", "vy", "F"),
        ),
    ]


def _belt() -> list[Variable]:
    def parameter(name: str, spec: ParameterSpec) -> Variable:
        is_input = name in INPUTS
        return Variable(
            name=name,
            type=Type.REAL,
            role=Role.INPUT if is_input else Role.PARAMETER,
            meaning=_BELT_MEANINGS[name],
            unit=spec.unit or _DIMENSIONLESS,
            start=spec.default if is_input else 0.0,
            # Zero stands for none.
            lower=0.0,
            upper=spec.upper,
            allowed=str(Interval(0.0, spec.upper, spec.unit)),
            nominal=spec.default,
        )

    def count(name: str, meaning: str, starts_from: Sequence[str]) -> Variable:
        return Variable(
            name=name,
            type=Type.REAL,
            role=Role.OUTPUT,
            meaning=meaning,
            unit=_DIMENSIONLESS,
            lower=0.0,
            nominal=1.0,
            discrete=True,
            starts_from=tuple(starts_from),
        )

    flag = Variable(
        name="finite_belt",
        type=Type.BOOLEAN,
        role=Role.PARAMETER,
        meaning="whether the belt has a finite speed, v_belt, or is always faster than the slider",
        start=False,
        allowed="true or false",
    )
    return [
        flag,
        *(parameter(name, spec) for name, spec in BELT_PARAMETERS.items()),
        count("switches", "number of changes of the mode so far", ()),
        count(
            "sticks",
            "number of times that the slider has begun to stick so far, at the start included",
            _MODE_ORIGIN,
        ),
    ]


# What is added stands at the end: value references are places in the table.
SLIDER_BELT_TABLE: Final = VariableTable(
    [*_parameters(), *_settings(), *_outputs(), *_locals(), *_belt()]
)
VARIABLES: Final = SLIDER_BELT_TABLE.variables
REFERENCES: Final = SLIDER_BELT_TABLE.references
