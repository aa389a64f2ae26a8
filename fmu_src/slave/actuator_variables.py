"""The table of variables of the brake actuator."""

from typing import Final

from fivtui.model.numbers import Interval
from fivtui.model.parameters import PARAMETERS

from .variable import Role, Type, Variable, VariableTable

ACTUATOR_SUMMARY: Final = (
    "Brake actuator: a force command becomes a preload, with a first-order lag and with feedback "
    "of the contact force"
)
_ANY_FORCE: Final = "a finite number of N"
_SHORTEST_LAG: Final = 1e-12
_LONGEST_LAG: Final = 1e6
_GREATEST_GAIN: Final = 1e3

_PRELOAD: Final = PARAMETERS["F"]

ACTUATOR_TABLE: Final = VariableTable(
    [
        Variable(
            name="command",
            type=Type.REAL,
            role=Role.INPUT,
            meaning="commanded contact force",
            unit="N",
            start=_PRELOAD.default,
            lower=_PRELOAD.lower,
            upper=_PRELOAD.upper,
            allowed=_PRELOAD.allowed,
            nominal=100.0,
        ),
        Variable(
            name="P",
            type=Type.REAL,
            role=Role.INPUT,
            meaning="contact force, fed back",
            unit="N",
            start=_PRELOAD.default,
            allowed=_ANY_FORCE,
            nominal=100.0,
        ),
        Variable(
            name="tau",
            type=Type.REAL,
            role=Role.PARAMETER,
            meaning="time constant of the lag",
            unit="s",
            start=0.05,
            lower=_SHORTEST_LAG,
            upper=_LONGEST_LAG,
            allowed=str(Interval(_SHORTEST_LAG, _LONGEST_LAG, "s")),
            nominal=0.05,
        ),
        Variable(
            name="gain",
            type=Type.REAL,
            role=Role.PARAMETER,
            meaning="gain of the feedback of the contact force",
            unit="1",
            start=0.1,
            lower=0.0,
            upper=_GREATEST_GAIN,
            allowed=str(Interval(0.0, _GREATEST_GAIN)),
            nominal=0.1,
        ),
        Variable(
            name="F_start",
            type=Type.REAL,
            role=Role.PARAMETER,
            meaning="preload at the start",
            unit="N",
            start=_PRELOAD.default,
            lower=_PRELOAD.lower,
            upper=_PRELOAD.upper,
            allowed=_PRELOAD.allowed,
            nominal=100.0,
        ),
        Variable(
            name="F",
            type=Type.REAL,
            role=Role.OUTPUT,
            meaning=_PRELOAD.meaning,
            unit="N",
            nominal=100.0,
            starts_from=("F_start",),
        ),
        Variable(
            name="F_rate",
            type=Type.REAL,
            role=Role.LOCAL,
            meaning="rate of the preload",
            unit="N/s",
            nominal=1e3,
            starts_from=("F_start", "command", "P", "tau", "gain"),
            derivative_of="F",
            varies_with=("F", "command", "P"),
        ),
    ]
)
