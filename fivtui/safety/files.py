"""Verdicts on friction as JSON data."""

import math
from typing import Any

from .search import SearchRound
from .verdict import OtherAttractor, SafeFriction
from .words import basis_rows, safety_words


def safe_friction_to_dict(found: SafeFriction) -> dict[str, Any]:
    """A verdict as JSON data, in SI units.

    Keys are ``safe_mu``, the least μ at which another attractor was found, else the critical μ,
    else None; ``safe_mu_not_known_above``, a μ where too little is known to say ``safe_mu``, else
    None; and ``safe_mu_basis`` with what was searched.
    """
    basis = found.basis
    offset = basis.proved_offset
    return {
        "safe_mu": found.safe_mu,
        "safe_mu_not_known_above": found.unknown_above,
        "safe_mu_basis": {
            "verdict": safety_words(found),
            "found_by": found.found_by,
            "statements": dict(basis_rows(found)),
            "others": [_other(one) for one in found.others],
            "coexisting": [
                {"period": one.period, "y_half_range": one.half_range} for one in found.coexisting
            ],
            "continuation": [
                {
                    "origin": one.origin,
                    "cycles": len(one.points),
                    "mu_min": min(point.value for point in one.points),
                    "mu_max": max(point.value for point in one.points),
                    "events": [
                        {"kind": str(event.kind), "mu": event.value, "period": event.period}
                        for event in one.events
                    ],
                }
                for one in basis.branches
            ],
            "global_search": {
                "searched_to": found.searched_to,
                "rounds": [_round(one) for one in basis.rounds],
                "unconfirmed_mu": [one.mu for one in found.others if one.kind == "other motion"],
                "growth_at_any_size_mu": basis.growth_at_any_size,
                "budget_ended": basis.budget_ended,
            },
            "proof": None
            if offset is None
            else {
                "mu": found.parameters.mu,
                "offset": None if math.isinf(offset) else offset,
                "everywhere": math.isinf(offset),
            },
            "cpu_s": basis.cpu_s,
        },
    }


def _other(one: OtherAttractor) -> dict[str, Any]:
    cycle = one.cycle
    return {
        "mu": one.mu,
        "kind": one.kind,
        "found_by": one.found_by,
        "period": None if cycle is None else cycle.period,
        "y_half_range": None if cycle is None else cycle.half_range,
    }


def _round(one: SearchRound) -> dict[str, Any]:
    return {
        "mu": list(one.levels),
        "starts": one.starts,
        "died_out": one.died_out,
        "settled": len(one.settled),
        "unbounded": len(one.unbounded),
        "undecided": one.undecided,
        "steps": one.steps,
    }
