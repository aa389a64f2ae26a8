"""Taylor coefficients of the motion, by recurrence.

With z = (x, y) and h = k3/2, Eqs. 2 and 5 of the paper "Nonlinear friction-induced vibration of a
slider-belt system", divided by the mass, read

    z̈ = a x + b y + C ż − d y³ − (0, F/m)

    a = (−k1 − h, h)/m,  b = (h − μ k2, −h − k2)/m,  C = −diag(c1, c2)/m,  d = (μ, 1) k_nl/m

where k2 = k_nl = 0 when separated. With z = Σ zₙ tⁿ and the Cauchy products s = y y, q = y s they
give, for every n ≥ 0,

    zₙ₊₂ = C zₙ₊₁/(n+2) + (a xₙ + b yₙ − d qₙ − (0, F/m) δₙ₀)/((n+1)(n+2))

The terms with the newest coefficient yₙ are separated from both products: this shortens the chain
of operations that wait for yₙ. With rₙ = sₙ + y₀ yₙ, and sums over 0 < i < n,

    rₙ = 3 y₀ yₙ + Σ yᵢ yₙ₋ᵢ,   qₙ = 3 s₀ yₙ + Σ yᵢ rₙ₋ᵢ

as sₙ = 2 y₀ yₙ + Σ yᵢ yₙ₋ᵢ, s₀ = y₀² and qₙ = y₀ sₙ + s₀ yₙ + Σ yᵢ sₙ₋ᵢ.

The recurrences are written as text: straight-line Python is several times faster than a loop.
"""

from collections.abc import Callable, Sequence
from enum import Enum
from functools import lru_cache, reduce
from operator import add
from typing import Any, NamedTuple, cast

from fivtui.model.field import Field
from fivtui.model.modes import IN_CONTACT, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State

from .expression import Expression

Coefficients = tuple[tuple[float, ...], tuple[float, ...]]
CoefficientFunction = Callable[..., Coefficients]
StateFunction = Callable[[Sequence[float], Sequence[float], float], State]


class RightHandSide(Enum):
    """Kind of right-hand side; a linear one needs no Cauchy product."""

    LINEAR = "linear"
    CUBIC = "cubic"


def right_hand_side(p: Parameters, mode: Mode) -> RightHandSide:
    """Kind of right-hand side in a mode: cubic in contact with k_nl > 0, else linear."""
    return RightHandSide.CUBIC if mode in IN_CONTACT and p.k_nl != 0.0 else RightHandSide.LINEAR


class _Pair(NamedTuple):
    # Expressions for x and for y.
    x: Expression
    y: Expression

    def times(self, factor: Expression | float) -> "_Pair":
        return _Pair(self.x * factor, self.y * factor)

    def plus(self, addend: "_Pair") -> "_Pair":
        return _Pair(self.x + addend.x, self.y + addend.y)

    def minus(self, subtrahend: "_Pair") -> "_Pair":
        return _Pair(self.x - subtrahend.x, self.y - subtrahend.y)


class _Lines:
    # Lines of a function; each reused value gets its own line.

    def __init__(self, head: str) -> None:
        self.lines = [head]

    def assign(self, name: str, value: Expression) -> Expression:
        self.lines.append(f"    {name} = {value.text}")
        return Expression(name)

    def assign_both(self, name: str, value: _Pair) -> _Pair:
        return _Pair(self.assign(f"x{name}", value.x), self.assign(f"y{name}", value.y))


def straight_line_source(rhs: RightHandSide, order: int) -> str:
    """Source of ``coefficients(x0, x1, y0, y1, …)``: the recurrences without loops."""
    arguments = ("x0", "x1", "y0", "y1", *Field._fields)
    x0, x1, y0, y1, xx, xy, yx, yy, xvx, yvy, friction, cubic, load = map(Expression, arguments)
    code = _Lines(f"def coefficients({', '.join(arguments)}):")
    a, b = _Pair(xx, yx), _Pair(xy, yy)
    z = [_Pair(x0, y0), _Pair(x1, y1)]
    acceleration = a.times(x0).plus(b.times(y0))
    acceleration = _Pair(acceleration.x, acceleration.y - load)
    # `_products` reads r from r₁ on: the first entry stands for r₀.
    r = [y0]
    if rhs is RightHandSide.CUBIC:
        d = code.assign_both("d", _Pair(friction * cubic, cubic))
        thrice = code.assign("thrice", y0 * 3.0)
        square = code.assign("square", y0 * y0)
        acceleration = acceleration.minus(d.times(code.assign("q", square * y0)))
        b = code.assign_both("b", b.minus(d.times(code.assign("slope", square * 3.0))))
    for n in range(order):
        if n > 0:
            acceleration = a.times(z[n].x).plus(b.times(z[n].y))
        if n > 0 and rhs is RightHandSide.CUBIC:
            newest = thrice * z[n].y
            if n > 1:
                square_term, cube_term = _products([pair.y for pair in z], r, n)
                acceleration = acceleration.minus(d.times(code.assign("q", cube_term)))
                newest = square_term + newest
            r.append(code.assign(f"r{n}", newest))
        damping = _Pair(
            xvx * (1.0 / (n + 2)) * z[n + 1].x,
            yvy * (1.0 / (n + 2)) * z[n + 1].y,
        )
        new = acceleration.times(1.0 / ((n + 1) * (n + 2))).plus(damping)
        z.append(code.assign_both(f"{n + 2}", new))
    xs, ys = (", ".join(value.text for value in values) for values in zip(*z, strict=True))
    return "\n".join([*code.lines, f"    return ({xs}), ({ys})", ""])


def _products(
    y: Sequence[Expression], r: Sequence[Expression], n: int
) -> tuple[Expression, Expression]:
    # The sums of yᵢ yₙ₋ᵢ and of yᵢ rₙ₋ᵢ over 0 < i < n, where n > 1; each mixed product of y is
    # computed once. The newest coefficients are added last.
    mixed = [y[i] * y[n - i] for i in range((n - 1) // 2, 0, -1)]
    squares = [y[n // 2] * y[n // 2]] if n % 2 == 0 else []
    if mixed:
        squares.append(reduce(add, mixed) * 2.0)
    # For n = 5 the order of i is 3, 2, 4, 1: y₄ and r₄ are in the last two terms.
    newest_last = sorted(range(n - 1, 0, -1), key=lambda i: min(i, n - i), reverse=True)
    return reduce(add, squares), reduce(add, [y[i] * r[n - i] for i in newest_last])


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


def compile_function(source: str, name: str, **namespace: Any) -> Callable[..., Any]:
    """The function `name` that a source defines; the source may use the objects passed by name."""
    exec(compile(source, f"<{name}>", "exec"), namespace)
    return cast("Callable[..., Any]", namespace[name])


@lru_cache(maxsize=64)
def coefficient_function(rhs: RightHandSide, order: int) -> CoefficientFunction:
    """The compiled `straight_line_source` of a right-hand side and an order N ≥ 1.

    It takes (x, ẋ, y, ẏ, *constants) and returns the coefficients of x and of y, N + 2 each.
    """
    return compile_function(straight_line_source(rhs, order), "coefficients")


@lru_cache(maxsize=64)
def state_function(degree: int) -> StateFunction:
    """The compiled `state_source` for two polynomials of a degree ≥ 1."""
    return compile_function(state_source(degree), "state")
