"""Taylor coefficients of the motion: the recurrences, readable and as straight-line code.

With x = Σ x_n tⁿ and y = Σ y_n tⁿ, Eqs. 2 and 5 give, for every n ≥ 0,

    (n+1)(n+2) m x_{n+2} = μ P_n − c1 (n+1) x_{n+1} − k1 x_n − h (x_n − y_n)
    (n+1)(n+2) m y_{n+2} = P_n − F δ_{n0} − c2 (n+1) y_{n+1} + h (x_n − y_n)
    P_n = −k2 y_n − k_nl q_n,   s = y y,   q = y s   (Cauchy products),   P_n = 0 when separated.

`coefficients` is these lines as a loop. `straight_line_source` writes the same operations without
the loop, for one field and one order; both interpreters and compilers run that much faster.
"""

from collections.abc import Callable, Sequence
from enum import Enum
from functools import lru_cache
from operator import mul
from typing import Any, cast

from .model import State
from .parameters import Parameters

Coefficients = tuple[tuple[float, ...], tuple[float, ...]]
Constants = tuple[float, float, float, float, float, float, float, float, float]
CoefficientFunction = Callable[..., Coefficients]
StateFunction = Callable[[Sequence[float], Sequence[float], float], State]


class Field(Enum):
    """The three right-hand sides, each with only the terms it needs."""

    SEPARATED = "separated"
    LINEAR_CONTACT = "linear contact"
    CUBIC_CONTACT = "cubic contact"


def constants(p: Parameters) -> Constants:
    """The constants of the recurrences.

    Parameters
    ----------
    p : Parameters
        The parameter set.

    Returns
    -------
    tuple of float
        (1/m, c1, c2, k1, h, k2, k_nl, μ, F) in SI units, h = k3/2.
    """
    return (1.0 / p.m, p.c1, p.c2, p.k1, 0.5 * p.k3, p.k2, p.k_nl, p.mu, p.F)


def coefficients(field: Field, order: int, state: State, given: Constants) -> Coefficients:
    """Taylor coefficients of x and y by the recurrences as they are written above.

    Parameters
    ----------
    field : Field
        Right-hand side.
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
    inverse_mass, c1, c2, k1, h, k2, k_nl, mu, preload = given
    x, y, s = [state[0], state[1]], [state[2], state[3]], list[float]()
    for n in range(order):
        force = 0.0
        if field is not Field.SEPARATED:
            force = -k2 * y[n]
        if field is Field.CUBIC_CONTACT:
            s.append(sum(map(mul, y[: n + 1], y[n::-1])))
            force -= k_nl * sum(map(mul, y[: n + 1], s[n::-1]))
        coupling = h * (x[n] - y[n])
        divisor = inverse_mass / ((n + 1) * (n + 2))
        load = preload if n == 0 else 0.0
        x.append((mu * force - k1 * x[n] - coupling - c1 * (n + 1) * x[n + 1]) * divisor)
        y.append((force - load + coupling - c2 * (n + 1) * y[n + 1]) * divisor)
    return tuple(x), tuple(y)


def straight_line_source(field: Field, order: int) -> str:
    """The recurrences of one field and order as a function without loops.

    Parameters
    ----------
    field : Field
        Right-hand side.
    order : int
        Order N to which the velocities are expanded.

    Returns
    -------
    str
        Source of ``coefficients(x0, x1, y0, y1, …)``, plain arithmetic only.
    """
    lines = [
        "def coefficients(x0, x1, y0, y1, inverse_mass, c1, c2, k1, h, k2, k_nl, mu, preload):"
    ]
    for n in range(order):
        force = ""
        if field is Field.LINEAR_CONTACT:
            force = f"-k2 * y{n}"
        if field is Field.CUBIC_CONTACT:
            lines.append(f"    s{n} = {_square_term(n)}")
            cube = " + ".join(f"y{i} * s{n - i}" for i in range(n + 1))
            force = f"-k2 * y{n} - k_nl * ({cube})"
        if force:
            lines.append(f"    force = {force}")
        lines.append(f"    coupling = h * (x{n} - y{n})")
        lines.append(f"    divisor = inverse_mass * {1.0 / ((n + 1) * (n + 2))!r}")
        pushed = "mu * force - " if force else "-"
        pressed = "force + coupling" if force else "coupling"
        load = " - preload" if n == 0 else ""
        lines.append(
            f"    x{n + 2} = ({pushed}k1 * x{n} - coupling - c1 * {n + 1.0} * x{n + 1}) * divisor"
        )
        lines.append(f"    y{n + 2} = ({pressed}{load} - c2 * {n + 1.0} * y{n + 1}) * divisor")
    xs = ", ".join(f"x{n}" for n in range(order + 2))
    ys = ", ".join(f"y{n}" for n in range(order + 2))
    lines.append(f"    return ({xs}), ({ys})")
    return "\n".join(lines) + "\n"


def _square_term(n: int) -> str:
    # Coefficient n of y², each mixed product once.
    mixed = " + ".join(f"y{i} * y{n - i}" for i in range((n + 1) // 2))
    doubled = f"2.0 * ({mixed})" if mixed else ""
    middle = f"y{n // 2} * y{n // 2}" if n % 2 == 0 else ""
    return " + ".join(filter(None, (doubled, middle)))


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
def coefficient_function(field: Field, order: int) -> CoefficientFunction:
    """`straight_line_source` as a function, made on first use.

    Parameters
    ----------
    field : Field
        Right-hand side.
    order : int
        Order N to which the velocities are expanded, 1 or more.

    Returns
    -------
    callable
        (x, ẋ, y, ẏ, *constants) to the coefficients of x and of y, N + 2 each.
    """
    return _compiled(straight_line_source(field, order), "coefficients")


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
