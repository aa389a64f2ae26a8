"""Restores a session at the start and saves it when it changes. Imports no Textual."""

import threading
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fivtui.model import InputError
from fivtui.tui.session import StoredResult

from .slots import Slot, claim, hold, saved_slots, slot_of
from .state_file import DamagedSession, State, load_state, rename_damaged, save_state

if TYPE_CHECKING:
    from .results import ResultStore


class Autosave:
    """Restores a session and saves it whenever it differs from its file.

    A session is locked against other processes.
    """

    def __init__(self, path: Path | None) -> None:
        self._first = path
        self._slot: Slot | None = None
        self._slot_lock: ExitStack | None = None
        # Signature of a session read without a lock.
        self._signature: tuple[int, int] | None = None
        self._saved: State | None = None
        self._lock = threading.Lock()
        self._results: ResultStore | None = None
        self.error = ""
        self.notices: list[str] = []

    @property
    def enabled(self) -> bool:
        """Whether sessions are saved."""
        return self._slot is not None

    @property
    def number(self) -> int:
        """Number of the session; 0 if none."""
        return 0 if self._slot is None else self._slot.number

    @property
    def other_slots(self) -> list[Slot]:
        """The other saved sessions, last used first; other processes may have locked them."""
        if self._first is None:
            return []
        return [slot for slot in saved_slots(self._first) if slot.number != self.number]

    def load(self) -> State | None:
        """Open the session last used that is not locked. Returns None for a new session."""
        if self._first is None:
            return None
        useless: set[int] = set()
        while True:
            try:
                self._slot, self._slot_lock = claim(self._first, useless)
            except InputError as error:
                self.error = str(error)
                return self._look(self._first)
            try:
                return self._read(self._slot)
            except InputError as error:
                self.notices.append(str(error))
                if self._slot.signature is None:
                    return None
                # The file stays for a version that can read it.
                useless.add(self._slot.number)
                self._release()

    def _look(self, first: Path) -> State | None:
        # Without a lock, read only.
        for slot in saved_slots(first):
            self._slot, self._signature = slot, slot.signature
            try:
                return self._load(slot)
            except InputError as error:
                self.notices.append(f"{slot.path}: {error}")
        self._slot, self._signature = slot_of(first, 1), slot_of(first, 1).signature
        return None

    def open(self, number: int) -> State:
        """Open the session `number`; raises `InputError` if it is locked or cannot be restored."""
        slot = slot_of(self._first or Path(), number)
        self._slot_lock = hold(slot)
        try:
            state = self._read(slot)
            if state is None:
                raise InputError(f"session {number} no longer exists")
        except InputError:
            self._release()
            raise
        self._slot = slot
        return state

    def _read(self, slot: Slot) -> State | None:
        try:
            return self._load(slot)
        except DamagedSession as error:
            raise InputError(
                f"the last session could not be restored ({error}); {rename_damaged(slot.path)}, "
                f"its results stay in {slot.results}"
            ) from None
        except InputError as error:
            raise InputError(
                f"the last session could not be restored ({error}); it stays in {slot.path}, "
                f"its results in {slot.results}"
            ) from None

    def _load(self, slot: Slot) -> State | None:
        self._saved = load_state(slot.path)
        if self._saved is not None:
            self._store_of(slot).adopt(self._saved.results)
        return self._saved

    def due(self, state: State) -> bool:
        """Whether a state differs from the session's file."""
        return self.enabled and state != self._saved

    def save(self, state: State) -> None:
        """Save a state if it is due."""
        with self._lock:
            if self._slot is not None and self.due(state):
                self._save(state, self._slot)

    def _save(self, state: State, slot: Slot) -> None:
        # After a failure, try again only when the state changes.
        self._saved = state
        store = self._store_of(slot)
        try:
            self._hold_again(slot)
            # Results are written before the state that refers to them, and removed after it.
            files, notes = store.put(state.results)
            save_state(replace(state, results=files, notes=notes), slot.path)
        except InputError as error:
            self.error = str(error)
        else:
            store.remove_others(files)
            self.error = store.failure

    def _hold_again(self, slot: Slot) -> None:
        if self._slot_lock is not None:
            return
        slot_lock = hold(slot)
        if slot.signature != self._signature:
            slot_lock.close()
            raise InputError(f"{slot.path}: another fivtui has written it since it was read")
        self._slot_lock = slot_lock

    def close(self, state: State) -> None:
        """Save for the last time and release the session."""
        with self._lock:
            if self._slot is not None and (self.due(state) or self.error):
                self._save(state, self._slot)
            self._release()
            self._slot = None

    def _release(self) -> None:
        if self._slot_lock is not None:
            self._slot_lock.close()
            self._slot_lock = None

    def result(self, key: str, stored: StoredResult) -> Any:
        """Read a stored result; raises `InputError` if it cannot be read."""
        slot = self._slot
        if slot is None:
            raise InputError(f"{key}: the session is closed")
        return self._store_of(slot).get(key, stored, aside=self._slot_lock is not None)

    def _store_of(self, slot: Slot) -> "ResultStore":
        from .results import ResultStore

        if self._results is None or self._results.folder != slot.results:
            self._results = ResultStore(slot.results)
        return self._results
