"""The result of an attractor search as one phrase."""

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .attractor_search import Coexistence

SEARCHING: Final = "searching for limit cycles…"


def coexistence_words(result: "Coexistence", since: str = "") -> str:
    """The attractors beside the equilibrium, or that there are none, as one phrase.

    `since` is the start of their range, for example `` from μ = 0.2779``.

    For example ``a limit cycle coexists: half peak-to-peak 7.443 m (after a knock)``, or ``no limit
    cycle found from 11 starts``.
    """
    from .explorer import Kind

    starts = len(result.reached)
    verb, origin = "coexist" if result.coexists else "attract", _origin(result)
    cycles = [attractor for attractor in result.others if attractor.orbit is not None]
    sizes = " and ".join(f"{attractor.half_range:#.4g} m" for attractor in cycles)
    parts = []
    if len(cycles) == 1:
        parts.append(f"a limit cycle {verb}s{since}: half peak-to-peak {sizes}{origin}")
    elif cycles:
        parts.append(f"{len(cycles)} limit cycles {verb}{since}: half peak-to-peak {sizes}{origin}")
    if any(attractor.kind is Kind.UNBOUNDED for attractor in result.others):
        parts.append(f"motion grows without bounds{origin}")
    if not parts:
        parts.append(f"no limit cycle found from {starts} starts")
    open_ends = sum(result.attractors[index].kind is Kind.UNSETTLED for index in result.reached)
    if open_ends:
        parts.append(f"from {open_ends} of {starts} starts motion did not settle")
    return "; ".join(parts)


def reached_words(result: "Coexistence") -> str:
    """What transients reach on a belt of finite speed, and the limits of that search."""
    count = len(result.reached)
    return (
        f"transients from {count} starts at μ = {result.parameters.mu:g}: "
        f"{coexistence_words(result)}; below which friction there are no limit cycles is not "
        "searched on a belt of finite speed (fivtui branch --vary mu --from cycle follows those "
        "found)"
    )


def _origin(result: "Coexistence") -> str:
    # The start from which a stable equilibrium is left.
    if not result.coexists:
        return ""
    from_static = any(
        result.attractors[result.reached[0]] is attractor for attractor in result.others
    )
    return " (from the static start)" if from_static else " (after a knock)"
