"""Slots: numbered session files with locks and result folders. Imports no Textual."""

import os
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fivtui.io import TEMPORARY_GLOB, hold_lock
from fivtui.model import InputError

# Maximum number of sessions.
_MAX_SESSIONS: Final = 100


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
    def last_used(self) -> float:
        """Time of the last use of its session, s since the epoch; 0 without a session."""
        try:
            return self.path.stat().st_mtime
        except OSError:
            return 0.0

    def lock(self) -> ExitStack:
        """Lock the slot until the returned stack is closed or the process ends.

        Raises `LockedError` if another process has locked it, `InputError` if it cannot be locked.
        """
        folder = self.path.parent
        make_folder(folder)
        stack = ExitStack()
        stack.enter_context(hold_lock(self.path.with_suffix(".lock"), "another fivtui"))
        stack.callback(_touch, self.path)
        with suppress(OSError):
            # Killed processes leave temporary files; the lock excludes other writers.
            for path in (*folder.glob(TEMPORARY_GLOB), *self.results_folder.glob(TEMPORARY_GLOB)):
                path.unlink(missing_ok=True)
        return stack


def make_folder(folder: Path) -> None:
    """Make a folder and its parents; raises `InputError` if that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None


def _touch(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)


def slot_of(first_path: Path, number: int) -> Slot:
    """The slot of a number; `first_path` is the file of session 1."""
    folder = first_path.parent if number == 1 else first_path.parent / f"{first_path.stem}-{number}"
    return Slot(number, folder / first_path.name)


def all_slots(first_path: Path) -> list[Slot]:
    """The slots that have a session file, last used first, then empty ones."""
    slots = [slot_of(first_path, number) for number in range(1, _MAX_SESSIONS + 1)]
    return sorted(slots, key=lambda slot: -slot.last_used)


def saved_slots(first_path: Path) -> list[Slot]:
    """The slots that have a session file, last used first."""
    return [slot for slot in all_slots(first_path) if slot.last_used]
