"""The results of the session in files beside it. Imports no Textual."""

import re
import secrets
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from fivtui.core.errors import ComputationError, InputError

from .imports import MAP, SWEEP, TRADEOFF
from .runs import Run
from .shown import Shown
from .state_file import KeptFile, put_aside

# Bytes of a result that is kept; about what takes a moment to read.
_MOST: Final = 20_000_000
_NUMBER_BYTES: Final = 8
_TEXT_BYTES: Final = 20
_RUN: Final = "run"
_OWN: Final = re.compile(r"(run|sweep|map|tradeoff)-[0-9a-f]{16}\.\w+")


@dataclass(frozen=True, slots=True)
class _Form:
    # How a kind of result is written and read, and about how many bytes it takes.
    suffix: str
    size: Callable[[Any], int]
    save: Callable[[Any, Path], None]
    load: Callable[[Path], Any]


class ResultStore:
    """A folder of results, each written once and removed when nothing refers to it any more.

    Parameters
    ----------
    folder : Path
        Made when it is needed.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        # What is in which file, by what it is of.
        self._files: dict[str, tuple[object, KeptFile]] = {}

    def put(self, results: Mapping[str, object]) -> tuple[dict[str, KeptFile], dict[str, str]]:
        """Write the results that are not written yet.

        Parameters
        ----------
        results : mapping of str to Shown, Run or KeptFile
            Results by what they are of; those of an earlier session that are not read yet are
            files already.

        Returns
        -------
        files : dict of str to KeptFile
            Where they are.
        notes : dict of str to str
            Why others are not kept.
        """
        files: dict[str, KeptFile] = {}
        notes: dict[str, str] = {}
        for key, result in results.items():
            if isinstance(result, KeptFile):
                files[key] = result
                continue
            token = result.result if isinstance(result, Run) else result
            known, file = self._files.get(key, (None, None))
            if known is not token or file is None or not (self._folder / file.file).exists():
                try:
                    file = self._write(key, result)
                except (InputError, ComputationError) as error:
                    notes[key] = str(error)
                    continue
                self._files[key] = (token, file)
            files[key] = file
        return files, notes

    def _write(self, key: str, result: object) -> KeptFile:
        kind, value, name, source = _parts(result, key)
        form = _FORMS[kind]
        size = form.size(value)
        if size > _MOST:
            raise InputError(f"it takes {size / 1e6:.0f} MB; kept are {_MOST / 1e6:.0f} MB each")
        file = f"{kind.replace('-', '')}-{secrets.token_hex(8)}{form.suffix}"
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self._folder}: cannot be made: {error.strerror}") from None
        form.save(value, self._folder / file)
        return KeptFile(file, name, source)

    def get(self, key: str, kept: KeptFile) -> Any:
        """Read a result.

        Parameters
        ----------
        key : str
            What it is of, as in `put`.
        kept : KeptFile
            Where it is.

        Returns
        -------
        Shown or Transient
            The result.

        Raises
        ------
        InputError
            If it cannot be read; it is then kept aside under another name.
        """
        kind = _kind(key)
        path = self._folder / kept.file
        try:
            if _OWN.fullmatch(kept.file) is None:
                raise InputError("not the name of a file of this session")
            value = _FORMS[kind].load(path)
        except InputError as error:
            why = str(error).removeprefix(f"{path}: ")
            where = f"; {put_aside(path)}" if path.exists() else ""
            raise InputError(
                f"the {key.replace('-', ' ') if kind == _RUN else key} of the last session could "
                f"not be restored ({why}){where}"
            ) from None
        found = value if kind == _RUN else Shown(value, kept.name, kept.source)
        self._files[key] = (found, kept)
        return found

    def remove_others(self, files: Mapping[str, KeptFile]) -> None:
        """Remove the results to which nothing refers any more.

        Parameters
        ----------
        files : mapping of str to KeptFile
            Those that stay.
        """
        wanted = {kept.file for kept in files.values()}
        with suppress(OSError):
            for path in self._folder.iterdir():
                if _OWN.fullmatch(path.name) and path.name not in wanted:
                    path.unlink(missing_ok=True)


def _kind(key: str) -> str:
    return _RUN if key.startswith(f"{_RUN}-") else key


def _parts(result: object, key: str) -> tuple[str, Any, str, str]:
    if isinstance(result, Run):
        return _RUN, result.result, "", ""
    if not isinstance(result, Shown):
        raise TypeError(f"{key}: {type(result)}")
    return key, result.value, result.name, result.source


def _run_size(value: Any) -> int:
    return 0 if value.trajectory is None else 7 * _NUMBER_BYTES * int(value.trajectory.t.size)


def _save_run(value: Any, path: Path) -> None:
    from .kept_runs import save_kept_run

    save_kept_run(value, path)


def _load_run(path: Path) -> Any:
    from .kept_runs import load_kept_run

    return load_kept_run(path)


def _save_sweep(value: Any, path: Path) -> None:
    from fivtui.sweep_files import save_sweep

    if len(value.table.reasons) < value.study.members:
        raise InputError("it is not complete")
    save_sweep(value, path)


def _load_sweep(path: Path) -> Any:
    from fivtui.sweep_files import read_sweep

    return read_sweep(path)


def _save_map(value: Any, path: Path) -> None:
    from fivtui.map_results import save_map

    save_map(value, path)


def _load_map(path: Path) -> Any:
    from fivtui.map_results import load_map

    return load_map(path)


def _save_tradeoff(value: Any, path: Path) -> None:
    from fivtui.files import save_json
    from fivtui.tradeoff_results import tradeoff_to_dict

    save_json(tradeoff_to_dict(value), path)


def _load_tradeoff(path: Path) -> Any:
    from fivtui.tradeoff_results import load_tradeoff

    return load_tradeoff(path)


_FORMS: Final[Mapping[str, _Form]] = {
    _RUN: _Form(".npz", _run_size, _save_run, _load_run),
    SWEEP: _Form(
        ".csv",
        lambda value: _TEXT_BYTES * len(value.table.reasons) * len(value.columns),
        _save_sweep,
        _load_sweep,
    ),
    MAP: _Form(
        ".npz", lambda value: 3 * _NUMBER_BYTES * int(value.values.size), _save_map, _load_map
    ),
    TRADEOFF: _Form(".json", lambda _: 0, _save_tradeoff, _load_tradeoff),
}
