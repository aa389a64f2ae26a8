"""Content of written files as lines: tables by column, pictures by size and text.

A reader, selected by the suffix, yields the lines of a file.
"""

import csv
import html
import io
import json
import re
import struct
import wave
import zipfile
from collections.abc import Callable, Iterator, Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any, Final

import numpy as np

from tests.net.text import array_line, column_line, data_lines, mask_varying


def file_lines(path: Path) -> list[str]:
    """A written file as lines of text."""
    read = READERS.get(path.suffix.lower(), _text)
    return [line for part in read(path) for line in mask_varying(part, path.parent).splitlines()]


def _text(path: Path) -> Iterator[str]:
    yield path.read_text(encoding="utf-8")


def _json(path: Path) -> Iterator[str]:
    yield from data_lines(json.loads(path.read_text(encoding="utf-8")))


def _csv(path: Path) -> Iterator[str]:
    lines = path.read_text(encoding="utf-8").splitlines()
    for line in takewhile(lambda line: line.startswith("#"), lines):
        key, _, value = line.removeprefix("# ").partition(": ")
        yield from data_lines(json.loads(value), f"# {key}")
    names, *rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    for index, name in enumerate(names):
        yield column_line(name, [_number(row[index]) for row in rows])


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _npz(path: Path) -> Iterator[str]:
    with np.load(path, allow_pickle=False) as arrays:
        for name, array in arrays.items():
            if array.dtype.names:
                entries = {key: array[key].tolist() for key in array.dtype.names}
                yield from data_lines(entries, f"# {name}")
            else:
                yield array_line(name, array)


def _parquet(path: Path) -> Iterator[str]:
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    for key, value in (table.schema.metadata or {}).items():
        if not key.startswith((b"ARROW", b"pandas")):
            yield from data_lines(_parsed(value.decode()), f"# {key.decode()}")
    for field in table.schema:
        notes = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
        notes.pop("PARQUET:field_id", None)
        yield f"# {field.name}: {field.type} {notes}"
        yield column_line(field.name, table[field.name].to_pylist())


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


def _svg(path: Path) -> Iterator[str]:
    text = path.read_text(encoding="utf-8")
    root = re.search(r"<svg [^>]*>", text)
    tag = root.group() if root else ""
    size = re.search(r'width="(\S+)" height="(\S+)"', tag) or re.search(r'viewBox="(.*?)"', tag)
    yield f"size {' '.join(size.groups()) if size else 'unknown'}"
    # A text is drawn as outlines, with its content in a comment, or it is a text element, which may
    # contain further tags.
    comment, element = r"<!-- (.*?) -->", r"<text[^>]*>(.*?)</text>"
    for outlined, written in re.findall(f"{comment}|{element}", text, re.DOTALL):
        content = outlined or re.sub(r"<[^>]*>", "", written)
        yield f"text {' '.join(html.unescape(content).split())}"


def _png(path: Path) -> Iterator[str]:
    # Width and height follow the signature and the name of the first chunk.
    width, height = struct.unpack(">II", path.read_bytes()[16:24])
    yield f"size {width} x {height}"


def _gif(path: Path) -> Iterator[str]:
    from PIL import Image

    with Image.open(path) as film:
        frames, duration = getattr(film, "n_frames", 1), film.info.get("duration")
        yield f"size {film.width} x {film.height}, {frames} frames of {duration} ms"


def _pdf(path: Path) -> Iterator[str]:
    boxes = re.findall(rb"/MediaBox \[(.*?)\]", path.read_bytes())
    yield f"{len(boxes)} pages of {b', '.join(boxes).decode().strip()}"


def _wav(path: Path) -> Iterator[str]:
    with wave.open(str(path)) as sound:
        yield f"{sound.getnchannels()} x {8 * sound.getsampwidth()} bit, {sound.getframerate()} Hz"
        samples = np.frombuffer(sound.readframes(sound.getnframes()), np.dtype("<i2"))
        yield column_line("samples", samples.tolist())


def _archive(path: Path) -> Iterator[str]:
    with zipfile.ZipFile(path) as archive:
        yield "\n".join(_entries(archive))
        for name in sorted(archive.namelist()):
            if name.endswith(".ssd"):
                yield from xml_lines(archive.read(name).decode())
            elif name.endswith((".fmu", ".ssp")):
                with zipfile.ZipFile(io.BytesIO(archive.read(name))) as part:
                    yield "\n".join(f"{name}: {entry}" for entry in _entries(part))


def _entries(archive: zipfile.ZipFile) -> list[str]:
    # Sources in an FMU are not for users: record only their folder.
    entries = set()
    for name in archive.namelist():
        folder, _, _ = name.partition("/")
        entries.add(f"{folder}/…" if folder in ("resources", "sources") else name)
    return sorted(entries)


def xml_lines(text: str) -> Iterator[str]:
    """XML with a line for each tag, and without identifiers."""
    without_identifiers = re.sub(
        r'(guid|instantiationToken|generationDateAndTime)="[^"]*"', r'\1="…"', text
    )
    yield from mask_varying(re.sub(r">\s*<", ">\n<", without_identifiers)).splitlines()


READERS: Final[Mapping[str, Callable[[Path], Iterator[str]]]] = {
    ".csv": _csv,
    ".fmu": _archive,
    ".gif": _gif,
    ".json": _json,
    ".npz": _npz,
    ".parquet": _parquet,
    ".pdf": _pdf,
    ".png": _png,
    ".ssp": _archive,
    ".svg": _svg,
    ".wav": _wav,
}
