"""Kinds of study: the paper's figures and claims.

A `StudyKind` tells the command line and the laboratory how to print, draw and save results.
`header` are keys that identify its tables; `command` is the command that computes them. `save`
writes a file for the user, and `as_json` offers JSON, too; `stored` is the file from which the
laboratory restores a result.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from fivtui.io import save_bytes, save_json
from fivtui.lazy import lazy_modules
from fivtui.results import TABLE_SUFFIXES, Command, Storage, StudyKind

if TYPE_CHECKING:
    from .claims.claim import CheckedClaim
    from .results import PaperResults

charts, data, check, report = lazy_modules(
    __name__, "charts", "data", "claims.check", "claims.report"
)


class ComputedPanel(NamedTuple):
    """A panel of a figure, and the results that it shows."""

    key: str
    results: "PaperResults"

    @property
    def number(self) -> int:
        """Number of the figure."""
        return int(self.key.rstrip("ab"))

    @property
    def letter(self) -> str:
        """Letter of the panel in its figure; empty for a single panel."""
        return self.key.lstrip("0123456789")


def _show_panel(panel: ComputedPanel) -> None:
    from fivtui.console import print_rows

    columns = panel.results.table(panel.key).columns
    rows = [[f"{value:.6g}" for value in row] for row in zip(*columns.values(), strict=True)]
    print_rows(f"Fig. {panel.key}", list(columns), rows)


FIGURE: Final = StudyKind(
    contents_name="figure's data",
    show=_show_panel,
    to_dict=lambda panel: {
        name: values.tolist() for name, values in panel.results.table(panel.key).columns.items()
    },
    figure=lambda panel: charts.draw(panel.number, panel.results),
    suffixes=TABLE_SUFFIXES,
    save=lambda panel, path: data.save_data(panel.results.table(panel.key), path),
    stem=lambda panel: f"fig-{panel.number:02d}{panel.letter}",
    header_keys=frozenset({"figure"}),
    command=lambda panel: Command("figures", arguments=[str(panel.number), "--out", "figures"]),
)


def _save_claims(checked: "Sequence[CheckedClaim]", path: Path) -> None:
    if path.suffix.lower() == ".csv":
        report.save_claims(checked, path)
    else:
        save_bytes(f"{report.claims_markdown(checked)}\n".encode(), path)


CLAIMS: Final = StudyKind(
    contents_name="claims",
    show=report.print_claims,
    to_dict=check.claims_to_list,
    suffixes=(".md", ".csv"),
    save=_save_claims,
    as_json=True,
    stem=lambda _: "claims",
    storage=Storage(
        suffix=".json",
        save=lambda checked, path: save_json(check.claims_to_stored(checked), path),
        load=check.stored_claims,
    ),
    command=lambda _: Command("claims"),
)
