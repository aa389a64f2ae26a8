"""Pieces of an incomplete sweep on disk: file names, checksums and manifest.

A piece has the rows of a range of members. The manifest has the study, the versions, and the number
of members per piece. A piece's file has a name such as ``000000012.3.09ab….5f1c….parquet``: piece
12 has 3 failed members; the digest of the manifest follows, then a checksum of these and the
content.
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
# Keys of a manifest that are not part of the provenance.
PIECE_MEMBERS: Final = "piece_members"
COLUMNS: Final = "columns"
_DIGEST_DIGITS: Final = 32
_NAME: Final = re.compile(r"(\d{9,})\.(\d+)\.([0-9a-f]{32})\.([0-9a-f]{32})\.\w+")
# File names of pieces by older versions, without the digest of a manifest.
_OLD_NAME: Final = re.compile(r"\d{9,}\.\d+\.[0-9a-f]{32}\.\w+")
# First letters of the names of files that are being written.
_TEMPORARY_PREFIXES: Final = (".fivtui-", "merged.")


@dataclass(frozen=True, slots=True)
class SweepPiece:
    """Piece `number` of a sweep: members `first` to `stop` - 1."""

    number: int
    first: int
    stop: int


def piece_count(members: int, size: int) -> int:
    """Number of pieces of `size` members; the last may be smaller."""
    return -(-members // size)


def sweep_piece(number: int, members: int, size: int) -> SweepPiece:
    """Piece `number` of a sweep of `members` members, `size` in a piece."""
    return SweepPiece(number, number * size, min((number + 1) * size, members))


class Manifest(NamedTuple):
    """The manifest of a folder of pieces: its digest, members per piece, and provenance."""

    digest: str
    size: int
    provenance: dict[str, Any]


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest in a folder of pieces; `InputError` if it is damaged."""
    try:
        content = json.loads((folder / MANIFEST).read_bytes())
        provenance = {key: content[key] for key in content if key not in (PIECE_MEMBERS, COLUMNS)}
        return Manifest(manifest_digest(content), int(content[PIECE_MEMBERS]), provenance)
    except (ValueError, KeyError, TypeError):
        raise InputError(f"its {MANIFEST} is damaged") from None


@dataclass(frozen=True, slots=True)
class PieceFile:
    """A file of a piece; number, failed members, manifest digest and checksum are from its name."""

    path: Path
    number: int
    failed: int
    digest: str
    checksum: str

    @property
    def valid(self) -> bool:
        """Whether the content agrees with the checksum in the name."""
        checksum = _checksum(self.number, self.failed, self.digest, self.path.read_bytes())
        return checksum == self.checksum


def piece_name(number: int, failed: int, digest: str, content: bytes, suffix: str) -> str:
    """The name of a piece's file."""
    return f"{number:09}.{failed}.{digest}.{_checksum(number, failed, digest, content)}{suffix}"


def _checksum(number: int, failed: int, digest: str, content: bytes) -> str:
    # The checksum covers the name, so that a renamed piece is not valid.
    checksum = hashlib.sha256(f"{number}.{failed}.{digest}\n".encode())
    checksum.update(content)
    return checksum.hexdigest()[:_DIGEST_DIGITS]


def manifest_digest(manifest: Mapping[str, Any]) -> str:
    """The digest of a manifest."""
    text = json.dumps(manifest, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGEST_DIGITS]


def piece_files(folder: Path) -> list[PieceFile]:
    """The files of pieces in a folder, in order; their content is not read."""
    matches = ((path, _NAME.fullmatch(path.name)) for path in sorted(folder.iterdir()))
    return [
        PieceFile(path, int(match[1]), int(match[2]), match[3], match[4])
        for path, match in matches
        if match is not None
    ]


def old_piece_files(folder: Path) -> list[Path]:
    """The files of pieces by older versions."""
    return [path for path in folder.iterdir() if _OLD_NAME.fullmatch(path.name)]


def is_sweep_file(path: Path) -> bool:
    """Whether a file in a folder of pieces is a piece, or incomplete because its run was killed."""
    match = _NAME.fullmatch(path.name) or _OLD_NAME.fullmatch(path.name)
    return match is not None or path.name.startswith(_TEMPORARY_PREFIXES)


def valid_pieces(folder: Path, digest: str, count: int) -> dict[int, PieceFile]:
    """The valid files of pieces 0 to `count` - 1, by number, with this digest of the manifest."""
    files: dict[int, PieceFile] = {}
    for file in piece_files(folder):
        if (
            file.digest == digest
            and file.number < count
            and file.number not in files
            and file.valid
        ):
            files[file.number] = file
    return files
