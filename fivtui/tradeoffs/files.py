"""A trade-off as plain data and as a table in a file, and what is best in it."""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from fivtui.io import check_output, check_suffix, read_bytes, write_atomically
from fivtui.model import InputError, Parameters
from fivtui.scene import Scene
from fivtui.transient import QUANTITIES, Deviation
from fivtui.version import __version__

from .measure import Feature, Tradeoff
from .settings import Row, Setting, cheapest, pareto


def tradeoff_to_dict(result: Tradeoff) -> dict[str, Any]:
    """A trade-off as data that JSON can hold.

    Parameters
    ----------
    result : Tradeoff
        What was measured.

    Returns
    -------
    dict
        ``parameters``, ``separation``, ``start``, ``t_end``, ``floor``, ``rows`` of ``method``,
        ``kernel``, ``setting``, ``cpu_s``, ``steps``, ``error_final``, ``error_peak``,
        ``error_half_range``, ``error_events`` (s), ``separations`` (too many or missing),
        ``failure``, ``pareto`` (the quantities on whose front the row is), and ``features``. What
        does not exist is null.
    """
    start = result.scene.start
    return {
        "parameters": result.scene.parameters.as_dict(),
        "separation": result.scene.separation,
        "start": start if isinstance(start, str) else list(start),
        "t_end": result.scene.t_end,
        "floor": {name: _finite(result.floor.of(name)) for name in QUANTITIES},
        "rows": _rows(result.rows, fronts(result)),
        "features": [asdict(feature) for feature in result.features],
    }


def tradeoff_columns(result: Tradeoff) -> dict[str, NDArray[Any]]:
    """The settings by column; NaN or empty text for what does not exist."""
    rows = _rows(result.rows, fronts(result))
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    columns["pareto"] = [" ".join(names) for names in columns["pareto"]]
    texts = ("method", "kernel", "setting", "failure", "pareto")
    return {
        name: np.array([value or "" for value in values], dtype=str)
        if name in texts
        else np.array(values, dtype=np.int64 if name == "steps" else np.float64)
        for name, values in columns.items()
    }


def fronts(result: Tradeoff) -> dict[str, list[Row]]:
    """The settings that no other beats, by quantity, cheapest first."""
    return {name: pareto(result.rows, name, result.floor.of(name)) for name in QUANTITIES}


def _rows(rows: Sequence[Row], best: Mapping[str, Sequence[Row]]) -> list[dict[str, Any]]:
    return [
        {
            "method": row.setting.method,
            "kernel": row.setting.kernel or None,
            "setting": row.setting.text,
            "cpu_s": row.cpu_s,
            "steps": row.steps,
            **{f"error_{name}": _error(row, name) for name in QUANTITIES},
            "separations": None if row.error is None else row.error.separations,
            "failure": row.failure or None,
            "pareto": [name for name in QUANTITIES if row in best[name]],
        }
        for row in rows
    ]


def cheapest_to_dict(result: Tradeoff, wishes: Mapping[str, float]) -> dict[str, Any]:
    """The cheapest settings for errors asked for, as data that JSON can hold.

    Parameters
    ----------
    result : Tradeoff
        What was measured.
    wishes : mapping of str to float
        Error allowed by quantity.

    Returns
    -------
    dict
        ``cheapest``, a list of ``quantity``, ``error`` and ``row`` (null if no setting reached the
        error); empty if nothing is asked.
    """
    if not wishes:
        return {}
    found = []
    for quantity, error in wishes.items():
        row = cheapest(result.rows, quantity, error)
        (plain,) = _rows([row], fronts(result)) if row is not None else [None]
        found.append({"quantity": quantity, "error": error, "row": plain})
    return {"cheapest": found}


def check_tradeoff_path(path: Path, *, force: bool) -> None:
    """Check that a trade-off can be written to a file, before it is measured.

    Parameters
    ----------
    path : Path
        The file; it ends in ``.csv``.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the name is wrong, or the file exists or cannot be written.
    """
    check_suffix(path, "trade-off", (".csv",))
    check_output(path, force=force)


def save_tradeoff(result: Tradeoff, path: Path, *, force: bool = False) -> None:
    """Write all that was measured as CSV, a row a setting.

    Parameters
    ----------
    result : Tradeoff
        What was measured.
    path : Path
        The file.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the file cannot be written, see `write_atomically`.
    """
    data = tradeoff_to_dict(result)
    known = ("parameters", "separation", "start", "t_end", "floor", "features")
    header = {"fivtui": __version__, **{key: data[key] for key in known}}
    rows = [{**row, "pareto": " ".join(row["pareto"])} for row in data["rows"]]

    def write(file: BinaryIO) -> None:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
        text.writelines(f"# {key}: {json.dumps(value)}\n" for key, value in header.items())
        table = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
        text.detach()

    write_atomically(path, write, force=force)


def load_tradeoff(path: Path) -> Tradeoff:
    """Read a trade-off from a file.

    Parameters
    ----------
    path : Path
        What ``fivtui tradeoff --json`` printed (``.json``) or ``--out`` wrote (``.csv``).

    Returns
    -------
    Tradeoff
        What was measured, without the reference.

    Raises
    ------
    InputError
        If the file is no trade-off.
    """
    suffix = check_suffix(path, "trade-off", (".csv", ".json"))
    content = read_bytes(path)
    try:
        text = content.decode("utf-8-sig")
        data = json.loads(text) if suffix == ".json" else _from_csv(text)
        return _tradeoff(path.stem, data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(f"{path}: not a trade-off, or damaged") from None


def _from_csv(text: str) -> dict[str, Any]:
    lines = text.splitlines()
    said = [line.removeprefix("# ").partition(": ") for line in lines if line.startswith("# ")]
    data = {key: json.loads(value) for key, _, value in said}
    table = csv.DictReader(line for line in lines if not line.startswith("# "))
    return {**data, "rows": [{k: v or None for k, v in row.items()} for row in table]}


def _tradeoff(name: str, data: Mapping[str, Any]) -> Tradeoff:
    start = data.get("start", "static")
    scene = Scene(
        name=name,
        description="",
        parameters=Parameters().with_values(data["parameters"]),
        separation=bool(data.get("separation", True)),
        start="static" if start == "static" else [float(value) for value in start],
        t_end=float(data["t_end"]),
    )
    floor = {quantity: _infinite(data["floor"][quantity]) for quantity in QUANTITIES}
    return Tradeoff(
        scene=scene,
        reference=None,
        floor=Deviation(**floor, separations=0),
        rows=[_row(row) for row in data["rows"]],
        features=[Feature(**feature) for feature in data.get("features", [])],
    )


def _row(data: Mapping[str, Any]) -> Row:
    knob, _, value = str(data["setting"]).partition("=")
    setting = Setting(str(data["method"]), data["kernel"] or "", knob, float(value))
    failure = data["failure"] or ""
    error = None
    if not failure:
        errors = {name: _infinite(data[f"error_{name}"]) for name in QUANTITIES}
        error = Deviation(**errors, separations=int(data["separations"]))
    return Row(setting, float(data["cpu_s"]), int(data["steps"]), error, failure)


def _infinite(value: float | str | None) -> float:
    return math.inf if value is None else float(value)


def _error(row: Row, quantity: str) -> float | None:
    return None if row.error is None else _finite(row.error.of(quantity))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
