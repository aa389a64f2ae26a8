"""Restores a session at the start and saves its changes. Imports no Textual.

A slot is a numbered place for a session: its file, lock file and folder of results.
"""

import threading
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fivtui.model import InputError
from fivtui.tui.session import StoredResult

from .slots import Slot, lock_free_slot, lock_slot, saved_slots, slot_of
from .state_file import DamagedSession, State, load_state, rename_damaged, save_state

if TYPE_CHECKING:
    from .results import ResultStore


class Autosave:
    """Restores a session, locks it against other processes, and saves its changes.

    `path` is the file of session 1; None saves nothing. `save_error` says why the last save failed,
    `notices` why sessions could not be restored.
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
        self._store: ResultStore | None = None
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

    def load(self) -> State | None:
        """Open the last used session that is not locked. Returns None for a new session."""
        if self._first_path is None:
            return None
        unreadable: set[int] = set()
        while True:
            try:
                self._slot, self._slot_lock = lock_free_slot(self._first_path, unreadable)
            except InputError as error:
                self.save_error = str(error)
                return self._load_unlocked(self._first_path)
            try:
                return self._load_or_explain(self._slot)
            except InputError as error:
                self.notices.append(str(error))
                if self._slot.signature is None:
                    # The damaged file was renamed, so the slot is empty.
                    return None
                # Keep the file: another version of fivtui may read it.
                unreadable.add(self._slot.number)
                self._release()

    def _load_unlocked(self, first_path: Path) -> State | None:
        # Sessions cannot be locked here, for example in a read-only folder.
        for slot in saved_slots(first_path):
            self._slot, self._signature = slot, slot.signature
            try:
                return self._load(slot)
            except InputError as error:
                self.notices.append(f"{slot.path}: {error}")
        self._slot, self._signature = slot_of(first_path, 1), slot_of(first_path, 1).signature
        return None

    def open(self, number: int) -> State:
        """Open the session `number`; raises `InputError` if it is locked or cannot be restored."""
        slot = slot_of(self._first_path or Path(), number)
        self._slot_lock = lock_slot(slot)
        try:
            state = self._load_or_explain(slot)
            if state is None:
                raise InputError(f"session {number} no longer exists")
        except InputError:
            self._release()
            raise
        self._slot = slot
        return state

    def _load_or_explain(self, slot: Slot) -> State | None:
        # As `_load`; the error says where the files stay.
        try:
            return self._load(slot)
        except DamagedSession as error:
            raise InputError(
                f"the last session could not be restored ({error}); {rename_damaged(slot.path)}, "
                f"its results stay in {slot.results_folder}"
            ) from None
        except InputError as error:
            raise InputError(
                f"the last session could not be restored ({error}); it stays in {slot.path}, "
                f"its results in {slot.results_folder}"
            ) from None

    def _load(self, slot: Slot) -> State | None:
        self._saved_state = load_state(slot.path)
        if self._saved_state is not None:
            self._result_store(slot).adopt_files(self._saved_state.results)
        return self._saved_state

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
        store = self._result_store(slot)
        try:
            self._ensure_locked(slot)
            # Write new results before the session file that refers to them; remove old ones later.
            files, reasons_not_stored = store.save(state.results)
            state_of_file = replace(state, results=files, notes=reasons_not_stored)
            save_state(state_of_file, slot.path)
        except InputError as error:
            self.save_error = str(error)
        else:
            store.remove_unused(files)
            self.save_error = store.write_error

    def _ensure_locked(self, slot: Slot) -> None:
        if self._slot_lock is not None:
            return
        slot_lock = lock_slot(slot)
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
            self._slot = None

    def _release(self) -> None:
        if self._slot_lock is not None:
            self._slot_lock.close()
            self._slot_lock = None

    def read_result(self, key: str, stored: StoredResult) -> Any:
        """Read a stored result; raises `InputError` if it cannot be read."""
        slot = self._slot
        if slot is None:
            raise InputError(f"{key}: the session is closed")
        # Without a lock the files may belong to another process.
        is_locked = self._slot_lock is not None
        return self._result_store(slot).read(key, stored, rename_if_damaged=is_locked)

    def _result_store(self, slot: Slot) -> "ResultStore":
        from .results import ResultStore

        if self._store is None or self._store.folder != slot.results_folder:
            self._store = ResultStore(slot.results_folder)
        return self._store
