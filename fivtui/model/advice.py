"""Advice for computations that cannot finish, composed of the remedies that apply."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from .field import load
from .parameters import Parameters


@dataclass(frozen=True, slots=True)
class Remedy:
    """A change that helps some parameter sets only.

    Attributes
    ----------
    text : str
        Noun phrase that follows "use".
    applies : callable
        Whether it is possible, of a parameter set and of whether separation is considered.
    """

    text: str
    applies: Callable[[Parameters, bool], bool]


LARGER_V_S: Final = Remedy(
    "a larger v_s", lambda p, _: p.v_belt is not None and p.speed_law is not None
)
LESS_DAMPING: Final = Remedy("less damping", lambda p, _: max(p.c1, p.c2) > 0.0)
# The linearisation depends on the preload by the cubic stiffness alone.
SMALLER_PRELOAD: Final = Remedy("a smaller preload", lambda p, _: load(p) != 0.0 and p.k_nl > 0.0)
SEPARATION: Final = Remedy("separation", lambda _, separation: not separation)
CUBIC_CONTACT: Final = Remedy("a cubic contact (k_nl above 0)", lambda p, _: p.k_nl == 0.0)


def use_one_of(alternatives: Iterable[str]) -> str:
    """Advice to use one of some alternatives: "use a, b or c"."""
    *others, final = alternatives
    return f"use {', '.join(others)} or {final}" if others else f"use {final}"


def advise(p: Parameters, remedies: Iterable[Remedy | str], *, separation: bool = True) -> str:
    """Advice to use one of the remedies that apply to a parameter set.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    remedies : iterable of Remedy or str
        Changes that may help; a text applies to all parameter sets. At least one must apply.
    separation : bool
        Whether separation is considered.
    """
    return use_one_of(
        remedy if isinstance(remedy, str) else remedy.text
        for remedy in remedies
        if isinstance(remedy, str) or remedy.applies(p, separation)
    )
