"""The paper's figures and claims among the studies."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fivtui.results import Command, StudyKind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .claims.claim import CheckedClaim
    from .results import PaperResults


class PanelOf(NamedTuple):
    """A panel of a figure, and where its numbers come from."""

    key: str
    results: "PaperResults"

    @property
    def number(self) -> int:
        """Number of the figure."""
        return int(self.key.rstrip("ab"))

    @property
    def letter(self) -> str:
        """Its letter in the figure; empty if it is the only one."""
        return self.key.lstrip("0123456789")


def _save_panel(panel: PanelOf, path: Path, force: bool) -> None:
    from .data import save_data

    save_data(panel.results.table(panel.key), path, force=force)


def _draw(panel: PanelOf) -> "Figure":
    from .drawing import draw

    return draw(panel.number, panel.results)


def _show_panel(panel: PanelOf) -> None:
    from fivtui.console import print_rows

    columns = panel.results.table(panel.key).columns
    rows = [[f"{value:.6g}" for value in row] for row in zip(*columns.values(), strict=True)]
    print_rows(f"Fig. {panel.key}", list(columns), rows)


def _panel_to_dict(panel: PanelOf) -> dict[str, Any]:
    return {name: v.tolist() for name, v in panel.results.table(panel.key).columns.items()}


FIGURE: Final = StudyKind(
    data="figure's data",
    show=_show_panel,
    to_dict=_panel_to_dict,
    figure=_draw,
    suffixes=(".csv", ".npz", ".parquet"),
    save=_save_panel,
    stem=lambda panel: f"fig-{panel.number:02d}{panel.letter}",
    header=frozenset({"figure"}),
    command=lambda panel: Command("figures", words=[str(panel.number), "--out", "figures"]),
)


def _show_claims(checked: "Sequence[CheckedClaim]") -> None:
    from .claims.report import print_claims

    print_claims(checked)


def _claims_to_list(checked: "Sequence[CheckedClaim]") -> Any:
    from .claims.check import claims_to_list

    return claims_to_list(checked)


def _save_claims(checked: "Sequence[CheckedClaim]", path: Path, force: bool) -> None:
    from fivtui.io import save_bytes

    from .claims.report import claims_csv, claims_markdown

    as_table = path.suffix.lower() == ".csv"
    text = claims_csv(checked) if as_table else f"{claims_markdown(checked)}\n"
    save_bytes(text.encode(), path, force=force)


CLAIMS: Final = StudyKind(
    data="claims",
    show=_show_claims,
    to_dict=_claims_to_list,
    suffixes=(".md", ".csv"),
    save=_save_claims,
    as_json=True,
    stem=lambda _: "claims",
    command=lambda _: Command("claims"),
)
