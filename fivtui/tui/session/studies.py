"""Results displayed in the tabs of studies. Imports no Textual."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from fivtui.model import InputError

if TYPE_CHECKING:
    from fivtui.sweeps import Study

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class DisplayedStudy(Generic[T]):
    """A displayed result, the name of its scene or file, and the file that it was read from."""

    value: T
    name: str
    source: str = ""


def check_drawable(study: "Study") -> None:
    """Raise `InputError` unless a sweep has one variable, or two as a full grid."""
    names, kind = list(study.design.axes), study.design.kind
    if len(names) > 2 or (len(names) == 2 and kind != "product"):
        raise InputError(
            f"a {kind} sweep over {', '.join(names)} cannot be displayed: use one name, "
            "or two with all combinations of their values"
        )


@dataclass(frozen=True, slots=True)
class StoredResult:
    """The file of a stored result; `name` and `source` are those of `DisplayedStudy`."""

    file: str
    name: str = ""
    source: str = ""
