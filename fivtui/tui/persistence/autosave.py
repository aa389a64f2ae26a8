"""Restores a session at the start and saves its changes. Imports no Textual.

A slot is a numbered place for a session: its file, lock file and folder of results.
"""

import threading
from contextlib import ExitStack
from pathlib import Path

from fivtui.io import LockedError
from fivtui.model import InputError
from fivtui.tui.session import Session

from .results import ResultStore
from .slots import Slot, all_slots, saved_slots, slot_of
from .state_file import State, load_session, rename_unread, save_state, session_state


class Autosave:
    """Restores a session, locks it against other processes, and saves its changes.

    `path` is the file of session 1; None saves nothing. `save_error` says what the last save could
    not write, `notices` why sessions could not be restored.
    """

    def __init__(self, path: Path | None) -> None:
        self._first_path = path
        self._slot: Slot | None = None
        self._slot_lock = ExitStack()
        self._saved_state: State | None = None
        # Held while the session is saved or closed.
        self._save_lock = threading.Lock()
        self.store = ResultStore(Path())
        self.save_error = ""
        self.notices: list[str] = []

    @property
    def number(self) -> int:
        """Number of the open session; 0 if sessions are not saved."""
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
                if slot.last_used:
                    continue
                # An empty slot that cannot be locked, for example in a read-only folder.
                self.save_error = f"the session is not saved: {error}"
                self.notices.append(self.save_error)
                return None
            try:
                return self._load(slot)
            except InputError as error:
                self.notices.append(str(error))
                if not slot.last_used:
                    # The file was renamed, so the slot is empty.
                    return None
                self._release()
        self.save_error = "the session is not saved: too many sessions are open"
        self.notices.append(self.save_error)
        return None

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
        self._slot, self.store = slot, ResultStore(slot.results_folder)
        try:
            session = load_session(slot.path)
        except InputError as error:
            raise InputError(
                f"the last session could not be restored ({error}); {rename_unread(slot.path)}, "
                f"its results stay in {slot.results_folder}"
            ) from None
        if session is not None:
            self._saved_state = session_state(session)
            self.store.adopt_files(session.unread_results)
        return session

    def needs_save(self, state: State) -> bool:
        """Whether a state differs from the saved one."""
        return self._slot is not None and state != self._saved_state

    def save(self, state: State) -> None:
        """Save a state if it differs from the saved one."""
        with self._save_lock:
            if self.needs_save(state):
                self._save(state)

    def _save(self, state: State) -> None:
        if self._slot is None:
            return
        # After a failure, try again only when the state changes.
        self._saved_state = state
        try:
            # Write new results before the session file that refers to them; remove old ones later.
            files, reasons_not_stored = self.store.save(state.results)
            save_state(state, files, reasons_not_stored, self._slot.path)
        except InputError as error:
            self.save_error = f"the session is not saved: {error}"
        else:
            self.store.remove_unused(files)
            self.save_error = self.store.write_error

    def close(self, state: State) -> None:
        """Save a state and unlock the session."""
        with self._save_lock:
            if self.needs_save(state) or self.save_error:
                self._save(state)
            self._release()

    def _release(self) -> None:
        self._slot = None
        self._slot_lock.close()
