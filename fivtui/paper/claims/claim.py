"""A claim of the paper, and the result of checking it against the model."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from fivtui.paper import PaperResults
from fivtui.scene import Scene


class Verdict(StrEnum):
    """Whether a statement of the paper follows from its own equations and parameters."""

    HOLDS = "holds"
    DOES_NOT_HOLD = "does not hold"
    NOT_TESTABLE = "not testable"


@dataclass(frozen=True, slots=True)
class Quantity:
    """A computed number: name in the paper's symbols, value, unit (SI or %, empty if none)."""

    name: str
    value: float
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.4g} {self.unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of the test of a claim: whether it holds, and the numbers that show it.

    `reason` is the likely reason if it does not hold, or the reading under which it does.
    """

    holds: bool
    quantities: tuple[Quantity, ...]
    reason: str = ""


Test = Callable[[PaperResults], Finding]


@dataclass(frozen=True, slots=True)
class Claim:
    """A statement of the paper.

    Attributes
    ----------
    id : str
        Short name, unique.
    section : str
        Section of the paper, and figure.
    statement : str
        The statement in brief.
    stated : str
        The value or relation that the paper gives.
    test : callable or None
        Computes the finding; None if the model cannot decide.
    untestable : str
        Why the model cannot decide; empty if it can.
    scenes : tuple of Scene
        Scenes whose amplitudes the test needs besides those of the figures.
    """

    id: str
    section: str
    statement: str
    stated: str
    test: Test | None = None
    untestable: str = ""
    scenes: tuple[Scene, ...] = ()


@dataclass(frozen=True, slots=True)
class CheckedClaim:
    """A claim with its verdict.

    Attributes
    ----------
    claim : Claim
        The claim.
    verdict : Verdict
        Whether it holds.
    quantities : tuple of Quantity
        The computed numbers.
    reason : str
        Why it does not hold or cannot be tested, or the reading under which it holds; may be empty.
    """

    claim: Claim
    verdict: Verdict
    quantities: tuple[Quantity, ...]
    reason: str

    @property
    def computed(self) -> str:
        """The computed numbers in one line."""
        return "; ".join(map(str, self.quantities)) or "–"


class Chapter:
    """A list of claims, filled by decorators."""

    def __init__(self) -> None:
        self._claims: list[Claim] = []

    def __iter__(self) -> Iterator[Claim]:
        return iter(self._claims)

    def claim(
        self, section: str, statement: str, stated: str, *, scenes: Sequence[Scene] = ()
    ) -> Callable[[Test], Test]:
        """Decorator that makes a claim of its test; the function's name gives the id."""

        def add(test: Test) -> Test:
            name = test.__name__.strip("_").replace("_", "-")
            self._claims.append(
                Claim(name, section, statement, stated, test=test, scenes=tuple(scenes))
            )
            return test

        return add

    def untestable(self, name: str, section: str, statement: str, stated: str, why: str) -> None:
        """Add a claim that the model cannot decide."""
        self._claims.append(Claim(name, section, statement, stated, untestable=why))


def check(claim: Claim, results: PaperResults) -> CheckedClaim:
    """Check a claim; `ComputationError` if a run cannot be finished."""
    if claim.test is None:
        return CheckedClaim(claim, Verdict.NOT_TESTABLE, (), claim.untestable)
    finding = claim.test(results)
    verdict = Verdict.HOLDS if finding.holds else Verdict.DOES_NOT_HOLD
    return CheckedClaim(claim, verdict, finding.quantities, finding.reason)
