"""Storage of a sweep: pieces that remain after a stop, merged into one file at the end.

Until ``out.parquet`` is complete, the folder ``out.parquet.parts`` beside it holds the pieces, and
a manifest that identifies their sweep. Rows of two sweeps, or with other last bits, are not mixed.
"""

import io
import json
import os
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, Final

from fivtui.io import (
    check_output,
    hold_lock,
    is_replaceable,
    output_path,
    parts_folder,
    resolve_path,
    save_bytes,
    write_atomically,
)
from fivtui.model import ComputationError, InputError

from .arithmetic import arithmetic_difference
from .formats import SweepFormat, sweep_format
from .pieces import (
    COLUMNS,
    MANIFEST,
    PIECE_MEMBERS,
    SweepPiece,
    is_sweep_file,
    manifest_digest,
    old_piece_files,
    piece_count,
    piece_files,
    piece_name,
    read_manifest,
    sweep_piece,
    valid_pieces,
)
from .provenance import ARITHMETIC, VERSIONS, make_provenance, study_header
from .rows import Rows
from .study import Study

# File in the folder of pieces that one process at a time may lock.
_LOCK: Final = "lock"
# Greatest length of a value in a message.
_MAX_LENGTH: Final = 100
# Simulated time of a piece, s, in batches and in single runs: about a second of work.
_BATCH_SIMULATED_S: Final = 1_000_000
_SINGLE_SIMULATED_S: Final = 100
# Runs that take as long as to find out whether a motion ends in vibration.
_VIBRATION_RUNS: Final = 20
# Bounds of the number of members per piece.
_PIECE_MEMBER_BOUNDS: Final = (1, 20_000)


def default_piece_size(study: Study) -> int:
    """Default number of members per piece: about a second of work."""
    least, greatest = _PIECE_MEMBER_BOUNDS
    simulated_s = _SINGLE_SIMULATED_S if study.is_run_by_run else _BATCH_SIMULATED_S
    runs = (study.design.starts or 1) * _VIBRATION_RUNS if study.has_vibration else 1
    return max(least, min(greatest, int(simulated_s / (study.t_end * runs))))


