"""The results of a sweep on disk: pieces that survive whatever stops it, then one file.

Beside the file that is asked for, say ``out.parquet``, stands the folder ``out.parquet.parts`` as
long as the sweep is not complete. Its ``manifest.json`` says what is computed, by which versions,
and how many members a piece has. A piece is a file whose name says its number, how many of its
members failed, and the checksum of its content: ``000000012.3.5f1c….parquet``.
"""

import hashlib
import io
import json
import os
import re
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

from .core.errors import ComputationError, InputError
from .core.study import Study
from .core.sweep import Rows
from .files import check_output, resolved, write_atomically
from .locks import locked
from .sweep_formats import SweepFormat, sweep_format
from .sweep_provenance import (
    provenance_of,
    study_from_dict,
)

_MANIFEST: Final = "manifest.json"
_LOCK: Final = "lock"
_CHECKSUM_DIGITS: Final = 32
_PIECE: Final = re.compile(r"(\d{9,})\.(\d+)\.([0-9a-f]{32})\.\w+")
# Characters of a value in a message.
_BRIEF: Final = 100
# Members of a piece whose horizon is one second, and the limits for other horizons: pieces of
# about a second, or of one member where that takes longer.
_MEMBER_SECONDS: Final = 1_000_000
_PIECE_MEMBERS: Final = (1, 20_000)


@dataclass(frozen=True, slots=True)
class Piece:
    """Piece `number` of a sweep: the members from `first` up to, not including, `last`."""

    number: int
    first: int
    last: int


