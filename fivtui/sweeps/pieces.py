"""Pieces of an incomplete sweep on disk: file names, checksums and manifest.

The manifest has the study, the versions, and the number of members of a piece. The name of a
piece's file has its number, its count of failed members, the digest of the manifest, and a checksum
of these and the content: ``000000012.3.09ab….5f1c….parquet``.
"""

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

from fivtui.model import InputError

MANIFEST: Final = "manifest.json"
# Keys of a manifest that the complete file does not have.
PIECE_MEMBERS: Final = "piece_members"
COLUMNS: Final = "columns"
_DIGITS: Final = 32
_NAME: Final = re.compile(r"(\d{9,})\.(\d+)\.([0-9a-f]{32})\.([0-9a-f]{32})\.\w+")
# The name of a piece by older versions, without the digest of a manifest.
_OLD_NAME: Final = re.compile(r"\d{9,}\.\d+\.[0-9a-f]{32}\.\w+")
_LEFT_OVER: Final = (".fivtui-", "merged.")


@dataclass(frozen=True, slots=True)
class SweepPiece:
    """Piece `number` of a sweep: members `first` to `stop` - 1."""

    number: int
    first: int
    stop: int


def piece_count(members: int, size: int) -> int:
    """Number of pieces of `size` members; the last may be smaller."""
    return -(-members // size)


def piece_of(number: int, members: int, size: int) -> SweepPiece:
    """Piece `number` of a sweep of `members` members, `size` in a piece."""
    return SweepPiece(number, number * size, min((number + 1) * size, members))


class Manifest(NamedTuple):
    """The manifest of a folder of pieces: its digest, members of a piece, and provenance."""

    digest: str
    size: int
    provenance: dict[str, Any]


def read_manifest(folder: Path) -> Manifest:
    """The manifest in a folder of pieces; `InputError` if it is damaged."""
    try:
        content = json.loads((folder / MANIFEST).read_bytes())
        provenance = {key: content[key] for key in content if key not in (PIECE_MEMBERS, COLUMNS)}
        return Manifest(digest_of(content), int(content[PIECE_MEMBERS]), provenance)
    except (ValueError, KeyError, TypeError):
        raise InputError(f"its {MANIFEST} is damaged") from None


@dataclass(frozen=True, slots=True)
class PieceFile:
    """A file of a piece: number, failures, manifest digest and checksum from its name."""

    path: Path
    number: int
    failed: int
    sweep: str
    checksum: str

    @property
    def sound(self) -> bool:
        """Whether the content has the checksum in the name."""
        checksum = _checksum(self.number, self.failed, self.sweep, self.path.read_bytes())
        return checksum == self.checksum


def piece_name(number: int, failed: int, sweep: str, content: bytes, suffix: str) -> str:
    """The name of a piece's file."""
    return f"{number:09}.{failed}.{sweep}.{_checksum(number, failed, sweep, content)}{suffix}"


def _checksum(number: int, failed: int, sweep: str, content: bytes) -> str:
    # The checksum includes the name, so that a renamed piece is not sound.
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


def sound_pieces(folder: Path, digest: str, count: int) -> dict[int, PieceFile]:
    """The sound files of pieces 0 to `count` - 1 of a manifest, by number."""
    sound: dict[int, PieceFile] = {}
    for file in piece_files(folder):
        if file.sweep == digest and file.number < count and file.number not in sound and file.sound:
            sound[file.number] = file
    return sound