class SweepStore:
    """The pieces and the file of one sweep; opened by `open_store`.

    `size` is the number of members per piece; `stored_members` and `failed` count the stored and
    the failed members; `complete` is whether the complete file exists.
    """

    def __init__(self, out: Path, study: Study, *, size: int | None) -> None:
        self._format: SweepFormat = sweep_format(out)
        # The path as it was given, and the file that it names.
        self._out, self._target = out, resolve_path(out)
        self._study = study
        self.folder = parts_folder(out)
        # The folder of pieces in messages.
        self._label = out.with_name(self.folder.name)
        self._study_header = study_header(study, self._format)
        self._provenance: dict[str, Any] = {}
        self._requested_size = size
        self.size = size or default_piece_size(study)
        # Digest of the manifest, and the stored pieces by number.
        self._digest = ""
        self._pieces: dict[int, Path] = {}
        self.stored_members = self.failed = 0
        with _wrap_read_errors(out):
            self.complete = self._is_complete()
        if not self.complete:
            check_output(out)
            self._provenance = make_provenance(study, self._format)

    def _is_complete(self) -> bool:
        # Whether the file has all rows of this sweep. A sweep gets its name when it is complete: a
        # file with fewer rows is damaged. `output_path` makes a path replaceable.
        if is_replaceable(self._out) or not self._target.is_file():
            return False
        provenance = self._format.provenance(self._target)
        if provenance is None:
            raise InputError(
                f"{self._out}: exists already, and is not a sweep or is damaged; choose another "
                "name or force overwriting"
            )
        if _without_arithmetic(provenance) != self._study_header:
            # `check_output` refuses to replace the file of another sweep.
            return False
        rows = self._format.count(self._target, self._study)
        if rows != self._study.members:
            raise InputError(
                f"{self._out}: exists already, and is damaged: {rows} of {self._study.members} "
                "rows are complete; force overwriting to compute it again, or choose another name"
            )
        return True

    def _manifest(self) -> dict[str, Any]:
        return {
            **self._provenance,
            PIECE_MEMBERS: self.size,
            COLUMNS: [column.name for column in self._study.columns],
        }

    def _load_pieces(self) -> None:
        # Register the valid pieces of an earlier run, and remove damaged ones.
        manifest = self.folder / MANIFEST
        reason = self._match_stored_pieces()
        if reason:
            if not is_replaceable(self._out):
                raise InputError(f"{self._label}: {reason}, or force overwriting of the pieces")
            self._remove_pieces()
        content = self._manifest()
        self._digest = manifest_digest(content)
        if not manifest.exists():
            text = json.dumps(content, ensure_ascii=False, indent=1) + "\n"
            save_bytes(text.encode(), manifest)
        members, size = self._study.members, self.size
        valid = valid_pieces(self.folder, self._digest, piece_count(members, size))
        for number, file in valid.items():
            self._register(sweep_piece(number, members, size), file.path, file.failed)
        for path in self.folder.iterdir():
            if is_sweep_file(path) and path not in self._pieces.values():
                path.unlink()

    def _match_stored_pieces(self) -> str:
        # Take over the size of the stored pieces. Return why their sweep cannot be continued, with
        # alternatives to which the caller adds the final one; empty if it can.
        manifest, files = self.folder / MANIFEST, piece_files(self.folder)
        if not manifest.exists():
            if files or old_piece_files(self.folder):
                return (
                    f"has pieces but no {MANIFEST} that describes their sweep; delete the folder, "
                    "choose another --out"
                )
            return ""
        try:
            _, size, provenance = read_manifest(self.folder)
            difference = _first_difference(
                _without_arithmetic(provenance), self._study_header
            ) or _first_difference(size, self._requested_size or size, "members of a piece")
        except InputError as error:
            difference = str(error)
        if difference:
            return _other_sweep_text(difference)
        difference = arithmetic_difference(provenance.get(ARITHMETIC), self._provenance[ARITHMETIC])
        if difference:
            return (
                f"rows computed here would differ in their last bits from the stored rows "
                f"({difference}); continue where the sweep was begun, choose another --out"
            )
        self.size = size
        digest = manifest_digest(self._manifest())
        if old_piece_files(self.folder) or any(file.digest != digest for file in files):
            return (
                f"has pieces that do not belong to its {MANIFEST}; delete the folder, choose "
                "another --out"
            )
        return ""

    def _register(self, piece: SweepPiece, path: Path, failed: int) -> None:
        self._pieces[piece.number] = path
        self.stored_members += piece.stop - piece.first
        self.failed += failed

    def missing(self) -> Iterator[SweepPiece]:
        """The pieces that are not stored yet, in order."""
        members = self._study.members
        for number in range(piece_count(members, self.size)):
            if number not in self._pieces:
                yield sweep_piece(number, members, self.size)

    def write(self, piece: SweepPiece, rows: Rows) -> None:
        """Store a piece atomically; `ComputationError` if that fails."""
        members = piece.stop - piece.first
        if rows.members != members:
            raise ComputationError(
                f"{rows.members} rows were computed for {members} members", self.advice
            )
        buffer = io.BytesIO()
        self._format.write_piece(buffer, self._study, rows)
        content = buffer.getvalue()
        suffix = self._target.suffix.lower()
        name = piece_name(piece.number, rows.failed, self._digest, content, suffix)
        path = self.folder / name
        try:
            with self._with_advice():
                save_bytes(content, output_path(path, force=True))
        finally:
            # Register the piece also if Ctrl+C came after it was stored.
            if path.exists():
                self._register(piece, path, rows.failed)

    def finish(self) -> None:
        """Merge the pieces into the file and remove them.

        Raises `ComputationError` if the file cannot be written or lacks rows (the pieces remain),
        and `InputError` if another program has written the file in the meantime.
        """
        merged = self.folder / f"merged{self._target.suffix.lower()}"
        paths = [self._pieces[number] for number in sorted(self._pieces)]

        def merge(file: BinaryIO) -> None:
            self._format.merge(file, self._study, paths, self._provenance)

        with self._with_advice():
            write_atomically(output_path(merged, force=True), merge)
        rows = self._format.count(merged, self._study)
        if rows != self._study.members:
            raise ComputationError(
                f"{merged}: {rows} of {self._study.members} rows were merged", self.advice
            )
        check_output(self._out)
        merged.replace(self._target)
        _sync_folder(self._target.parent)
        self.complete = True
        self._remove_pieces()

    def _remove_pieces(self) -> None:
        # Delete the manifest last: after a kill it identifies the remaining pieces.
        for path in (*filter(is_sweep_file, self.folder.iterdir()), self.folder / MANIFEST):
            path.unlink(missing_ok=True)
        self._pieces.clear()
        self.stored_members = self.failed = 0

    def remove_leftovers(self) -> None:
        """Remove pieces that remain after a kill although the file is complete."""
        with suppress(OSError, InputError):
            if _without_arithmetic(read_manifest(self.folder).provenance) == self._study_header:
                self._remove_pieces()

    @contextmanager
    def _with_advice(self) -> Iterator[None]:
        # Turn an error of writing into one that says how to continue.
        try:
            yield
        except InputError as error:
            raise ComputationError(str(error), self.advice) from None

    @property
    def advice(self) -> str:
        """How to continue after a stop."""
        return (
            f"{self.stored_members} of {self._study.members} members are kept in {self._label}: "
            "the same command continues"
        )


