"""The stored results of a session. Imports no Textual."""

import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from fivtui.model import ComputationError, InputError
from fivtui.studies import restore_study, store_study, study
from fivtui.tui.session import SAFETY_MAPS, DisplayedStudy, ResultKey, Run, StoredResult

from .slots import make_folder
from .state_file import SessionResult

# Maximum size of a stored result, bytes, so that the start stays fast.
_MAX_SIZE: Final = 20_000_000


class _NotStored(InputError):
    # Raised for a result that is unfinished, or too large to be stored.
    pass


class ResultStore:
    """A folder with the result files of a session, each written once.

    The key of a result is its run, or the key of a study such as ``sweep``. Files that the session
    no longer uses are removed; unrelated files are never touched.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.write_error = ""
        # The files that this session has written or refers to.
        self._own_files: set[Path] = set()
        # The last stored values by key, compared by identity, and their files.
        self._written: dict[ResultKey, tuple[object, StoredResult]] = {}

    def _path(self, stored: StoredResult) -> Path:
        # Always in the folder, whatever the session file contains.
        return self.folder / Path(stored.file).name

    def adopt_files(self, results: Mapping[ResultKey, StoredResult]) -> None:
        """Count the result files of a restored session as own: `remove_unused` may delete them."""
        self._own_files |= set(map(self._path, results.values()))

    def save(
        self, results: Mapping[ResultKey, SessionResult]
    ) -> tuple[dict[ResultKey, StoredResult], dict[ResultKey, str]]:
        """Write the results that are not stored yet; a `StoredResult` is returned unchanged.

        Returns two mappings by key: the files, and why a result was not stored. The previous file
        of a result that was not stored is kept.
        """
        files: dict[ResultKey, StoredResult] = {}
        reasons_not_stored: dict[ResultKey, str] = {}
        self.write_error = ""
        for key, result in results.items():
            if isinstance(result, StoredResult):
                files[key] = result
                continue
            displayed = result if isinstance(result, DisplayedStudy) else DisplayedStudy(result, "")
            value, stored = self._written.get(key, (None, None))
            if value is not displayed.value:
                try:
                    stored = self._write(_study_kind(key), displayed)
                    self._written[key] = (displayed.value, stored)
                    self._own_files.add(self._path(stored))
                except (InputError, ComputationError) as error:
                    suffix = "" if stored is None else "; the previous result is kept"
                    reasons_not_stored[key] = f"{error}{suffix}"
                    if not isinstance(error, (_NotStored, ComputationError)):
                        self.write_error = f"{key} is not saved: {error}"
            if stored is not None:
                files[key] = stored
        return files, reasons_not_stored

    def _write(self, kind: str, displayed: DisplayedStudy[Any]) -> StoredResult:
        storage, value = study(kind).storage, displayed.value
        if storage is None:
            raise _NotStored("it must be computed again")
        reason = storage.reason_not_to_store(value)
        if reason:
            raise _NotStored(reason)
        size = storage.size(value)
        if size > _MAX_SIZE:
            raise _NotStored(f"it takes {size / 1e6:.0f} MB; the limit is {_MAX_SIZE / 1e6:.0f} MB")
        make_folder(self.folder)
        file = f"{kind}-{secrets.token_hex(8)}{storage.suffix}"
        store_study(kind, value, self.folder / file)
        return StoredResult(file, displayed.name, displayed.source)

    def read(
        self, results: Mapping[ResultKey, StoredResult]
    ) -> tuple[dict[ResultKey, Any], list[str]]:
        """Read results by key, None for one that cannot be read, and error messages.

        The file of a result that cannot be read no longer belongs to the session.
        """
        values: dict[ResultKey, Any] = {}
        errors = []
        for key, stored in results.items():
            path = self._path(stored)
            try:
                value = restore_study(_study_kind(key), path)
            except InputError as error:
                values[key] = None
                errors.append(f"the {key} of the last session could not be restored: {error}")
                self._own_files.discard(path)
            else:
                displayed = DisplayedStudy(value, stored.name, stored.source)
                values[key] = value if isinstance(key, Run) else displayed
                self._written[key] = (value, stored)
        return values, errors

    def remove_unused(self, files: Mapping[ResultKey, StoredResult]) -> None:
        """Delete files of this session that are not in `files`."""
        unused = self._own_files - set(map(self._path, files.values()))
        for path in unused:
            with suppress(OSError):
                path.unlink(missing_ok=True)
        self._own_files -= unused
        # Forget the results, too: undo may bring back a run, which is then written again.
        for key in self._written.keys() - files.keys():
            del self._written[key]


def _study_kind(key: ResultKey) -> str:
    if isinstance(key, Run):
        return "run"
    return "map" if key in SAFETY_MAPS else key
