"""Taylor coefficients of the motion, by recurrence.

With z = (x, y), Eqs. 2 and 5 divided by the mass read

    z̈ = a x + b y + C ż − d y³ − (0, F/m)

    a = (−k1 − h, h)/m,  b = (h − μ k2, −h − k2)/m,  C = −diag(c1, c2)/m,  d = (μ, 1) k_nl/m

where k2 = k_nl = 0 when separated. With z = Σ zₙ tⁿ and the Cauchy products s = y y, q = y s they
give, for every n ≥ 0,

    zₙ₊₂ = C zₙ₊₁/(n+2) + (a xₙ + b yₙ − d qₙ − (0, F/m) δₙ₀)/((n+1)(n+2))

The newest coefficient yₙ is taken out of both products, which shortens the chain of operations
that wait for it: with rₙ = sₙ + y₀ yₙ, and sums over 0 < i < n,

    rₙ = 3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ,   qₙ = 3 s₀ yₙ + Σ yᵢ rₙ₋ᵢ

`recurrences` is the one implementation. It runs on numbers, on text (giving straight-line
Python, several times faster than a loop) and on the values of a compiler.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache, reduce
from itertools import count, islice
from operator import add
from typing import Any, Generic, Protocol, Self, TypeVar, cast

from fivtui.model.field import Field
from fivtui.model.modes import IN_CONTACT, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State

from .expression import Expression

Coefficients = tuple[tuple[float, ...], tuple[float, ...]]
CoefficientFunction = Callable[..., Coefficients]
StateFunction = Callable[[Sequence[float], Sequence[float], float], State]


class Arithmetic(Protocol):
    """The operations that the recurrences need of a number, a text or a compiler's value."""

    def __add__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Self | float, /) -> Self: ...


T = TypeVar("T", bound=Arithmetic)


class Both(Protocol):
    """The operations that the recurrences need of a pair (x, y)."""

    @property
    def x(self) -> Any:
        """The x of the pair."""

    @property
    def y(self) -> Any:
        """The y of the pair."""

    def __add__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Any, /) -> Self: ...


B = TypeVar("B", bound=Both)


class Backend(Protocol[T, B]):
    """How the recurrences compute: on numbers, on text or in a compiler.

    Values that are used more than once pass through `keep`, which may store them under a name.
    """

    def both(self, x: T, y: T, /) -> B:
        """Make a pair."""

    def fused(self, value: B, factor: float, rest: B, /) -> B:
        """Return value × factor + rest; `rest` is known first."""

    def products(self, y: Sequence[T], r: Sequence[T], n: int, /) -> tuple[T, T]:
        """The sums of yᵢ yₙ₋ᵢ and of yᵢ rₙ₋ᵢ over 0 < i < n, where n > 1."""

    def keep(self, name: str, value: T, /) -> T:
        """Store a value under a name; return what to use in its place."""

    def keep_both(self, name: str, value: B, /) -> B:
        """Store a pair, as x and y followed by the name; return what to use in its place."""


class RightHandSide(Enum):
    """Kind of right-hand side; a linear one needs no Cauchy product."""

    LINEAR = "linear"
    CUBIC = "cubic"


def right_hand_side(p: Parameters, mode: Mode) -> RightHandSide:
    """Kind of right-hand side in a mode: cubic in contact with k_nl > 0, else linear."""
    return RightHandSide.CUBIC if mode in IN_CONTACT and p.k_nl != 0.0 else RightHandSide.LINEAR


def recurrences(
    rhs: RightHandSide, state: Sequence[T], given: Sequence[T], backend: Backend[T, B]
) -> Iterator[B]:
    """Yield the coefficients z₂, z₃, … of the motion, in m/sⁿ, without end."""
    xx, xy, yx, yy, xvx, yvy, friction, cubic, load = given
    a, b, damping = backend.both(xx, yx), backend.both(xy, yy), backend.both(xvx, yvy)
    z = [backend.both(state[0], state[2]), backend.both(state[1], state[3])]
    y, r = [state[2], state[3]], [state[2]]
    pull = a * z[0].x + b * y[0]
    pull = backend.both(pull.x, pull.y - load)
    if rhs is RightHandSide.CUBIC:
        d = backend.keep_both("d", backend.both(friction * cubic, cubic))
        thrice = backend.keep("thrice", y[0] * 3.0)
        square = backend.keep("square", y[0] * y[0])
        pull = pull - d * backend.keep("q", square * y[0])
        b = backend.keep_both("b", b - d * backend.keep("slope", square * 3.0))
    for n in count():
        if n > 0:
            pull = a * z[n].x + b * y[n]
        if n > 0 and rhs is RightHandSide.CUBIC:
            newest = thrice * y[n]
            if n > 1:
                rest, product = backend.products(y, r, n)
                pull = pull - d * backend.keep("q", product)
                newest = rest + newest
            r.append(backend.keep(f"r{n}", newest))
        share = 1.0 / ((n + 1) * (n + 2))
        new = backend.fused(pull, share, damping * (1.0 / (n + 2)) * z[n + 1])
        z.append(backend.keep_both(f"{n + 2}", new))
        y.append(z[-1].y)
        yield z[-1]


