"""Restores a session at the start and saves its changes. Imports no Textual.

A slot is a numbered place for a session: its file, lock file and folder of results.
"""

import threading
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from fivtui.io import LockedError
from fivtui.model import InputError
from fivtui.tui.session import Session, StoredResult

from .results import ResultStore
from .slots import Slot, all_slots, saved_slots, slot_of
from .state_file import (
    DamagedSession,
    State,
    load_session,
    rename_damaged,
    save_state,
    session_state,
)


class Autosave:
    """Restores a session, locks it against other processes, and saves its changes.

    `path` is the file of session 1; None saves nothing. `save_error` says what the last save could
    not write, `notices` why sessions could not be restored.
    """

    def __init__(self, path: Path | None) -> None:
        self._first_path = path
        self._slot: Slot | None = None
        self._slot_lock: ExitStack | None = None
        # Modification time and size of the file of a session that was read without a lock.
        self._signature: tuple[int, int] | None = None
        self._saved_state: State | None = None
        # Held while the session is saved or closed.
        self._save_lock = threading.Lock()
        self._store = ResultStore(Path())
        self.save_error = ""
        self.notices: list[str] = []

    @property
    def enabled(self) -> bool:
        """Whether sessions are saved."""
        return self._slot is not None

    @property
    def number(self) -> int:
        """Number of the open session; 0 if no session is open."""
        return 0 if self._slot is None else self._slot.number

    @property
    def other_slots(self) -> list[Slot]:
        """The other saved sessions, last used first; some may be open in other processes."""
        if self._first_path is None:
            return []
        return [slot for slot in saved_slots(self._first_path) if slot.number != self.number]

    def load(self) -> Session | None:
        """Open the last used session that is not locked. Returns None for a new session."""
        if self._first_path is None:
            return None
        for slot in all_slots(self._first_path):
            try:
                self._slot_lock = slot.lock()
            except LockedError:
                continue
            except InputError as error:
                if slot.signature is not None:
                    continue
                # An empty slot that cannot be locked, for example in a read-only folder.
                self.save_error = f"the session is not saved: {error}"
                return self._load_unlocked(self._first_path)
            try:
                return self._load(slot)
            except InputError as error:
                self.notices.append(str(error))
                if slot.signature is None:
                    # The damaged file was renamed, so the slot is empty.
                    return None
                # Keep the file: another version of fivtui may read it.
                self._release()
        raise AssertionError("the number of empty slots is unlimited")

    def _load_unlocked(self, first_path: Path) -> Session | None:
        for slot in all_slots(first_path):
            self._signature = slot.signature
            try:
                return self._load(slot)
            except InputError as error:
                self.notices.append(str(error))
        raise AssertionError("an empty slot raises no error")

    def open(self, number: int) -> Session:
        """Open the session `number`; raises `InputError` if it is locked or cannot be restored."""
        slot = slot_of(self._first_path or Path(), number)
        self._slot_lock = slot.lock()
        try:
            session = self._load(slot)
            if session is None:
                raise InputError(f"session {number} no longer exists")
        except InputError:
            self._release()
            raise
        return session

    def _load(self, slot: Slot) -> Session | None:
        # Read the session of a slot, and use the slot; the error says where the files stay.
        self._slot, self._store = slot, ResultStore(slot.results_folder)
        try:
            session = None if slot.signature is None else load_session(slot.path)
        except InputError as error:
            is_damaged = isinstance(error, DamagedSession) and self._slot_lock is not None
            phrase = rename_damaged(slot.path) if is_damaged else f"it stays in {slot.path}"
            raise InputError(
                f"the last session could not be restored ({error}); {phrase}, "
                f"its results stay in {slot.results_folder}"
            ) from None
        if session is not None:
            self._saved_state = session_state(session)
            self._store.adopt_files(session.unread_results)
        return session

    def needs_save(self, state: State) -> bool:
        """Whether a state differs from the saved one."""
        return self.enabled and state != self._saved_state

    def save(self, state: State) -> None:
        """Save a state if it differs from the saved one."""
        with self._save_lock:
            if self._slot is not None and self.needs_save(state):
                self._save(state, self._slot)

    def _save(self, state: State, slot: Slot) -> None:
        # After a failure, try again only when the state changes.
        self._saved_state = state
        try:
            self._ensure_locked(slot)
            # Write new results before the session file that refers to them; remove old ones later.
            files, reasons_not_stored = self._store.save(state.results)
            save_state(state, files, reasons_not_stored, slot.path)
        except InputError as error:
            self.save_error = f"the session is not saved: {error}"
        else:
            self._store.remove_unused(files)
            self.save_error = self._store.write_error

    def _ensure_locked(self, slot: Slot) -> None:
        if self._slot_lock is not None:
            return
        slot_lock = slot.lock()
        if slot.signature != self._signature:
            slot_lock.close()
            raise InputError(f"{slot.path}: another fivtui has written it since it was read")
        self._slot_lock = slot_lock

    def close(self, state: State) -> None:
        """Save a state and unlock the session."""
        with self._save_lock:
            if self._slot is not None and (self.needs_save(state) or self.save_error):
                self._save(state, self._slot)
            self._release()

    def _release(self) -> None:
        self._slot = None
        if self._slot_lock is not None:
            self._slot_lock.close()
            self._slot_lock = None

    def read_results(
        self, unread: Mapping[str, StoredResult]
    ) -> tuple[dict[str, object], list[str]]:
        """Read stored results by key, None for one that cannot be read, and error messages."""
        results: dict[str, object] = {}
        errors = []
        for key, stored in unread.items():
            try:
                # Without a lock the files may belong to another process.
                is_locked = self._slot_lock is not None
                results[key] = self._store.read(key, stored, rename_if_damaged=is_locked)
            except InputError as error:
                results[key] = None
                errors.append(str(error))
        return results, errors
