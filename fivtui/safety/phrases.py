"""Sentences for the verdict and its basis."""

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .verdict import SafeFriction


_TOO_SLOW: Final = "motions die out too slowly to be followed in the work allowed"


def _mu(value: float) -> str:
    return f"μ = {value:.4g}"


def safety_words(result: "SafeFriction") -> str:
    """The verdict as one phrase.

    For example ``stable to small disturbances below μ = 0.4394; to all disturbances found below
    μ = 0.2779``.
    """
    critical = result.critical_mu
    small = "at every μ" if critical is None else f"below {_mu(critical)}"
    if result.undamped:
        return f"small disturbances do not grow {small}; without damping none dies out"
    verdict = f"stable to small disturbances {small}"
    if result.linear:
        return f"{verdict}; to large ones as well: the system is linear"
    if result.unknown_above is not None:
        return f"{verdict}; {_unknown(result)}"
    warning = f" ({_undecided(result)})" if result.basis.rounds[-1].undecided else ""
    if result.others and result.safe_mu is not None:
        return f"{verdict}; to all disturbances found below {_mu(result.safe_mu)}{warning}"
    up_to = "" if critical is not None else f" up to {_mu(result.searched_to)}"
    return f"{verdict}; to all disturbances found{up_to} as well{warning}"


def _unknown(result: "SafeFriction") -> str:
    # The μ above which safe μ is not known, an upper bound of safe μ, and the reason.
    above = result.unknown_above
    unknown = f"safe μ is not known above {_mu(above)}" if above else "safe μ is not known"
    why = _undecided(result) if result.basis.rounds[-1].starts else _TOO_SLOW
    below_it = f", and is below {_mu(result.others[0].mu)}" if result.others else ""
    return f"{unknown}{below_it} ({why})"


def _undecided(result: "SafeFriction") -> str:
    final_round = result.basis.rounds[-1]
    return f"{final_round.undecided} of {final_round.starts} motions stayed undecided"


def coexistence_here(result: "SafeFriction") -> str:
    """The largest limit cycle at the μ of the parameter set; empty if none is known.

    For example ``a limit cycle coexists from μ = 0.2779: half peak-to-peak 7.443 m``.
    """
    if not result.coexisting:
        return ""
    p, critical = result.parameters, result.critical_mu
    verb = "coexists" if critical is None or p.mu < critical else "attracts"
    least = result.others[0].mu if result.others else critical
    since = "" if least is None else f" from {_mu(least)}"
    return (
        f"a limit cycle {verb}{since}: half peak-to-peak {result.coexisting[-1].half_range:#.4g} m"
    )


def basis_rows(result: "SafeFriction") -> list[tuple[str, str]]:
    """The basis of every statement of the verdict: name of the method, and its result."""
    rows = [("continuation", _continuation(result))]
    if result.basis.rounds:
        rows.append(("global search", _search(result)))
    rows.append(("proof", _proof(result)))
    return rows


def _continuation(result: "SafeFriction") -> str:
    basis = result.basis
    if basis.not_followed:
        return f"none: {basis.not_followed}"
    first = basis.branches[0]
    values = [point.value for point in first.points]
    events = ", ".join(f"{event.kind} {event.value:.4g}" for event in first.events[:6])
    return f"{len(values)} limit cycles from the Hopf point, μ up to {max(values):.4g}: {events}"


def _search(result: "SafeFriction") -> str:
    basis = result.basis
    final_round = basis.rounds[-1]
    if not final_round.starts:
        return f"none: {_TOO_SLOW}"
    mu = final_round.levels
    levels = f"{len(mu)} values of μ from {mu[0]:.4g} to {mu[-1]:.4g}"
    all_of = "all " if final_round.died_out == final_round.starts else f"{final_round.died_out} of "
    text = f"{all_of}{final_round.starts} starts at {levels} die out"
    if final_round.undecided:
        text += f"; the limit of work left {final_round.undecided} undecided"
    searched = [attractor for attractor in result.others if attractor.found_by == "global search"]
    cycles = [attractor.mu for attractor in searched if attractor.kind == "limit cycle"]
    if cycles:
        text += f"; limit cycles from {_mu(min(cycles))} were found so, and followed"
    motions = [attractor.mu for attractor in searched if attractor.kind == "other motion"]
    if motions:
        text += f"; from {_mu(min(motions))} on motions stay that are no cycle"
    growth = [attractor.mu for attractor in searched if attractor.kind == "unbounded growth"]
    if growth:
        text += f"; from {_mu(min(growth))} on motions grow without bounds"
    if basis.growth_at_any_size is not None:
        text += (
            ": with a linear contact spring (k_nl = 0) all that are large enough do, and they have "
            "to be the larger, the nearer μ is to this value"
        )
    return text


def _proof(result: "SafeFriction") -> str:
    offset, at = result.basis.proved_offset, _mu(result.parameters.mu)
    if offset is None:
        return f"none at {at}: small disturbances do not die out"
    if math.isinf(offset):
        return f"at {at} every motion decays"
    return f"at {at} motion from rest within ±{offset:.3g} m of the equilibrium decays"


def verdict_rows(result: "SafeFriction") -> list[tuple[str, str]]:
    """The verdict, the cycle that coexists at the μ of the set, and the basis of each statement."""
    cycle = coexistence_here(result)
    coexisting = [(f"at μ = {result.parameters.mu:.4g}", cycle)] if cycle else []
    return [("verdict", safety_words(result)), *coexisting, *basis_rows(result)]
