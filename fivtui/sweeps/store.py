"""Storage of a sweep: pieces that survive a stop, merged into one file at the end.

Until ``out.parquet`` is complete, the folder ``out.parquet.parts`` beside it holds the pieces.
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
    digest_of,
    is_own,
    old_piece_files,
    piece_count,
    piece_files,
    piece_name,
    piece_of,
    read_manifest,
    sound_pieces,
)
from .provenance import ARITHMETIC, VERSIONS, provenance_of, study_header
from .rows import Rows
from .study import Study

_LOCK: Final = "lock"
# Greatest length of a value in a message.
_BRIEF: Final = 100
# Members of a piece for runs of 1 s, about a second of work, and the bounds for other durations.
_MEMBER_SECONDS: Final = 1_000_000
_MEMBER_SECONDS_IN_TURN: Final = 100
_PIECE_MEMBERS: Final = (1, 20_000)


def default_piece_size(study: Study) -> int:
    """Members of a piece by default: about a second of work; depends on method and horizon."""
    least, greatest = _PIECE_MEMBERS
    seconds = _MEMBER_SECONDS_IN_TURN if study.is_run_by_run else _MEMBER_SECONDS
    return max(least, min(greatest, int(seconds / study.t_end)))


class SweepStore:
    """The pieces and the file of one sweep; opened by `open_store`.

    `size` is the number of members of a piece, `stored_members` of those stored, `failed` of those
    that failed; `complete` says whether the file exists.
    """

    def __init__(self, out: Path, study: Study, *, size: int | None) -> None:
        self._form: SweepFormat = sweep_format(out)
        self._out, self._study = out, study
        self._target = resolve_path(out)
        self.folder = parts_folder(out)
        self._shown = out.with_name(self.folder.name)
        self._study_header = study_header(study, self._form)
        self._provenance: dict[str, Any] = {}
        self._requested_size = size
        self.size = size or default_piece_size(study)
        self._sweep = ""
        self._pieces: dict[int, Path] = {}
        self.stored_members = self.failed = 0
        with _readable(out):
            self.complete = self._is_complete()
        if not self.complete:
            check_output(out)
            self._provenance = provenance_of(study, self._form)

    def _is_complete(self) -> bool:
        # The file was renamed when complete, but may have been damaged since.
        if is_replaceable(self._out) or not self._target.is_file():
            return False
        provenance = self._form.provenance(self._target)
        if provenance is None:
            raise InputError(
                f"{self._out}: exists already, and is not a sweep or is damaged; choose another "
                "name or force overwriting"
            )
        if _without_arithmetic(provenance) != self._study_header:
            return False
        rows = self._form.count(self._target, self._study)
        if rows != self._study.members:
            raise InputError(
                f"{self._out}: exists already, and is damaged: {rows} of {self._study.members} "
                "rows are whole; force overwriting to compute it again, or choose another name"
            )
        return True

    def _manifest(self) -> dict[str, Any]:
        return {
            **self._provenance,
            PIECE_MEMBERS: self.size,
            COLUMNS: [column.name for column in self._study.columns],
        }

    def _open(self) -> None:
        # Count the sound pieces of an earlier run, and remove what is damaged.
        manifest = self.folder / MANIFEST
        reason = self._reason_against()
        if reason:
            if not is_replaceable(self._out):
                raise InputError(f"{self._shown}: {reason}, or force to discard what is there")
            self._clear()
        content = self._manifest()
        self._sweep = digest_of(content)
        if not manifest.exists():
            text = json.dumps(content, ensure_ascii=False, indent=1) + "\n"
            save_bytes(text.encode(), manifest)
        members, size = self._study.members, self.size
        sound = sound_pieces(self.folder, self._sweep, piece_count(members, size))
        for number, file in sound.items():
            self._count(piece_of(number, members, size), file.path, file.failed)
        for path in self.folder.iterdir():
            if is_own(path) and path not in self._pieces.values():
                path.unlink()

    def _reason_against(self) -> str:
        # Why the stored pieces cannot be continued, with advice; empty if they can.
        manifest, files = self.folder / MANIFEST, piece_files(self.folder)
        if not manifest.exists():
            if files or old_piece_files(self.folder):
                return (
                    f"has pieces but no {MANIFEST} that says of which sweep they are; delete that "
                    "folder, choose another --out"
                )
            return ""
        try:
            _, size, provenance = read_manifest(self.folder)
            difference = _difference(
                _without_arithmetic(provenance), self._study_header
            ) or _difference(size, self._requested_size or size, "members of a piece")
        except InputError as error:
            difference = str(error)
        if difference:
            return _not_continued(difference)
        difference = arithmetic_difference(provenance.get(ARITHMETIC), self._provenance[ARITHMETIC])
        if difference:
            return (
                f"rows computed here would differ in the last bits from those there ({difference});"
                " finish it where it was begun, choose another --out"
            )
        self.size = size
        digest = digest_of(self._manifest())
        if old_piece_files(self.folder) or any(file.sweep != digest for file in files):
            return (
                f"has pieces of another sweep than its {MANIFEST} says; delete that folder, choose "
                "another --out"
            )
        return ""

    def _count(self, piece: SweepPiece, path: Path, failed: int) -> None:
        self._pieces[piece.number] = path
        self.stored_members += piece.stop - piece.first
        self.failed += failed

    def missing(self) -> Iterator[SweepPiece]:
        """The pieces that are not stored yet, in order."""
        members = self._study.members
        for number in range(piece_count(members, self.size)):
            if number not in self._pieces:
                yield piece_of(number, members, self.size)

    def write(self, piece: SweepPiece, rows: Rows) -> None:
        """Store a piece, whole or not at all; `ComputationError` if that fails."""
        members = piece.stop - piece.first
        if len(rows.reasons) != members:
            raise ComputationError(
                f"{len(rows.reasons)} rows were computed for {members} members", self.advice
            )
        buffer = io.BytesIO()
        self._form.write_piece(buffer, self._study, rows)
        content = buffer.getvalue()
        suffix = self._target.suffix.lower()
        name = piece_name(piece.number, rows.failed, self._sweep, content, suffix)
        path = self.folder / name
        try:
            with self._explained():
                save_bytes(content, output_path(path, force=True))
        finally:
            # Count the piece if Ctrl+C came after it was stored.
            if path.exists():
                self._count(piece, path, rows.failed)

    def finish(self) -> None:
        """Merge the pieces into the file and remove them.

        Raises `ComputationError` if the file cannot be written or lacks rows (the pieces are kept),
        and `InputError` if a file of its name has appeared.
        """
        merged = self.folder / f"merged{self._target.suffix.lower()}"
        paths = [self._pieces[number] for number in sorted(self._pieces)]

        def merge(file: BinaryIO) -> None:
            self._form.merge(file, self._study, paths, self._provenance)

        with self._explained():
            write_atomically(output_path(merged, force=True), merge)
        rows = self._form.count(merged, self._study)
        if rows != self._study.members:
            raise ComputationError(
                f"{merged}: {rows} of {self._study.members} rows were merged", self.advice
            )
        check_output(self._out)
        merged.replace(self._target)
        _sync(self._target.parent)
        self.complete = True
        self._clear()

    def _clear(self) -> None:
        # Delete the manifest last: it identifies the pieces that remain after a kill.
        for path in (*filter(is_own, self.folder.iterdir()), self.folder / MANIFEST):
            path.unlink(missing_ok=True)
        self._pieces.clear()
        self.stored_members = self.failed = 0

    def clear_own(self) -> None:
        """Remove pieces that remain after a kill although the file is complete."""
        with suppress(OSError, InputError):
            if _without_arithmetic(read_manifest(self.folder).provenance) == self._study_header:
                self._clear()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except InputError as error:
            raise ComputationError(str(error), self.advice) from None

    @property
    def advice(self) -> str:
        """How to continue after a stop."""
        return (
            f"{self.stored_members} of {self._study.members} members are kept in {self._shown}: "
            "the same command continues"
        )


@contextmanager
def open_store(out: Path, study: Study, *, size: int | None = None) -> Iterator[SweepStore]:
    """Open the storage of a sweep, to begin or to continue it; damaged pieces are removed.

    `size` is by default that of the stored pieces, or `default_piece_size`. A replaceable path has
    an existing file replaced and pieces of another sweep discarded.
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
            store.clear_own()
        else:
            with _readable(store.folder):
                store._open()
        yield store
    if store.complete:
        (folder / _LOCK).unlink(missing_ok=True)
        # Keep the folder if it holds files of other programs.
        with suppress(OSError):
            folder.rmdir()


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def _sync(folder: Path) -> None:
    # The new name must survive a power loss before the pieces are removed.
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _without_arithmetic(provenance: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in provenance.items() if key != ARITHMETIC}


def _difference(stored: Any, expected: Any, name: str = "") -> str:
    # The first difference of two manifests as text; empty if there is none.
    if isinstance(stored, dict) and isinstance(expected, dict):
        for key in {**expected, **stored}:
            inner = _difference(stored.get(key), expected.get(key), f"{name}.{key}".lstrip("."))
            if inner:
                return inner
        return ""
    if stored == expected:
        return ""
    return f"{name}: {_brief(stored)} there, {_brief(expected)} here"


def _not_continued(difference: str) -> str:
    if difference.startswith(VERSIONS):
        return (
            f"was begun by other versions, whose last bits may differ ({difference}); finish it "
            "with those, choose another --out"
        )
    return f"holds another sweep ({difference}); finish that one, choose another --out"


def _brief(value: Any) -> str:
    if value is None:
        return "none"
    return textwrap.shorten(json.dumps(value, ensure_ascii=False), _BRIEF, placeholder=" …")
