"""Comparisons of a run with a measurement among the studies."""

from typing import TYPE_CHECKING, Any, Final

from fivtui.results import PHYSICS, TABLES, Command, StudyKind, listed, scene_fields

if TYPE_CHECKING:
    from collections.abc import Sequence

_SAID: Final = (*PHYSICS, "start", "t_end", "method", "tol", "step")


def _command(asked: "tuple[Any, Sequence[str]]") -> Command:
    # Of a scene and the options that say what it is compared with.
    scene, options = asked
    needed = {"accuracy": scene.accuracy, "over_time": scene.over_time}
    return Command("validate", scene_fields(scene, _SAID), _SAID, options, needed)


VALIDATION: Final = StudyKind(
    data="validation",
    show=listed("Run beside measured data"),
    suffixes=TABLES,
    as_json=True,
    header=frozenset({"validation"}),
    stem=lambda result: f"validation-{result.quantity}",
    command=_command,
)
