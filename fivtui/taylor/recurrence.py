"""Recurrences of Taylor coefficients, made from the equations of `fivtui.model.field`.

The equations are evaluated on `Series`. A series writes the statement that computes its n-th
coefficient from those of lower degree: in Python here, in C in `fivtui.kernel.field_text`. The
recurrences serve all modes, friction laws and tables over time. `series` is faster where
parameters are constant and friction follows no law.
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

from .expression import PRODUCT, Expression, ReflectedOperators, expression
from .series import Coefficients, compile_function

# Text of a value from its group ("p": parameters, "rates": their rates) and its name in the group.
Naming = Callable[[str, str], str]


class Terms(NamedTuple):
    """Which optional terms the equations have.

    They come from a friction law, a finite belt speed and parameters over time.
    """

    by_law: bool
    finite_belt: bool
    over_time: bool


class Recurrence:
    """The statements of a recurrence, each as the text of its right-hand side by name.

    `constants` are numbers. `linear` are linear functions of time, as value and slope.
    `statements` are n-th coefficients in the order of computation.
    """

    def __init__(self) -> None:
        self.constants: dict[str, str] = {}
        self.linear: dict[str, tuple[str, str]] = {}
        self.statements: dict[str, str] = {}

    def add_constant(self, value: Expression) -> Expression:
        """Store a constant under a name, so that it is computed once."""
        if value.is_number:
            return value
        names = {text: name for name, text in self.constants.items()}
        name = names.get(value.text, f"c{len(self.constants)}")
        self.constants[name] = value.text
        return Expression(name)

    def add_linear(self, value: Expression, slope: Expression) -> "Series":
        """Store a linear function of time under a name."""
        name = f"line{len(self.linear)}"
        self.linear[name] = (value.text, slope.text)
        return Series(self, Expression(f"{name}[n]"), name)

    @property
    def next_name(self) -> str:
        """The name of the next series that `add_series` adds."""
        return f"s{len(self.statements)}"

    def add_series(self, value: Expression) -> "Series":
        """Add a statement that computes the n-th coefficient of a series."""
        name = self.next_name
        self.statements[name] = value.text
        return Series(self, Expression(f"{name}[n]"), name)

    def coordinate(self, name: str) -> tuple["Series", "Series"]:
        """A coordinate with known coefficients, and its velocity."""
        position = Series(self, Expression(f"{name}[n]"), name)
        return position, Series(self, Expression(f"(n + 1) * {name}[n + 1]", PRODUCT), "")


class Series(ReflectedOperators):
    """A function of time, or a constant. `value` is its n-th coefficient, or the constant.

    `array` names the array that stores the coefficients; "" if none does so yet, None for a
    constant.
    """

    __slots__ = ("array", "recurrence", "value")

    def __init__(self, recurrence: Recurrence, value: Expression, array: str | None) -> None:
        self.recurrence, self.value, self.array = recurrence, value, array

    @property
    def is_constant(self) -> bool:
        """Whether the value is the constant, not an n-th coefficient."""
        return self.array is None

    def __neg__(self) -> "Series":
        return Series(self.recurrence, -self.value, None if self.is_constant else "")

    def __add__(self, operand: object) -> "Series":
        return self._sum(self._operand(operand), Expression.__add__)

    def __sub__(self, operand: object) -> "Series":
        return self._sum(self._operand(operand), Expression.__sub__)

    def __mul__(self, operand: object) -> "Series":
        a, b = self, self._operand(operand)
        if a.is_constant or b.is_constant:
            return self._combine_with_constant(a, b, Expression.__mul__)
        product = f"product({a._array_name()}, {b._array_name()}, n)"
        return self.recurrence.add_series(Expression(product))

    def __truediv__(self, operand: object) -> "Series":
        a, b = self, self._operand(operand)
        if b.is_constant:
            return self._combine_with_constant(a, b, Expression.__truediv__)
        numerator, denominator = a.as_varying()._array_name(), b._array_name()
        result = self.recurrence.next_name
        return self.recurrence.add_series(
            Expression(f"quotient({numerator}, {denominator}, {result}, n)")
        )

    def exp(self) -> "Series":
        """The exponential of the series."""
        if self.is_constant:
            return Series(self.recurrence, self.value.exp(), None)
        exponent = self._array_name()
        result = self.recurrence.next_name
        return self.recurrence.add_series(Expression(f"exponential_term({exponent}, {result}, n)"))

    def _operand(self, value: object) -> "Series":
        return value if isinstance(value, Series) else _constant(self.recurrence, value)

    def _sum(
        self, operand: "Series", add: Callable[[Expression, Expression], Expression]
    ) -> "Series":
        if self.is_constant and operand.is_constant:
            return Series(self.recurrence, add(self.value, operand.value), None)
        # For n > 0 the n-th coefficient of a constant is 0, not its value: an array has both. Zero
        # needs none.
        a, b = (side if side.value.is_zero else side.as_varying() for side in (self, operand))
        return Series(self.recurrence, add(a.value, b.value), "")

    def _combine_with_constant(
        self, a: "Series", b: "Series", combine: Callable[[Expression, Expression], Expression]
    ) -> "Series":
        # A product with a constant operand, or a quotient with a constant denominator.
        if a.is_constant and b.is_constant:
            return Series(self.recurrence, combine(a.value, b.value), None)
        values = [
            self.recurrence.add_constant(side.value) if side.is_constant else side.value
            for side in (a, b)
        ]
        product = combine(values[0], values[1])
        return Series(self.recurrence, product, None if product.is_zero else "")

    def as_varying(self) -> "Series":
        """The series itself, or a constant as a linear function of zero slope."""
        if not self.is_constant:
            return self
        return self.recurrence.add_linear(self.recurrence.add_constant(self.value), expression(0.0))

    def _array_name(self) -> str:
        if not self.array:
            self.array = self.recurrence.add_series(self.value).array
            self.value = Expression(f"{self.array}[n]")
        assert self.array is not None  # noqa: S101
        return self.array


def motion_recurrence(terms: Terms, mode: Mode, name: Naming) -> tuple[Recurrence, Series, Series]:
    """The recurrence of a mode, with the accelerations in x and y."""
    recurrence = Recurrence()
    p, rates = _parameters(recurrence, terms, name)
    (x, vx), (y, vy) = recurrence.coordinate("x"), recurrence.coordinate("y")
    state: Any = (x, vx, y, vy)
    ax, ay = accelerations(p, state, mode, rates)
    return recurrence, _as_series(recurrence, ax), _as_series(recurrence, ay)


def guard_recurrence(terms: Terms, guard: Guard, name: Naming) -> tuple[Recurrence, Series]:
    """The recurrence of a guard, whose zero ends a mode, along a motion with known coefficients."""
    recurrence = Recurrence()
    p, rates = _parameters(recurrence, terms, name)
    (x, vx), (y, vy) = recurrence.coordinate("x"), recurrence.coordinate("y")
    value = guard_value(p, (x, vx, y, vy), guard, rates)
    return recurrence, _as_series(recurrence, value)


def _constant(recurrence: Recurrence, value: object) -> Series:
    return Series(recurrence, expression(value), None)


def _as_series(recurrence: Recurrence, value: Any) -> Series:
    # The value as a series that varies with time.
    return (value if isinstance(value, Series) else _constant(recurrence, value)).as_varying()


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
            p[key] = recurrence.add_linear(values[key], slope)
    p["v_s"] = p["v_s"] if terms.by_law else None
    p["v_belt"] = p["v_belt"] if terms.finite_belt else None
    return SimpleNamespace(**p), SimpleNamespace(**rates)


def python_name(group: str, name: str) -> str:
    """Name of a parameter or its rate in Python."""
    return f"{group}.{name}"


def _python_lines(recurrence: Recurrence, count: str, loop_end: Sequence[str]) -> list[str]:
    lines = [f"    {name} = {text}" for name, text in recurrence.constants.items()]
    for name, (value, slope) in recurrence.linear.items():
        lines.append(f"    {name} = [{value}, {slope}, *repeat(0.0, {count})]")
    lines += [f"    {name} = [0.0] * ({count})" for name in recurrence.statements]
    lines.append(f"    for n in range({count}):")
    lines += [f"        {name}[n] = {text}" for name, text in recurrence.statements.items()]
    return [*lines, *(f"        {line}" for line in loop_end)]


def _compile(head: str, lines: Sequence[str], returned: str) -> Callable[..., Any]:
    source = "\n".join([f"def recurrence({head}):", *lines, f"    return {returned}", ""])
    functions = (exponential, exponential_term, product, quotient, repeat)
    return compile_function(source, "recurrence", **{f.__name__: f for f in functions})


@lru_cache(maxsize=64)
def motion_function(terms: Terms, mode: Mode) -> Callable[[Any, Rates, Any, int], Coefficients]:
    """The function of (p, rates, state, order) that expands the motion in a mode.

    It returns the coefficients of x and of y, order + 2 each, in m/sⁿ.
    """
    recurrence, ax, ay = motion_recurrence(terms, mode, python_name)
    steps = [
        "share = 1.0 / ((n + 1) * (n + 2))",
        f"ax, ay = {ax.value.text}, {ay.value.text}",
        "x.append(ax * share)",
        "y.append(ay * share)",
    ]
    lines = ["    x, y = [state[0], state[1]], [state[2], state[3]]"]
    lines += _python_lines(recurrence, "order", steps)
    return _compile("p, rates, state, order", lines, "tuple(x), tuple(y)")


@lru_cache(maxsize=64)
def guard_function(terms: Terms, guard: Guard) -> Callable[[Any, Rates, Any, Any], list[float]]:
    """The function of (p, rates, x, y) that returns a guard's coefficients in 1/sⁿ.

    x and y are coefficients of the motion in m/sⁿ; the guard has as many.
    """
    recurrence, value = guard_recurrence(terms, guard, python_name)
    # Guards contain ẋ, whose n-th coefficient needs that of x for n + 1, but not ẏ.
    lines = ["    x, c = [*x, 0.0], []"]
    lines += _python_lines(recurrence, "len(y)", [f"c.append({value.value.text})"])
    return _compile("p, rates, x, y", lines, "c")


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
    weighted = map(mul, count(1), exponent[1 : n + 1])
    return sum(map(mul, weighted, power[n - 1 :: -1])) / n
