"""Results displayed in the tabs of studies. Imports no Textual."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from fivtui.model import InputError

if TYPE_CHECKING:
    from fivtui.equilibrium import StabilityMap
    from fivtui.sweeps import Study, Sweep
    from fivtui.tradeoffs import Tradeoff

T = TypeVar("T")

# Identifier of the chart by tab.
CHARTS: Final = {"sweep": "sweep-chart", "map": "map-chart", "trade-off": "errors-chart"}


@dataclass(frozen=True, slots=True, eq=False)
class DisplayedStudy(Generic[T]):
    """A displayed result, the name of its scene or file, and the file it was read from."""

    value: T
    name: str
    source: str = ""


@dataclass(slots=True)
class DisplayedStudies:
    """The displayed results; None where there is nothing.

    Attributes
    ----------
    sweep : DisplayedStudy of Sweep
        May be incomplete.
    map : DisplayedStudy of StabilityMap
        A map read from a file; the computed one follows the form.
    tradeoff : DisplayedStudy of Tradeoff
        Measured here or read from a file.
    """

    sweep: "DisplayedStudy[Sweep] | None" = None
    map: "DisplayedStudy[StabilityMap] | None" = None
    tradeoff: "DisplayedStudy[Tradeoff] | None" = None

    def put(self, kind: str, study: "DisplayedStudy[Any]") -> None:
        """Display a result in a tab, such as ``trade-off``."""
        setattr(self, kind.replace("-", ""), study)

    def get(self, kind: str) -> "DisplayedStudy[Any] | None":
        """The result displayed in a tab, such as ``trade-off``."""
        study: DisplayedStudy[Any] | None = getattr(self, kind.replace("-", ""))
        return study


def check_drawable(study: "Study") -> None:
    """Raise `InputError` unless a sweep has one variable, or two as a full grid."""
    names, kind = list(study.design.axes), study.design.kind
    if len(names) > 2 or (len(names) == 2 and kind != "product"):
        raise InputError(
            f"a {kind} sweep over {', '.join(names)}: shown are sweeps over one name, "
            "or over every value of two"
        )


@dataclass(frozen=True, slots=True)
class StoredResult:
    """A stored result: the name of its file, and name and source as in `DisplayedStudy`."""

    file: str
    name: str = ""
    source: str = ""
