"""Solvers of a benchmark, with settings from coarse to fine.

The scene of a benchmark is a `Reference`: parameters and start with a final state to 25 digits.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from fivtui import simulate
from fivtui.model.slider_belt import State
from fivtui.transient.request import KernelChoice
from tests.references import Reference

# Computes the transient once and returns its final state.
Run = Callable[[], Sequence[float]]


@dataclass(frozen=True)
class Solver:
    """A solver under test.

    `prepare` does the untimed work needed once for a scene, its start as a state, and a setting,
    mainly compilation.
    """

    name: str
    settings: Sequence[float]
    prepare: Callable[[Reference, State, float], Run]


def decades(first: int, end: int, per_decade: int = 1) -> list[float]:
    """Powers of ten from 1e-`first` down to 1e-`end`."""
    return [10.0 ** (-n / per_decade) for n in range(first * per_decade, end * per_decade + 1)]


def _prepare_taylor(kernel: KernelChoice) -> Callable[[Reference, State, float], Run]:
    def prepare(scene: Reference, _start: State, tol: float) -> Run:
        def run() -> Sequence[float]:
            final = simulate(
                scene.parameters,
                t_end=scene.t_end,
                tol=tol,
                separation=scene.separation,
                start=scene.start,
                kernel=kernel,
            ).final
            return (final.x, final.vx, final.y, final.vy)

        return run

    return prepare


def _prepare_method(method: str) -> Callable[[Reference, State, float], Run]:
    def prepare(scene: Reference, _start: State, setting: float) -> Run:
        def run() -> Sequence[float]:
            final = simulate(
                scene.parameters,
                t_end=scene.t_end,
                separation=scene.separation,
                start=scene.start,
                method=method,
                **({"step": setting} if method == "rk4" else {"tol": setting}),  # type: ignore[arg-type]
            ).final
            return (final.x, final.vx, final.y, final.vy)

        return run

    return prepare


COMPILED: Final = "fivtui taylor, compiled"
FIVTUI_SOLVERS: Final = (
    Solver(COMPILED, decades(2, 13, 2), _prepare_taylor("compiled")),
    Solver("fivtui taylor, interpreted", decades(2, 13), _prepare_taylor("interpreted")),
    Solver("fivtui rk4", [0.02, 0.01, 0.005], _prepare_method("rk4")),
    Solver("SciPy DOP853 with events", decades(4, 12), _prepare_method("scipy-dop853")),
    Solver("SciPy LSODA with events", decades(4, 12), _prepare_method("scipy-lsoda")),
)
