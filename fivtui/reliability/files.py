"""Files of uncertainty studies: those of their scattered sweeps."""

from pathlib import Path

from fivtui.sweeps import read_sweep, save_sweep

from .result import Uncertainty, judged


def save_uncertainty(result: Uncertainty, path: Path, *, force: bool = False) -> None:
    """Write the members of a study; `InputError` if the file cannot be written."""
    save_sweep(result.sweep, path, force=force)


def read_uncertainty(path: Path) -> Uncertainty:
    """Read a study from the file of its members, or from the pieces of one under way.

    Raises `InputError` if it is another file, or damaged.
    """
    return judged(read_sweep(path))
