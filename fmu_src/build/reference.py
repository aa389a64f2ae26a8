"""Reference runs that FMUs carry below ``extra/``, in the layout of the FMI cross-check."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

_FOLDER: Final = "extra"


class Reference(NamedTuple):
    """A run that any tool can repeat.

    Attributes
    ----------
    stop_time, step : float
        Last time and communication step, s; the first time is 0.
    tol : float
        Relative tolerance of the experiment.
    inputs : mapping of str to sequence of float
        ``time`` and the inputs, by name; two rows of one time are a jump.
    outputs : mapping of str to sequence of float
        ``time`` and outputs at all communication points, by name.
    """

    stop_time: float
    step: float
    tol: float
    inputs: Mapping[str, Sequence[float]]
    outputs: Mapping[str, Sequence[float]]


def reference_files(model: str, reference: Reference) -> dict[str, bytes]:
    """A reference run as files.

    Parameters
    ----------
    model : str
        Name of the model.
    reference : Reference
        The run.

    Returns
    -------
    dict of str to bytes
        Content by name in the FMU: ``_in.csv``, ``_ref.csv`` and ``_ref.opt``.
    """
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
    # Ten digits: more would differ between mathematical libraries.
    lines = [",".join(f'"{name}"' for name in columns)]
    lines += [
        ",".join(f"{value:.10g}" for value in row) for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join(lines) + "\n"
