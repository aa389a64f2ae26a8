"""The verdict on safe friction, its basis and coexisting limit cycles as text.

The global search has rounds, each below the least μ of the attractors known before it. The verdict
depends on the motions of the last round.
"""

import math
from decimal import ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .verdict import SafeFriction


# Why the last round of a search follows no motions.
_TOO_SLOW: Final = "motions die out too slowly to be followed within the limit of steps"
# Greatest number of events that the phrase about continuation names.
_NAMED_EVENTS: Final = 6


def _below_text(bound: float) -> str:
    # Rounded down: what holds below μ = 0.277877 does not hold up to 0.2779.
    rounded = Context(prec=5, rounding=ROUND_FLOOR).create_decimal_from_float(bound)
    return f"below μ = {float(rounded):g}"


def _mu_text(value: float) -> str:
    return f"μ = {value:.4g}"


def verdict_text(result: "SafeFriction") -> str:
    """The verdict as one phrase.

    For example ``stable to small disturbances below μ = 0.43938; to all disturbances found below
    μ = 0.27787``.
    """
    critical = result.critical_mu
    stable_range = "at every μ" if critical is None else _below_text(critical)
    if result.undamped:
        return f"small disturbances do not grow {stable_range}; without damping none dies out"
    verdict = f"stable to small disturbances {stable_range}"
    if result.linear:
        return f"{verdict}; to large ones as well: the system is linear"
    if result.unknown_above is not None:
        return f"{verdict}; {_unknown_text(result)}"
    note = f" ({_undecided_text(result)})" if result.basis.rounds[-1].undecided else ""
    if result.others and result.safe_mu is not None:
        return f"{verdict}; to all disturbances found {_below_text(result.safe_mu)}{note}"
    # With a critical μ the verdict names it already.
    searched_range = "" if critical is not None else f" up to {_mu_text(result.searched_to)}"
    return f"{verdict}; to all disturbances found{searched_range} as well{note}"


def _unknown_text(result: "SafeFriction") -> str:
    # From which μ on safe μ is not known, its upper bound if an attractor was found, and why.
    limit = result.unknown_above
    # A limit of 0: safe μ is known at no μ.
    unknown = f"safe μ is not known above {_mu_text(limit)}" if limit else "safe μ is not known"
    reason = _undecided_text(result) if result.basis.rounds[-1].starts else _TOO_SLOW
    upper_bound = f", and is below {_mu_text(result.others[0].mu)}" if result.others else ""
    return f"{unknown}{upper_bound} ({reason})"


def _undecided_text(result: "SafeFriction") -> str:
    final_round = result.basis.rounds[-1]
    return f"{final_round.undecided} of {final_round.starts} motions stayed undecided"


def largest_cycle_text(result: "SafeFriction") -> str:
    """The largest stable limit cycle at the μ of the parameter set; empty if none is known.

    For example ``a limit cycle coexists from μ = 0.2779: half peak-to-peak 7.443 m``.
    """
    if not result.coexisting:
        return ""
    p, critical = result.parameters, result.critical_mu
    verb = "coexists" if critical is None or p.mu < critical else "attracts"
    # Other attractors ascend by least μ, coexisting cycles by size.
    least_mu = result.others[0].mu if result.others else critical
    largest_cycle = result.coexisting[-1]
    since = "" if least_mu is None else f" from {_mu_text(least_mu)}"
    return f"a limit cycle {verb}{since}: half peak-to-peak {largest_cycle.half_range:#.4g} m"


def basis_rows(result: "SafeFriction") -> list[tuple[str, str]]:
    """The basis of the verdict: the name of each method and what it found."""
    rows = [("continuation", _continuation_text(result))]
    if result.basis.rounds:
        rows.append(("global search", _search_text(result)))
    rows.append(("proof", _proof_text(result)))
    return rows


def _continuation_text(result: "SafeFriction") -> str:
    basis = result.basis
    if reason := basis.not_followed:
        return f"none: {reason}"
    hopf_branch = basis.branches[0]
    mus = [point.value for point in hopf_branch.points]
    events = ", ".join(
        f"{event.kind} {event.value:.4g}" for event in hopf_branch.events[:_NAMED_EVENTS]
    )
    return f"{len(mus)} limit cycles from the Hopf point, μ up to {max(mus):.4g}: {events}"


def _search_text(result: "SafeFriction") -> str:
    basis = result.basis
    final_round = basis.rounds[-1]
    if not final_round.starts:
        return f"none: {_TOO_SLOW}"
    mus = final_round.levels
    levels = f"{len(mus)} values of μ from {mus[0]:.4g} to {mus[-1]:.4g}"
    share = "all " if final_round.died_out == final_round.starts else f"{final_round.died_out} of "
    text = f"{share}{final_round.starts} starts at {levels} die out"
    if final_round.undecided:
        text += f"; the limit of steps left {final_round.undecided} undecided"
    # The least μ of each kind of attractor that the search found.
    least_mus: dict[str, float] = {}
    for attractor in result.others:
        if attractor.found_by == "global search":
            least_mu = least_mus.get(attractor.kind, math.inf)
            least_mus[attractor.kind] = min(least_mu, attractor.mu)
    if "limit cycle" in least_mus:
        text += f"; limit cycles from {_mu_text(least_mus['limit cycle'])} were found and followed"
    if "other motion" in least_mus:
        mu_text = _mu_text(least_mus["other motion"])
        text += f"; from {mu_text} on motions persist that are not limit cycles"
    if "unbounded growth" in least_mus:
        mu_text = _mu_text(least_mus["unbounded growth"])
        text += f"; from {mu_text} on motions grow without bounds"
    if basis.growth_at_any_size is not None:
        text += (
            ": with a linear contact spring (k_nl = 0) all sufficiently large motions grow; the "
            "closer μ is to this value, the larger they must be"
        )
    return text


def _proof_text(result: "SafeFriction") -> str:
    # Vertical displacement from rest, m, below which a Lyapunov function proves decay.
    offset, mu_text = result.basis.proved_offset, _mu_text(result.parameters.mu)
    if offset is None:
        return f"none at {mu_text}: small disturbances do not die out"
    if math.isinf(offset):
        return f"at {mu_text} every motion decays"
    return f"at {mu_text} motion from rest within ±{offset:.3g} m of the equilibrium decays"


def verdict_rows(result: "SafeFriction") -> list[tuple[str, str]]:
    """Rows of the verdict, of the cycle that coexists at the μ of the set, and of the basis."""
    cycle = largest_cycle_text(result)
    coexisting = [(f"at μ = {result.parameters.mu:.4g}", cycle)] if cycle else []
    return [("verdict", verdict_text(result)), *coexisting, *basis_rows(result)]
