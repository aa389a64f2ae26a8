"""Read branches of limit cycles, and keep them whole."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from fivtui.io import output_path, save_json
from fivtui.model import Parameters, System
from fivtui.results import from_data, read_result

from .events import End
from .result import BranchEvent, CycleBranch, CyclePoint, Origin

# Key of the set's own value of the parameter that varies, in stored branches.
_OWN: Final = "own_value"


def store_branch(result: CycleBranch, path: Path) -> None:
    """Write all of a branch as JSON; replaces a file."""
    value = result.parameters.as_dict()[result.name]
    save_json({**result.to_dict(), _OWN: value}, output_path(path, force=True))


def restore_branch(path: Path) -> CycleBranch:
    """Read a branch from JSON, that of ``fivtui branch --json`` too.

    What that does not say, the set's own value of the parameter that varies, is then that of the
    first point. Raises `InputError` for a table, or if the file is damaged.
    """
    return read_result(path, CycleBranch.data_name, _branch)


def _branch(data: Mapping[str, Any]) -> CycleBranch:
    name = str(data["parameter"])
    points = from_data(data["points"], tuple[CyclePoint, ...])
    value = data.get(_OWN, points[0].value)
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
