"""Taylor coefficients of the motion: the recurrences, and what is made of them.

With z = (x, y), Eqs. 2 and 5 divided by the mass read

    z̈ = a x + b y + C ż − d y³ − (0, F/m)

    a = (−k1 − h, h)/m,  b = (h − μ k2, −h − k2)/m,  C = −diag(c1, c2)/m,  d = (μ, 1) k_nl/m

where k2 = k_nl = 0 when separated. With z = Σ zₙ tⁿ and the Cauchy products s = y y, q = y s they
give, for every n ≥ 0,

    zₙ₊₂ = C zₙ₊₁/(n+2) + (a xₙ + b yₙ − d qₙ − (0, F/m) δₙ₀)/((n+1)(n+2))

The newest coefficient yₙ is taken out of both products, so that little more than one
multiplication and one addition waits for it: with rₙ = sₙ + y₀ yₙ, and sums over 0 < i < n,

    rₙ = 3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ,   qₙ = 3 s₀ yₙ + Σ yᵢ rₙ₋ᵢ

`recurrences` is the only place where this is written. It is arithmetic on whatever it is given:
numbers, text (straight-line Python, which runs several times faster than a loop), or values of a
compiler.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache, reduce
from itertools import count, islice
from operator import add
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar, cast

from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import Mode, State

Coefficients = tuple[tuple[float, ...], tuple[float, ...]]
CoefficientFunction = Callable[..., Coefficients]
StateFunction = Callable[[Sequence[float], Sequence[float], float], State]


class Arithmetic(Protocol):
    """What the recurrences ask of a number, of text, or of a compiler's value."""

    def __add__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Self | float, /) -> Self: ...


T = TypeVar("T", bound=Arithmetic)


class Both(Protocol):
    """What the recurrences ask of a pair (x, y): arithmetic on both, by a pair or a value."""

    @property
    def x(self) -> Any:
        """The value of x."""

    @property
    def y(self) -> Any:
        """The value of y."""

    def __add__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Any, /) -> Self: ...


B = TypeVar("B", bound=Both)


class Backend(Protocol[T, B]):
    """Where the arithmetic is done.

    A value that is used more than once is kept under a name; what that returns is used instead.
    """

    def both(self, x: T, y: T, /) -> B:
        """A pair."""

    def fused(self, value: B, factor: float, rest: B, /) -> B:
        """The pair value × factor + rest, where `rest` is known first."""

    def products(self, y: Sequence[T], r: Sequence[T], n: int, /) -> tuple[T, T]:
        """The sums of yᵢ yₙ₋ᵢ and of yᵢ rₙ₋ᵢ over 0 < i < n, where n > 1."""

    def keep(self, name: str, value: T, /) -> T:
        """Keep a value."""

    def keep_both(self, name: str, value: B, /) -> B:
        """Keep a pair, its values under the name with x or y before it."""


class RightHandSide(Enum):
    """The two kinds of right-hand side; a linear one needs no Cauchy product."""

    LINEAR = "linear"
    CUBIC = "cubic"


class Constants(NamedTuple):
    """The constants of the recurrences, SI units.

    What x, y, ẋ and ẏ contribute to ẍ and ÿ; μ, k_nl/m and F/m.
    """

    xx: float
    xy: float
    yx: float
    yy: float
    xvx: float
    yvy: float
    friction: float
    cubic: float
    load: float


def right_hand_side(p: Parameters, mode: Mode) -> RightHandSide:
    """The kind of right-hand side that governs a mode.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    mode : Mode
        Contact or separated.

    Returns
    -------
    RightHandSide
        Cubic in contact with k_nl > 0.
    """
    return RightHandSide.CUBIC if mode is Mode.CONTACT and p.k_nl > 0.0 else RightHandSide.LINEAR


def constants(p: Parameters, mode: Mode) -> Constants:
    """The constants of the recurrences.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    mode : Mode
        Contact or separated.

    Returns
    -------
    Constants
        Every force divided by the mass.
    """
    m, h, mu = p.m, 0.5 * p.k3, p.mu
    k2, k_nl = (p.k2, p.k_nl) if mode is Mode.CONTACT else (0.0, 0.0)
    return Constants(
        -(p.k1 + h) / m,
        (h - mu * k2) / m,
        h / m,
        -(h + k2) / m,
        -p.c1 / m,
        -p.c2 / m,
        mu,
        k_nl / m,
        p.F / m,
    )


def recurrences(
    rhs: RightHandSide, state: Sequence[T], given: Sequence[T], backend: Backend[T, B]
) -> Iterator[B]:
    """The coefficients z₂, z₃, … of the motion, without end.

    Parameters
    ----------
    rhs : RightHandSide
        Kind of right-hand side.
    state : sequence of four values
        (x, ẋ, y, ẏ) in m and m/s: the coefficients x₀, x₁, y₀, y₁.
    given : sequence of nine values
        The `Constants`.
    backend : Backend
        Where the arithmetic is done.

    Yields
    ------
    Both
        Coefficients of x and y, in m/sⁿ.
    """
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
    """The indices 0 < i < n, those last for which i or n − i is nearest to n.

    Parameters
    ----------
    n : int
        Degree of a product.

    Returns
    -------
    list of int
        The order in which its terms become known.
    """
    return sorted(range(n - 1, 0, -1), key=lambda i: min(i, n - i), reverse=True)


