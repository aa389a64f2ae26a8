"""The stored results of a session. Imports no Textual."""

import re
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from fivtui.model import ComputationError, InputError
from fivtui.studies import STUDIES, restore_study, store_study, study
from fivtui.tui.session import DisplayedStudy, Run, SessionResult, StoredResult, study_kind

from .state_file import rename_damaged

# Maximum size of a stored result, bytes, so that the start stays fast.
_MAX_SIZE: Final = 20_000_000
_RUN_KIND: Final = "run"
# Name of a result file: kind of study without hyphens, and a random number.
_RESULT_FILE: Final = re.compile(r"([a-z]+)-[0-9a-f]{16}\.\w+")


class _NotStored(InputError):
    # Raised for a result that is unfinished, or too large to be stored.
    pass


class ResultStore:
    """A folder with the result files of a session, each written once.

    The key of a result is ``run-1`` and so on for runs, else the kind of study. Files that the
    session no longer uses are removed; unrelated files are never touched.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.write_error = ""
        # Names of the files that this session has written or refers to.
        self._own_files: set[str] = set()
        # The last stored values by key, compared by identity, and their files.
        self._written: dict[str, tuple[object, StoredResult]] = {}

    def adopt_files(self, results: Mapping[str, StoredResult]) -> None:
        """Count the result files of a restored session as own: `remove_unused` may delete them."""
        self._own_files |= {stored.file for stored in results.values()}

    def save(
        self, results: Mapping[str, SessionResult]
    ) -> tuple[dict[str, StoredResult], dict[str, str]]:
        """Write the results that are not stored yet; a `StoredResult` is returned unchanged.

        Returns two mappings by key: the files, and why a result was not stored. The previous file
        of a result that was not stored is kept.
        """
        files: dict[str, StoredResult] = {}
        reasons_not_stored: dict[str, str] = {}
        self.write_error = ""
        for key, result in results.items():
            if isinstance(result, StoredResult):
                files[key] = result
                continue
            study = DisplayedStudy(result.result, "") if isinstance(result, Run) else result
            value, stored = self._written.get(key, (None, None))
            is_written = stored is not None and (self.folder / stored.file).exists()
            if value is not study.value or not is_written:
                try:
                    stored = self._write(study_kind(key), study)
                    self._written[key] = (study.value, stored)
                    self._own_files.add(stored.file)
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
        file = f"{kind.replace('-', '')}-{secrets.token_hex(8)}{storage.suffix}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be made: {error.strerror}") from None
        store_study(kind, value, self.folder / file)
        return StoredResult(file, displayed.name, displayed.source)

    def read(self, key: str, stored: StoredResult, *, rename_if_damaged: bool = True) -> Any:
        """Read the result `key`; raises `InputError` if it cannot be read.

        A damaged file no longer belongs to the session.
        """
        kind = study_kind(key)
        path = self.folder / stored.file
        try:
            if not _is_result_file(stored.file):
                raise InputError("not the name of a file of this session")
            value = restore_study(kind, path)
        except InputError as error:
            reason = str(error).removeprefix(f"{path}: ")
            self._own_files.discard(stored.file)
            may_rename = rename_if_damaged and _is_result_file(stored.file) and path.exists()
            phrase = f"; {rename_damaged(path)}" if may_rename else ""
            raise InputError(
                f"the {key.replace('-', ' ') if kind == _RUN_KIND else key} of the last session "
                f"could not be restored ({reason}){phrase}"
            ) from None
        self._written[key] = (value, stored)
        self._own_files.add(stored.file)
        return value if kind == _RUN_KIND else DisplayedStudy(value, stored.name, stored.source)

    def remove_unused(self, files: Mapping[str, StoredResult]) -> None:
        """Delete files of this session that are not in `files`."""
        for name in self._own_files - {stored.file for stored in files.values()}:
            if _is_result_file(name):
                with suppress(OSError):
                    (self.folder / name).unlink(missing_ok=True)
            self._own_files.discard(name)


def _is_result_file(name: str) -> bool:
    match = _RESULT_FILE.fullmatch(name)
    return match is not None and match[1] in {kind.replace("-", "") for kind in STUDIES}
