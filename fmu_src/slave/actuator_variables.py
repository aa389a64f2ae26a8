"""The FMU variables of the brake actuator, and what each depends on."""

from typing import Final

from fivtui.model.parameters import PARAMETERS

from .variable import DIMENSIONLESS, Role, Variable, VariableTable

ACTUATOR_SUMMARY: Final = (
    "Brake actuator: a force command becomes a preload, with a first-order lag and with feedback "
    "of the contact force"
)
_F: Final = PARAMETERS["F"]


def _force(name: str, role: Role, meaning: str) -> Variable:
    return Variable(
        name, role, meaning, "N", start=_F.default, lower=_F.lower, upper=_F.upper, nominal=100.0
    )


ACTUATOR_TABLE: Final = VariableTable(
    [
        _force("command", Role.INPUT, "commanded contact force"),
        Variable("P", Role.INPUT, "contact force, fed back", "N", start=_F.default, nominal=100.0),
        Variable(
            "tau",
            Role.PARAMETER,
            "time constant of the lag",
            "s",
            start=0.05,
            lower=1e-12,
            upper=1e6,
            tunable=True,
            nominal=0.05,
        ),
        Variable(
            "gain",
            Role.PARAMETER,
            "gain of the feedback of the contact force",
            DIMENSIONLESS,
            start=0.1,
            lower=0.0,
            upper=1e3,
            tunable=True,
            nominal=0.1,
        ),
        _force("F_start", Role.PARAMETER, "preload at the start"),
        Variable("F", Role.OUTPUT, _F.meaning, "N", nominal=100.0, start_depends_on=("F_start",)),
        Variable(
            "F_rate",
            Role.LOCAL,
            "rate of the preload",
            "N/s",
            nominal=1e3,
            start_depends_on=("F_start", "command", "P", "tau", "gain"),
            derivative_of="F",
            rate_depends_on=("F", "command", "P"),
        ),
    ]
)
