"""Verdicts on friction as JSON data."""

import math
from typing import Any

from .phrases import basis_rows, safety_words
from .search import SearchRound
from .verdict import OtherAttractor, SafeFriction


def safe_friction_to_dict(verdict: SafeFriction) -> dict[str, Any]:
    """A verdict as JSON data, in SI units.

    ``safe_mu`` is the least μ at which another attractor was found, else the critical μ, else None.
    ``safe_mu_not_known_above`` is the μ above which ``safe_mu`` is not known, else None.
    ``safe_mu_basis`` has the record of the search.
    """
    basis = verdict.basis
    offset = basis.proved_offset
    return {
        "safe_mu": verdict.safe_mu,
        "safe_mu_not_known_above": verdict.unknown_above,
        "safe_mu_basis": {
            "verdict": safety_words(verdict),
            "found_by": verdict.found_by,
            "statements": dict(basis_rows(verdict)),
            "others": [_other(record) for record in verdict.others],
            "coexisting": [
                {"period": record.period, "y_half_range": record.half_range}
                for record in verdict.coexisting
            ],
            "continuation": [
                {
                    "origin": record.origin,
                    "cycles": len(record.points),
                    "mu_min": min(point.value for point in record.points),
                    "mu_max": max(point.value for point in record.points),
                    "events": [
                        {"kind": str(event.kind), "mu": event.value, "period": event.period}
                        for event in record.events
                    ],
                }
                for record in basis.branches
            ],
            "global_search": {
                "searched_to": verdict.searched_to,
                "rounds": [_round(record) for record in basis.rounds],
                "unconfirmed_mu": [
                    record.mu for record in verdict.others if record.kind == "other motion"
                ],
                "growth_at_any_size_mu": basis.growth_at_any_size,
                "budget_ended": basis.budget_ended,
            },
            "proof": None
            if offset is None
            else {
                "mu": verdict.parameters.mu,
                "offset": None if math.isinf(offset) else offset,
                "everywhere": math.isinf(offset),
            },
            "cpu_s": basis.cpu_s,
        },
    }


def _other(record: OtherAttractor) -> dict[str, Any]:
    cycle = record.cycle
    return {
        "mu": record.mu,
        "kind": record.kind,
        "found_by": record.found_by,
        "period": None if cycle is None else cycle.period,
        "y_half_range": None if cycle is None else cycle.half_range,
    }


def _round(record: SearchRound) -> dict[str, Any]:
    return {
        "mu": list(record.levels),
        "starts": record.starts,
        "died_out": record.died_out,
        "settled": len(record.settled),
        "unbounded": len(record.unbounded),
        "undecided": record.undecided,
        "steps": record.steps,
    }
