"""The results of a sweep on disk: pieces that survive whatever stops it, then one file.

Beside the file that is asked for, say ``out.parquet``, stands the folder ``out.parquet.parts`` as
long as the sweep is not complete, see `sweep_pieces`.
"""

import io
import json
import os
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, Final

from fivtui.io import check_output, locked, parts_folder, resolved, write_atomically
from fivtui.model import ComputationError, InputError

from .arithmetic import arithmetic_difference
from .formats import SweepFormat, sweep_format
from .pieces import (
    COLUMNS,
    MANIFEST,
    PIECE_MEMBERS,
    Piece,
    digest_of,
    is_own,
    old_piece_files,
    piece_count,
    piece_files,
    piece_name,
    piece_of,
)
from .provenance import ARITHMETIC, described, provenance_of
from .rows import Rows
from .study import Study

_LOCK: Final = "lock"
# Characters of a value in a message.
_BRIEF: Final = 100
# Members of a piece whose horizon is one second, and the limits for other horizons: pieces of
# about a second, or of one member where that takes longer.
_MEMBER_SECONDS: Final = 1_000_000
_PIECE_MEMBERS: Final = (1, 20_000)


def default_piece_size(study: Study) -> int:
    """How many members a piece has if nothing is said: about a second's work, or one member.

    Parameters
    ----------
    study : Study
        The sweep.

    Returns
    -------
    int
        The number; it depends on the horizon alone, never on the machine.
    """
    least, most = _PIECE_MEMBERS
    return max(least, min(most, int(_MEMBER_SECONDS / study.t_end)))


class SweepStore:
    """The results of one sweep on disk; made by `open_store`.

    Attributes
    ----------
    size : int
        Members of a piece.
    kept : int
        Members whose rows are stored.
    failed : int
        How many of them failed.
    complete : bool
        Whether the file asked for is there, and is of this sweep.
    """

    def __init__(self, out: Path, study: Study, *, size: int | None, force: bool) -> None:
        self._form: SweepFormat = sweep_format(out)
        self._out, self._study, self._force = out, study, force
        self._target = resolved(out)
        self.folder = parts_folder(out)
        self._shown = out.with_name(self.folder.name)
        self._described = described(study, self._form)
        self._provenance: dict[str, Any] = {}
        self._asked_size = size
        self.size = size or default_piece_size(study)
        self._sweep = ""
        self._pieces: dict[int, Path] = {}
        self.kept = self.failed = 0
        with _readable(out):
            self.complete = self._is_complete()
        if not self.complete:
            check_output(out, force=force)
            self._provenance = provenance_of(study, self._form)

    def _is_complete(self) -> bool:
        # A file appears under its name when it is whole; what became of it since is looked at.
        if self._force or not self._target.is_file():
            return False
        said = self._form.provenance(self._target)
        if said is None:
            raise InputError(
                f"{self._out}: exists already, and is no sweep or damaged; choose another name or "
                "force overwriting"
            )
        if _without_arithmetic(said) != self._described:
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
        # Finds out what an earlier run has left.
        manifest = self.folder / MANIFEST
        reason = self._reason_against()
        if reason:
            if not self._force:
                raise InputError(f"{self._shown}: {reason}, or force to discard what is there")
            self._clear()
        content = self._manifest()
        self._sweep = digest_of(content)
        if not manifest.exists():
            text = json.dumps(content, ensure_ascii=False, indent=1) + "\n"
            write_atomically(manifest, lambda file: _write(file, text.encode()))
        count = piece_count(self._study.members, self.size)
        for file in piece_files(self.folder):
            wanted = file.number < count and file.number not in self._pieces
            if wanted and file.sound:
                piece = piece_of(file.number, self._study.members, self.size)
                self._count(piece, file.path, file.failed)
        for path in self.folder.iterdir():
            if is_own(path) and path not in self._pieces.values():
                path.unlink()

    def _reason_against(self) -> str:
        # Why not to go on from what is there, and what to do; empty if nothing is against it.
        manifest, own = self.folder / MANIFEST, piece_files(self.folder)
        if not manifest.exists():
            if own or old_piece_files(self.folder):
                return (
                    f"has pieces but no {MANIFEST} that says of which sweep they are; delete that "
                    "folder, choose another --out"
                )
            return ""
        try:
            there = json.loads(manifest.read_bytes())
            size = int(there[PIECE_MEMBERS])
            of_sweep = _without_arithmetic(_of_file(there))
            arithmetic = there.get(ARITHMETIC)
        except (ValueError, KeyError, AttributeError, TypeError):
            difference = f"its {MANIFEST} is damaged"
        else:
            difference = _difference(of_sweep, self._described) or _difference(
                size, self._asked_size or size, "members of a piece"
            )
        if difference:
            return f"holds another sweep ({difference}); finish that one, choose another --out"
        here = self._provenance[ARITHMETIC]
        difference = arithmetic_difference(arithmetic, here)
        if difference:
            return (
                f"rows computed here would differ in the last bits from those there ({difference});"
                " finish it where it was begun, choose another --out"
            )
        self.size = size
        asked = digest_of(self._manifest())
        if old_piece_files(self.folder) or any(file.sweep != asked for file in own):
            return (
                f"has pieces of another sweep than its {MANIFEST} says; delete that folder, choose "
                "another --out"
            )
        return ""

    def _count(self, piece: Piece, path: Path, failed: int) -> None:
        self._pieces[piece.number] = path
        self.kept += piece.last - piece.first
        self.failed += failed

    def missing(self) -> Iterator[Piece]:
        """The pieces that are not stored yet.

        Yields
        ------
        Piece
            In order.
        """
        members = self._study.members
        for number in range(piece_count(members, self.size)):
            if number not in self._pieces:
                yield piece_of(number, members, self.size)

    def write(self, piece: Piece, rows: Rows) -> None:
        """Store a piece, whole or not at all.

        Parameters
        ----------
        piece : Piece
            Which one.
        rows : Rows
            Its rows.

        Raises
        ------
        ComputationError
            If it cannot be written, or has not a row a member; everything stored before is kept.
        """
        members = piece.last - piece.first
        if len(rows.reasons) != members:
            raise ComputationError(
                f"{len(rows.reasons)} rows were computed for {members} members", self.advice
            )
        buffer = io.BytesIO()
        self._form.write_piece(buffer, self._study, rows)
        content = buffer.getvalue()
        suffix = self._target.suffix.lower()
        name = piece_name(piece.number, rows.failed, self._sweep, content, suffix)
        with self._explained():
            write_atomically(self.folder / name, lambda file: _write(file, content), force=True)
        self._count(piece, self.folder / name, rows.failed)

    def finish(self) -> None:
        """Make the file that is asked for from its pieces, and remove these.

        Raises
        ------
        ComputationError
            If it cannot be written, or does not have all rows; the pieces are kept.
        InputError
            If a file of its name has appeared.
        """
        merged = self.folder / f"merged{self._target.suffix.lower()}"
        paths = [self._pieces[number] for number in sorted(self._pieces)]

        def merge(file: BinaryIO) -> None:
            self._form.merge(file, self._study, paths, self._provenance)

        with self._explained():
            write_atomically(merged, merge, force=True)
        rows = self._form.count(merged, self._study)
        if rows != self._study.members:
            raise ComputationError(
                f"{merged}: {rows} of {self._study.members} rows came together", self.advice
            )
        check_output(self._out, force=self._force)
        merged.replace(self._target)
        _sync(self._target.parent)
        self.complete = True
        self._clear()

    def _clear(self) -> None:
        # The manifest last: what is left by a kill in between is still known.
        for path in (*filter(is_own, self.folder.iterdir()), self.folder / MANIFEST):
            path.unlink(missing_ok=True)
        self._pieces.clear()
        self.kept = self.failed = 0

    def clear_own(self) -> None:
        """Remove what a kill has left of this sweep after its file was complete."""
        try:
            there = json.loads((self.folder / MANIFEST).read_bytes())
            own = _without_arithmetic(_of_file(there)) == self._described
        except (OSError, ValueError, KeyError, AttributeError, TypeError):
            own = False
        if own:
            self._clear()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except InputError as error:
            raise ComputationError(str(error), self.advice) from None

    @property
    def advice(self) -> str:
        """How to go on after a stop."""
        return (
            f"{self.kept} of {self._study.members} members are kept in {self._shown}: "
            "the same command continues"
        )


