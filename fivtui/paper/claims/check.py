"""Every testable statement of the paper, held against the model."""

from collections.abc import Sequence
from typing import Final

from fivtui.model.errors import Cancelled
from fivtui.paper.amplitudes import Progress
from fivtui.paper.families import PANELS
from fivtui.paper.study import Study

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


def check_claims(
    study: Study | None = None, *, progress: Progress | None = None
) -> list[CheckedClaim]:
    """Check all claims.

    Parameters
    ----------
    study : Study, optional
        Where the numbers come from; a new one if not given.
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
    source = Study() if study is None else study
    report = progress or (lambda _fraction: True)
    scenes = [s for panel in PANELS.values() if panel.kind == "amplitude" for s in panel.scenes()]
    scenes += [scene for claim in CLAIMS for scene in claim.scenes]
    source.prepare(scenes, lambda fraction: report(_RUNS * fraction))
    checked: list[CheckedClaim] = []
    source.go_on = lambda: report(_RUNS + (1.0 - _RUNS) * len(checked) / len(CLAIMS))
    try:
        for claim in CLAIMS:
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