@dataclass(frozen=True, slots=True)
class XY(Generic[T]):
    """A pair (x, y) of any values, as a `Both`."""

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
    """The backend of values that need no names."""

    def both(self, x: T, y: T) -> XY[T]:
        """A pair of them."""
        return XY(x, y)

    def fused(self, value: XY[T], factor: float, rest: XY[T]) -> XY[T]:
        """The product and the sum."""
        return value * factor + rest

    def products(self, y: Sequence[T], r: Sequence[T], n: int) -> tuple[T, T]:
        """The sums, each mixed product of y once."""
        mixed = [y[i] * y[n - i] for i in range((n - 1) // 2, 0, -1)]
        terms = [y[n // 2] * y[n // 2]] if n % 2 == 0 else []
        if mixed:
            terms.append(reduce(add, mixed) * 2.0)
        return reduce(add, terms), reduce(add, [y[i] * r[n - i] for i in newest_last(n)])

    def keep(self, _name: str, value: T) -> T:
        """The value itself."""
        return value

    def keep_both(self, _name: str, value: XY[T]) -> XY[T]:
        """The pair itself."""
        return value


def coefficients(rhs: RightHandSide, order: int, state: State, given: Constants) -> Coefficients:
    """Taylor coefficients of x and y in numbers.

    Parameters
    ----------
    rhs : RightHandSide
        Kind of right-hand side.
    order : int
        Order N to which the velocities are expanded.
    state : tuple of float
        (x, ẋ, y, ẏ) in m and m/s.
    given : Constants
        See `constants`.

    Returns
    -------
    tuple of tuple of float
        Coefficients of x and of y, N + 2 each, in m/sⁿ.
    """
    higher = list(islice(recurrences(rhs, state, given, Values[float]()), order))
    return (
        (state[0], state[1], *(z.x for z in higher)),
        (state[2], state[3], *(z.y for z in higher)),
    )


class _Text:
    """An expression in Python, parenthesised where precedence asks for it."""

    __slots__ = ("is_sum", "text")

    def __init__(self, text: str, *, is_sum: bool = False) -> None:
        self.text = text
        self.is_sum = is_sum

    def __add__(self, other: "_Text") -> "_Text":
        return _Text(f"{self.text} + {other.text}", is_sum=True)

    def __sub__(self, other: "_Text") -> "_Text":
        return _Text(f"{self.text} - {other._factor()}", is_sum=True)

    def __mul__(self, other: "_Text | float") -> "_Text":
        factor = repr(other) if isinstance(other, float) else other._factor()
        return _Text(f"{self._factor()} * {factor}")

    def _factor(self) -> str:
        return f"({self.text})" if self.is_sum else self.text


class _Lines(Values[_Text]):
    """The backend of text: every value that is kept becomes a line."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def keep(self, name: str, value: _Text) -> _Text:
        self.lines.append(f"    {name} = {value.text}")
        return _Text(name)

    def keep_both(self, name: str, value: XY[_Text]) -> XY[_Text]:
        return XY(self.keep(f"x{name}", value.x), self.keep(f"y{name}", value.y))


def straight_line_source(rhs: RightHandSide, order: int) -> str:
    """The recurrences of one rhs and order as a function without loops.

    Parameters
    ----------
    rhs : RightHandSide
        Kind of right-hand side.
    order : int
        Order N to which the velocities are expanded.

    Returns
    -------
    str
        Source of ``coefficients(x0, x1, y0, y1, …)``, plain arithmetic only.
    """
    backend = _Lines()
    state = [_Text(name) for name in ("x0", "x1", "y0", "y1")]
    given = [_Text(name) for name in Constants._fields]
    for _ in islice(recurrences(rhs, state, given, backend), order):
        pass
    arguments = ", ".join(value.text for value in (*state, *given))
    xs, ys = (", ".join(f"{name}{n}" for n in range(order + 2)) for name in ("x", "y"))
    lines = [f"def coefficients({arguments}):", *backend.lines, f"    return ({xs}), ({ys})", ""]
    return "\n".join(lines)


def state_source(degree: int) -> str:
    """Horner's rule for x, y and their derivatives as a function without loops.

    Parameters
    ----------
    degree : int
        Degree of the two polynomials.

    Returns
    -------
    str
        Source of ``state(x, y, t)``, which returns (x, ẋ, y, ẏ) at t.
    """
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


def _compiled(source: str, name: str) -> Callable[..., Any]:
    namespace: dict[str, Any] = {}
    exec(compile(source, f"<{name}>", "exec"), namespace)
    return cast("Callable[..., Any]", namespace[name])


@lru_cache(maxsize=64)
def coefficient_function(rhs: RightHandSide, order: int) -> CoefficientFunction:
    """`straight_line_source` as a function, made on first use.

    Parameters
    ----------
    rhs : RightHandSide
        Kind of right-hand side.
    order : int
        Order N to which the velocities are expanded, 1 or more.

    Returns
    -------
    callable
        (x, ẋ, y, ẏ, *constants) to the coefficients of x and of y, N + 2 each.
    """
    return _compiled(straight_line_source(rhs, order), "coefficients")


@lru_cache(maxsize=64)
def state_function(degree: int) -> StateFunction:
    """`state_source` as a function, made on first use.

    Parameters
    ----------
    degree : int
        Degree of the two polynomials, 1 or more.

    Returns
    -------
    callable
        (coefficients of x, coefficients of y, t) to (x, ẋ, y, ẏ).
    """
    return _compiled(state_source(degree), "state")
