"""The result of an attractor search as one phrase."""

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .attractor_search import Coexistence

SEARCHING: Final = "searching for limit cycles…"


def coexistence_words(found: "Coexistence", since: str = "") -> str:
    """What was found beside the equilibrium, or that nothing was, in one phrase.

    `since` says from where on, for example `` from μ = 0.2779``.

    For example ``a limit cycle coexists: half peak-to-peak 7.443 m (after a knock)``, or ``no limit
    cycle found from 11 starts``.
    """
    from .explorer import Kind

    starts = len(found.reached)
    verb = "coexist" if found.coexists else "attract"
    cycles = [each for each in found.others if each.orbit is not None]
    sizes = " and ".join(f"{each.half_range:#.4g} m" for each in cycles)
    parts = []
    if len(cycles) == 1:
        parts.append(f"a limit cycle {verb}s{since}: half peak-to-peak {sizes}{_way(found)}")
    elif cycles:
        parts.append(
            f"{len(cycles)} limit cycles {verb}{since}: half peak-to-peak {sizes}{_way(found)}"
        )
    if any(each.kind is Kind.UNBOUNDED for each in found.others):
        parts.append(f"motion grows without bounds{_way(found)}")
    if not parts:
        parts.append(f"no limit cycle found from {starts} starts")
    open_ends = sum(found.attractors[place].kind is Kind.UNSETTLED for place in found.reached)
    if open_ends:
        parts.append(f"from {open_ends} of {starts} starts motion did not settle")
    return "; ".join(parts)


def reached_words(found: "Coexistence") -> str:
    """What transients reach on a belt of finite speed, and what is not known of other friction."""
    count = len(found.reached)
    return (
        f"transients from {count} starts at μ = {found.parameters.mu:g}: "
        f"{coexistence_words(found)}; below which friction there are no limit cycles is not "
        "searched on a belt of finite speed (fivtui branch --vary mu --from cycle follows those "
        "found)"
    )


def _way(found: "Coexistence") -> str:
    # What takes the slider there from a stable equilibrium.
    if not found.coexists:
        return ""
    from_static = any(found.attractors[found.reached[0]] is each for each in found.others)
    return " (from the static start)" if from_static else " (after a knock)"
