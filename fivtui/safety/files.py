"""Verdicts on safe friction as JSON data.

The global search has rounds: each follows motions from many starts at several μ, below the least μ
of the attractors that are known before it.
"""

import math
from typing import Any

from .phrases import basis_rows, verdict_text
from .search import SearchRound
from .verdict import OtherAttractor, SafeFriction


def safe_friction_to_dict(verdict: SafeFriction) -> dict[str, Any]:
    """A verdict as JSON data, in SI units.

    ``safe_mu`` is the least μ at which an attractor beside the equilibrium was found. Without one
    it is the critical μ; it is None if there is no critical μ, or safe μ is not known.
    ``safe_mu_not_known_above`` is the μ above which ``safe_mu`` is not known, else None.
    ``safe_mu_basis`` is the record of the search. Its ``statements`` say what each method found.
    ``others`` are the attractors below the critical μ, each at its least μ; ``coexisting`` are the
    stable limit cycles at the μ of the parameter set. ``budget_ended`` tells whether a limit of
    steps or rounds ended the search.
    """
    basis = verdict.basis
    # Vertical displacement from rest, m, below which motion is proved to decay; infinite if all
    # motion does.
    offset = basis.proved_offset
    return {
        "safe_mu": verdict.safe_mu,
        "safe_mu_not_known_above": verdict.unknown_above,
        "safe_mu_basis": {
            "verdict": verdict_text(verdict),
            "found_by": verdict.found_by,
            "statements": dict(basis_rows(verdict)),
            "others": [_attractor_data(attractor) for attractor in verdict.others],
            "coexisting": [
                {"period": cycle.period, "y_half_range": cycle.half_range}
                for cycle in verdict.coexisting
            ],
            "continuation": [
                {
                    "origin": branch.origin,
                    "cycles": len(branch.points),
                    "mu_min": min(point.value for point in branch.points),
                    "mu_max": max(point.value for point in branch.points),
                    "events": [
                        {"kind": str(event.kind), "mu": event.value, "period": event.period}
                        for event in branch.events
                    ],
                }
                for branch in basis.branches
            ],
            "global_search": {
                "searched_to": verdict.searched_to,
                "rounds": [_round_data(search_round) for search_round in basis.rounds],
                # The μ of motions that transients found and no limit cycle confirms.
                "unconfirmed_mu": [
                    attractor.mu for attractor in verdict.others if attractor.kind == "other motion"
                ],
                # The least μ at which all sufficiently large motions grow without bounds.
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


def _attractor_data(attractor: OtherAttractor) -> dict[str, Any]:
    cycle = attractor.cycle
    return {
        "mu": attractor.mu,
        "kind": attractor.kind,
        "found_by": attractor.found_by,
        "period": None if cycle is None else cycle.period,
        "y_half_range": None if cycle is None else cycle.half_range,
    }


def _round_data(search_round: SearchRound) -> dict[str, Any]:
    # Levels are the values of μ; the numbers are of motions, except the integration steps.
    return {
        "mu": list(search_round.levels),
        "starts": search_round.starts,
        "died_out": search_round.died_out,
        "settled": len(search_round.settled),
        "unbounded": len(search_round.unbounded),
        "undecided": search_round.undecided,
        "steps": search_round.steps,
    }
