"""A claim of the paper, and the result of checking it against the model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from fivtui.paper import PaperResults
from fivtui.scene import Scene

# The computed numbers of a claim, in the order of their names; None is not reported.
Values = Sequence[float | None]
# What a test returns: whether the claim holds, and the computed numbers.
Finding = tuple[bool | np.bool, Values]
Test = Callable[[PaperResults], Finding]


class Verdict(StrEnum):
    """Whether a statement of the paper follows from its own equations and parameters."""

    HOLDS = "holds"
    DOES_NOT_HOLD = "does not hold"
    NOT_TESTABLE = "not testable"


class Quantity(NamedTuple):
    """A computed number: name in the paper's symbols, value, unit (SI or %, empty if none)."""

    name: str
    value: float
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.4g} {self.unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Claim:
    """A statement of the paper: a row of `statements.toml`, and its test.

    `stated` is the value or relation in the paper. A claim without a test cannot be decided by the
    model; `untestable` says why. `scenes` are scenes outside the figures whose amplitudes the test
    needs. `names` are those of the computed numbers, each with its unit in brackets, if any.
    `reason` is why a tested claim does not hold, or the assumption under which it holds.
    """

    id: str
    section: str
    statement: str
    stated: str
    test: Test | None = None
    untestable: str = ""
    scenes: tuple[Scene, ...] = ()
    names: Sequence[str] = field(default=(), repr=False)
    reason: str = field(default="", repr=False)


@dataclass(frozen=True, slots=True)
class CheckedClaim:
    """A claim with its verdict, the computed numbers, and the claim's `reason` or `untestable`."""

    claim: Claim
    verdict: Verdict
    quantities: tuple[Quantity, ...]
    reason: str

    @property
    def computed(self) -> str:
        """The computed numbers in one line."""
        return "; ".join(map(str, self.quantities)) or "–"

    @property
    def row(self) -> dict[str, str]:
        """The texts of a table, by column."""
        return {
            "id": self.claim.id,
            "section": self.claim.section,
            "statement": self.claim.statement,
            "stated": self.claim.stated,
            "computed": self.computed,
            "verdict": self.verdict.value,
            "reason": self.reason,
        }


def check(claim: Claim, results: PaperResults) -> CheckedClaim:
    """Check a claim; `ComputationError` if a run cannot be finished."""
    if claim.test is None:
        return CheckedClaim(claim, Verdict.NOT_TESTABLE, (), claim.untestable)
    holds, values = claim.test(results)
    quantities = tuple(
        _make_quantity(name_and_unit, value)
        for name_and_unit, value in zip(claim.names, values, strict=True)
        if value is not None
    )
    verdict = Verdict.HOLDS if holds else Verdict.DOES_NOT_HOLD
    return CheckedClaim(claim, verdict, quantities, claim.reason)


def _make_quantity(name_and_unit: str, value: float) -> Quantity:
    # `name_and_unit` is such as "greatest |P| [N]".
    name, _, unit = name_and_unit.partition(" [")
    number = value.item() if isinstance(value, np.generic) else value
    return Quantity(name, number, unit.rstrip("]"))
