"""The equations of `fivtui.model.field` as text in C: the header `field.h`, made at the build.

Each function is evaluated on expressions, and its derivative on pairs of expressions, so that the
kernel and the native FMU have the same equations as Python. Imported by the build hook, so that it
needs the standard library alone.
"""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

from fivtui.model import field as equations
from fivtui.model.modes import MODES, Mode
from fivtui.model.parameters import ALL_PARAMETERS, PARAMETERS
from fivtui.taylor.expression import Expression, expression

FIELD_HEADER: Final = "field.h"
_MOTION: Final = ("x", "y", "vx", "vy")


class Dual:
    """An expression with its derivative."""

    __slots__ = ("slope", "value")

    def __init__(self, value: Expression, slope: Expression) -> None:
        self.value, self.slope = value, slope

    def __neg__(self) -> "Dual":
        return Dual(-self.value, -self.slope)

    def __add__(self, other: object) -> "Dual":
        b = _dual(other)
        return Dual(self.value + b.value, self.slope + b.slope)

    def __sub__(self, other: object) -> "Dual":
        b = _dual(other)
        return Dual(self.value - b.value, self.slope - b.slope)

    def __mul__(self, other: object) -> "Dual":
        b = _dual(other)
        return Dual(self.value * b.value, self.slope * b.value + self.value * b.slope)

    def __truediv__(self, other: object) -> "Dual":
        b = _dual(other)
        quotient = self.value / b.value
        return Dual(quotient, (self.slope - quotient * b.slope) / b.value)

    def __radd__(self, other: object) -> "Dual":
        return _dual(other) + self

    def __rsub__(self, other: object) -> "Dual":
        return _dual(other) - self

    def __rmul__(self, other: object) -> "Dual":
        return _dual(other) * self

    def __rtruediv__(self, other: object) -> "Dual":
        return _dual(other) / self


def _dual(value: object) -> Dual:
    return value if isinstance(value, Dual) else Dual(expression(value), expression(0.0))


def column(name: str) -> str:
    """Name in C of the column of a parameter."""
    return f"P_{name.upper()}"


def _named(prefix: str) -> dict[str, Expression]:
    return {name: Expression(f"{prefix}[{column(name)}]") for name in ALL_PARAMETERS}


def _parameters(values: Mapping[str, Any]) -> SimpleNamespace:
    return SimpleNamespace(**values, mu_static=values["mu_s"])


# Functions of parameters and other numbers, by their names in C: what is called with them, and the
# names of the numbers.
_FUNCTIONS: Final[Mapping[str, tuple[Any, Sequence[str]]]] = {
    "load_of": (equations.load, ()),
    "coupling_of": (equations.coupling_stiffness, ()),
    "horizontal_stiffness": (equations.horizontal_stiffness, ()),
    "total_stiffness": (equations.total_stiffness, ()),
    "suspension_stiffness": (equations.suspension_stiffness, ()),
    "spring_force": (equations.spring_force, ("y",)),
    "tangent_stiffness": (equations.tangent_stiffness, ("y",)),
    "tangent_slope": (equations.tangent_slope, ("y",)),
    "horizontal_acceleration": (
        equations.horizontal_acceleration,
        ("x", "vx", "y", "friction"),
    ),
    "vertical_acceleration": (equations.vertical_acceleration, ("x", "y", "vy", "force")),
    "holding_force": (
        lambda p, x, y, speed_rate: equations.holding_force(
            p, x, y, equations.Rates(v_belt=speed_rate)
        ),
        ("x", "y", "speed_rate"),
    ),
    "holding_force_rate": (equations.holding_force_rate, ("acceleration", "vx", "vy")),
    "rest_position": (equations.rest_position, ("y", "friction")),
    "rest_cubic": (lambda p, mu: equations.rest_coefficients(p, mu)[0], ("mu",)),
    "rest_linear": (lambda p, mu: equations.rest_coefficients(p, mu)[1], ("mu",)),
}


def _function(name: str, function: Any, arguments: Sequence[str]) -> str:
    values = [Expression(argument) for argument in arguments]
    text = expression(function(_parameters(_named("p")), *values)).text
    given = "".join(f", double {argument}" for argument in arguments)
    return f"INLINE double {name}(const double *p{given})\n{{\n    return {text};\n}}\n"


def _derivative(name: str, function: Any, arguments: Sequence[str]) -> str:
    slopes = _named("q")
    parameters = {each: Dual(value, slopes[each]) for each, value in _named("p").items()}
    values = [Dual(Expression(each), Expression(f"d{each}")) for each in arguments]
    text = _dual(function(_parameters(parameters), *values)).slope.text
    given = "".join(f", double {each}, double d{each}" for each in arguments)
    return (
        f"INLINE double {name}_change(const double *p, const double *q{given})\n"
        f"{{\n    return {text};\n}}\n"
    )


def _coefficients(mode: Mode) -> list[str]:
    # The coefficients of a mode, and how they change with parameters p that change by q.
    name = mode.name.lower()
    values = _named("p")
    slopes = _named("q")
    c = equations.field(_parameters(values), mode)
    changes = equations.field(
        _parameters({each: Dual(value, slopes[each]) for each, value in values.items()}), mode
    )
    texts = ",\n        ".join(expression(value).text for value in c)
    of_changes = ",\n        ".join(_dual(value).slope.text for value in changes)
    head = f"INLINE Coefficients {name}"
    return [
        f"{head}_coefficients(const double *p)\n{{\n"
        f"    return (Coefficients){{\n        {texts}}};\n}}\n",
        f"{head}_changes(const double *p, const double *q)\n{{\n"
        f"    return (Coefficients){{\n        {of_changes}}};\n}}\n",
    ]


def field_header() -> str:
    """The text of `field.h`."""
    columns = [column(name) for name in PARAMETERS]
    optional = [column(name) for name in ALL_PARAMETERS if name not in PARAMETERS]
    modes = ", ".join(mode.name for mode in Mode)
    names = ", ".join(equations.Field._fields)
    parts = [
        "/* The equations of `fivtui.model.field`, made by `fivtui.kernel.field_text`. */\n",
        "#ifndef FIVTUI_FIELD_H\n#define FIVTUI_FIELD_H\n",
        '#include "vector.h"\n',
        f"/* Columns of parameters; behind them those of a belt of finite speed. */\nenum {{\n"
        f"    {', '.join(columns)}, PARAMETERS,\n    {optional[0]} = PARAMETERS, "
        f"{', '.join(optional[1:])}, BELT_PARAMETERS\n}};\n",
        f"enum {{ {modes}, MODES }};\n",
        f"/* As `fivtui.model.field.Field`. */\ntypedef struct {{\n    double {names};\n"
        "} Coefficients;\n",
        *(_function(name, *rest) for name, rest in _FUNCTIONS.items()),
        *(_derivative(name, *rest) for name, rest in _FUNCTIONS.items()),
        *(text for mode in MODES for text in _coefficients(mode)),
        "#endif\n",
    ]
    return "\n".join(parts)


def sources_digest(folder: Path) -> str:
    """The digest of the kernel's text, by which a library that is older than it is recognised."""
    content = hashlib.sha256()
    texts = {path.name: path.read_bytes() for path in [*folder.glob("*.c"), *folder.glob("*.h")]}
    texts[FIELD_HEADER] = field_header().encode()
    for name, text in sorted(texts.items()):
        content.update(name.encode() + b"\0" + text.replace(b"\r\n", b"\n"))
    return content.hexdigest()[:32]
