"""Make ``belt.json``: transients on a belt of finite speed to 25 digits, by mpmath.

Independent of the package: Taylor series of order 36 in 42 digits, the ends of modes by bisection.
Modes of slip are "forward" and "backward", after the direction of friction on the slider. The
friction coefficient at the sliding speed v is mu + (mu_s - mu) exp(-v/v_s); without v_s it is mu.
Run it as ``python -m tests.references.make_belt``; it needs mpmath and takes a few minutes.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mpmath import exp, mp, mpf

from .make import Number, Table, slope, value

# Decimal digits of the computation and of the results.
mp.dps = 42
DIGITS = 25
ORDER = 36
# Size of the last series terms relative to the motion.
TOLERANCE = mpf(10) ** -36
# Largest change of v/v_s over a step.
MAX_SPEED_CHANGE = mpf(1)
# Parts of a step in which guards are evaluated, and bisections of a root.
SAMPLES = 40
BISECTIONS = 140

BASE: Table = {"m": 5, "k1": 100, "k2": 50, "k3": 60, "c1": 0.32, "c2": 0.32}
BASE |= {"F": 80, "k_nl": 100, "mu": 0.7, "mu_s": None, "v_s": None}
AT_REST = (0, 0, -0.8, 0)
# Changes to the base set, whether separation is considered, the horizon in s, and the start.
SCENES: dict[str, tuple[Table, bool, float, tuple[float, ...]]] = {
    "slow": ({"v_belt": 0.2}, True, 8, AT_REST),
    "base": ({"v_belt": 1}, True, 8, AT_REST),
    "static-friction": ({"v_belt": 0.5, "mu_s": 0.9}, True, 8, (-2, -4, -1, 3)),
    "speed-law": ({"v_belt": 0.5, "mu_s": 0.9, "v_s": 0.4}, True, 8, (-2, -4, -1, 3)),
    "sharp-law": ({"v_belt": 2, "mu_s": 1.2, "v_s": 0.1}, True, 6, AT_REST),
    "backward": ({"v_belt": 0.3, "mu": 0.2, "k3": 0}, True, 8, (1.5, 5, -1, 4)),
    "belt-at-rest": ({"v_belt": 0, "mu": 0.1, "F": 20}, True, 8, (2, 5, -0.3, 4)),
    # With separation ignored the contact spring also pulls, where y > 0.
    "tension": ({"v_belt": 0.5, "k_nl": 0, "F": 5}, False, 6, (0.5, 0, 1, 2)),
    "linear-law": ({"v_belt": 0.5, "k_nl": 0, "mu_s": 1, "v_s": 0.2}, True, 6, (0, 0.5, -1, 2)),
    "light": ({"v_belt": 1, "m": 0.5, "F": 40, "mu_s": 0.8}, True, 3, (0, 1, -0.5, 0)),
}


def product(a: list[Number], b: list[Number], n: int) -> Number:
    return sum(a[i] * b[n - i] for i in range(n + 1))


def contact_force(p: Table, y: Number) -> Number:
    return -p["k2"] * y - p["k_nl"] * y**3


def holding_force(p: Table, x: Number, y: Number) -> Number:
    return p["c1"] * p["v_belt"] + (p["k1"] + p["k3"] / 2) * x - p["k3"] / 2 * y


def expand(p: Table, state: list[Number], mode: str) -> tuple[list[Number], list[Number]]:
    half_k3, sign = p["k3"] / 2, {"forward": 1, "backward": -1}.get(mode, 0)
    x, y = [state[0], state[1]], [state[2], state[3]]
    square: list[Number] = []
    force: list[Number] = []
    ax: list[Number] = []
    has_exponential = sign != 0 and p["v_s"] is not None
    sliding_speed = sign * (p["v_belt"] - state[1])
    exponential = [exp(-sliding_speed / p["v_s"]) if has_exponential else mpf(0)]
    for n in range(ORDER):
        square.append(product(y, y, n))
        spring_force = -p["k2"] * y[n] - p["k_nl"] * product(y, square, n)
        force.append(mpf(0) if mode == "separated" else spring_force)
        if n > 0:
            # From the derivative of e = exp(-v/v_s): ė = -v̇ e/v_s, where -v̇ = sign ẍ.
            exponential.append(
                sign * product(ax, exponential, n - 1) / (n * p["v_s"])
                if has_exponential
                else mpf(0)
            )
        friction = sign * (
            p["mu"] * force[n] + (p["mu_s"] - p["mu"]) * product(exponential, force, n)
        )
        coupling = half_k3 * (x[n] - y[n])
        load = p["F"] if n == 0 else 0
        ax_n = (friction - p["c1"] * (n + 1) * x[n + 1] - p["k1"] * x[n] - coupling) / p["m"]
        ax.append(mpf(0) if mode == "stick" else ax_n)
        ay_n = (force[n] - load - p["c2"] * (n + 1) * y[n + 1] + coupling) / p["m"]
        x.append(ax[n] / ((n + 1) * (n + 2)))
        y.append(ay_n / ((n + 1) * (n + 2)))
    return x, y


def mode_of(p: Table, state: list[Number]) -> str:
    x, vx, y, vy = state
    if p["separation"] and (y > 0 or (y == 0 and vy > 0)):
        return "separated"
    if vx != p["v_belt"]:
        return "forward" if vx < p["v_belt"] else "backward"
    required, grip = holding_force(p, x, y), p["mu_s"] * contact_force(p, y)
    if abs(required) <= grip:
        return "stick"
    return "forward" if required > 0 else "backward"


def guard_functions(p: Table, mode: str) -> dict[str, Callable[[list[Number]], Number]]:
    # Functions of (x, ẋ, y) that are positive during a mode, which ends where one becomes negative.
    # The key of that one is the next mode, or begins with "?" if `mode_of` decides the next mode.
    functions: dict[str, Callable[[list[Number]], Number]] = {}
    if mode == "separated":
        return {"?land": lambda z: z[2]}
    if p["separation"]:
        functions["separated"] = lambda z: -z[2]
    if mode == "stick":
        functions["forward"] = lambda z: (
            p["mu_s"] * contact_force(p, z[2]) - holding_force(p, z[0], z[2])
        )
        functions["backward"] = lambda z: (
            p["mu_s"] * contact_force(p, z[2]) + holding_force(p, z[0], z[2])
        )
    else:
        sign = 1 if mode == "forward" else -1
        functions["?stop"] = lambda z: sign * (p["v_belt"] - z[1])
    return functions


def first_end(
    p: Table, mode: str, x: list[Number], y: list[Number], h: Number
) -> tuple[Number, str] | None:
    speed = slope(x)

    def guard_value_at(guard: Callable[[list[Number]], Number], t: Number) -> Number:
        return guard([value(x, t), value(speed, t), value(y, t)])

    best: tuple[Number, str] | None = None
    for name, guard in guard_functions(p, mode).items():
        for i in range(1, SAMPLES + 1):
            if guard_value_at(guard, h * i / SAMPLES) < 0:
                low, high = h * (i - 1) / SAMPLES, h * i / SAMPLES
                if i == 1:
                    low = high * mpf(10) ** -9
                for _ in range(BISECTIONS):
                    middle = (low + high) / 2
                    low, high = (
                        (low, middle) if guard_value_at(guard, middle) < 0 else (middle, high)
                    )
                if best is None or high < best[0]:
                    best = (high, name)
                break
    return best


def choose_step(
    p: Table,
    mode: str,
    state: list[Number],
    z: tuple[list[Number], list[Number]],
    remaining: Number,
) -> Number:
    size = max(abs(s) for s in (*state, p["F"] / (p["k1"] + p["k2"])))
    steps = [remaining, mpf(1)]
    for n in (ORDER + 1, ORDER):
        term = max(abs(c[n]) for c in z)
        if term > 0:
            steps.append((TOLERANCE * size / term) ** (mpf(1) / n))
    h = min(steps)
    if p["v_s"] is not None and mode in ("forward", "backward"):
        sizes = [n * abs(c) for n, c in enumerate(z[0])]
        while (
            sum(s * h ** (n - 1) for n, s in enumerate(sizes) if n > 1)
            > MAX_SPEED_CHANGE * p["v_s"]
        ):
            h *= mpf("0.8")
    return h


def compute_transient(
    p: Table, state: list[Number], t_end: Number
) -> tuple[list[Number], list[Any]]:
    t, mode = mpf(0), mode_of(p, state)
    changes: list[Any] = []
    while t < t_end:
        x, y = expand(p, state, mode)
        h = choose_step(p, mode, state, (x, y), t_end - t)
        ended = first_end(p, mode, x, y, h)
        if ended is not None:
            h = ended[0]
        state = [value(x, h), value(slope(x), h), value(y, h), value(slope(y), h)]
        t += h
        if mode == "stick":
            state[1] = p["v_belt"]
        if ended is not None:
            successor = ended[1]
            if successor in ("separated", "?land"):
                state[2] = mpf(0)
            if successor == "?stop":
                state[1] = p["v_belt"]
            successor = mode_of(p, state) if successor.startswith("?") else successor
            changes.append((t, mode, successor))
            mode = successor
    return state, changes


def main() -> None:
    result = {}
    for name, (changes_to_base, separation, t_end, start) in SCENES.items():
        parameters = BASE | changes_to_base
        p = {key: None if entry is None else mpf(float(entry)) for key, entry in parameters.items()}
        p |= {"separation": separation, "mu_s": p["mu"] if p["mu_s"] is None else p["mu_s"]}
        final, changes = compute_transient(p, [mpf(float(s)) for s in start], mpf(t_end))
        result[name] = {
            "parameters": parameters,
            "separation": separation,
            "start": list(start),
            "t_end": t_end,
            "final": [mp.nstr(s, DIGITS) for s in final],
            "changes": [[mp.nstr(t, DIGITS), before, after] for t, before, after in changes],
        }
        print(name, len(changes), result[name]["final"], file=sys.stderr, flush=True)
        target = Path(__file__).with_name("belt.json")
        target.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
