"""Entry of stability in the registry of studies.

The keys in `header` identify the study in the header of a saved table, those in `json_keys` in a
JSON object. `stem` is the part of default file names that describes the result. `command` computes
a study: a result, or a request with its parameters.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from fivtui.lazy import lazy_modules
from fivtui.results import TABLE_SUFFIXES, StudyKind, command_for, save_table

if TYPE_CHECKING:
    from .eigenvalues import Stability

(report,) = lazy_modules(__name__, "report")
_DATA: Final = "table of modes"


def _save_modes(result: "Stability", path: Path) -> None:
    header = {
        "parameters": result.parameters.as_dict(),
        "separation": result.separation,
        "critical_mu": [critical.mu for critical in result.critical_mu],
    }
    save_table(path, _DATA, result.modes_over_mu()._table(), header)


STABILITY: Final = StudyKind(
    contents_name=_DATA,
    show=report.print_stability,
    suffixes=TABLE_SUFFIXES,
    save=_save_modes,
    as_json=True,
    stem=lambda _study: "stability",
    header_keys=frozenset({"critical_mu"}),
    json_keys=frozenset({"eigenvalues", "critical_mu"}),
    command=lambda study: command_for("stability", study),
)
