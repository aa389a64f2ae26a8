"""All claims of the paper, and checking them against the model."""

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any, Final

from fivtui.io import read_bytes
from fivtui.model import InputError, OnProgress, Progress, check_known
from fivtui.paper import PANELS, PaperResults
from fivtui.results import from_data, to_data

from . import stability, vibration
from .claim import CheckedClaim, Claim, Quantity, Verdict, check

_TESTS: Final = {**stability.TESTS, **vibration.TESTS}


_STATEMENTS: Final = Path(__file__).with_name("statements.toml")


def _make_claim(claim_id: str, row: Sequence[Any]) -> Claim:
    # A claim from a row of statements.toml. The last entry, which may be missing, is the reason why
    # the claim does not hold or cannot be tested, or the assumption under which it holds.
    section, stated, statement, quantity_names, *rest = row
    reason = rest[0] if rest else ""
    if claim_id not in _TESTS:
        return Claim(claim_id, section, statement, stated, untestable=reason)
    return Claim(
        claim_id,
        section,
        statement,
        stated,
        test=_TESTS[claim_id],
        scenes=vibration.SCENES.get(claim_id, ()),
        names=quantity_names,
        reason=reason,
    )


CLAIMS: Final[tuple[Claim, ...]] = tuple(
    _make_claim(claim_id, row)
    for claim_id, row in tomllib.loads(_STATEMENTS.read_text(encoding="utf-8")).items()
)

# Share of the computing time that the runs for amplitudes take, for the progress.
_AMPLITUDES_SHARE: Final = 0.7


class CheckedClaims(list[CheckedClaim]):
    """Checked claims, which a notebook displays as a table."""

    def _repr_html_(self) -> str:
        names = ("section", "statement", "stated", "computed", "verdict")
        rows = [names, *([entry.row[name] for name in names] for entry in self)]
        cells = ("".join(f"<td>{escape(text)}</td>" for text in row) for row in rows)
        return f"<table><tr>{'</tr><tr>'.join(cells)}</tr></table>"


def claims(ids: Sequence[str] = (), *, progress: OnProgress | None = None) -> CheckedClaims:
    """Check the testable statements of the paper against the model.

    Parameters
    ----------
    ids : sequence of str
        Ids of the claims; all if empty.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    list of CheckedClaim
        Stated value, computed value and verdict, in the order of the paper's sections; a notebook
        displays a table.

    Raises
    ------
    InputError
        If an id is unknown.
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
    by_id = {claim.id: claim for claim in CLAIMS}
    for name in ids:
        check_known("claim", name, by_id)
    chosen = [claim for claim in CLAIMS if not ids or claim.id in ids]
    return CheckedClaims(check_claims(chosen=chosen, progress=progress))


def check_claims(
    results: PaperResults | None = None,
    *,
    chosen: Sequence[Claim] = CLAIMS,
    progress: OnProgress | None = None,
) -> list[CheckedClaim]:
    """Check claims, in the order of the paper's sections.

    `results` provides the numbers; new ones are computed if not given. Raises `ComputationError` if
    a run cannot be finished, and `Cancelled` if `progress`, called with the fraction done, returns
    False.
    """
    source = PaperResults() if results is None else results
    work = Progress(progress)
    scenes = [scene for claim in chosen for scene in claim.scenes]
    # All claims together need all figures: their amplitudes are computed in the same batch. Single
    # claims compute the figures that they need when they are tested.
    if len(chosen) == len(CLAIMS):
        amplitudes = (panel for panel in PANELS.values() if panel.kind == "amplitude")
        scenes += [scene for panel in amplitudes for scene in panel.scenes()]
    source.prepare(scenes, work.stage(0.0, _AMPLITUDES_SHARE).callback)
    checked: list[CheckedClaim] = []
    checking = work.stage(_AMPLITUDES_SHARE, 1.0)
    source.should_continue = checking.should_continue
    try:
        for claim in chosen:
            checked.append(check(claim, source))
            checking.report(len(checked) / len(chosen))
    finally:
        source.should_continue = lambda: True
    return checked


def claims_to_list(checked: Sequence[CheckedClaim]) -> list[dict[str, str]]:
    """Checked claims as JSON data: their rows, without an empty ``reason``."""
    rows = [entry.row for entry in checked]
    return [{key: text for key, text in row.items() if text or key != "reason"} for row in rows]


@dataclass(frozen=True, slots=True)
class StoredClaim:
    """A checked claim in a file; id, statement and stated value identify the claim."""

    id: str
    statement: str
    stated: str
    verdict: Verdict
    quantities: tuple[Quantity, ...]
    reason: str


def claims_to_stored(checked: Sequence[CheckedClaim]) -> Any:
    """Checked claims as data that `stored_claims` reads."""
    return to_data(
        [
            StoredClaim(
                entry.claim.id,
                entry.claim.statement,
                entry.claim.stated,
                entry.verdict,
                entry.quantities,
                entry.reason,
            )
            for entry in checked
        ]
    )


def stored_claims(path: Path) -> list[CheckedClaim]:
    """Read checked claims; those whose statement or stated value has changed are left out.

    Raises `InputError` if the file is damaged.
    """
    current = {(claim.id, claim.statement, claim.stated): claim for claim in CLAIMS}
    try:
        stored = from_data(json.loads(read_bytes(path)), list[StoredClaim])
    except (ValueError, RecursionError):
        raise InputError(f"{path}: damaged") from None
    return [
        CheckedClaim(current[key], row.verdict, row.quantities, row.reason)
        for row in stored
        if (key := (row.id, row.statement, row.stated)) in current
    ]
