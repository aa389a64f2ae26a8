"""C headers with the equations of `fivtui.model.field`, generated when the kernel is compiled.

Each function is evaluated on expressions, and its derivative on pairs of expressions. So the kernel
and the native FMU have the same equations as Python. The build hook imports this module, so it uses
only the standard library.
"""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, NamedTuple

from fivtui.model import field as equations
from fivtui.model.modes import Mode
from fivtui.model.parameters import ALL_PARAMETERS, PARAMETERS
from fivtui.taylor.expression import Expression, ReflectedOperators, expression
from fivtui.taylor.recurrence import Terms, motion_recurrence

# Compiler options. Contraction is off, so that every compiler gives the same bits.
FLAGS: Final = (
    *("-std=c11", "-O3", "-g0", "-fPIC", "-fvisibility=hidden", "-Wall", "-Wno-psabi"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fno-strict-aliasing"),
    "-fomit-frame-pointer",
)
_COMMA: Final = ",\n        "


class Dual(ReflectedOperators):
    """An expression with its derivative (a dual number); operators differentiate."""

    __slots__ = ("slope", "value")

    def __init__(self, value: Expression, slope: Expression) -> None:
        self.value, self.slope = value, slope

    def __neg__(self) -> "Dual":
        return Dual(-self.value, -self.slope)

    def __add__(self, operand: object) -> "Dual":
        b = _dual(operand)
        return Dual(self.value + b.value, self.slope + b.slope)

    def __sub__(self, operand: object) -> "Dual":
        b = _dual(operand)
        return Dual(self.value - b.value, self.slope - b.slope)

    def __mul__(self, operand: object) -> "Dual":
        b = _dual(operand)
        return Dual(self.value * b.value, self.slope * b.value + self.value * b.slope)

    def __truediv__(self, operand: object) -> "Dual":
        b = _dual(operand)
        quotient = self.value / b.value
        return Dual(quotient, (self.slope - quotient * b.slope) / b.value)

    def exp(self) -> "Dual":
        """The exponential with its derivative."""
        value = self.value.exp()
        return Dual(value, value * self.slope)

    def _operand(self, value: object) -> "Dual":
        # For operators of the base class whose left operand is a number.
        return _dual(value)


def _dual(value: object) -> Dual:
    return value if isinstance(value, Dual) else Dual(expression(value), expression(0.0))


def column(name: str) -> str:
    """C name of the column of a parameter."""
    return f"P_{name.upper()}"


def _symbols(prefix: str) -> dict[str, Expression]:
    # C expressions of the parameters in an array of this name.
    return {name: Expression(f"{prefix}[{column(name)}]") for name in ALL_PARAMETERS}


def _namespace(values: Mapping[str, Any], *, by_law: bool = False) -> SimpleNamespace:
    # The parameters as attributes, with or without a friction law. The equations of friction read
    # the static coefficient as `mu_static`; in C it is always given, in the column of μ_s.
    friction = {"v_s": values["v_s"] if by_law else None, "mu_static": values["mu_s"]}
    return SimpleNamespace(**{**values, **friction})


class Function(NamedTuple):
    """A C function of parameters and of the named numbers, and the Python function it equals.

    With `has_change` its derivative is generated too, as `NAME_change`.
    """

    compute: Callable[..., Any]
    arguments: Sequence[str] = ()
    has_change: bool = False


# By name in C. `tangent_slope` is the derivative of the tangent stiffness by y; `rest_cubic` and
# `rest_linear` are α and β of the equilibrium, α y³ + β y + load = 0.
_FUNCTIONS: Final[Mapping[str, Function]] = {
    "load_of": Function(equations.load, (), True),
    "coupling_stiffness": Function(equations.coupling_stiffness),
    "horizontal_stiffness": Function(equations.horizontal_stiffness),
    "total_stiffness": Function(equations.total_stiffness),
    "suspension_stiffness": Function(equations.suspension_stiffness, (), True),
    "spring_force": Function(equations.spring_force, ("y",), True),
    "tangent_stiffness": Function(equations.tangent_stiffness, ("y",)),
    "tangent_slope": Function(equations.tangent_slope, ("y",)),
    "horizontal_acceleration": Function(
        equations.horizontal_acceleration, ("x", "vx", "y", "friction"), True
    ),
    "vertical_acceleration": Function(
        equations.vertical_acceleration, ("x", "y", "vy", "force"), True
    ),
    "holding_force": Function(
        lambda p, x, y, speed_rate: equations.holding_force(
            p, x, y, equations.Rates(v_belt=speed_rate)
        ),
        ("x", "y", "speed_rate"),
        True,
    ),
    "holding_force_rate": Function(equations.holding_force_rate, ("acceleration", "vx", "vy")),
    "rest_position": Function(equations.rest_position, ("y", "friction"), True),
    "rest_cubic": Function(lambda p, mu: equations.rest_coefficients(p, mu)[0], ("mu",), True),
    "rest_linear": Function(lambda p, mu: equations.rest_coefficients(p, mu)[1], ("mu",), True),
}
_FRICTION: Final = Function(equations.friction_coefficient, ("speed",), True)
# The law for which `friction.h` and `driven.h` have tuned recurrences: written by hand, faster than
# generated ones.
_TUNED_LAW: Final = "p[P_MU] + (p[P_MU_S] - p[P_MU]) * exponential(-speed / p[P_V_S])"


def _value_text(function: Function, *, by_law: bool = False) -> str:
    p = _namespace(_symbols("p"), by_law=by_law)
    return expression(function.compute(p, *map(Expression, function.arguments))).text


def _change_text(function: Function, *, by_law: bool = False) -> str:
    slopes = _symbols("q")
    duals = {name: Dual(value, slopes[name]) for name, value in _symbols("p").items()}
    numbers = [Dual(Expression(name), Expression(f"d{name}")) for name in function.arguments]
    return _dual(function.compute(_namespace(duals, by_law=by_law), *numbers)).slope.text


def _define(name: str, function: Function, value: str) -> str:
    arguments = "".join(f", double {argument}" for argument in function.arguments)
    return f"INLINE double {name}(const double *p{arguments})\n{{\n    return {value};\n}}\n"


def _define_change(name: str, function: Function, change: str) -> str:
    arguments = "".join(f", double {number}, double d{number}" for number in function.arguments)
    return (
        f"INLINE double {name}_change(const double *p, const double *q{arguments})\n"
        f"{{\n    return {change};\n}}\n"
    )


def _function_definitions() -> list[str]:
    texts = [_define(name, f, _value_text(f)) for name, f in _FUNCTIONS.items()]
    texts += [
        _define_change(name, f, _change_text(f)) for name, f in _FUNCTIONS.items() if f.has_change
    ]
    # v_s = 0 means constant friction. With several lanes `exponential` takes vectors, not numbers.
    name, f = "friction_coefficient", _FRICTION
    value, change = (
        f"p[P_V_S] > 0.0 ? {text(f, by_law=True)} : {text(f)}"
        for text in (_value_text, _change_text)
    )
    scalar = [_define(name, f, value), _define_change(name, f, change)]
    return [*texts, "#if LANES == 1\n", *scalar, "#endif\n"]


def _coefficient_functions() -> list[str]:
    # C functions: the coefficients of each mode, those of a mode given by its number, and their
    # derivative in the direction q of the parameters.
    values, slopes = _symbols("p"), _symbols("q")
    duals = {name: Dual(value, slopes[name]) for name, value in values.items()}
    p, varied = _namespace(values), _namespace(duals)
    head = "INLINE Coefficients"
    texts: list[str] = []
    coefficients_by_mode: dict[str, str] = {}
    changes_by_mode: dict[str, str] = {}
    for mode in Mode:
        name = f"{mode.name.lower()}_coefficients"
        coefficients = _COMMA.join(expression(value).text for value in equations.field(p, mode))
        texts.append(
            f"{head} {name}(const double *p)\n{{\n"
            f"    return (Coefficients){{\n        {coefficients}}};\n}}\n"
        )
        changes = _COMMA.join(_dual(value).slope.text for value in equations.field(varied, mode))
        coefficients_by_mode[mode.name] = f"{name}(p)"
        changes_by_mode[mode.name] = f"(Coefficients){{\n        {changes}}}"
    for signature, results in (
        ("coefficients_in(int mode, const double *p)", coefficients_by_mode),
        ("changes_in(int mode, const double *p, const double *q)", changes_by_mode),
    ):
        *cases, (_, final) = results.items()
        lines = [f"    if (mode == {mode})\n        return {result};" for mode, result in cases]
        body = "\n".join([*lines, f"    return {final};"])
        texts.append(f"{head} {signature}\n{{\n{body}\n}}\n")
    return texts


def _field_header() -> str:
    columns = [column(name) for name in PARAMETERS]
    optional = [column(name) for name in ALL_PARAMETERS if name not in PARAMETERS]
    modes = ", ".join(mode.name for mode in Mode)
    parts = [
        "/* The equations of `fivtui.model.field`, generated by `fivtui.kernel.field_text`. */\n",
        "#ifndef FIVTUI_FIELD_H\n#define FIVTUI_FIELD_H\n",
        '#include "exponential.h"\n',
        f"/* Columns of parameters, then those of a belt of finite speed. */\nenum {{\n"
        f"    {', '.join(columns)}, PARAMETERS,\n    {optional[0]} = PARAMETERS, "
        f"{', '.join(optional[1:])}, BELT_PARAMETERS\n}};\n",
        f"enum {{ {modes}, MODES }};\n",
        f"/* Coefficients: `Field` in `fivtui.model.field`. */\ntypedef struct {{\n"
        f"    double {', '.join(equations.Field._fields)};\n}} Coefficients;\n",
        f"/* Slopes over time: `Rates` in `fivtui.model.field`. */\ntypedef struct {{\n"
        f"    double {', '.join(equations.Rates._fields)};\n}} Rates;\n",
        *_function_definitions(),
        *_coefficient_functions(),
        "#endif\n",
    ]
    return "\n".join(parts)


def has_tuned_law() -> bool:
    """Whether the kernel has tuned recurrences for the friction law; if not, generated ones."""
    return _value_text(_FRICTION, by_law=True) == _TUNED_LAW


def _c_name(group: str, name: str) -> str:
    if group == "rates":
        return f"rates->{name}"
    return f"p[{column('mu_s' if name == 'mu_static' else name)}]"


def _expansion_text(mode: Mode) -> str:
    # The C function that expands a sliding motion with a friction law from its start.
    terms = Terms(by_law=True, finite_belt=True, over_time=True)
    recurrence, ax, ay = motion_recurrence(terms, mode, _c_name)
    lines = [f"const double {name} = {text};" for name, text in recurrence.constants.items()]
    for name, (value, slope) in recurrence.linear.items():
        lines.append(f"const double {name}[MAX_TERMS] = {{{value}, {slope}}};")
    lines += [f"double {name}[MAX_TERMS];" for name in recurrence.statements]
    lines.append("for (int n = 0; n < order; n++) {")
    lines += [f"    {name}[n] = {text};" for name, text in recurrence.statements.items()]
    lines += [
        f"    const double ax = {ax.value.text}, ay = {ay.value.text};",
        "    x[n + 2] = ax / ((n + 1) * (n + 2)), y[n + 2] = ay / ((n + 1) * (n + 2));",
        "}",
    ]
    head = f"INLINE void expand_{mode.name.lower()}(const double *p, const Rates *rates, double *x,"
    body = "\n    ".join(lines)
    return f"{head}\n    double *y, int order)\n{{\n    {body}\n}}\n"


def _expansion_texts() -> list[str]:
    # With several lanes `power_series.h` has no recurrences: runs by such a law are single runs.
    functions = map(_expansion_text, (Mode.FORWARD, Mode.BACKWARD))
    return ["#if LANES == 1\n", *functions, "#endif\n"]


def _recurrence_header() -> str:
    tuned = has_tuned_law()
    parts = [
        "/* Recurrences for a friction law without tuned ones, which are written by hand in\n"
        "   `friction.h` and `driven.h`. Generated by `fivtui.kernel.field_text`. */\n",
        "#ifndef FIVTUI_RECURRENCE_H\n#define FIVTUI_RECURRENCE_H\n",
        '#include "power_series.h"\n',
        f"#define LAW_IS_TUNED {int(tuned)}\n",
        *([] if tuned else _expansion_texts()),
        "#endif\n",
    ]
    return "\n".join(parts)


def equation_headers() -> dict[str, str]:
    """The generated headers by name."""
    return {"field.h": _field_header(), "recurrence.h": _recurrence_header()}


def sources_digest(folder: Path) -> str:
    """Digest of the kernel's sources, by which an outdated library is recognised."""
    content = hashlib.sha256()
    texts = {path.name: path.read_bytes() for path in [*folder.glob("*.c"), *folder.glob("*.h")]}
    texts |= {name: text.encode() for name, text in equation_headers().items()}
    for name, text in sorted(texts.items()):
        content.update(name.encode() + b"\0" + text.replace(b"\r\n", b"\n"))
    return content.hexdigest()[:32]
