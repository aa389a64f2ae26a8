"""Make ``paper_points.json``: a few points of the paper's figures, computed independently.

The paper is *Nonlinear friction-induced vibration of a slider-belt system*. The key of a point is
the number of its figure, or "base" for the base set.

Equilibria, eigenvalues and critical friction coefficients are those of
``tests/support/paper_model.py``, and runs use the paper's method: RK4 with bisection at a small
step. Run it as ``python -m tests.data.make_paper_points``; it takes some minutes.
"""

import json
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from fivtui.model import System
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import static_start
from fivtui.transient.steppers.rk4 import RungeKutta4
from tests.support.paper_model import BASE, critical_mu, eigenvalues, equilibrium

# Step of RK4, end of a run, and times of recorded states, s.
STEP = 5e-4
T_END = 100.0
TIMES = (5.0, 25.0, 50.0, 99.0)

SOFT = {"k1": 50.0, "k2": 100.0}
Table = dict[str, float]


def oscillating_modes(p: Table) -> list[list[float]]:
    """Real and imaginary part, 1/s, of one eigenvalue of each conjugate pair."""
    upper = [value for value in eigenvalues(**p).tolist() if value.imag > 0.0]
    return [[value.real, value.imag] for value in sorted(upper, key=lambda value: value.imag)]


def runs(sets: Sequence[Table], *, separation: bool) -> list[dict[str, Any]]:
    parameters = [Parameters(**p) for p in sets]
    starts = [static_start(System(p)) for p in parameters]
    integrator = RungeKutta4(parameters, starts, step=STEP, separation=separation)
    peak, late_max, late_min = (np.full(len(sets), value) for value in (0.0, -np.inf, np.inf))
    states_at: dict[float, Any] = {}
    for number in range(1, round(T_END / STEP) + 1):
        integrator.advance()
        y = integrator.state[2]
        peak = np.maximum(peak, np.abs(y))
        if number >= round(0.5 * T_END / STEP):
            late_max, late_min = np.maximum(late_max, y), np.minimum(late_min, y)
        for time in TIMES:
            if number == round(time / STEP):
                states_at[time] = integrator.state.copy()
    return [
        {
            "y_peak": max(float(peak[index]), abs(starts[index][2])),
            "y_half_range": float(0.5 * (late_max[index] - late_min[index])),
            "states": {str(time): states_at[time][:, index].tolist() for time in TIMES},
        }
        for index in range(len(sets))
    ]


def point(key: str, changes: Table, **values: Any) -> dict[str, Any]:
    return {"key": key, "changes": changes, **values}


def equilibrium_points() -> Iterator[dict[str, Any]]:
    for key, F, k_nl in (
        ("2a", 30.0, 0.0), ("2a", 50.0, 50.0), ("2a", 80.0, 100.0), ("2a", 100.0, 500.0),
        ("2b", 5.0, 200.0), ("2b", 50.0, 40.0), ("2b", 100.0, 300.0),
    ):  # fmt: skip
        x, y, _ = equilibrium(F=F, k_nl=k_nl)
        yield point(key, {"F": F, "k_nl": k_nl}, x_e=x, y_e=y)


def eigenvalue_points() -> Iterator[dict[str, Any]]:
    cases: tuple[tuple[str, Table], ...] = (
        ("3", {"F": 20.0}),
        ("4", {"F": 100.0}),
        ("5", {"F": 100.0, "c1": 0.8}),
    )
    for (key, changes), k_nl, mu in product(cases, (0.0, 50.0, 100.0, 500.0), (0.2, 0.7, 1.8)):
        p = BASE | changes | {"k_nl": k_nl, "mu": mu}
        yield point(
            key, {"k_nl": k_nl, "mu": mu}, modes=oscillating_modes(p), mu_c=critical_mu(**p)
        )


def critical_points() -> Iterator[dict[str, Any]]:
    along_preload = [
        {"k_nl": k_nl, "F": F}
        for k_nl, F in product((0.0, 50.0, 200.0, 500.0), (10.0, 40.0, 100.0))
    ]
    along_stiffness = [
        {"F": F, "k_nl": k_nl} for F, k_nl in product((0.0, 5.0, 50.0, 100.0), (3.0, 100.0, 500.0))
    ]
    cases: tuple[tuple[str, Table, list[Table]], ...] = (
        ("6", {}, along_preload),
        ("7", {}, along_stiffness),
        ("8", SOFT, along_preload),
        ("9", SOFT, along_stiffness),
    )
    for key, changes, points in cases:
        for values_at_point in points:
            yield point(key, values_at_point, mu_c=critical_mu(**{**changes, **values_at_point}))


def transient_points() -> Iterator[dict[str, Any]]:
    # Key, changes for all points of the figure, and changes along its axis.
    families: list[tuple[str, Table, Table]] = [("base", {}, {})]
    families += [("13", {"k_nl": 20.0, "mu": 0.5}, {"F": F}) for F in (60.0, 102.0, 190.0)]
    families += [("14", {}, {"F": F}) for F in (20.0, 40.0, 110.0)]
    families += [("15", {"F": 40.0}, {"k_nl": k}) for k in (20.0, 100.0, 500.0)]
    families += [("16", {"F": 60.0, "mu": 1.0}, {"k_nl": k}) for k in (20.0, 50.0, 500.0)]
    for separation in (False, True):
        sets = [BASE | shared | along for _, shared, along in families]
        results = runs(sets, separation=separation)
        for (key, _, along), result in zip(families, results, strict=True):
            states = result.pop("states")
            values = {"states": states} if key == "base" else result
            yield point(key, along | {"separation": float(separation)}, **values)


def main() -> None:
    point_generators = (equilibrium_points, eigenvalue_points, critical_points, transient_points)
    lines = [json.dumps(entry) for generate in point_generators for entry in generate()]
    path = Path(__file__).with_name("paper_points.json")
    path.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
