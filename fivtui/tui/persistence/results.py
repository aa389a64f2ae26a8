"""The stored results of a session. Imports no Textual."""

import re
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from fivtui.model import ComputationError, InputError
from fivtui.studies import STUDIES, restore_study, store_study, study
from fivtui.tui.session import DisplayedStudy, Run, StoredResult

from .state_file import rename_damaged

# Maximum size of a stored result, bytes, so that the start stays fast.
_MAX_SIZE: Final = 20_000_000
_RUN: Final = "run"
_RESULT_FILE: Final = re.compile(r"([a-z]+)-[0-9a-f]{16}\.\w+")


class _NotStored(InputError):
    # A result that is deliberately not stored.
    pass


class ResultStore:
    """A folder with the result files of a session, each written once.

    Files that the session no longer uses are removed; unrelated files are never touched.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.failure = ""
        # Names of files that this session wrote or refers to.
        self._ours: set[str] = set()
        # Results and their files, by key.
        self._files: dict[str, tuple[object, StoredResult]] = {}

    def adopt(self, results: Mapping[str, object]) -> None:
        """Register the files of a restored session."""
        self._ours |= {
            stored.file for stored in results.values() if isinstance(stored, StoredResult)
        }

    def put(self, results: Mapping[str, object]) -> tuple[dict[str, StoredResult], dict[str, str]]:
        """Write new results, by key; a `StoredResult` is returned unchanged.

        Returns the files by key, and by key why a result was not stored (its previous file stays).
        """
        files: dict[str, StoredResult] = {}
        notes: dict[str, str] = {}
        self.failure = ""
        for key, result in results.items():
            if isinstance(result, StoredResult):
                files[key] = result
                continue
            token = result.result if isinstance(result, Run) else result
            stored_token, file = self._files.get(key, (None, None))
            if stored_token is not token or file is None or not (self.folder / file.file).exists():
                try:
                    written = self._write(key, result)
                except (_NotStored, ComputationError) as error:
                    notes[key] = str(error)
                except InputError as error:
                    notes[key] = self.failure = str(error)
                else:
                    self._files[key] = (token, written)
                    self._ours.add(written.file)
                    file = written
                if key in notes and file is not None:
                    notes[key] += "; the previous one is kept"
            if file is not None:
                files[key] = file
        return files, notes

    def _write(self, key: str, result: object) -> StoredResult:
        kind, value, name, source = _parts(result, key)
        form = study(kind).stored
        if form is None:
            raise TypeError(f"{kind}: {type(value)}")
        if why := form.unfinished(value):
            raise _NotStored(why)
        size = form.size(value)
        if size > _MAX_SIZE:
            raise _NotStored(f"it takes {size / 1e6:.0f} MB; the limit is {_MAX_SIZE / 1e6:.0f} MB")
        file = f"{kind.replace('-', '')}-{secrets.token_hex(8)}{form.suffix}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be made: {error.strerror}") from None
        store_study(kind, value, self.folder / file)
        return StoredResult(file, name, source)

    def get(self, key: str, stored: StoredResult, *, aside: bool = True) -> Any:
        """Read the result `key`; raises `InputError` if it cannot be read.

        A damaged file is renamed if `aside`, and no longer belongs to the session.
        """
        kind = _kind(key)
        path = self.folder / stored.file
        try:
            if not _is_own(stored.file):
                raise InputError("not the name of a file of this session")
            value = restore_study(kind, path)
        except InputError as error:
            why = str(error).removeprefix(f"{path}: ")
            self._ours.discard(stored.file)
            is_own = _is_own(stored.file)
            where = f"; {rename_damaged(path)}" if aside and is_own and path.exists() else ""
            raise InputError(
                f"the {key.replace('-', ' ') if kind == _RUN else key} of the last session could "
                f"not be restored ({why}){where}"
            ) from None
        result = value if kind == _RUN else DisplayedStudy(value, stored.name, stored.source)
        self._files[key] = (result, stored)
        self._ours.add(stored.file)
        return result

    def remove_others(self, files: Mapping[str, StoredResult]) -> None:
        """Remove files of this session that are not in `files`."""
        for name in self._ours - {stored.file for stored in files.values()}:
            if _is_own(name):
                with suppress(OSError):
                    (self.folder / name).unlink(missing_ok=True)
            self._ours.discard(name)


def _is_own(name: str) -> bool:
    match = _RESULT_FILE.fullmatch(name)
    return match is not None and match[1] in {kind.replace("-", "") for kind in STUDIES}


def _kind(key: str) -> str:
    return _RUN if key.startswith(f"{_RUN}-") else key


def _parts(result: object, key: str) -> tuple[str, Any, str, str]:
    if isinstance(result, Run):
        return _RUN, result.result, "", ""
    if not isinstance(result, DisplayedStudy):
        raise TypeError(f"{key}: {type(result)}")
    return key, result.value, result.name, result.source
