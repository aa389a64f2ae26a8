"""The verdict and what it rests on, in words."""

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .verdict import SafeFriction


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
    said = f"stable to small disturbances {small}"
    if found.linear:
        return f"{said}; to large ones as well: the system is linear"
    if found.others and found.safe_mu is not None:
        return f"{said}; to all disturbances found below {_mu(found.safe_mu)}"
    if not any(one.died_out for one in found.basis.rounds):
        return f"{said}; nothing is known of large ones"
    up_to = "" if critical is not None else f" up to {_mu(found.searched_to)}"
    return f"{said}; to all disturbances found{up_to} as well"


def coexistence_here(found: "SafeFriction") -> str:
    """The largest limit cycle at the μ of the parameter set; empty if none is known.

    For example ``a limit cycle coexists from μ = 0.2779: half peak-to-peak 7.443 m``.
    """
    if not found.coexisting:
        return ""
    p, critical = found.parameters, found.critical_mu
    verb = "coexists" if critical is None or p.mu < critical else "attracts"
    since = f" from {_mu(found.safe_mu)}" if found.safe_mu is not None else ""
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
        return "none: damping is too small for motions to die out in the work allowed"
    levels = f"{len(last.levels)} values of μ from {last.levels[0]:.4g} to {last.levels[-1]:.4g}"
    all_of = "all " if last.died_out == last.starts else f"{last.died_out} of "
    said = f"{all_of}{last.starts} starts at {levels} die out"
    if last.undecided:
        said += f"; the limit of work left {last.undecided} undecided"
    cycles = [one for one in found.others if one.found_by == "global search"]
    if cycles:
        said += f"; limit cycles from {_mu(cycles[0].mu)} were found so, and followed"
    if basis.unconfirmed:
        said += (
            f"; {len(basis.unconfirmed)} motions from {_mu(min(basis.unconfirmed))} on stay, "
            "but are no cycle"
        )
    return said


def _proof(found: "SafeFriction") -> str:
    offset, at = found.basis.proved_offset, _mu(found.parameters.mu)
    if offset is None:
        return f"none at {at}: small disturbances do not die out"
    if math.isinf(offset):
        return f"at {at} every motion decays"
    return f"at {at} motion from rest within ±{offset:.3g} m of the equilibrium decays"
