"""Recurrences of Taylor coefficients, made from the equations of `fivtui.model.field`.

The equations are evaluated on `Series`, which write the statements that compute their n-th
coefficients from those of lower degree: in Python here, in C in `fivtui.kernel.field_text`. They
serve all modes, friction laws and tables over time; where parameters are constant and friction
follows no law `series` is faster.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import count, repeat
from operator import mul
from types import SimpleNamespace
from typing import Any, NamedTuple

from fivtui.model.field import Rates, exponential, guard_value
from fivtui.model.modes import Guard, Mode
from fivtui.model.parameters import ALL_PARAMETERS
from fivtui.model.slider_belt import accelerations

from .expression import Expression, Reflected, expression
from .series import Coefficients, compiled

# The name of a parameter ("p") or its rate ("rates") in a language.
Naming = Callable[[str, str], str]


class Terms(NamedTuple):
    """Which terms the equations have.

    Whether friction follows a law of speed, the belt has a finite speed, and parameters follow
    tables over time.
    """

    by_law: bool
    finite_belt: bool
    over_time: bool


class Recurrence:
    """The statements of a recurrence.

    `constants` are texts of numbers by name. `lines` are texts of value and slope of linear
    functions of time. `statements` are texts of n-th coefficients in the order of computation.
    """

    def __init__(self) -> None:
        self.constants: dict[str, str] = {}
        self.lines: dict[str, tuple[str, str]] = {}
        self.statements: dict[str, str] = {}

    def constant(self, value: Expression) -> Expression:
        """A constant under a name, so that it is computed once."""
        if value.is_number:
            return value
        names = {text: name for name, text in self.constants.items()}
        name = names.get(value.text, f"c{len(self.constants)}")
        self.constants[name] = value.text
        return Expression(name)

    def line(self, value: Expression, slope: Expression) -> "Series":
        """A linear function of time, stored under a name."""
        name = f"line{len(self.lines)}"
        self.lines[name] = (value.text, slope.text)
        return Series(self, Expression(f"{name}[n]"), name)

    def stored(self, value: Expression) -> "Series":
        """A series whose n-th coefficient is computed by a statement."""
        name = f"s{len(self.statements)}"
        self.statements[name] = value.text
        return Series(self, Expression(f"{name}[n]"), name)

    def motion(self, name: str) -> tuple["Series", "Series"]:
        """A coordinate whose coefficients are known, and its velocity."""
        position = Series(self, Expression(f"{name}[n]"), name)
        return position, Series(self, Expression(f"(n + 1) * {name}[n + 1]", 2), "")


class Series(Reflected):
    """A function of time: its n-th coefficient as text, or the text of a constant.

    `array` is the name under which all coefficients are stored; empty if they are not, and None for
    a constant.
    """

    __slots__ = ("array", "recurrence", "value")

    def __init__(self, recurrence: Recurrence, value: Expression, array: str | None) -> None:
        self.recurrence, self.value, self.array = recurrence, value, array

    def __neg__(self) -> "Series":
        return Series(self.recurrence, -self.value, self.array and "")

    def __add__(self, operand: object) -> "Series":
        return self._sum(self._operand(operand), Expression.__add__)

    def __sub__(self, operand: object) -> "Series":
        return self._sum(self._operand(operand), Expression.__sub__)

    def __mul__(self, operand: object) -> "Series":
        a, b = self, self._operand(operand)
        if a.array is None or b.array is None:
            return self._linear(a, b, Expression.__mul__)
        product = f"product({a._stored()}, {b._stored()}, n)"
        return self.recurrence.stored(Expression(product))

    def __truediv__(self, operand: object) -> "Series":
        a, b = self, self._operand(operand)
        if b.array is None:
            return self._linear(a, b, Expression.__truediv__)
        numerator, denominator = a.varying()._stored(), b._stored()
        result = f"s{len(self.recurrence.statements)}"
        return self.recurrence.stored(
            Expression(f"quotient({numerator}, {denominator}, {result}, n)")
        )

    def exp(self) -> "Series":
        """The exponential of the series."""
        if self.array is None:
            return Series(self.recurrence, self.value.exp(), None)
        exponent = self._stored()
        result = f"s{len(self.recurrence.statements)}"
        return self.recurrence.stored(Expression(f"exponential_term({exponent}, {result}, n)"))

    def _operand(self, value: object) -> "Series":
        return value if isinstance(value, Series) else _constant(self.recurrence, value)

    def _sum(
        self, operand: "Series", add: Callable[[Expression, Expression], Expression]
    ) -> "Series":
        if self.array is None and operand.array is None:
            return Series(self.recurrence, add(self.value, operand.value), None)
        a, b = (side if side.value.is_zero else side.varying() for side in (self, operand))
        return Series(self.recurrence, add(a.value, b.value), "")

    def _linear(
        self, a: "Series", b: "Series", combine: Callable[[Expression, Expression], Expression]
    ) -> "Series":
        # A product or quotient with a constant operand.
        if a.array is None and b.array is None:
            return Series(self.recurrence, combine(a.value, b.value), None)
        values = [
            self.recurrence.constant(side.value) if side.array is None else side.value
            for side in (a, b)
        ]
        product = combine(values[0], values[1])
        return Series(self.recurrence, product, None if product.is_zero else "")

    def varying(self) -> "Series":
        """The series itself, or a constant as a linear function of zero slope."""
        if self.array is not None:
            return self
        return self.recurrence.line(self.recurrence.constant(self.value), expression(0.0))

    def _stored(self) -> str:
        if not self.array:
            self.array = self.recurrence.stored(self.value).array
            self.value = Expression(f"{self.array}[n]")
        assert self.array is not None  # noqa: S101
        return self.array


def motion(terms: Terms, mode: Mode, name: Naming) -> tuple[Recurrence, Series, Series]:
    """The recurrence of a mode, with the accelerations in x and y."""
    recurrence = Recurrence()
    p, rates = _parameters(recurrence, terms, name)
    (x, vx), (y, vy) = recurrence.motion("x"), recurrence.motion("y")
    state: Any = (x, vx, y, vy)
    ax, ay = accelerations(p, state, mode, rates)
    return recurrence, _series(recurrence, ax), _series(recurrence, ay)


def guard(terms: Terms, of: Guard, name: Naming) -> tuple[Recurrence, Series]:
    """The recurrence of a guard along a motion whose coefficients are known."""
    recurrence = Recurrence()
    p, rates = _parameters(recurrence, terms, name)
    (x, vx), (y, vy) = recurrence.motion("x"), recurrence.motion("y")
    value = guard_value(p, (x, vx, y, vy), of, rates)
    return recurrence, _series(recurrence, value)


def _constant(recurrence: Recurrence, value: object) -> Series:
    return Series(recurrence, expression(value), None)


def _series(recurrence: Recurrence, value: Any) -> Series:
    # Convert a value to a series that varies with time.
    return (value if isinstance(value, Series) else _constant(recurrence, value)).varying()


def _parameters(recurrence: Recurrence, terms: Terms, name: Naming) -> tuple[Any, Any]:
    # Parameters and rates as series.
    names = sorted({*ALL_PARAMETERS, *Rates._fields})
    values = {key: Expression(name("p", key)) for key in names}
    rates = dict.fromkeys(Rates._fields, _constant(recurrence, 0.0))
    p: dict[str, Series | None] = {
        key: _constant(recurrence, value) for key, value in values.items()
    }
    if terms.over_time:
        for key in rates:
            slope = Expression(name("rates", key))
            rates[key] = _constant(recurrence, slope)
            p[key] = recurrence.line(values[key], slope)
    p["v_s"] = p["v_s"] if terms.by_law else None
    p["v_belt"] = p["v_belt"] if terms.finite_belt else None
    return SimpleNamespace(**p), SimpleNamespace(**rates)


def python_name(group: str, name: str) -> str:
    """Name of a parameter or its rate in Python."""
    return f"{group}.{name}"


def _python(recurrence: Recurrence, count: str, results: Sequence[str]) -> list[str]:
    lines = [f"    {name} = {text}" for name, text in recurrence.constants.items()]
    for name, (value, slope) in recurrence.lines.items():
        lines.append(f"    {name} = [{value}, {slope}, *repeat(0.0, {count})]")
    lines += [f"    {name} = [0.0] * ({count})" for name in recurrence.statements]
    lines.append(f"    for n in range({count}):")
    lines += [f"        {name}[n] = {text}" for name, text in recurrence.statements.items()]
    return [*lines, *(f"        {line}" for line in results)]


def _function(head: str, lines: Sequence[str], returned: str) -> Callable[..., Any]:
    source = "\n".join([f"def computed({head}):", *lines, f"    return {returned}", ""])
    functions = (exponential, exponential_term, product, quotient, repeat)
    return compiled(source, "computed", **{function.__name__: function for function in functions})


@lru_cache(maxsize=64)
def motion_function(terms: Terms, mode: Mode) -> Callable[[Any, Rates, Any, int], Coefficients]:
    """The function of (p, rates, state, order) that continues a motion in a mode.

    It returns the coefficients of x and of y, order + 2 each, in m/sⁿ.
    """
    recurrence, ax, ay = motion(terms, mode, python_name)
    steps = [
        "share = 1.0 / ((n + 1) * (n + 2))",
        f"ax, ay = {ax.value.text}, {ay.value.text}",
        "x.append(ax * share)",
        "y.append(ay * share)",
    ]
    lines = ["    x, y = [state[0], state[1]], [state[2], state[3]]"]
    lines += _python(recurrence, "order", steps)
    return _function("p, rates, state, order", lines, "tuple(x), tuple(y)")


@lru_cache(maxsize=64)
def guard_function(terms: Terms, of: Guard) -> Callable[[Any, Rates, Any, Any], list[float]]:
    """The function of (p, rates, x, y) that returns a guard's coefficients in 1/sⁿ.

    The motion has the coefficients x and y in m/sⁿ; there are as many for the guard.
    """
    recurrence, value = guard(terms, of, python_name)
    lines = ["    x, c = [*x, 0.0], []"]
    lines += _python(recurrence, "len(y)", [f"c.append({value.value.text})"])
    return _function("p, rates, x, y", lines, "c")


def product(a: Sequence[Any], b: Sequence[Any], n: int) -> Any:
    """The n-th coefficient of a product."""
    return sum(map(mul, a, b[n::-1]))


def quotient(a: Sequence[Any], b: Sequence[Any], ratio: Sequence[Any], n: int) -> Any:
    """The n-th coefficient of the ratio a/b from the lower coefficients."""
    lower_terms = sum(map(mul, b[1 : n + 1], ratio[n - 1 :: -1])) if n else 0.0
    return (a[n] - lower_terms) / b[0]


def exponential_term(exponent: Sequence[Any], power: Sequence[Any], n: int) -> Any:
    """The n-th coefficient of an exponential function from the lower coefficients."""
    if n == 0:
        return exponential(exponent[0])
    slopes = map(mul, count(1), exponent[1 : n + 1])
    return sum(map(mul, slopes, power[n - 1 :: -1])) / n
