"""Keeps the session in its file. Imports no Textual."""

import threading
from pathlib import Path

from fivtui.core.errors import InputError

from .state_file import State, load_state, save_state


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
                save_state(state, self._path)
            except InputError as error:
                self.error = str(error)
            else:
                self.error = ""
