"""Pieces of an incomplete sweep on disk: file names, checksums and manifest.

The manifest says what is computed, with which versions, and how many members a piece has. The name
of a piece's file has its number, how many of its members failed, the digest of the manifest, and a
checksum of all this and of the content: ``000000012.3.09ab….5f1c….parquet``.
"""

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from fivtui.model import InputError

from .formats import SweepFormat, sweep_format
from .provenance import study_from_dict
from .study import Study

MANIFEST: Final = "manifest.json"
# Keys of a manifest that the file does not have.
PIECE_MEMBERS: Final = "piece_members"
COLUMNS: Final = "columns"
_DIGITS: Final = 32
_NAME: Final = re.compile(r"(\d{9,})\.(\d+)\.([0-9a-f]{32})\.([0-9a-f]{32})\.\w+")
# A name without the digest of a manifest.
_OLD_NAME: Final = re.compile(r"\d{9,}\.\d+\.[0-9a-f]{32}\.\w+")
_LEFT_OVER: Final = (".fivtui-", "merged.")


@dataclass(frozen=True, slots=True)
class SweepPiece:
    """Piece `number` of a sweep: members `first` to `last` - 1."""

    number: int
    first: int
    last: int


def piece_count(members: int, size: int) -> int:
    """Number of pieces of `size` members; the last may be smaller."""
    return -(-members // size)


def piece_of(number: int, members: int, size: int) -> SweepPiece:
    """Piece `number` of a sweep of `members` members, `size` in a piece."""
    return SweepPiece(number, number * size, min((number + 1) * size, members))


@dataclass(frozen=True, slots=True)
class PieceFile:
    """A file of a piece: what its name says of number, failures, manifest and checksum."""

    path: Path
    number: int
    failed: int
    sweep: str
    checksum: str

    @property
    def sound(self) -> bool:
        """Whether the content has the checksum in the name."""
        found = _checksum(self.number, self.failed, self.sweep, self.path.read_bytes())
        return found == self.checksum


def piece_name(number: int, failed: int, sweep: str, content: bytes, suffix: str) -> str:
    """The name of a piece's file."""
    return f"{number:09}.{failed}.{sweep}.{_checksum(number, failed, sweep, content)}{suffix}"


def _checksum(number: int, failed: int, sweep: str, content: bytes) -> str:
    # The name is part of it: a piece renamed as another one is unsound.
    digest = hashlib.sha256(f"{number}.{failed}.{sweep}\n".encode())
    digest.update(content)
    return digest.hexdigest()[:_DIGITS]


def digest_of(manifest: Mapping[str, Any]) -> str:
    """The digest of a manifest."""
    text = json.dumps(manifest, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]


def piece_files(folder: Path) -> list[PieceFile]:
    """The files of pieces in a folder, in order; their content is not read."""
    named = ((path, _NAME.fullmatch(path.name)) for path in sorted(folder.iterdir()))
    return [
        PieceFile(path, int(match[1]), int(match[2]), match[3], match[4])
        for path, match in named
        if match is not None
    ]


def old_piece_files(folder: Path) -> list[Path]:
    """Pieces whose names lack the digest of a manifest."""
    return [path for path in folder.iterdir() if _OLD_NAME.fullmatch(path.name)]


def is_own(path: Path) -> bool:
    """Whether a file is a piece, or left half-written by a kill."""
    named = _NAME.fullmatch(path.name) or _OLD_NAME.fullmatch(path.name)
    return named is not None or path.name.startswith(_LEFT_OVER)


@dataclass(frozen=True, slots=True)
class StoredPieces:
    """The sound pieces of an incomplete sweep, `members` in all, and its provenance."""

    study: Study
    form: SweepFormat
    paths: tuple[Path, ...]
    members: int
    provenance: dict[str, Any]


def find_pieces(folder: Path) -> StoredPieces:
    """Find the sound pieces in ``FILE.parts`` that belong to its manifest; changes nothing there.

    Raises `InputError` if the folder is not of an incomplete sweep, has no sound piece yet, or its
    pieces do not say which sweep they are of.
    """
    try:
        manifest = json.loads((folder / MANIFEST).read_bytes())
        study, size = study_from_dict(manifest["sweep"]), int(manifest[PIECE_MEMBERS])
        form, count = sweep_format(Path(folder.stem)), piece_count(study.members, size)
        sweep = digest_of(manifest)
        own = [file for file in piece_files(folder) if file.sweep == sweep and file.sound]
        sound = {file.number: file for file in own if file.number < count}
        old = old_piece_files(folder)
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError("not the folder of a sweep under way (FILE.parts)") from None
    if old:
        raise InputError(
            "an older fivtui began this sweep: its pieces do not say which sweep they are of"
        )
    if not sound:
        raise InputError("no member of this sweep is stored yet")
    pieces = [piece_of(number, study.members, size) for number in sound]
    return StoredPieces(
        study,
        form,
        tuple(file.path for file in sound.values()),
        sum(piece.last - piece.first for piece in pieces),
        {key: value for key, value in manifest.items() if key not in (PIECE_MEMBERS, COLUMNS)},
    )
