"""Write and read complete sweeps, and read incomplete ones.

The rows of an incomplete sweep are in the files of its pieces, in a folder ``FILE.parts``.
"""

import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

from fivtui.io import check_regular, is_folder, parts_folder, temporary_folder, write_atomically
from fivtui.model import InputError

from .formats import SweepFormat, sweep_format
from .pieces import old_piece_files, piece_count, read_manifest, sweep_piece, valid_pieces
from .provenance import convert_provenance, make_provenance, study_from_dict
from .run import Sweep, check_memory_limit
from .study import Study


def save_sweep(result: Sweep, path: Path) -> None:
    """Write a complete sweep; the file has the same bytes as that of `sweep_to_file`.

    The provenance is that of the file the sweep was read from, or else of this machine. Raises
    `InputError` if the file cannot be written, or the sweep is not complete.
    """
    file_format, study, members = sweep_format(path), result.study, result.table.members
    if members != study.members:
        raise InputError(f"{path}: {members} of {study.members} members are computed, not all")
    provenance = (
        make_provenance(study, file_format)
        if result.provenance is None
        else convert_provenance(result.provenance, file_format)
    )

    def write(file: BinaryIO) -> None:
        with tempfile.TemporaryDirectory(prefix="fivtui-") as folder:
            piece = Path(folder) / f"rows{path.suffix.lower()}"
            with piece.open("wb") as rows:
                file_format.write_piece(rows, study, result.table)
            file_format.merge(file, study, [piece], provenance)

    write_atomically(path, write)


def read_sweep(path: Path) -> Sweep:
    """Read a sweep from its file, or the rows stored so far from its ``FILE.parts``.

    Raises `InputError` if the file is damaged or no sweep, or has more than a million members.
    """
    file_format = None if is_folder(path) else sweep_format(path)
    if file_format is not None:
        check_regular(path)
    try:
        result, members = (
            _read_folder(path) if file_format is None else _read_file(path, file_format)
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (OSError, ValueError, KeyError, IndexError, TypeError, RecursionError):
        raise InputError(f"{path}: not a sweep, or damaged") from None
    if result.table.members != members:
        raise InputError(f"{path}: damaged: {result.table.members} rows, not {members}")
    return result


def read_stored_studies(out: Path) -> tuple[Study | None, Study | None]:
    """Read the study of a complete file and that of the pieces beside it; None if missing."""
    file_format = sweep_format(out)
    stored = incomplete = None
    if out.is_file() and (provenance := file_format.provenance(out)) is not None:
        stored = _parse_study(provenance)
    with suppress(OSError, InputError):
        incomplete = _parse_study(read_manifest(parts_folder(out)).provenance)
    return stored, incomplete


def _parse_study(provenance: Any) -> Study | None:
    # The study in a provenance; None if it is not complete.
    try:
        return study_from_dict(provenance["sweep"])
    except (InputError, KeyError, TypeError):
        return None


def _read_file(path: Path, file_format: SweepFormat) -> tuple[Sweep, int]:
    # Read a complete sweep; also the number of its members.
    provenance = file_format.provenance(path)
    if provenance is None or "sweep" not in provenance:
        raise InputError("not a sweep that fivtui wrote")
    study = study_from_dict(provenance["sweep"])
    check_memory_limit(study)
    return Sweep(study, file_format.read(path, study), provenance), study.members


def _read_folder(folder: Path) -> tuple[Sweep, int]:
    # Read the rows of the valid pieces; also the number of their members.
    try:
        manifest, file_format = read_manifest(folder), sweep_format(Path(folder.stem))
        study = study_from_dict(manifest.provenance["sweep"])
        count = piece_count(study.members, manifest.size)
        files, old_files = (valid_pieces(folder, manifest.digest, count), old_piece_files(folder))
    except (OSError, ValueError, KeyError):
        raise InputError("not the folder of an incomplete sweep (FILE.parts)") from None
    if old_files:
        raise InputError("an older fivtui began this sweep: its pieces do not identify their sweep")
    if not files:
        raise InputError("no member of this sweep is stored yet")
    pieces = [sweep_piece(number, study.members, manifest.size) for number in files]
    members = sum(piece.stop - piece.first for piece in pieces)
    check_memory_limit(study, members)
    with temporary_folder() as temporary:
        merged = temporary / folder.stem
        with merged.open("wb") as file:
            file_format.merge(file, study, [piece.path for piece in files.values()], {})
        return Sweep(study, file_format.read(merged, study), manifest.provenance), members
