"""Scenes that come with the program: the paper's examples.

The paper is "Nonlinear friction-induced vibration of a slider-belt system". The static start is
at rest at the equilibrium without friction, μ = 0.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from fivtui.model import Parameters, System, TimeTable, equilibrium

from .scene import Scene

DEFAULT_PRESET: Final = "base"

_BASE: Final = Parameters()
_COEXISTENCE: Final = _BASE.with_values({"F": 120.0})
# Horizon, s: in its second half the motion is settled to five digits.
_COEXISTENCE_T_END: Final = 800.0


def _offset_from_equilibrium(p: Parameters, offset: float) -> tuple[float, float, float, float]:
    # A start (x, ẋ, y, ẏ) at rest, with y at an offset, m, from the equilibrium.
    point = equilibrium(System(p))
    return (point.x, 0.0, point.y + offset, 0.0)


_SCENES: Final = (
    Scene(
        name=DEFAULT_PRESET,
        description="Figs. 10 to 12, Case 1: the base set, separation considered",
        parameters=_BASE,
    ),
    Scene(
        name="separation-ignored",
        description="Figs. 10 to 12, Case 2: the base set, separation ignored",
        parameters=_BASE,
        separation=False,
    ),
    Scene(
        name="linear",
        description="Figs. 3 to 9, the linear system: k_nl = 0, separation ignored",
        parameters=_BASE.with_values({"k_nl": 0.0}),
        separation=False,
    ),
    Scene(
        name="nonproportional-damping",
        description="Fig. 5: non-proportional damping c1 = 0.8, F = 100 N",
        parameters=_BASE.with_values({"c1": 0.8, "F": 100.0}),
    ),
    Scene(
        name="soft-horizontal",
        description="Figs. 8 and 9: k1 = 50, k2 = 100, softer horizontally than vertically",
        parameters=_BASE.with_values({"k1": 50.0, "k2": 100.0}),
    ),
    Scene(
        name="stiff-contact",
        description="Section 4: μ = 1.2, F = 100 N, k_nl = 300, said to be stabilised",
        parameters=_BASE.with_values({"mu": 1.2, "F": 100.0, "k_nl": 300.0}),
    ),
    Scene(
        name="coexistence",
        description="Section 5: F = 120 N, stable, yet the static start ends in a limit cycle",
        parameters=_COEXISTENCE,
        t_end=_COEXISTENCE_T_END,
    ),
    Scene(
        name="coexistence-decay",
        description="Section 5: F = 120 N, a start 0.1 m off the equilibrium dies out",
        parameters=_COEXISTENCE,
        start=_offset_from_equilibrium(_COEXISTENCE, 0.1),
        t_end=_COEXISTENCE_T_END,
    ),
    Scene(
        name="brake-stop",
        description="Beyond the paper, a brake application: preload rises, the belt slows to rest",
        parameters=_BASE.with_values({"mu": 0.6, "mu_s": 0.9, "v_s": 0.3, "c2": 2.0}),
        t_end=40.0,
        over_time=(
            ("F", TimeTable((0.0, 4.0), (10.0, 60.0))),
            ("v_belt", TimeTable((0.0, 4.0, 24.0), (10.0, 10.0, 0.0))),
        ),
    ),
)

PRESETS: Final[Mapping[str, Scene]] = MappingProxyType({scene.name: scene for scene in _SCENES})