def newest_last(n: int) -> list[int]:
    """The indices 0 < i < n in the order in which the terms i and n − i become known."""
    return sorted(range(n - 1, 0, -1), key=lambda i: min(i, n - i), reverse=True)


@dataclass(frozen=True, slots=True)
class XY(Generic[T]):
    """A pair (x, y) of any values."""

    x: T
    y: T

    def __add__(self, other: "XY[T]") -> "XY[T]":
        return XY(self.x + other.x, self.y + other.y)

    def __sub__(self, other: "XY[T]") -> "XY[T]":
        return XY(self.x - other.x, self.y - other.y)

    def __mul__(self, other: Any) -> "XY[T]":
        x, y = (other.x, other.y) if isinstance(other, XY) else (other, other)
        return XY(self.x * x, self.y * y)


class Values(Generic[T]):
    """Backend for values that need no names."""

    def both(self, x: T, y: T) -> XY[T]:
        """Make a pair."""
        return XY(x, y)

    def fused(self, value: XY[T], factor: float, rest: XY[T]) -> XY[T]:
        """Return value × factor + rest."""
        return value * factor + rest

    def products(self, y: Sequence[T], r: Sequence[T], n: int) -> tuple[T, T]:
        """The two sums of `Backend.products`; each mixed product of y is computed once."""
        mixed = [y[i] * y[n - i] for i in range((n - 1) // 2, 0, -1)]
        terms = [y[n // 2] * y[n // 2]] if n % 2 == 0 else []
        if mixed:
            terms.append(reduce(add, mixed) * 2.0)
        return reduce(add, terms), reduce(add, [y[i] * r[n - i] for i in newest_last(n)])

    def keep(self, _name: str, value: T) -> T:
        """Return the value."""
        return value

    def keep_both(self, _name: str, value: XY[T]) -> XY[T]:
        """Return the pair."""
        return value


def coefficients(rhs: RightHandSide, order: int, state: State, given: Field) -> Coefficients:
    """Taylor coefficients of x and of y as numbers, `order` + 2 each, in m/sⁿ."""
    higher = list(islice(recurrences(rhs, state, given, Values[float]()), order))
    return (
        (state[0], state[1], *(z.x for z in higher)),
        (state[2], state[3], *(z.y for z in higher)),
    )


class _Lines(Values[Expression]):
    """Backend for text: every value that is kept becomes a line."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def keep(self, name: str, value: Expression) -> Expression:
        self.lines.append(f"    {name} = {value.text}")
        return Expression(name)

    def keep_both(self, name: str, value: XY[Expression]) -> XY[Expression]:
        return XY(self.keep(f"x{name}", value.x), self.keep(f"y{name}", value.y))


def straight_line_source(rhs: RightHandSide, order: int) -> str:
    """Source of ``coefficients(x0, x1, y0, y1, …)``: the recurrences without loops."""
    backend = _Lines()
    state = [Expression(name) for name in ("x0", "x1", "y0", "y1")]
    given = [Expression(name) for name in Field._fields]
    for _ in islice(recurrences(rhs, state, given, backend), order):
        pass
    arguments = ", ".join(value.text for value in (*state, *given))
    xs, ys = (", ".join(f"{name}{n}" for n in range(order + 2)) for name in ("x", "y"))
    lines = [f"def coefficients({arguments}):", *backend.lines, f"    return ({xs}), ({ys})", ""]
    return "\n".join(lines)


def state_source(degree: int) -> str:
    """Source of ``state(x, y, t)``, which returns (x, ẋ, y, ẏ) by Horner's rule without loops."""
    lines = ["def state(x, y, t):"]
    values = []
    for name in ("x", "y"):
        lines.append("    " + ", ".join(f"{name}{n}" for n in range(degree + 1)) + f" = {name}")
        position = f"{name}{degree}"
        velocity = f"{float(degree)} * {name}{degree}"
        for n in range(degree - 1, -1, -1):
            position = f"{name}{n} + t * ({position})"
            if n > 0:
                velocity = f"{float(n)} * {name}{n} + t * ({velocity})"
        values += [position, velocity]
    lines.append("    return (" + ",\n            ".join(values) + ")")
    return "\n".join(lines) + "\n"


def compiled(source: str, name: str, **namespace: Any) -> Callable[..., Any]:
    """The function of a name that a source defines, which uses what else is given by name."""
    exec(compile(source, f"<{name}>", "exec"), namespace)
    return cast("Callable[..., Any]", namespace[name])


@lru_cache(maxsize=64)
def coefficient_function(rhs: RightHandSide, order: int) -> CoefficientFunction:
    """The compiled `straight_line_source` of a right-hand side and an order N ≥ 1.

    It takes (x, ẋ, y, ẏ, *constants) and returns the coefficients of x and of y, N + 2 each.
    """
    return compiled(straight_line_source(rhs, order), "coefficients")


@lru_cache(maxsize=64)
def state_function(degree: int) -> StateFunction:
    """The compiled `state_source` for two polynomials of a degree ≥ 1."""
    return compiled(state_source(degree), "state")
