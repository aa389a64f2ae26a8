"""What the tabs of studies show, and where it came from. Imports no Textual."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from fivtui.model.errors import InputError

if TYPE_CHECKING:
    from fivtui.equilibrium.map import StabilityMap
    from fivtui.sweeps.run import Sweep
    from fivtui.sweeps.study import Study
    from fivtui.tradeoffs.measure import Tradeoff

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


def check_drawable(study: "Study") -> None:
    """Check that a sweep can be shown: over one name, or over two, every value with every other.

    Parameters
    ----------
    study : Study
        The sweep.

    Raises
    ------
    InputError
        If it cannot.
    """
    names, kind = list(study.design.axes), study.design.kind
    if len(names) > 2 or (len(names) == 2 and kind != "product"):
        raise InputError(
            f"a {kind} sweep over {', '.join(names)}: shown are sweeps over one name, "
            "or over every value of two"
        )


@dataclass(frozen=True, slots=True)
class KeptFile:
    """A result in a file: the name of the file, and what `Shown` says of it."""

    file: str
    name: str = ""
    source: str = ""
