"""The Taylor path on a belt of finite speed against references and independent integrators."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.model.modes import Mode
from fivtui.transient.request import KernelChoice
from fivtui.transient.steppers.rk4_on_belts import BeltRungeKutta4
from tests.support.independent_belt import IndependentBelt, integrate

REFERENCES: dict[str, Any] = json.loads(
    Path(__file__).parents[1].joinpath("references", "belt.json").read_text(encoding="utf-8")
)
KERNELS: tuple[KernelChoice, ...] = ("interpreted", "compiled")


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("name", REFERENCES)
def test_transients_equal_references_of_25_digits(name: str, kernel: KernelChoice) -> None:
    reference = REFERENCES[name]
    run = simulate(
        Parameters().with_values(reference["parameters"]),
        start=reference["start"],
        separation=reference["separation"],
        t_end=reference["t_end"],
        kernel=kernel,
    )
    final = [float(text) for text in reference["final"]]
    assert run.final[1:] == pytest.approx(final, rel=1e-11, abs=1e-11 * max(map(abs, final)))
    changes = [(c.first.name.lower(), c.then.name.lower()) for c in run.mode_changes]
    assert changes == [(first, successor) for _, first, successor in reference["changes"]]
    times = [float(t) for t, _, _ in reference["changes"]]
    assert [c.t for c in run.mode_changes] == pytest.approx(times, abs=1e-11)


def test_the_references_have_all_modes() -> None:
    changes = [change for reference in REFERENCES.values() for change in reference["changes"]]
    modes_found = {mode for _, *modes in changes for mode in modes}
    # CONTACT is the mode on a belt that is always faster, without `v_belt`.
    assert modes_found == {mode.name.lower() for mode in Mode if mode is not Mode.CONTACT}
    assert len(REFERENCES) >= 8


def random_scenes(count: int, seed: int) -> list[tuple[Parameters, bool, np.ndarray]]:
    rng = np.random.default_rng(seed)
    scenes = []
    for _ in range(count):
        mu, uniform = rng.uniform(0.1, 1.0), rng.uniform
        p = Parameters(
            m=uniform(1.0, 6.0),
            k1=uniform(30.0, 150.0),
            k2=uniform(30.0, 100.0),
            k3=uniform(0.0, 100.0),
            c1=uniform(0.0, 0.6),
            c2=uniform(0.0, 0.6),
            F=uniform(10.0, 100.0),
            k_nl=uniform(0.0, 200.0),
            mu=mu,
            mu_s=mu * uniform(1.0, 1.5),
            v_s=uniform(0.1, 1.0) if rng.random() < 0.5 else None,
            v_belt=uniform(0.0, 3.0),
        )
        scenes.append((p, bool(rng.random() < 0.8), rng.uniform(-1.5, 1.5, 4)))
    return scenes


@pytest.mark.parametrize("scene", range(10))
def test_a_random_scene_has_the_motion_of_an_independent_integrator(scene: int) -> None:
    p, separation, start = random_scenes(10, 1976)[scene]
    state, modes = integrate(IndependentBelt(p, separation), start, 4.0)
    run = simulate(p, t_end=4.0, start=start.tolist(), separation=separation)
    mode_sequence = [run.first_mode, *(change.then for change in run.mode_changes)]
    assert [mode.name.lower() for mode in mode_sequence] == modes
    assert run.final[1:] == pytest.approx(state.tolist(), rel=1e-8, abs=1e-8)


def test_random_scenes_have_the_motion_of_rk4_with_bisection() -> None:
    for separation in (True, False):
        scenes = [(p, start_state) for p, _, start_state in random_scenes(12, 5)]
        step, t_end = 4e-3, 1.5
        rk4 = BeltRungeKutta4(
            [p for p, _ in scenes],
            [tuple(start_state.tolist()) for _, start_state in scenes],
            step=step,
            separation=separation,
        )
        for _ in range(round(t_end / step)):
            rk4.advance()
        for index, (p, start) in enumerate(scenes):
            run = simulate(p, t_end=t_end, start=start.tolist(), separation=separation)
            last_mode = run.mode_changes[-1].then if run.mode_changes else run.first_mode
            # On these belts `contact` holds the number of the mode.
            assert Mode(int(rk4.contact[index])) is last_mode
            assert run.final[1:] == pytest.approx(rk4.state[:, index].tolist(), abs=2e-4)


@pytest.mark.parametrize("method", ["scipy-dop853", "scipy-lsoda", "scipy-radau"])
def test_random_scenes_have_the_motion_of_scipy(method: str) -> None:
    for p, separation, start in random_scenes(4, 11):
        settings = {"t_end": 1.0, "start": start.tolist(), "separation": separation}
        run, taylor = simulate(p, method=method, tol=1e-8, **settings), simulate(p, **settings)
        assert run.events.transitions == taylor.events.transitions
        assert run.final == pytest.approx(taylor.final, abs=1e-4)


@pytest.mark.parametrize("method", ["rk4", "scipy-dop853", "scipy-lsoda", "scipy-radau"])
def test_the_other_methods_have_the_same_events(method: str) -> None:
    p, start = Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4), (-2.0, -4.0, -1.0, 3.0)
    step, tol = (4e-3, 1e-12) if method == "rk4" else (None, 1e-8)
    run = simulate(p, t_end=2.0, start=start, method=method, samples=31, step=step, tol=tol)
    taylor = simulate(p, t_end=2.0, start=start, samples=31)
    assert run.final == pytest.approx(taylor.final, abs=2e-5)
    assert run.events.transitions == taylor.events.transitions
    assert run.events.stick_time == pytest.approx(taylor.events.stick_time, abs=2e-5)
    for name in ("x", "vx", "y", "vy", "P"):
        assert run.to_columns()[name] == pytest.approx(taylor.to_columns()[name], abs=1e-3)