def piece_count(members: int, size: int) -> int:
    """How many pieces of `size` members there are; the last may have fewer members."""
    return -(-members // size)


def piece_of(number: int, members: int, size: int) -> Piece:
    """Piece `number` of a sweep that has `members` members, `size` in a piece."""
    return Piece(number, number * size, min((number + 1) * size, members))


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
        self.folder = self._target.with_name(f"{self._target.name}.parts")
        self._shown = out.with_name(self.folder.name)
        self._provenance = provenance_of(study, self._form)
        self._asked_size = size
        self.size = size or default_piece_size(study)
        self._pieces: dict[int, Path] = {}
        self.kept = self.failed = 0
        self.complete = self._is_complete()
        if not self.complete:
            check_output(out, force=force)

    def _is_complete(self) -> bool:
        # A file appears under its name when it is whole.
        if self._force or not self._target.is_file():
            return False
        return self._form.provenance(self._target) == self._provenance

    def _open(self) -> None:
        # Finds out what an earlier run has left.
        manifest = self.folder / _MANIFEST
        if manifest.exists() and not self._is_mine(manifest):
            self._clear()
        if not manifest.exists():
            content = {**self._provenance, "piece_members": self.size}
            content["columns"] = [column.name for column in self._study.columns]
            text = json.dumps(content, ensure_ascii=False, indent=1) + "\n"
            write_atomically(manifest, lambda file: _write(file, text.encode()))
        count = piece_count(self._study.members, self.size)
        for path in sorted(self.folder.iterdir()):
            match = _PIECE.fullmatch(path.name)
            number = int(match[1]) if match else -1
            wanted = 0 <= number < count and number not in self._pieces
            if match is not None and wanted and _is_sound(path, match[3]):
                self._count(piece_of(number, self._study.members, self.size), path, int(match[2]))
            elif _is_own(path):
                path.unlink()

    def _is_mine(self, manifest: Path) -> bool:
        # Whether to go on from what is there (True), or to start over.
        try:
            there = json.loads(manifest.read_bytes())
            size = int(there.pop("piece_members"))
            del there["columns"]
        except (ValueError, KeyError, AttributeError, TypeError):
            size, difference = 0, f"its {_MANIFEST} is damaged"
        else:
            asked = self._asked_size or size
            difference = _difference(there, self._provenance) or _difference(
                size, asked, "members of a piece"
            )
        if not difference:
            self.size = size
            return True
        if self._force:
            return False
        raise InputError(
            f"{self._shown}: holds another sweep ({difference}); finish that one, choose another "
            "--out, or force to discard it"
        )

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
            If it cannot be written; everything stored before is kept.
        """
        buffer = io.BytesIO()
        self._form.write_piece(buffer, self._study, rows)
        content = buffer.getvalue()
        name = f"{piece.number:09}.{rows.failed}.{_checksum(content)}{self._target.suffix.lower()}"
        with self._explained():
            write_atomically(self.folder / name, lambda file: _write(file, content), force=True)
        self._count(piece, self.folder / name, rows.failed)

    def finish(self) -> None:
        """Make the file that is asked for from its pieces, and remove these.

        Raises
        ------
        ComputationError
            If it cannot be written; the pieces are kept.
        InputError
            If a file of its name has appeared.
        """
        merged = self.folder / f"merged{self._target.suffix.lower()}"
        paths = [self._pieces[number] for number in sorted(self._pieces)]

        def merge(file: BinaryIO) -> None:
            self._form.merge(file, self._study, paths, self._provenance)

        with self._explained():
            write_atomically(merged, merge, force=True)
        check_output(self._out, force=self._force)
        merged.replace(self._target)
        _sync(self._target.parent)
        self.complete = True
        self._clear()

    def _clear(self) -> None:
        # The manifest last: what is left by a kill in between is still known.
        for path in (*filter(_is_own, self.folder.iterdir()), self.folder / _MANIFEST):
            path.unlink(missing_ok=True)
        self._pieces.clear()
        self.kept = self.failed = 0

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
        If the file cannot be written, another sweep was begun under its name, or another process
        is at work on it.
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
            store._clear()
        else:
            store._open()
        yield store
    if store.complete:
        (folder / _LOCK).unlink(missing_ok=True)
        # What somebody else has put there is left.
        with suppress(OSError):
            folder.rmdir()


@dataclass(frozen=True, slots=True)
class Pieces:
    """What is stored of a sweep that is not complete.

    Attributes
    ----------
    study : Study
        The sweep.
    form : SweepFormat
        Format of the pieces.
    paths : tuple of Path
        The pieces, in order.
    members : int
        How many members they have.
    """

    study: Study
    form: SweepFormat
    paths: tuple[Path, ...]
    members: int


def find_pieces(folder: Path) -> Pieces:
    """Look into the folder of a sweep that is not complete; nothing is changed there.

    Parameters
    ----------
    folder : Path
        ``FILE.parts``.

    Returns
    -------
    Pieces
        Those that are sound.

    Raises
    ------
    InputError
        If it is no such folder, or has no sound piece yet.
    """
    try:
        said = json.loads((folder / _MANIFEST).read_bytes())
        study, size = study_from_dict(said["sweep"]), int(said["piece_members"])
        form = sweep_format(Path(folder.stem))
        found = [(path, _PIECE.fullmatch(path.name)) for path in sorted(folder.iterdir())]
        sound = [(path, m) for path, m in found if m is not None and _is_sound(path, m[3])]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError("not the folder of a sweep under way (FILE.parts)") from None
    if not sound:
        raise InputError("no member of this sweep is stored yet")
    pieces = [piece_of(int(match[1]), study.members, size) for _, match in sound]
    return Pieces(
        study,
        form,
        tuple(path for path, _ in sound),
        sum(piece.last - piece.first for piece in pieces),
    )


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


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:_CHECKSUM_DIGITS]


def _is_own(path: Path) -> bool:
    # Pieces, and what a kill has left half written; nothing that somebody else has put there.
    return _PIECE.fullmatch(path.name) is not None or path.name.startswith((".fivtui-", "merged."))


def _is_sound(path: Path, checksum: str) -> bool:
    return _checksum(path.read_bytes()) == checksum


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
