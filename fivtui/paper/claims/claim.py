"""What a claim is, and what comes of holding it against the model."""

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
    """A computed number.

    Attributes
    ----------
    name : str
        What it is, in the paper's symbols.
    value : float
        Its value.
    unit : str
        SI unit or %; empty when dimensionless.
    """

    name: str
    value: float
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.4g} {self.unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Finding:
    """What a test of a claim found.

    Attributes
    ----------
    holds : bool
        Whether the statement holds.
    quantities : tuple of Quantity
        The numbers on which that rests.
    reason : str
        The likely reason if it does not hold, or under which reading it does.
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
        Computes the finding; None if the model cannot say.
    untestable : str
        Why it cannot; empty if it can.
    scenes : tuple of Scene
        The scenes whose amplitudes the test needs besides those of the figures.
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
        What came of it.
    quantities : tuple of Quantity
        The computed numbers.
    reason : str
        Why it does not hold or cannot be tested, or under which reading it holds; may be empty.
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
    """Claims in the order in which they are written down."""

    def __init__(self) -> None:
        self._claims: list[Claim] = []

    def __iter__(self) -> Iterator[Claim]:
        return iter(self._claims)

    def claim(
        self, section: str, statement: str, stated: str, *, scenes: Sequence[Scene] = ()
    ) -> Callable[[Test], Test]:
        """Make a claim of the function that tests it; the name of the function gives the id.

        Parameters
        ----------
        section, statement, stated, scenes
            See `Claim`.

        Returns
        -------
        callable
            The decorator.
        """

        def add(test: Test) -> Test:
            name = test.__name__.strip("_").replace("_", "-")
            self._claims.append(
                Claim(name, section, statement, stated, test=test, scenes=tuple(scenes))
            )
            return test

        return add

    def untestable(self, name: str, section: str, statement: str, stated: str, why: str) -> None:
        """Add a claim on which the model has nothing to say.

        Parameters
        ----------
        name : str
            Its id.
        section, statement, stated
            See `Claim`.
        why : str
            Why it cannot be tested.
        """
        self._claims.append(Claim(name, section, statement, stated, untestable=why))


def check(claim: Claim, results: PaperResults) -> CheckedClaim:
    """Hold a claim against the model.

    Parameters
    ----------
    claim : Claim
        The claim.
    results : PaperResults
        Where the numbers come from.

    Returns
    -------
    CheckedClaim
        With its verdict.

    Raises
    ------
    ComputationError
        If a run cannot be finished.
    """
    if claim.test is None:
        return CheckedClaim(claim, Verdict.NOT_TESTABLE, (), claim.untestable)
    finding = claim.test(results)
    verdict = Verdict.HOLDS if finding.holds else Verdict.DOES_NOT_HOLD
    return CheckedClaim(claim, verdict, finding.quantities, finding.reason)
