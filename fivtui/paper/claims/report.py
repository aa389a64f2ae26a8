"""The paper's claims as console output, Markdown and CSV file."""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from fivtui.console import print_titled, terminal_width
from fivtui.io import save_csv

if TYPE_CHECKING:
    from .claim import CheckedClaim

# Columns of the table of claims, and their shares of its width.
_CLAIM_COLUMNS: Final = {"section": 2, "statement": 6, "stated": 4, "computed": 7, "verdict": 2}
# Least terminal width for a table, and the width of the table without a terminal.
_LEAST_TABLE_WIDTH: Final = 100
_FILE_WIDTH: Final = 200
_CLAIM_HEADER: Final = ("id", "section", "statement", "stated", "computed", "verdict", "reason")
_VERDICT_STYLES: Final = {"does not hold": "bold", "not testable": "dim"}


def print_claims(checked: Sequence["CheckedClaim"]) -> None:
    """Print the paper's claims, the computed numbers and the verdicts."""
    width = terminal_width()
    has_space = width is None or width >= _LEAST_TABLE_WIDTH
    content = _claims_table(checked) if has_space else _claims_list(checked)
    print_titled("Claims of the paper", content)
    Console(stderr=True, highlight=False).print(verdict_counts(checked))


def verdict_counts(checked: Sequence["CheckedClaim"]) -> str:
    """How many claims have each verdict."""
    counts = Counter(entry.verdict.value for entry in checked)
    text = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
    return f"{len(checked)} claims: {text}"


def _claims_table(checked: Sequence["CheckedClaim"]) -> Table:
    table = Table(show_lines=True, width=None if terminal_width() else _FILE_WIDTH, expand=True)
    for name, share in _CLAIM_COLUMNS.items():
        table.add_column(name, ratio=share)
    for entry in checked:
        claim = entry.claim
        statement = Text.assemble(claim.statement, "\n", (claim.id, "dim"))
        computed = Text("\n".join(_quantity_lines(entry)))
        table.add_row(Text(claim.section), statement, Text(claim.stated), computed, _verdict(entry))
    return table


def _claims_list(checked: Sequence["CheckedClaim"]) -> Group:
    # Separate lines for each claim, for narrow terminals.
    parts: list[Text] = []
    for entry in checked:
        claim = entry.claim
        lines = (claim.statement, f"stated: {claim.stated}", *_quantity_lines(entry))
        heading = Text.assemble(_verdict(entry), f"  section {claim.section}  ", (claim.id, "dim"))
        parts += [Text(), heading, *(Text(line) for line in lines)]
    return Group(*parts)


def _quantity_lines(entry: "CheckedClaim") -> list[str]:
    return [*map(str, entry.quantities), *([f"({entry.reason})"] if entry.reason else [])]


def _verdict(entry: "CheckedClaim") -> Text:
    return Text(entry.verdict.value, style=_VERDICT_STYLES.get(entry.verdict.value, ""))


def claims_markdown(checked: Sequence["CheckedClaim"]) -> str:
    """The paper's claims as a Markdown table, one row each, the reason in the last column."""
    rows = [entry.row | {"id": f"`{entry.claim.id}`"} for entry in checked]
    table = [_CLAIM_HEADER, ["---"] * len(_CLAIM_HEADER), *(row.values() for row in rows)]
    return "\n".join(f"| {' | '.join(map(_markdown_cell, row))} |" for row in table)


def save_claims(checked: Sequence["CheckedClaim"], path: Path) -> None:
    """Write the paper's claims as CSV, one row each; `InputError` if they cannot be written."""
    rows = [entry.row for entry in checked]
    columns = {name: [row[name] for row in rows] for name in _CLAIM_HEADER}
    save_csv(path, "claims", columns, header={})


def _markdown_cell(text: str) -> str:
    # Characters that end a cell or are read as emphasis or HTML.
    return re.sub(r"[|*_<]", r"\\\g<0>", text) if "`" not in text else text
