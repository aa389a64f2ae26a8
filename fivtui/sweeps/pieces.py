"""The pieces of a sweep that is not complete, on disk: their names, and what is sound of them.

The folder has a manifest, which says what is computed, by what, and how many members a piece has.
A piece is a file whose name says its number, how many of its members failed, the digest of the
manifest that it belongs to, and a checksum of all this and of its content:
``000000012.3.09ab….5f1c….parquet``.
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
# What a manifest says besides what the file will say.
PIECE_MEMBERS: Final = "piece_members"
COLUMNS: Final = "columns"
_DIGITS: Final = 32
_NAME: Final = re.compile(r"(\d{9,})\.(\d+)\.([0-9a-f]{32})\.([0-9a-f]{32})\.\w+")
# Named so by a fivtui that did not write the digest of the manifest into the name.
_OLD_NAME: Final = re.compile(r"\d{9,}\.\d+\.[0-9a-f]{32}\.\w+")
_LEFT_OVER: Final = (".fivtui-", "merged.")


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


@dataclass(frozen=True, slots=True)
class PieceFile:
    """A file of a piece, as its name has it.

    Attributes
    ----------
    path : Path
        The file.
    number : int
        Number of the piece.
    failed : int
        How many of its members failed.
    sweep : str
        Digest of the manifest that it belongs to.
    checksum : str
        See `piece_name`.
    """

    path: Path
    number: int
    failed: int
    sweep: str
    checksum: str

    @property
    def sound(self) -> bool:
        """Whether the file is what its name says."""
        found = _checksum(self.number, self.failed, self.sweep, self.path.read_bytes())
        return found == self.checksum


def piece_name(number: int, failed: int, sweep: str, content: bytes, suffix: str) -> str:
    """The name of the file of a piece."""
    return f"{number:09}.{failed}.{sweep}.{_checksum(number, failed, sweep, content)}{suffix}"


def _checksum(number: int, failed: int, sweep: str, content: bytes) -> str:
    # A piece under the name of another one is unsound as well.
    digest = hashlib.sha256(f"{number}.{failed}.{sweep}\n".encode())
    digest.update(content)
    return digest.hexdigest()[:_DIGITS]


def digest_of(manifest: Mapping[str, Any]) -> str:
    """The digest of a manifest, the same whether it was read from a file or not."""
    text = json.dumps(manifest, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]


def piece_files(folder: Path) -> list[PieceFile]:
    """The files of pieces in a folder, in order; none is read."""
    named = ((path, _NAME.fullmatch(path.name)) for path in sorted(folder.iterdir()))
    return [
        PieceFile(path, int(match[1]), int(match[2]), match[3], match[4])
        for path, match in named
        if match is not None
    ]


def old_piece_files(folder: Path) -> list[Path]:
    """Pieces in a folder that do not say which sweep they are of."""
    return [path for path in folder.iterdir() if _OLD_NAME.fullmatch(path.name)]


def is_own(path: Path) -> bool:
    """Whether a file is a piece, or what a kill has left half written."""
    named = _NAME.fullmatch(path.name) or _OLD_NAME.fullmatch(path.name)
    return named is not None or path.name.startswith(_LEFT_OVER)


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
    said : dict
        What the file will say of its making.
    """

    study: Study
    form: SweepFormat
    paths: tuple[Path, ...]
    members: int
    said: dict[str, Any]


def find_pieces(folder: Path) -> Pieces:
    """Look into the folder of a sweep that is not complete; nothing is changed there.

    Parameters
    ----------
    folder : Path
        ``FILE.parts``.

    Returns
    -------
    Pieces
        Those that are sound, and of the sweep that the manifest says.

    Raises
    ------
    InputError
        If it is no such folder, has no such piece yet, or an older fivtui made it.
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
        raise InputError("an older fivtui began this sweep: its pieces do not say of which it is")
    if not sound:
        raise InputError("no member of this sweep is stored yet")
    pieces = [piece_of(number, study.members, size) for number in sound]
    return Pieces(
        study,
        form,
        tuple(file.path for file in sound.values()),
        sum(piece.last - piece.first for piece in pieces),
        {key: value for key, value in manifest.items() if key not in (PIECE_MEMBERS, COLUMNS)},
    )
