"""Reference runs below ``extra/``, in the layout of the FMI cross-check."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

_FOLDER: Final = "extra"


class Reference(NamedTuple):
    """A run that any tool can repeat: times in s; inputs and outputs by name, each with ``time``.

    Two rows of one time in the inputs are a jump; outputs are at all communication points.
    """

    stop_time: float
    step: float
    tol: float
    inputs: Mapping[str, Sequence[float]]
    outputs: Mapping[str, Sequence[float]]


def reference_files(model: str, reference: Reference) -> dict[str, bytes]:
    """A reference run as ``_in.csv``, ``_ref.csv`` and ``_ref.opt``: content by name in the FMU."""
    options = {
        "StartTime": 0.0,
        "StopTime": reference.stop_time,
        "StepSize": reference.step,
        "RelTol": reference.tol,
    }
    texts = {
        "in.csv": _table(reference.inputs),
        "ref.csv": _table(reference.outputs),
        "ref.opt": "".join(f"{name}, {value!r}\n" for name, value in options.items()),
    }
    return {f"{_FOLDER}/{model}_{name}": text.encode() for name, text in texts.items()}


def _table(columns: Mapping[str, Sequence[float]]) -> str:
    # Ten digits; further ones depend on the platform's mathematical library.
    lines = [",".join(f'"{name}"' for name in columns)]
    lines += [
        ",".join(f"{value:.10g}" for value in row) for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join(lines) + "\n"
