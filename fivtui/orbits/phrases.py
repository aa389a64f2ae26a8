"""The result of an attractor search as one phrase."""

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .attractor_search import Coexistence

SEARCHING_TEXT: Final = "searching for limit cycles…"


def coexistence_phrase(result: "Coexistence", since: str = "") -> str:
    """One phrase about the attractors beside the equilibrium.

    The text `since` says from which parameter on they exist, for example `` from μ = 0.2779``.

    Examples: ``a limit cycle coexists: half peak-to-peak 7.443 m (after a knock)``, and ``no limit
    cycle found from 11 starts``.
    """
    from .explorer import Kind

    start_count = len(result.reached)
    verb, cause = "coexist" if result.coexists else "attract", _cause_text(result)
    cycles = [attractor for attractor in result.others if attractor.orbit is not None]
    sizes = " and ".join(f"{attractor.half_range:#.4g} m" for attractor in cycles)
    parts = []
    if len(cycles) == 1:
        parts.append(f"a limit cycle {verb}s{since}: half peak-to-peak {sizes}{cause}")
    elif cycles:
        parts.append(f"{len(cycles)} limit cycles {verb}{since}: half peak-to-peak {sizes}{cause}")
    if any(attractor.kind is Kind.UNBOUNDED for attractor in result.others):
        parts.append(f"motion grows without bounds{cause}")
    if not parts:
        parts.append(f"no limit cycle found from {start_count} starts")
    unsettled = sum(result.attractors[index].kind is Kind.UNSETTLED for index in result.reached)
    if unsettled:
        parts.append(f"from {unsettled} of {start_count} starts motion did not settle")
    return "; ".join(parts)


def transients_phrase(result: "Coexistence") -> str:
    """One phrase about what transients reach on a belt of finite speed."""
    start_count = len(result.reached)
    return (
        f"transients from {start_count} starts at μ = {result.parameters.mu:g}: "
        f"{coexistence_phrase(result)}; the least friction with limit cycles is not searched on a "
        "belt of finite speed (fivtui branch --vary mu --from cycle follows a cycle along μ)"
    )


def _cause_text(result: "Coexistence") -> str:
    # How motion leaves the basin of a stable equilibrium.
    if not result.coexists:
        return ""
    from_static = any(
        result.attractors[result.reached[0]] is attractor for attractor in result.others
    )
    return " (from the static start)" if from_static else " (after a knock)"
