"""Every testable statement of the paper, held against the model."""

from collections.abc import Sequence
from typing import Final

from fivtui.model import Cancelled, unknown_name
from fivtui.paper import PANELS, PaperResults, Progress

from .amplitude import AMPLITUDES
from .attractor import ATTRACTORS
from .claim import CheckedClaim, Claim, check
from .critical import CRITICAL
from .eigenvalue import EIGENVALUES
from .equilibrium import EQUILIBRIUM
from .transient import TRANSIENTS

CLAIMS: Final[tuple[Claim, ...]] = (
    *EQUILIBRIUM,
    *EIGENVALUES,
    *CRITICAL,
    *ATTRACTORS,
    *TRANSIENTS,
    *AMPLITUDES,
)

# Share of the time that the runs for amplitudes take.
_RUNS: Final = 0.7


def claims(ids: Sequence[str] = (), *, progress: Progress | None = None) -> list[CheckedClaim]:
    """Hold the testable statements of the paper against the model.

    Parameters
    ----------
    ids : sequence of str
        Which ones; all if empty.
    progress : callable, optional
        Called with the fraction done; the work is cancelled when it returns False.

    Returns
    -------
    list of CheckedClaim
        What the paper states, what is computed, and the verdict; in the order of its sections.

    Raises
    ------
    InputError
        If there is no such claim.
    ComputationError
        If a run cannot be finished.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import claims
    >>> (checked,) = claims(["critical-friction-of-the-example"])
    >>> str(checked.verdict)
    'does not hold'
    """
    known = {claim.id: claim for claim in CLAIMS}
    for name in ids:
        if name not in known:
            raise unknown_name("claim", name, known)
    if not ids:
        return check_claims(progress=progress)
    return check_claims(chosen=[claim for claim in CLAIMS if claim.id in ids], progress=progress)


def check_claims(
    results: PaperResults | None = None,
    *,
    chosen: Sequence[Claim] = CLAIMS,
    progress: Progress | None = None,
) -> list[CheckedClaim]:
    """Check claims.

    Parameters
    ----------
    results : PaperResults, optional
        Where the numbers come from; a new one if not given.
    chosen : sequence of Claim
        Which ones; all if not given.
    progress : callable, optional
        Called with the fraction done; the work is cancelled when it returns False.

    Returns
    -------
    list of CheckedClaim
        In the order of the paper's sections.

    Raises
    ------
    ComputationError
        If a run cannot be finished.
    Cancelled
        If `progress` returned False.
    """
    source = PaperResults() if results is None else results
    report = progress or (lambda _fraction: True)
    scenes = [scene for claim in chosen for scene in claim.scenes]
    if len(chosen) == len(CLAIMS):
        amplitudes = (panel for panel in PANELS.values() if panel.kind == "amplitude")
        scenes += [scene for panel in amplitudes for scene in panel.scenes()]
    source.prepare(scenes, lambda fraction: report(_RUNS * fraction))
    checked: list[CheckedClaim] = []
    source.go_on = lambda: report(_RUNS + (1.0 - _RUNS) * len(checked) / len(chosen))
    try:
        for claim in chosen:
            checked.append(check(claim, source))
            if not source.go_on():
                raise Cancelled
    finally:
        source.go_on = lambda: True
    return checked


def claims_to_list(checked: Sequence[CheckedClaim]) -> list[dict[str, str]]:
    """Checked claims as data that JSON can hold.

    Parameters
    ----------
    checked : sequence of CheckedClaim
        The claims.

    Returns
    -------
    list of dict
        ``id``, ``section``, ``statement``, ``stated``, ``computed``, ``verdict``, and ``reason``
        where there is one.
    """
    rows = []
    for entry in checked:
        row = {
            "id": entry.claim.id,
            "section": entry.claim.section,
            "statement": entry.claim.statement,
            "stated": entry.claim.stated,
            "computed": entry.computed,
            "verdict": entry.verdict.value,
        }
        rows.append(row | ({"reason": entry.reason} if entry.reason else {}))
    return rows
