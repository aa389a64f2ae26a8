"""Make ``transients.json``: transients of varied scenes to 25 digits, by mpmath.

Independent of the package: Taylor series of order 40 in 45 digits, switches by bisection. The
spring k3 stands at 45°, so half of its stiffness acts along x and y and couples them.
Run it as ``python tests/references/make.py``; it needs mpmath and takes a few minutes.
"""

import json
import sys
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from mpmath import mp, mpf

Number = Any
Table = dict[str, Any]

# Decimal digits of the computation and of the results.
mp.dps = 45
DIGITS = 25
ORDER = 40
# Size of the last series terms relative to the motion.
TOLERANCE = mpf(10) ** -40
# Parts of a step in which signs are compared.
SAMPLES = 24

BASE: Table = {"m": 5, "k1": 100, "k2": 50, "k3": 60, "c1": "0.32", "c2": "0.32"}
BASE |= {"F": 80, "k_nl": 100, "mu": "0.7"}
# Changes to the base set, whether separation is considered, the horizon in s, and the start, (x, ẋ,
# y, ẏ) or empty for the static start.
SCENES: dict[str, tuple[Table, bool, float, tuple[str | float, ...]]] = {
    "base": ({}, True, 100, ()),
    "base-ignored": ({}, False, 100, ()),
    "stable-static-start": ({"F": 100, "k_nl": 500, "mu": "0.7"}, True, 60, ()),
    # A stable equilibrium and a limit cycle coexist.
    "coexistence": ({"F": 120}, True, 100, ()),
    "fig-13": ({"F": 60, "k_nl": 20, "mu": "0.5"}, True, 100, ()),
    "fig-16-ignored": ({"F": 60, "k_nl": 60, "mu": 1}, False, 60, ()),
    "undamped": ({"c1": 0, "c2": 0}, True, 40, ()),
    "no-preload-offset": ({"F": 0}, True, 60, (0, 0, "-0.5", 0)),
    "lifted": ({"F": -20}, True, 40, ("0.1", 0, "-0.2", 1)),
    "hard-contact": ({"k_nl": 1000000, "mu": "0.5"}, True, 40, ()),
    "strong-friction": ({"mu": 5}, True, 12, ()),
    "soft-horizontal": ({"k1": 50, "k2": 100, "c1": "0.8", "mu": 1}, True, 60, ()),
    "light-stiff": ({"m": "0.05", "k2": 500, "c1": "0.05", "c2": "0.02"}, True, 10, ()),
}


def number(value: str | float) -> Number:
    # The double that the package uses, exactly.
    return mpf(float(value))


def bisect_increasing(function: Callable[[Number], Number], low: Number, high: Number) -> Number:
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if function(middle) > 0 else (middle, high)
    return (low + high) / 2


def static_start(p: Table) -> list[Number]:
    # At rest at the equilibrium of zero friction.
    half_k3 = p["k3"] / 2
    k_x = p["k1"] + half_k3

    def balance(y: Number) -> Number:
        contact = p["k2"] * y + p["k_nl"] * y**3 if y < 0 or not p["separation"] else 0
        return contact + half_k3 * p["k1"] / k_x * y + p["F"]

    y = bisect_increasing(balance, mpf(-1000), mpf(1000))
    return [half_k3 * y / k_x, mpf(0), y, mpf(0)]


def expand(p: Table, state: list[Number], contact: bool) -> tuple[list[Number], list[Number]]:
    half_k3 = p["k3"] / 2
    x, y = [state[0], state[1]], [state[2], state[3]]
    square: list[Number] = []
    for n in range(ORDER):
        force = mpf(0)
        if contact:
            square.append(sum(y[i] * y[n - i] for i in range(n + 1)))
            cube = sum(y[i] * square[n - i] for i in range(n + 1))
            force = -p["k2"] * y[n] - p["k_nl"] * cube
        coupling = half_k3 * (x[n] - y[n])
        load = p["F"] if n == 0 else 0
        divisor = p["m"] * (n + 1) * (n + 2)
        force_x = p["mu"] * force - p["c1"] * (n + 1) * x[n + 1] - p["k1"] * x[n] - coupling
        x.append(force_x / divisor)
        y.append((force - load - p["c2"] * (n + 1) * y[n + 1] + coupling) / divisor)
    return x, y


def value(c: list[Number], t: Number) -> Number:
    total = mpf(0)
    for coefficient in reversed(c):
        total = total * t + coefficient
    return total


