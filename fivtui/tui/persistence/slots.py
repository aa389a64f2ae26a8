"""The places of sessions, a folder each, and the lock of whoever has one. Imports no Textual."""

import os
import re
from collections.abc import Collection, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Final

from fivtui.io.locks import Locked, locked
from fivtui.model.errors import InputError

_HOLDER: Final = "another fivtui"
# What `fivtui.files` calls a file until it is whole.
_HALF_WRITTEN: Final = ".fivtui-*.tmp"


@dataclass(frozen=True, slots=True)
class Slot:
    """A place for a session.

    Attributes
    ----------
    number : int
        From 1.
    path : Path
        The file of the session; its results and its lock are beside it.
    """

    number: int
    path: Path

    @property
    def results(self) -> Path:
        """The folder of its results."""
        return self.path.parent / "results"

    @property
    def lock(self) -> Path:
        """The file that is locked by whoever has the session."""
        return self.path.with_suffix(".lock")

    @property
    def used(self) -> float:
        """When it was used last, in seconds of the system's clock."""
        times = [0.0]
        for path in (self.path, self.lock):
            with suppress(OSError):
                times.append(path.stat().st_mtime)
        return max(times)

    @property
    def signature(self) -> tuple[int, int] | None:
        """What tells the session's file from what it is after someone has written it."""
        try:
            found = self.path.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size


def slot_of(first: Path, number: int) -> Slot:
    """The place of a number.

    Parameters
    ----------
    first : Path
        The file of the session in the first place; the others have folders beside it.
    number : int
        From 1.

    Returns
    -------
    Slot
        Perhaps with nothing there.
    """
    folder = first.parent if number == 1 else first.parent / f"{first.stem}-{number}"
    return Slot(number, folder / first.name)


def kept_slots(first: Path) -> list[Slot]:
    """The places where there is a session, that used last first; `first` as in `slot_of`."""
    numbers = {1}
    with suppress(OSError):
        for path in first.parent.iterdir():
            found = re.fullmatch(rf"{re.escape(first.stem)}-([1-9][0-9]{{0,8}})", path.name)
            if found:
                numbers.add(int(found[1]))
    slots = [slot_of(first, number) for number in sorted(numbers)]
    return sorted((slot for slot in slots if slot.signature), key=lambda slot: -slot.used)


def hold(slot: Slot) -> ExitStack:
    """Take a place for this process.

    Parameters
    ----------
    slot : Slot
        The place.

    Returns
    -------
    ExitStack
        To be closed to let others have it; the end of the process does the same.

    Raises
    ------
    Locked
        If another process has it.
    InputError
        If it cannot be locked.
    """
    folder = slot.path.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
    held = ExitStack()
    held.enter_context(locked(slot.lock, _HOLDER))
    held.callback(_touch, slot.lock)
    _touch(slot.lock)
    with suppress(OSError):
        # A process that was killed leaves them; nobody else writes here now.
        for path in (*folder.glob(_HALF_WRITTEN), *slot.results.glob(_HALF_WRITTEN)):
            path.unlink(missing_ok=True)
    return held


def _touch(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)


def claim(first: Path, but: Collection[int] = ()) -> tuple[Slot, ExitStack]:
    """Take the session used last that nobody has, or else a place where there is none.

    Parameters
    ----------
    first : Path
        As in `slot_of`.
    but : collection of int
        Numbers of places that are of no use.

    Returns
    -------
    slot : Slot
        The place.
    held : ExitStack
        As of `hold`.

    Raises
    ------
    InputError
        If none can be locked.
    """
    for slot in kept_slots(first):
        if slot.number not in but:
            with suppress(InputError):
                return slot, hold(slot)
    for slot in _empty(first):
        with suppress(Locked):
            return slot, hold(slot)
    raise AssertionError("there are places without end")


def _empty(first: Path) -> Iterator[Slot]:
    slots = (slot_of(first, number) for number in count(1))
    return (slot for slot in slots if slot.signature is None)
