"""Other packages' solvers, each used as its documentation recommends, if installed."""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.slider_belt import State, accelerations, mode_of
from tests.references import Reference

from .solvers import Run, Solver, decades


def peers() -> list[Solver]:
    """Solvers that are installed on this machine."""
    solvers = []
    if find_spec("heyoka") is not None:
        solvers.append(
            Solver(
                "heyoka, switch by event callback",
                decades(3, 16, per_decade=2),
                _prepare_heyoka(False),
            )
        )
        solvers.append(
            Solver("heyoka with fast_math", decades(3, 16, per_decade=2), _prepare_heyoka(True))
        )
    if find_spec("sksundae") is not None:
        solvers.append(Solver("CVODE (Adams) with events", decades(4, 12), _prepare_cvode))
    if find_spec("numbalsoda") is not None:
        solvers.append(
            Solver("numbalsoda DOP853 across the kink", decades(4, 13), _prepare_numbalsoda)
        )
    if shutil.which("gcc") is not None:
        solvers.append(
            Solver("C RK4 with bisection", [0.02 / 2**n for n in range(11)], _prepare_c_rk4)
        )
    return solvers


def missing_packages() -> list[str]:
    """Packages and programs that are missing and would add solvers."""
    packages = [n for n in ("heyoka", "sksundae", "numbalsoda") if find_spec(n) is None]
    return packages + (["gcc"] if shutil.which("gcc") is None else [])


def _prepare_heyoka(fast_math: bool) -> Callable[[Reference, State, float], Run]:
    def prepare(scene: Reference, start: State, tol: float) -> Run:
        import heyoka as hy

        p = scene.parameters
        x, vx, y, vy = hy.make_vars("x", "vx", "y", "vy")
        # The parameter is 1 in contact and 0 when separated.
        force = hy.par[0] * (-p.k2 * y - p.k_nl * y**3)
        coupling = 0.5 * p.k3 * (x - y)
        system = [
            (x, vx),
            (vx, (p.mu * force - p.c1 * vx - p.k1 * x - coupling) / p.m),
            (y, vy),
            (vy, (force - p.F - p.c2 * vy + coupling) / p.m),
        ]

        def switch(integrator: Any, direction: int) -> bool:
            integrator.pars[0] = 0.0 if direction > 0 else 1.0
            return True

        events = [hy.t_event(y, callback=switch)] if scene.separation else []
        integrator = hy.taylor_adaptive(
            system, list(start), t_events=events, pars=[1.0], tol=tol, fast_math=fast_math
        )
        mode = float(mode_of(p, start, separation=scene.separation))

        def run() -> Sequence[float]:
            integrator.time = 0.0
            integrator.state[:] = start
            integrator.pars[0] = mode
            if events:
                integrator.reset_cooldowns()
            integrator.propagate_until(scene.t_end)
            return integrator.state.tolist()  # type: ignore[no-any-return]

        return run

    return prepare


def _prepare_cvode(scene: Reference, start: State, tol: float) -> Run:
    from sksundae.cvode import CVODE

    p = scene.parameters

    def solver(mode: Mode) -> Any:
        def motion(_t: float, z: Any, rates: Any) -> None:
            state = z.tolist()
            rates[0], rates[2] = state[1], state[3]
            rates[1], rates[3] = accelerations(p, state, mode)

        def switch(_t: float, z: Any, events: Any) -> None:
            events[0] = z[2]

        options = {"eventsfn": switch, "num_events": 1} if scene.separation else {}
        return CVODE(motion, method="Adams", rtol=tol, atol=tol, max_num_steps=1_000_000, **options)

    # The modes on a belt that is always faster: contact and separation.
    solvers = {mode: solver(mode) for mode in ALWAYS_SLIDING}

    def run() -> Sequence[float]:
        t, state = 0.0, start
        while t < scene.t_end:
            mode = mode_of(p, state, separation=scene.separation)
            solution = solvers[mode].solve(np.array([t, scene.t_end]), np.array(state))
            t = float(solution.t[-1])
            x, vx, y, vy = solution.y[-1].tolist()
            # A solution that ends before t_end ends at a switch, where y is zero but for rounding.
            state = (x, vx, y if t >= scene.t_end else 0.0, vy)
        return state

    return run


def _prepare_numbalsoda(scene: Reference, start: State, tol: float) -> Run:
    import numba
    from numbalsoda import dop853, lsoda_sig

    p = scene.parameters
    m, k1, k2, k3, c1, c2, preload, k_nl, mu = p.values()
    h, separation = 0.5 * k3, scene.separation

    @numba.cfunc(lsoda_sig)  # type: ignore[untyped-decorator, unused-ignore]
    def motion(_t: Any, z: Any, rates: Any, _data: Any) -> None:
        x, vx, y, vy = z[0], z[1], z[2], z[3]
        force = 0.0
        if y < 0.0 or not separation:
            force = -k2 * y - k_nl * y * y * y
        rates[0], rates[2] = vx, vy
        rates[1] = (mu * force - c1 * vx - k1 * x - h * (x - y)) / m
        rates[3] = (force - preload - c2 * vy + h * (x - y)) / m

    times = np.array([0.0, scene.t_end])

    def run() -> Sequence[float]:
        states, success = dop853(motion.address, np.array(start), times, rtol=tol, atol=tol)
        if not success:
            raise ArithmeticError("numbalsoda has failed")
        return states[-1].tolist()  # type: ignore[no-any-return]

    return run


def _prepare_c_rk4(scene: Reference, start: State, step: float) -> Run:
    library = _compile_rk4()
    values = (ctypes.c_double * 9)(*scene.parameters.values())
    steps = round(scene.t_end / step)
    contact = int(mode_of(scene.parameters, start, separation=scene.separation))

    def run() -> Sequence[float]:
        state = (ctypes.c_double * 4)(*start)
        step_s = ctypes.c_double(scene.t_end / steps)
        library.run(values, state, contact, int(scene.separation), step_s, ctypes.c_long(steps))
        return list(state)

    return run


def _compile_rk4() -> ctypes.CDLL:
    source = Path(__file__).with_name("rk4.c")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "rk4.so"
        command = ["gcc", "-O3", "-march=native", "-shared", "-fPIC", "-o", str(library)]
        subprocess.run([*command, str(source)], check=True)
        return ctypes.CDLL(str(library))
