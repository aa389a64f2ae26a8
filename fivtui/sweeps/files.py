"""Write and read complete sweeps, and read incomplete ones."""

import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

from fivtui.io import check_regular, is_folder, parts_folder, temporary_folder, write_atomically
from fivtui.model import InputError

from .formats import SweepFormat, sweep_format
from .pieces import old_piece_files, piece_count, piece_of, read_manifest, sound_pieces
from .provenance import converted_provenance, provenance_of, study_from_dict
from .run import Sweep, check_memory_limit
from .study import Study


def save_sweep(result: Sweep, path: Path) -> None:
    """Write a complete sweep; the file has the same bytes as that of `sweep_to_file`.

    The provenance is that of the file it was read from, or of this machine. Raises `InputError` if
    the file cannot be written, or the sweep is not complete.
    """
    form, study, members = sweep_format(path), result.study, len(result.table.reasons)
    if members != study.members:
        raise InputError(f"{path}: {members} of {study.members} members are computed, not all")
    provenance = (
        provenance_of(study, form)
        if result.provenance is None
        else converted_provenance(result.provenance, form)
    )

    def write(file: BinaryIO) -> None:
        with tempfile.TemporaryDirectory(prefix="fivtui-") as folder:
            piece = Path(folder) / f"rows{path.suffix.lower()}"
            with piece.open("wb") as rows:
                form.write_piece(rows, study, result.table)
            form.merge(file, study, [piece], provenance)

    write_atomically(path, write)


def read_sweep(path: Path) -> Sweep:
    """Read a sweep from its file, or the rows stored so far from its ``FILE.parts``.

    Raises `InputError` if it is another file, is damaged, or has more than a million members.
    """
    form = None if is_folder(path) else sweep_format(path)
    if form is not None:
        check_regular(path)
    try:
        result, members = _from_folder(path) if form is None else _from_file(path, form)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (OSError, ValueError, KeyError, IndexError, TypeError, RecursionError):
        raise InputError(f"{path}: not a sweep, or damaged") from None
    if len(result.table.reasons) != members:
        raise InputError(f"{path}: damaged: {len(result.table.reasons)} rows, not {members}")
    return result


def stored_studies(out: Path) -> tuple[Study | None, Study | None]:
    """The study of a complete file, and that of the pieces beside it; None if missing."""
    form = sweep_format(out)
    stored = under_way = None
    if out.is_file() and (provenance := form.provenance(out)) is not None:
        stored = _study_in(provenance)
    with suppress(OSError, InputError):
        under_way = _study_in(read_manifest(parts_folder(out)).provenance)
    return stored, under_way


def _study_in(provenance: Any) -> Study | None:
    try:
        return study_from_dict(provenance["sweep"])
    except (InputError, KeyError, TypeError):
        return None


def _from_file(path: Path, form: SweepFormat) -> tuple[Sweep, int]:
    provenance = form.provenance(path)
    if provenance is None or "sweep" not in provenance:
        raise InputError("not a sweep that fivtui wrote")
    study = study_from_dict(provenance["sweep"])
    check_memory_limit(study)
    return Sweep(study, form.read(path, study), provenance), study.members


def _from_folder(folder: Path) -> tuple[Sweep, int]:
    # The rows of the sound pieces in ``FILE.parts``, and their number; only reads the folder.
    try:
        manifest, form = read_manifest(folder), sweep_format(Path(folder.stem))
        study = study_from_dict(manifest.provenance["sweep"])
        count = piece_count(study.members, manifest.size)
        pieces, old = sound_pieces(folder, manifest.digest, count), old_piece_files(folder)
    except (OSError, ValueError, KeyError):
        raise InputError("not the folder of a sweep under way (FILE.parts)") from None
    if old:
        raise InputError(
            "an older fivtui began this sweep: its pieces do not say which sweep they are of"
        )
    if not pieces:
        raise InputError("no member of this sweep is stored yet")
    parts = [piece_of(number, study.members, manifest.size) for number in pieces]
    members = sum(part.stop - part.first for part in parts)
    check_memory_limit(study, members)
    with temporary_folder() as scratch:
        merged = scratch / folder.stem
        with merged.open("wb") as file:
            form.merge(file, study, [piece.path for piece in pieces.values()], {})
        return Sweep(study, form.read(merged, study), manifest.provenance), members
