"""Make ``derivatives.json``: derivatives of transients, from differences of 25-digit runs.

Central differences over 1e-12 of runs by the integrator of ``make.py``: the derivatives are good to
15 digits. Run it as ``python -m tests.references.make_derivatives``; it takes a quarter of an hour.
"""

import json
import sys
from pathlib import Path

from mpmath import mpf

from .make import (
    BASE,
    Number,
    Table,
    expand,
    extreme_values,
    first_root,
    in_contact,
    longest_step,
    number,
    slope,
    static_start,
    value,
)

STEP = mpf(10) ** -12
START = ("x0", "vx0", "y0", "vy0")
QUANTITIES = (
    *("x", "vx", "y", "vy"),
    *("y_abs", "y_max", "y_min", "x_abs", "vx_max"),
    *("y_half_range", "force_min", "force_max"),
)
# Changes to the base set, whether separation is considered, the horizon in s, and the start, (x, ẋ,
# y, ẏ) or empty for the static start. In "drawn" scenes all parameters have irregular values.
SCENES: dict[str, tuple[Table, bool, float, tuple[str, ...]]] = {
    "base": ({}, True, 20, ()),
    "separation-ignored": ({}, False, 8, ()),
    "linear-contact": ({"k_nl": 0, "mu": "0.9"}, True, 8, ()),
    "lifted": ({"F": -20}, True, 6, ()),
    "drawn-1": (
        {"m": "3.1", "k1": "141", "k2": "82", "k3": "33", "c1": "0.71", "c2": "0.18", "F": "47"}
        | {"k_nl": "212", "mu": "0.93"},
        True,
        8,
        ("0.35", "-2.1", "0.62", "1.7"),
    ),
    "drawn-2": (
        {"m": "7.9", "k1": "58", "k2": "31", "k3": "104", "c1": "0.05", "c2": "1.2", "F": "131"}
        | {"k_nl": "37", "mu": "0.41"},
        True,
        10,
        ("-1.2", "0.8", "-1.9", "-3.3"),
    ),
    "drawn-3": (
        {"m": "1.6", "k1": "77", "k2": "119", "k3": "71", "c1": "0.44", "c2": "0.09", "F": "26"}
        | {"k_nl": "340", "mu": "1.3"},
        True,
        5,
        (),
    ),
}


def compute_quantities(p: Table, state: list[Number], t_end: Number) -> list[Number]:
    """The `QUANTITIES` of a run."""
    t, contact, half = mpf(0), in_contact(p, state), t_end / 2
    xs: list[Number] = []
    ys: list[Number] = []
    speeds: list[Number] = []
    second_half_ys: list[Number] = []
    while t < t_end:
        x, y = expand(p, state, contact)
        h = longest_step(p, state, x, y, (half if t < half else t_end) - t)
        root = first_root(y, h, contact) if p["separation"] else None
        h = h if root is None else root
        xs += extreme_values(x, h)
        speeds += extreme_values(slope(x), h)
        ys += extreme_values(y, h)
        if t >= half:
            second_half_ys += extreme_values(y, h)
        state = [value(x, h), value(slope(x), h), value(y, h), value(slope(y), h)]
        t += h
        if root is not None:
            state[2] = mpf(0)
            contact = not contact
    low, high = min(ys), max(ys)
    # The contact force falls with y: it is least at the greatest y. Off the belt, where y > 0, it
    # is zero, as at y = 0.
    force_ys = (min(high, 0), min(low, 0)) if p["separation"] else (high, low)
    forces = [-p["k2"] * y - p["k_nl"] * y**3 for y in force_ys]
    x_abs = max(map(abs, xs))
    half_range = (max(second_half_ys) - min(second_half_ys)) / 2
    return [*state, max(high, -low), high, low, x_abs, max(speeds), half_range, *forces]


def derivatives(name: str, p: Table, start: list[Number], t_end: Number) -> list[float]:
    ends = []
    for sign in (1, -1):
        shifted_parameters, shifted_start = dict(p), list(start)
        if name in START:
            shifted_start[START.index(name)] += sign * STEP
        else:
            shifted_parameters[name] += sign * STEP
        ends.append(
            compute_quantities(
                shifted_parameters, shifted_start or static_start(shifted_parameters), t_end
            )
        )
    return [float((plus - minus) / (2 * STEP)) for plus, minus in zip(*ends, strict=True)]


def main() -> None:
    target = Path(__file__).with_name("derivatives.json")
    result: Table = {}
    for scene, (changes, separation, t_end, start) in SCENES.items():
        parameters = BASE | changes
        p = {key: number(entry) for key, entry in parameters.items()} | {"separation": separation}
        names = [*parameters, *(START if start else ())]
        scene_start = [number(text) for text in start]
        result[scene] = {
            "parameters": {key: float(entry) for key, entry in parameters.items()},
            "separation": separation,
            "start": [float(text) for text in start] if start else "static",
            "t_end": t_end,
            "quantities": QUANTITIES,
            "by": {name: derivatives(name, p, scene_start, mpf(t_end)) for name in names},
        }
        print(scene, file=sys.stderr, flush=True)
        target.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
