"""Session folders and their locks. Imports no Textual."""

import os
import re
from collections.abc import Collection, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Final

from fivtui.io import TEMPORARY_GLOB, LockedError, hold_lock
from fivtui.model import InputError

_HOLDER: Final = "another fivtui"


@dataclass(frozen=True, slots=True)
class Slot:
    """Number of a session, from 1, and its file; results and lock are in the same folder."""

    number: int
    path: Path

    @property
    def results(self) -> Path:
        """The folder of its results."""
        return self.path.parent / "results"

    @property
    def lock(self) -> Path:
        """The lock file."""
        return self.path.with_suffix(".lock")

    @property
    def used(self) -> float:
        """Time of its last use, as a system time, s."""
        times = [0.0]
        for path in (self.path, self.lock):
            with suppress(OSError):
                times.append(path.stat().st_mtime)
        return max(times)

    @property
    def signature(self) -> tuple[int, int] | None:
        """Modification time and size of the session file; None if there is none."""
        try:
            status = self.path.stat()
        except OSError:
            return None
        return status.st_mtime_ns, status.st_size


def slot_of(first: Path, number: int) -> Slot:
    """The slot of a number; `first` is the file of session 1."""
    folder = first.parent if number == 1 else first.parent / f"{first.stem}-{number}"
    return Slot(number, folder / first.name)


def saved_slots(first: Path) -> list[Slot]:
    """The slots with a session, last used first."""
    numbers = {1}
    with suppress(OSError):
        for path in first.parent.iterdir():
            match = re.fullmatch(rf"{re.escape(first.stem)}-([1-9][0-9]{{0,8}})", path.name)
            if match:
                numbers.add(int(match[1]))
    slots = [slot_of(first, number) for number in sorted(numbers)]
    return sorted((slot for slot in slots if slot.signature), key=lambda slot: -slot.used)


def hold(slot: Slot) -> ExitStack:
    """Lock a slot until the returned stack is closed or the process ends.

    Raises `LockedError` if another process holds it, `InputError` if it cannot be locked.
    """
    folder = slot.path.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
    stack = ExitStack()
    stack.enter_context(hold_lock(slot.lock, _HOLDER))
    stack.callback(_touch, slot.lock)
    _touch(slot.lock)
    with suppress(OSError):
        # Temporary files of killed processes; the lock excludes other writers.
        for path in (*folder.glob(TEMPORARY_GLOB), *slot.results.glob(TEMPORARY_GLOB)):
            path.unlink(missing_ok=True)
    return stack


def _touch(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)


def claim(first: Path, but: Collection[int] = ()) -> tuple[Slot, ExitStack]:
    """Lock the last used free session except `but`, or else an empty slot."""
    for slot in saved_slots(first):
        if slot.number not in but:
            with suppress(InputError):
                return slot, hold(slot)
    for slot in _empty(first):
        with suppress(LockedError):
            return slot, hold(slot)
    raise AssertionError("there are places without end")


def _empty(first: Path) -> Iterator[Slot]:
    slots = (slot_of(first, number) for number in count(1))
    return (slot for slot in slots if slot.signature is None)