@contextmanager
def open_store(out: Path, study: Study, *, size: int | None = None) -> Iterator[SweepStore]:
    """Open the storage of a sweep, to begin or to continue it; damaged pieces are removed.

    By default, `size` is that of the stored pieces, or `default_piece_size`. If the path is
    replaceable, an existing file is replaced and pieces of another sweep are removed.
    """
    store = SweepStore(out, study, size=size)
    folder = store.folder
    if store.complete and not folder.exists():
        yield store
        return
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror or error}") from None
    with hold_lock(folder / _LOCK, "another fivtui sweep"):
        if store.complete:
            store.remove_leftovers()
        else:
            with _wrap_read_errors(store.folder):
                store._load_pieces()
        yield store
    if store.complete:
        (folder / _LOCK).unlink(missing_ok=True)
        # Keep the folder if it holds files of other programs.
        with suppress(OSError):
            folder.rmdir()


@contextmanager
def _wrap_read_errors(path: Path) -> Iterator[None]:
    # Turn operating system errors into an `InputError`.
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def _sync_folder(folder: Path) -> None:
    # The new name must survive a power loss before the pieces are removed.
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _without_arithmetic(provenance: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in provenance.items() if key != ARITHMETIC}


def _first_difference(stored: Any, expected: Any, name: str = "") -> str:
    # Describe the first difference of two values called `name`; empty if they are equal.
    if isinstance(stored, dict) and isinstance(expected, dict):
        for key in {**expected, **stored}:
            key_name = f"{name}.{key}".lstrip(".")
            difference = _first_difference(stored.get(key), expected.get(key), key_name)
            if difference:
                return difference
        return ""
    if stored == expected:
        return ""
    return f"{name}: {_shorten(stored)} there, {_shorten(expected)} here"


def _other_sweep_text(difference: str) -> str:
    # Why pieces of another sweep cannot be continued, as in `_match_stored_pieces`.
    if difference.startswith(VERSIONS):
        return (
            f"was begun with other versions, which may give other last bits ({difference}); "
            "continue with those versions, choose another --out"
        )
    return f"holds another sweep ({difference}); finish that sweep, choose another --out"


def _shorten(value: Any) -> str:
    if value is None:
        return "none"
    return textwrap.shorten(json.dumps(value, ensure_ascii=False), _MAX_LENGTH, placeholder=" …")
