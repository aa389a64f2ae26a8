"""Store branches of limit cycles without loss, and read them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from fivtui.io import output_path, save_json
from fivtui.model import Parameters, System
from fivtui.results import from_data, read_result

from .events import End
from .result import BranchEvent, CycleBranch, CyclePoint, Origin

# Key in stored branches: the parameter set's value of the parameter that varies.
_SET_VALUE_KEY: Final = "own_value"


def store_branch(result: CycleBranch, path: Path) -> None:
    """Write a branch without loss as JSON; replaces an existing file."""
    value = result.parameters.as_dict()[result.name]
    save_json({**result.to_dict(), _SET_VALUE_KEY: value}, output_path(path, force=True))


def restore_branch(path: Path) -> CycleBranch:
    """Read a branch from JSON, stored or printed by ``fivtui branch --json``.

    Printed branches lack the parameter set's value of the parameter that varies; the value of the
    first point replaces it. Raises `InputError` for a table, or if the file is damaged.
    """
    return read_result(path, CycleBranch.data_name, _branch_from_data)


def _branch_from_data(data: Mapping[str, Any]) -> CycleBranch:
    name = str(data["parameter"])
    points = from_data(data["points"], tuple[CyclePoint, ...])
    value = data.get(_SET_VALUE_KEY, points[0].value)
    p = Parameters().with_values({**data["parameters"], name: value})
    low, high = from_data(data["range"], tuple[float, float])
    return CycleBranch(
        System(p, bool(data["separation"])),
        name,
        low,
        high,
        from_data(data["from"], Origin),
        points,
        from_data(data["events"], tuple[BranchEvent, ...]),
        from_data(data["ends"], tuple[End, End]),
        bool(data["doubled"]),
    )
