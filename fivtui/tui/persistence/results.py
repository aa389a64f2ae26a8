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

from .state_file import put_aside

# Maximum size of a stored result, bytes: reads quickly.
_MOST: Final = 20_000_000
_RUN: Final = "run"
_OWN: Final = re.compile(r"([a-z]+)-[0-9a-f]{16}\.\w+")


class _NotKept(InputError):
    # A result that is not stored on purpose.
    pass


class ResultStore:
    """A folder with the result files of a session, each written once.

    Files that the session no longer uses are removed; other files are never touched.
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
        self._ours |= {kept.file for kept in results.values() if isinstance(kept, StoredResult)}

    def put(self, results: Mapping[str, object]) -> tuple[dict[str, StoredResult], dict[str, str]]:
        """Write new results, by key; stored ones (`StoredResult`) pass through.

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
            known, file = self._files.get(key, (None, None))
            if known is not token or file is None or not (self.folder / file.file).exists():
                try:
                    written = self._write(key, result)
                except (_NotKept, ComputationError) as error:
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
            raise _NotKept(why)
        size = form.size(value)
        if size > _MOST:
            raise _NotKept(f"it takes {size / 1e6:.0f} MB; the limit is {_MOST / 1e6:.0f} MB")
        file = f"{kind.replace('-', '')}-{secrets.token_hex(8)}{form.suffix}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be made: {error.strerror}") from None
        store_study(kind, value, self.folder / file)
        return StoredResult(file, name, source)

    def get(self, key: str, kept: StoredResult, *, aside: bool = True) -> Any:
        """Read the result `key`; raises `InputError` if it cannot be read.

        A damaged file is renamed if `aside`, and no longer belongs to the session.
        """
        kind = _kind(key)
        path = self.folder / kept.file
        try:
            if not _is_own(kept.file):
                raise InputError("not the name of a file of this session")
            value = restore_study(kind, path)
        except InputError as error:
            why = str(error).removeprefix(f"{path}: ")
            self._ours.discard(kept.file)
            own = _is_own(kept.file)
            where = f"; {put_aside(path)}" if aside and own and path.exists() else ""
            raise InputError(
                f"the {key.replace('-', ' ') if kind == _RUN else key} of the last session could "
                f"not be restored ({why}){where}"
            ) from None
        found = value if kind == _RUN else DisplayedStudy(value, kept.name, kept.source)
        self._files[key] = (found, kept)
        self._ours.add(kept.file)
        return found

    def remove_others(self, files: Mapping[str, StoredResult]) -> None:
        """Remove files of this session that are not in `files`."""
        for name in self._ours - {kept.file for kept in files.values()}:
            if _is_own(name):
                with suppress(OSError):
                    (self.folder / name).unlink(missing_ok=True)
            self._ours.discard(name)


def _is_own(name: str) -> bool:
    found = _OWN.fullmatch(name)
    return found is not None and found[1] in {kind.replace("-", "") for kind in STUDIES}


def _kind(key: str) -> str:
    return _RUN if key.startswith(f"{_RUN}-") else key


def _parts(result: object, key: str) -> tuple[str, Any, str, str]:
    if isinstance(result, Run):
        return _RUN, result.result, "", ""
    if not isinstance(result, DisplayedStudy):
        raise TypeError(f"{key}: {type(result)}")
    return key, result.value, result.name, result.source
