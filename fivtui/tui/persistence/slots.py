"""Slots: numbered session files with locks and result folders. Imports no Textual."""

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

_LOCK_OWNER: Final = "another fivtui"


@dataclass(frozen=True, slots=True)
class Slot:
    """A numbered place for a session, from 1: its file; results and lock file are beside it."""

    number: int
    path: Path

    @property
    def results_folder(self) -> Path:
        """The folder of the result files."""
        return self.path.parent / "results"

    @property
    def lock_path(self) -> Path:
        """The lock file."""
        return self.path.with_suffix(".lock")

    @property
    def last_used(self) -> float:
        """Time of the last use: seconds since the epoch."""
        times = [0.0]
        for path in (self.path, self.lock_path):
            with suppress(OSError):
                times.append(path.stat().st_mtime)
        return max(times)

    @property
    def signature(self) -> tuple[int, int] | None:
        """Modification time and size of the session file; None if it does not exist."""
        try:
            status = self.path.stat()
        except OSError:
            return None
        return status.st_mtime_ns, status.st_size


def slot_of(first_path: Path, number: int) -> Slot:
    """The slot of a number; `first_path` is the file of session 1."""
    folder = first_path.parent if number == 1 else first_path.parent / f"{first_path.stem}-{number}"
    return Slot(number, folder / first_path.name)


def saved_slots(first_path: Path) -> list[Slot]:
    """The slots that have a session file, last used first."""
    numbers = {1}
    with suppress(OSError):
        for path in first_path.parent.iterdir():
            match = re.fullmatch(rf"{re.escape(first_path.stem)}-([1-9][0-9]{{0,8}})", path.name)
            if match:
                numbers.add(int(match[1]))
    slots = [slot_of(first_path, number) for number in sorted(numbers)]
    return sorted((slot for slot in slots if slot.signature), key=lambda slot: -slot.last_used)


def lock_slot(slot: Slot) -> ExitStack:
    """Lock a slot until the returned stack is closed or the process ends.

    Raises `LockedError` if another process has locked it, `InputError` if it cannot be locked.
    """
    folder = slot.path.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
    stack = ExitStack()
    stack.enter_context(hold_lock(slot.lock_path, _LOCK_OWNER))
    stack.callback(_touch, slot.lock_path)
    _touch(slot.lock_path)
    with suppress(OSError):
        # Killed processes leave temporary files; the lock excludes other writers.
        for path in (*folder.glob(TEMPORARY_GLOB), *slot.results_folder.glob(TEMPORARY_GLOB)):
            path.unlink(missing_ok=True)
    return stack


def _touch(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)


def lock_free_slot(first_path: Path, excluded: Collection[int] = ()) -> tuple[Slot, ExitStack]:
    """Lock the last used session that is free and not `excluded`, or else an empty slot."""
    for slot in saved_slots(first_path):
        if slot.number not in excluded:
            with suppress(InputError):
                return slot, lock_slot(slot)
    for slot in _empty_slots(first_path):
        # Another process may hold an empty slot; an error of another kind is that of all slots.
        with suppress(LockedError):
            return slot, lock_slot(slot)
    raise AssertionError("the number of empty slots is unlimited")


def _empty_slots(first_path: Path) -> Iterator[Slot]:
    slots = (slot_of(first_path, number) for number in count(1))
    return (slot for slot in slots if slot.signature is None)
