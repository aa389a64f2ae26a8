"""What the tabs of studies show, and where it came from. Imports no Textual."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

if TYPE_CHECKING:
    from fivtui.core.stability_map import StabilityMap
    from fivtui.sweeps import Sweep
    from fivtui.tradeoff import Tradeoff

T = TypeVar("T")

# The chart that shows it, by tab.
CHARTS: Final = {"sweep": "sweep-chart", "map": "map-chart", "trade-off": "errors-chart"}


@dataclass(frozen=True, slots=True, eq=False)
class Shown(Generic[T]):
    """The result of a study.

    Attributes
    ----------
    value : Sweep, StabilityMap or Tradeoff
        The result.
    name : str
        Name of the scene that it is of, or of the file.
    source : str
        File that it was read from; empty if it was computed here.
    """

    value: T
    name: str
    source: str = ""


@dataclass(slots=True)
class Studies:
    """What the tabs show; None where there is nothing.

    Attributes
    ----------
    sweep : Shown of Sweep
        Perhaps not complete.
    map : Shown of StabilityMap
        Read from a file; what follows the form is no more than it.
    tradeoff : Shown of Tradeoff
        Measured here, or read from a file.
    """

    sweep: "Shown[Sweep] | None" = None
    map: "Shown[StabilityMap] | None" = None
    tradeoff: "Shown[Tradeoff] | None" = None

    def put(self, kind: str, shown: "Shown[Any]") -> None:
        """Show something: `kind` is a tab, such as ``trade-off``."""
        setattr(self, kind.replace("-", ""), shown)

    def get(self, kind: str) -> "Shown[Any] | None":
        """What is shown in a tab, such as ``trade-off``."""
        shown: Shown[Any] | None = getattr(self, kind.replace("-", ""))
        return shown
