"""The trade-off among the studies."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.results import PHYSICS, Command, Stored, StudyKind, scene_fields

if TYPE_CHECKING:
    from .measure import Tradeoff

_SAID: Final = (*PHYSICS, "start", "t_end")


def _show(result: "Tradeoff") -> None:
    from .report import print_tradeoff

    print_tradeoff(result, {})


def _save(result: "Tradeoff", path: Path, force: bool) -> None:
    from .files import save_tradeoff

    save_tradeoff(result, path, force=force)


def _load(path: Path) -> "Tradeoff":
    from .files import load_tradeoff

    return load_tradeoff(path)


def _store(result: "Tradeoff", path: Path) -> None:
    from fivtui.io import save_json

    save_json(result.to_dict(), path)


def _command(scene: Any) -> Command:
    return Command("tradeoff", scene_fields(scene, _SAID), _SAID)


TRADEOFF: Final = StudyKind(
    data="trade-off",
    show=_show,
    suffixes=(".csv",),
    save=_save,
    as_json=True,
    stem=lambda _: "tradeoff",
    load=_load,
    load_suffixes=(".csv", ".json"),
    header=frozenset({"floor"}),
    json_keys=frozenset({"floor", "rows"}),
    command=_command,
    stored=Stored(".json", _store, _load),
)
