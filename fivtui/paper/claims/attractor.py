"""Claims of sections 1 and 5: what stable and unstable systems end in."""

import dataclasses
from itertools import product
from typing import Final

from fivtui.equilibrium import growth_rate
from fivtui.model import Parameters, System, equilibrium
from fivtui.orbits import EventKind, branch
from fivtui.paper import PaperResults, critical_mu
from fivtui.scene import PRESETS, Scene

from .claim import Chapter, Finding, Quantity

ATTRACTORS: Final = Chapter()
_BASE: Final = Parameters()
_COEXISTENCE: Final = PRESETS["coexistence"]
_DECAY: Final = PRESETS["coexistence-decay"]
# A motion whose half peak-to-peak is less than this part of its peak has returned to rest.
_RETURNED: Final = 0.1
# Long enough for a motion to decay, s.
_T_END: Final = 200.0
_TOL: Final = 1e-9


def _linear(t_end: float) -> Scene:
    scene = dataclasses.replace(PRESETS["linear"], name="linear, unstable", t_end=t_end)
    return scene.with_values({"mu": 1.2})


_LINEAR: Final = (_linear(30.0), _linear(60.0))


def _grid_of_starts() -> tuple[Scene, ...]:
    # Static starts from 10 to 150 N at stiffnesses and friction coefficients like the paper's.
    grid = product(range(10, 151, 20), (20.0, 50.0, 100.0, 200.0, 500.0), (0.3, 0.5, 0.7, 1.0))
    base = dataclasses.replace(PRESETS["base"], name="static start", t_end=_T_END, tol=_TOL)
    scenes = (base.with_values({"F": F, "k_nl": k_nl, "mu": mu}) for F, k_nl, mu in grid)
    return tuple(scene for scene in scenes if growth_rate(System(scene.parameters)) < 0.0)


_STABLE: Final = _grid_of_starts()


def _pushed_up(offset: float) -> Scene:
    point = equilibrium(System(_COEXISTENCE.parameters))
    start = (point.x, 0.0, point.y + offset, 0.0)
    return dataclasses.replace(_COEXISTENCE, name=f"offset {offset:g} m", start=start)


_PUSHED: Final = _pushed_up(0.3)


@ATTRACTORS.claim(
    "Abstract, 1",
    "If a linear contact never breaks, unstable vibration grows without bound",
    "unbounded",
    scenes=_LINEAR,
)
def _linear_contact_unbounded(results: PaperResults) -> Finding:
    early, late = results.amplitudes(_LINEAR)
    growth = growth_rate(System(_LINEAR[0].parameters))
    return Finding(
        late.y_half_range > 1e3 * early.y_half_range and growth > 0.0,
        (
            Quantity("half peak-to-peak of y, 15 to 30 s", early.y_half_range, "m"),
            Quantity("half peak-to-peak of y, 30 to 60 s", late.y_half_range, "m"),
            Quantity("growth rate", growth, "1/s"),
        ),
        "k_nl = 0, μ = 1.2",
    )


@ATTRACTORS.claim(
    "5",
    "In most situations a stable system does not separate",
    "no separation, mostly",
    scenes=_STABLE,
)
def _stable_seldom_separates(results: PaperResults) -> Finding:
    separated = sum(a.separations > 0 for a in results.amplitudes(_STABLE))
    return Finding(
        separated < 0.5 * len(_STABLE),
        (Quantity("stable static starts", len(_STABLE)), Quantity("with separation", separated)),
        f"static starts of {_T_END:g} s: F = 10 to 150 N, k_nl = 20 to 500 N/m³, μ = 0.3 to 1",
    )


@ATTRACTORS.claim(
    "5",
    "If a stable system separates, its vibration still dies out",
    "returns to the equilibrium",
    scenes=(*_STABLE, _COEXISTENCE, _DECAY, _PUSHED),
)
def _stable_returns_to_equilibrium(results: PaperResults) -> Finding:
    separated = [
        (scene, amplitude)
        for scene, amplitude in zip(_STABLE, results.amplitudes(_STABLE), strict=True)
        if amplitude.separations > 0
    ]
    returned = sum(
        amplitude.y_half_range < _RETURNED * amplitude.y_peak for _, amplitude in separated
    )
    static, small, large = results.amplitudes((_COEXISTENCE, _DECAY, _PUSHED))
    return Finding(
        returned == len(separated) and static.y_half_range < _RETURNED * static.y_peak,
        (
            Quantity("stable static starts with separation", len(separated)),
            Quantity("of these back at the equilibrium", returned),
            Quantity(
                "growth rate (F = 120 N)", growth_rate(System(_COEXISTENCE.parameters)), "1/s"
            ),
            Quantity("half peak-to-peak, second half, static start", static.y_half_range, "m"),
            Quantity("half peak-to-peak, second half, offset 0.3 m", large.y_half_range, "m"),
            Quantity("half peak-to-peak, second half, offset 0.1 m", small.y_half_range, "m"),
        ),
        "a stable equilibrium and a large separating limit cycle coexist: eigenvalues tell of "
        "small motions alone, and the start decides",
    )


@ATTRACTORS.claim(
    "5.1",
    "The critical friction coefficient of the example (F = 80 N, k_nl = 100 N/m³) is 0.28",
    "μ_c = 0.28",
)
def _critical_friction_of_the_example(_: PaperResults) -> Finding:
    critical = critical_mu(_BASE)
    lighter = critical_mu(_BASE.with_values({"F": 50.0}))
    events = branch(_BASE, "mu", low=0.0, high=critical).events
    fold = next(event for event in events if event.kind is EventKind.FOLD)
    return Finding(
        abs(critical - 0.28) < 0.005,
        (
            Quantity("μ_c(F = 80 N)", critical),
            Quantity("fold of the limit cycles (F = 80 N)", fold.value),
            Quantity("μ_c(F = 50 N)", lighter),
        ),
        "0.28 is the eigenvalues' answer for F = 50 N; at F = 80 N itself it is the fold where the "
        "separating limit cycle is born, below which large disturbances die out as well: likely "
        "what the paper saw. μ = 0.7 is above all three, so that the example is unstable all the "
        "same",
    )