@contextmanager
def open_store(
    out: Path, study: Study, *, size: int | None = None, force: bool = False
) -> Iterator[SweepStore]:
    """Open the results of a sweep, to begin it or to go on.

    Parameters
    ----------
    out : Path
        The file that is asked for; its suffix ``.csv`` or ``.parquet`` says the format.
    study : Study
        The sweep.
    size : int, optional
        Members of a piece; by default `default_piece_size`, or what the sweep was begun with.
    force : bool
        Whether a file that exists may be replaced, and what is left of another sweep discarded.

    Yields
    ------
    SweepStore
        What is damaged of it has been removed, to be computed again.

    Raises
    ------
    InputError
        If the file cannot be written or is damaged, another sweep was begun under its name, this
        one where arithmetic differs, or another process is at work on it.
    ComputationError
        If the compiled kernel cannot be loaded.
    """
    store = SweepStore(out, study, size=size, force=force)
    folder = store.folder
    if store.complete and not folder.exists():
        yield store
        return
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror or error}") from None
    with locked(folder / _LOCK, "another fivtui sweep"):
        if store.complete:
            store.clear_own()
        else:
            with _readable(store.folder):
                store._open()
        yield store
    if store.complete:
        (folder / _LOCK).unlink(missing_ok=True)
        # What somebody else has put there is left.
        with suppress(OSError):
            folder.rmdir()


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def _write(file: BinaryIO, content: bytes) -> None:
    file.write(content)


def _sync(folder: Path) -> None:
    # The new name must outlive a loss of power before what it replaces is removed.
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _of_file(manifest: dict[str, Any]) -> dict[str, Any]:
    # What of a manifest the file says as well.
    return {key: manifest[key] for key in manifest if key not in (PIECE_MEMBERS, COLUMNS)}


def _without_arithmetic(said: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in said.items() if key != ARITHMETIC}


def _difference(there: Any, here: Any, name: str = "") -> str:
    # The first place at which two manifests differ, in words; empty if they do not.
    if isinstance(there, dict) and isinstance(here, dict):
        for key in {**here, **there}:
            inner = _difference(there.get(key), here.get(key), f"{name}.{key}".lstrip("."))
            if inner:
                return inner
        return ""
    if there == here:
        return ""
    return f"{name}: {_brief(there)} there, {_brief(here)} here"


def _brief(value: Any) -> str:
    return textwrap.shorten(json.dumps(value, ensure_ascii=False), _BRIEF, placeholder=" …")