def slope(c: list[Number]) -> list[Number]:
    return [n * coefficient for n, coefficient in enumerate(c)][1:]


def in_contact(p: Table, state: list[Number]) -> bool:
    if not p["separation"]:
        return True
    x, vx, y, vy = state
    half_k3 = p["k3"] / 2
    # y and its derivatives, up to positive factors; each is valid if those before it are zero. The
    # first that is not zero decides. The fourth derivative has the sign of ẍ, opposite to x.
    for y_derivative in (y, vy, half_k3 * x - p["F"], half_k3 * vx, -half_k3 * x):
        if y_derivative != 0:
            return bool(y_derivative < 0)
    return True


def extreme_values(c: list[Number], duration: Number) -> list[Number]:
    """Values of a polynomial at both ends of a step and at every sign change of its slope."""
    slope_series = slope(c)
    grid = [duration * i / SAMPLES for i in range(SAMPLES + 1)]
    slopes = [value(slope_series, t) for t in grid]
    values = [value(c, grid[0]), value(c, grid[-1])]
    for (start, end), (first, second) in zip(pairwise(grid), pairwise(slopes), strict=True):
        if first * second < 0:
            rising = slope_series if second > 0 else [-coefficient for coefficient in slope_series]
            values.append(value(c, bisect_increasing(partial(value, rising), start, end)))
    return values


def longest_step(
    p: Table, state: list[Number], x: list[Number], y: list[Number], limit: Number
) -> Number:
    """The longest step, up to `limit` and 1 s, at which the last series terms are negligible."""
    size = max(abs(s) for s in (*state, p["F"] / (p["k1"] + p["k2"])))
    steps = [limit, mpf(1)]
    for n in (ORDER + 1, ORDER):
        term = max(abs(x[n]), abs(y[n]))
        if term > 0:
            steps.append((TOLERANCE * size / term) ** (mpf(1) / n))
    return min(steps)


def first_root(y: list[Number], h: Number, contact: bool) -> Number | None:
    """Time in a step of h at which the slider separates or lands; None if it does neither."""
    overshoot = y if contact else [-coefficient for coefficient in y]
    previous = mpf(0)
    for i in range(1, SAMPLES + 1):
        t = h * i / SAMPLES
        if value(overshoot, t) > 0:
            # After a switch y is zero at the start, which is not the root.
            low = previous if previous > 0 else t * mpf(10) ** -12
            return bisect_increasing(partial(value, overshoot), low, t)
        previous = t
    return None


def compute_transient(
    p: Table, state: list[Number], t_end: Number
) -> tuple[list[Number], list[Number], Number, Number]:
    t, contact = mpf(0), in_contact(p, state)
    switches: list[Number] = []
    separated_time = peak = mpf(0)
    while t < t_end:
        x, y = expand(p, state, contact)
        h = longest_step(p, state, x, y, t_end - t)
        root = first_root(y, h, contact) if p["separation"] else None
        h = h if root is None else root
        peak = max(peak, *map(abs, extreme_values(y, h)))
        if not contact:
            separated_time += h
        state = [value(x, h), value(slope(x), h), value(y, h), value(slope(y), h)]
        t += h
        if root is not None:
            state[2] = mpf(0)
            contact = not contact
            switches.append(t)
    return state, switches, separated_time, peak


def main() -> None:
    result = {}
    for name, (changes, separation, t_end, start) in SCENES.items():
        parameters = BASE | changes
        p = {key: number(entry) for key, entry in parameters.items()} | {"separation": separation}
        state = [number(s) for s in start] if start else static_start(p)
        first_contact = in_contact(p, state)
        final, switches, separated_time, peak = compute_transient(p, list(state), mpf(t_end))
        # Separations and landings alternate.
        first_separation = 0 if first_contact else 1
        separation_count = len(switches[first_separation::2])
        result[name] = {
            "parameters": {key: float(number(entry)) for key, entry in parameters.items()},
            "separation": separation,
            "start": [float(s) for s in start] if start else "static",
            "t_end": float(t_end),
            "final": [mp.nstr(s, DIGITS) for s in final],
            "peak_y_abs": mp.nstr(peak, DIGITS),
            "separations": separation_count,
            "separated_time": mp.nstr(separated_time, DIGITS),
            "switch_times": [mp.nstr(s, DIGITS) for s in switches],
        }
        print(name, separation_count, result[name]["final"], file=sys.stderr, flush=True)
    target = Path(__file__).with_name("transients.json")
    target.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
