"""Stiffness and damping over time: held between rows, as tunable parameters of an FMU."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from fivtui import InputError, Parameters, simulate
from fivtui.model import spring_force
from fivtui.transient import Transient
from fivtui.transient.files import load_transient, save_trajectory

BELTS: Final[dict[str, dict[str, float]]] = {
    "always faster": {},
    "constant friction": {"v_belt": 2.0},
    "falling friction": {"v_belt": 2.0, "mu_s": 0.9, "v_s": 0.4},
    "backward": {"v_belt": -0.7, "mu_s": 0.9, "v_s": 0.4},
}
# Times of rows, s, within steps of the integrator: off the belt, in contact and in stick.
ROWS: Final = (0.0, 1.3, 3.1)
T_END: Final = 4.0
VALUES: Final[dict[str, tuple[float, ...]]] = {
    "k1": (100.0, 100.0, 60.0),
    "k2": (50.0, 120.0, 80.0),
    "k3": (60.0, 60.0, 90.0),
    "c1": (0.32, 0.8, 0.1),
    "c2": (0.3, 0.3, 0.5),
    "k_nl": (100.0, 0.0, 400.0),
}
TABLES: Final = {name: list(zip(ROWS, values, strict=True)) for name, values in VALUES.items()}


def numbers(run: Transient) -> list[float]:
    """End, extremes and events."""
    peak, force, events = run.peak, run.contact_force, run.events
    state = list(run.final)[1:]
    extremes = [peak.y_min, peak.y_max, peak.x_abs, peak.vx_max, force.min, force.max]
    return [*state, *extremes, events.separated_time, events.stick_time, events.separations]


def runs_one_by_one(belt: dict[str, float], method: str, **options: Any) -> list[Transient]:
    """A run from each row to the next, each from the end of the one before."""
    start: Any = "static"
    runs = []
    for row, (begin, end) in enumerate(zip(ROWS, (*ROWS[1:], T_END), strict=True)):
        p = Parameters(**belt, **{name: values[row] for name, values in VALUES.items()})
        run = simulate(p, t_end=end - begin, start=start, method=method, **options)
        start = list(run.final)[1:]
        runs.append(run)
    return runs


@pytest.mark.parametrize("belt", BELTS.values(), ids=BELTS)
@pytest.mark.parametrize(
    ("method", "options", "tolerance"),
    [("rk4", {"step": 2e-3}, 1e-5), ("scipy-dop853", {"tol": 1e-11}, 1e-7)],
)
def test_a_run_is_the_runs_of_independent_methods_from_row_to_row(
    belt: dict[str, float], method: str, options: dict[str, float], tolerance: float
) -> None:
    runs = runs_one_by_one(belt, method, **options)
    run = simulate(Parameters(**belt), t_end=T_END, over_time=TABLES)
    expected = [
        *list(runs[-1].final)[1:],
        min(part.peak.y_min for part in runs),
        max(part.peak.y_max for part in runs),
        max(part.peak.x_abs for part in runs),
        max(part.peak.vx_max for part in runs),
        min(part.contact_force.min for part in runs),
        max(part.contact_force.max for part in runs),
        sum(part.events.separated_time for part in runs),
        sum(part.events.stick_time for part in runs),
        sum(part.events.separations for part in runs),
    ]
    assert numbers(run) == pytest.approx(expected, rel=tolerance, abs=tolerance)
    assert run.events.separations + run.events.sticks > 1


@pytest.mark.parametrize("belt", BELTS.values(), ids=BELTS)
def test_the_interpreted_kernel_and_both_fmus_follow_the_same_tables(
    belt: dict[str, float],
) -> None:
    p, times = Parameters(**belt), [*ROWS, 3.7, T_END]
    run = simulate(p, t_end=T_END, over_time=TABLES, samples=times)
    assert run.trajectory is not None
    choices: list[dict[str, Any]] = [
        {"kernel": "interpreted"},
        {"method": "fmu-native"},
        {"method": "fmu"},
    ]
    for options in choices:
        other: Any = simulate(p, t_end=T_END, over_time=TABLES, samples=times, **options)
        assert numbers(other) == pytest.approx(numbers(run), rel=1e-8, abs=1e-8), options
        # At a row the contact force is that of the stiffness from then on.
        np.testing.assert_allclose(other.trajectory.P, run.trajectory.P, rtol=1e-8, atol=1e-8)


def test_energy_is_constant_between_rows_and_jumps_with_a_stiffness() -> None:
    p = Parameters(mu=0.0, c1=0.0, c2=0.0)
    rows = [(0.0, 100.0), (1.0, 150.0)]
    run = simulate(
        p, t_end=3.0, start=(0.3, 0.0, -1.0, 2.0), over_time={"k1": rows}, samples="dense"
    )
    assert run.solution is not None
    motion = run.solution(np.linspace(0.0, 3.0, 301))
    k1 = np.where(motion.t < 1.0, 100.0, 150.0)
    x, y, depth = motion.x, motion.y, np.minimum(motion.y, 0.0)
    energy = 0.5 * p.m * (motion.vx**2 + motion.vy**2) + 0.5 * k1 * x**2 + p.F * y
    energy += 0.25 * p.k3 * (x - y) ** 2 + 0.5 * p.k2 * depth**2 + 0.25 * p.k_nl * depth**4
    assert energy[:100] == pytest.approx(energy[0], rel=1e-12)
    jump = 0.5 * 50.0 * x[100] ** 2
    assert energy[100:] == pytest.approx(energy[0] + jump, rel=1e-12)
    assert run.events.separations > 0


def test_the_contact_force_follows_the_stiffness_and_reads_back(tmp_path: Path) -> None:
    tables = {"k2": [(0.0, 50.0), (1.0, 500.0)]}
    run = simulate(t_end=2.0, over_time=tables, samples=401)
    assert run.trajectory is not None
    motion = run.trajectory
    in_contact = motion.mode > 0
    k2 = np.where(motion.t < 1.0, 50.0, 500.0)
    expected = [
        spring_force(Parameters(k2=stiffness), y)
        for stiffness, y in zip(k2[in_contact], motion.y[in_contact], strict=True)
    ]
    assert motion.P[in_contact].tolist() == expected
    assert run.contact_force.max == pytest.approx(motion.P.max(), rel=1e-2)
    save_trajectory(run, tmp_path / "run.csv")
    assert load_transient(tmp_path / "run.csv").contact_force.max == motion.P.max()


def test_a_slider_slips_where_softer_contact_cannot_hold_it() -> None:
    # With constant P = F the slider sticks until k1 rises: then k1 x exceeds μ P.
    p = Parameters(m=1.0, k1=0.5, k2=1.0, k3=0.0, c1=0.0, c2=0.0, F=1.0, k_nl=0.0, mu=0.8)
    p = p.with_values({"v_belt": 1.0})
    tables = {"k1": [(0.0, 0.5), (1.0, 2.0)]}
    run = simulate(p, t_end=1.5, start=(0.0, 1.0, -1.0, 0.0), over_time=tables)
    assert next((c.t, c.first.name, c.then.name) for c in run.mode_changes) == (
        1.0,
        "STICK",
        "FORWARD",
    )


def test_methods_without_tables_say_which_follow_them() -> None:
    with pytest.raises(InputError, match="c1 over time: the method must be taylor, fmu or fmu-nat"):
        simulate(over_time={"c1": [(0.0, 1.0)]}, method="rk4")
    with pytest.raises(
        InputError, match="F, c1 over time: the method must be taylor or fmu-native"
    ):
        simulate(over_time={"F": [(0.0, 1.0)], "c1": [(0.0, 1.0)]}, method="fmu")
