"""Keeps the session in its file. Imports no Textual."""

import threading
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.core.errors import InputError

from .state_file import KeptFile, State, load_state, save_state

if TYPE_CHECKING:
    from .result_store import ResultStore

_RESULTS: Final = "results"


class Keeper:
    """Reads a session at the start, and writes it whenever it differs from what is in the file.

    Parameters
    ----------
    path : Path or None
        The file; None to keep nothing.

    Attributes
    ----------
    error : str
        Why the session could not be written the last time; empty if it could.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._kept: State | None = None
        self._lock = threading.Lock()
        self._results: ResultStore | None = None
        self.error = ""

    @property
    def keeps(self) -> bool:
        """Whether anything is kept."""
        return self._path is not None

    def load(self) -> State | None:
        """The session of the last time.

        Returns
        -------
        State or None
            None if there is none.

        Raises
        ------
        InputError
            If it cannot be restored. Where it could not be put aside either, nothing is kept from
            now on: its file is left alone.
        """
        if self._path is None:
            return None
        try:
            self._kept = load_state(self._path)
        except InputError:
            if self._path.exists():
                self._path = None
            raise
        return self._kept

    def due(self, state: State) -> bool:
        """Whether a session differs from what is in the file."""
        return self.keeps and state != self._kept

    def save(self, state: State) -> None:
        """Write a session if it is due.

        Parameters
        ----------
        state : State
            The session.
        """
        with self._lock:
            if self._path is None or not self.due(state):
                return
            # One that could not be written is not tried again until it changes.
            self._kept = state
            try:
                files, notes = self._store.put(state.results)
                save_state(replace(state, results=files, notes=notes), self._path)
            except InputError as error:
                self.error = str(error)
            else:
                self._store.remove_others(files)
                self.error = ""

    def result(self, key: str, kept: KeptFile) -> Any:
        """A result of the last time; parameters and errors as `ResultStore.get`."""
        return self._store.get(key, kept)

    @property
    def _store(self) -> "ResultStore":
        from .result_store import ResultStore

        if self._results is None:
            self._results = ResultStore((self._path or Path()).parent / _RESULTS)
        return self._results
