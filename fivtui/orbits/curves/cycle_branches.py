"""Branches of limit cycles along a parameter, stable and unstable."""

from typing import Final

from fivtui.model import InputError, Parameters, parameter_spec
from fivtui.orbits.explorer import Watch
from fivtui.transient import Progress

from .origins import from_cycle, from_hopf
from .result import CycleBranch, Origin

ORIGINS: Final[tuple[Origin, ...]] = ("hopf", "cycle")
# Bounds of the parameter, if not given: its value over and times this.
_SPAN: Final = 10.0


def branch(
    parameters: Parameters | None,
    name: str,
    *,
    low: float | None = None,
    high: float | None = None,
    origin: Origin = "hopf",
    separation: bool = True,
    progress: Progress | None = None,
) -> CycleBranch:
    """Follow a branch of limit cycles along a parameter, through folds, stable or not.

    By pseudo-arclength continuation over shooting: folds, the first touch of y = 0, period
    doublings and tori are located to 1e-10 of the parameter. Branches that are not connected to the
    one followed are not found.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None. Of several Hopf points in the range the one
        nearest to its value of the parameter that varies is taken.
    name : str
        The parameter that varies.
    low, high : float, optional
        Range of the parameter; a tenth and ten times its value if not given.
    origin : "hopf" or "cycle"
        Where the branch begins: at a Hopf point of the equilibrium, or at the first limit cycle
        that is reached by transients of the parameter set; this one is followed both ways.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the fraction of the greatest number of points; cancels the work by returning
        False.

    Returns
    -------
    CycleBranch
        The limit cycles along the branch, and the events.

    Raises
    ------
    InputError
        If the name is unknown, or the range is wrong.
    ComputationError
        If there is nothing to begin with in the range.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import branch
    >>> found = branch(None, "mu", low=0.2, high=1.0)
    >>> [(str(event.kind), round(event.value, 6)) for event in found.events]
    [('hopf', 0.439388), ('touch', 0.37073), ('fold', 0.277877)]
    """
    p = Parameters() if parameters is None else parameters
    if origin not in ORIGINS:
        raise InputError(f"origin = {origin!r}: must be one of {', '.join(ORIGINS)}")
    bottom, top = _range(p, name, low, high)
    if not separation and p.k_nl == 0.0 and name != "k_nl":
        raise InputError("k_nl = 0: must be above 0 where separation is ignored: it is linear")
    watch = Watch(progress)
    if origin == "hopf":
        begun = from_hopf(p, name, (bottom, top), watch, separation=separation)
    else:
        begun = from_cycle(p, name, (bottom, top), watch, separation=separation)
    if progress is not None:
        progress(1.0)
    return CycleBranch(p, separation, name, bottom, top, origin, *begun)


def _range(p: Parameters, name: str, low: float | None, high: float | None) -> tuple[float, float]:
    spec, value = parameter_spec(name), getattr(p, name)
    if (low is None or high is None) and not value > 0.0:
        raise InputError(f"{name} = {value:g}: must be above 0, or the range be given")
    bottom = max(value / _SPAN, spec.lower) if low is None else spec.check(low)
    top = min(value * _SPAN, spec.upper) if high is None else spec.check(high)
    if not bottom < top:
        raise InputError(f"{name}: {bottom:g} to {top:g}: must be a range of ascending values")
    return bottom, top
