"""Slots: numbered session files with locks and result folders. Imports no Textual."""

import os
import re
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import Final

from fivtui.io import TEMPORARY_GLOB, hold_lock
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

    def lock(self) -> ExitStack:
        """Lock the slot until the returned stack is closed or the process ends.

        Raises `LockedError` if another process has locked it, `InputError` if it cannot be locked.
        """
        folder = self.path.parent
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
        stack = ExitStack()
        stack.enter_context(hold_lock(self.lock_path, _LOCK_OWNER))
        stack.callback(_touch, self.lock_path)
        _touch(self.lock_path)
        with suppress(OSError):
            # Killed processes leave temporary files; the lock excludes other writers.
            for path in (*folder.glob(TEMPORARY_GLOB), *self.results_folder.glob(TEMPORARY_GLOB)):
                path.unlink(missing_ok=True)
        return stack


def _touch(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)


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


def all_slots(first_path: Path) -> Iterator[Slot]:
    """The slots that have a session file, last used first, then empty ones without end."""
    slots = (slot_of(first_path, number) for number in count(1))
    return chain(saved_slots(first_path), (slot for slot in slots if slot.signature is None))
