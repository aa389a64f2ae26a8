"""Advice for computations that cannot finish, composed of the remedies that apply."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from .system import System


@dataclass(frozen=True, slots=True)
class Remedy:
    """A change that helps some parameter sets only."""

    text: str
    applies: Callable[[System], bool]


# Friction falls from μ_s to μ over the sliding speed v_s; `speed_law` is None where friction is
# constant.
LARGER_V_S: Final = Remedy(
    "a larger v_s",
    lambda system: system.parameters.v_belt is not None and system.parameters.speed_law is not None,
)
# Damping c changes a velocity within the time m/c, which may be too short to resolve.
LESS_DAMPING: Final = Remedy(
    "less damping", lambda system: max(system.parameters.c1, system.parameters.c2) > 0.0
)
SEPARATION: Final = Remedy("separation", lambda system: not system.separation)
CUBIC_CONTACT: Final = Remedy(
    "a cubic contact (k_nl above 0)", lambda system: system.parameters.k_nl == 0.0
)


def advise_one_of(alternatives: Iterable[str]) -> str:
    """Advice to use one of some alternatives: "use a, b or c"."""
    *first, final = alternatives
    return f"use {', '.join(first)} or {final}" if first else f"use {final}"


def advise(system: System, remedies: Iterable[Remedy | str]) -> str:
    """Advice to use one of the remedies that apply to a system."""
    return advise_one_of(
        remedy if isinstance(remedy, str) else remedy.text
        for remedy in remedies
        if isinstance(remedy, str) or remedy.applies(system)
    )
