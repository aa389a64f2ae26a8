"""The verdict and what it rests on, in words."""

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .verdict import SafeFriction


_TOO_SLOW: Final = "motions die out too slowly to be followed in the work allowed"


def _mu(value: float) -> str:
    return f"μ = {value:.4g}"


def safety_words(found: "SafeFriction") -> str:
    """The verdict in one phrase.

    For example ``stable to small disturbances below μ = 0.4394; to all disturbances found below
    μ = 0.2779``.
    """
    critical = found.critical_mu
    small = "at every μ" if critical is None else f"below {_mu(critical)}"
    if found.undamped:
        return f"small disturbances do not grow {small}; without damping none dies out"
    verdict = f"stable to small disturbances {small}"
    if found.linear:
        return f"{verdict}; to large ones as well: the system is linear"
    if found.unknown_above is not None:
        return f"{verdict}; {_unknown(found)}"
    warning = f" ({_undecided(found)})" if found.basis.rounds[-1].undecided else ""
    if found.others and found.safe_mu is not None:
        return f"{verdict}; to all disturbances found below {_mu(found.safe_mu)}{warning}"
    up_to = "" if critical is not None else f" up to {_mu(found.searched_to)}"
    return f"{verdict}; to all disturbances found{up_to} as well{warning}"


def _unknown(found: "SafeFriction") -> str:
    # What is not known of large disturbances, and from where on they are not safe.
    above = found.unknown_above
    unknown = f"safe μ is not known above {_mu(above)}" if above else "safe μ is not known"
    why = _undecided(found) if found.basis.rounds[-1].starts else _TOO_SLOW
    from_there = f", and is below {_mu(found.others[0].mu)}" if found.others else ""
    return f"{unknown}{from_there} ({why})"


def _undecided(found: "SafeFriction") -> str:
    last = found.basis.rounds[-1]
    return f"{last.undecided} of {last.starts} motions stayed undecided"


def coexistence_here(found: "SafeFriction") -> str:
    """The largest limit cycle at the μ of the parameter set; empty if none is known.

    For example ``a limit cycle coexists from μ = 0.2779: half peak-to-peak 7.443 m``.
    """
    if not found.coexisting:
        return ""
    p, critical = found.parameters, found.critical_mu
    verb = "coexists" if critical is None or p.mu < critical else "attracts"
    least = found.others[0].mu if found.others else critical
    since = "" if least is None else f" from {_mu(least)}"
    return (
        f"a limit cycle {verb}{since}: half peak-to-peak {found.coexisting[-1].half_range:#.4g} m"
    )


def basis_rows(found: "SafeFriction") -> list[tuple[str, str]]:
    """What each statement of the verdict rests on: its name and what was done."""
    rows = [("continuation", _continuation(found))]
    if found.basis.rounds:
        rows.append(("global search", _search(found)))
    rows.append(("proof", _proof(found)))
    return rows


def _continuation(found: "SafeFriction") -> str:
    basis = found.basis
    if basis.not_followed:
        return f"none: {basis.not_followed}"
    first = basis.branches[0]
    values = [point.value for point in first.points]
    events = ", ".join(f"{event.kind} {event.value:.4g}" for event in first.events[:6])
    return f"{len(values)} limit cycles from the Hopf point, μ up to {max(values):.4g}: {events}"


def _search(found: "SafeFriction") -> str:
    basis = found.basis
    last = basis.rounds[-1]
    if not last.starts:
        return f"none: {_TOO_SLOW}"
    levels = f"{len(last.levels)} values of μ from {last.levels[0]:.4g} to {last.levels[-1]:.4g}"
    all_of = "all " if last.died_out == last.starts else f"{last.died_out} of "
    text = f"{all_of}{last.starts} starts at {levels} die out"
    if last.undecided:
        text += f"; the limit of work left {last.undecided} undecided"
    searched = [one for one in found.others if one.found_by == "global search"]
    cycles = [one.mu for one in searched if one.kind == "limit cycle"]
    if cycles:
        text += f"; limit cycles from {_mu(min(cycles))} were found so, and followed"
    motions = [one.mu for one in searched if one.kind == "other motion"]
    if motions:
        text += f"; from {_mu(min(motions))} on motions stay that are no cycle"
    growth = [one.mu for one in searched if one.kind == "unbounded growth"]
    if growth:
        text += f"; from {_mu(min(growth))} on motions grow without bounds"
    if basis.growth_at_any_size is not None:
        text += (
            ": with a linear contact spring (k_nl = 0) all that are large enough do, and they have "
            "to be the larger, the nearer μ is to this value"
        )
    return text


def _proof(found: "SafeFriction") -> str:
    offset, at = found.basis.proved_offset, _mu(found.parameters.mu)
    if offset is None:
        return f"none at {at}: small disturbances do not die out"
    if math.isinf(offset):
        return f"at {at} every motion decays"
    return f"at {at} motion from rest within ±{offset:.3g} m of the equilibrium decays"


def verdict_rows(found: "SafeFriction") -> list[tuple[str, str]]:
    """The verdict, what coexists at the friction of the set, and what each statement rests on."""
    here = coexistence_here(found)
    coexisting = [(f"at μ = {found.parameters.mu:.4g}", here)] if here else []
    return [("verdict", safety_words(found)), *coexisting, *basis_rows(found)]
