"""Shell commands that compute what a tab shows. Imports no Textual."""

import dataclasses
import shlex
from collections.abc import Collection
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS, InputError
from fivtui.scene import Scene

from .scene_differences import base_scene, differences
from .steps import number_text

if TYPE_CHECKING:
    from fivtui.equilibrium import StabilityMap
    from fivtui.sweeps import Axis, Study

_PHYSICS: Final = (*PARAMETERS, "separation")
_MOTION: Final = (*_PHYSICS, "start", "t_end")
_OF_SWEEPS: Final = (*PARAMETERS, "start", "t_end", "tol", "accuracy")
# Error targets replace these.
_OF_ACCURACY: Final = ("tol", "step")
_OF_TRANSIENTS: Final = (*_MOTION, "method", "tol", "accuracy", "step")
_DEFAULT_VALUE: Final = "growth-rate"


@dataclasses.dataclass(frozen=True, slots=True)
class Origin:
    """A scene with its name on the command line: preset or file, empty for the base scene."""

    scene: Scene
    source: str


def _words(command: str, scene: Scene, origin: Origin, said: Collection[str]) -> list[str]:
    # The command, its scene, and an option for every difference to that.
    begin, words = origin.scene, ["fivtui", command, origin.source]
    considered = "separation" in said and scene.separation and not begin.separation
    by_tolerance = "accuracy" in said and not scene.accuracy and begin.accuracy
    if not origin.source or considered or by_tolerance:
        # No option switches separation on again, or removes error targets.
        begin, words = base_scene(), ["fivtui", command]
    following = _OF_ACCURACY if scene.accuracy else ()
    for difference in differences(scene, begin):
        if difference.name in said and difference.name not in following:
            words += difference.words
    return words


def transient_line(scene: Scene, origin: Origin) -> str:
    """The command that computes a transient of a scene, quoted for a POSIX shell."""
    return shlex.join(_words("simulate", scene, origin, _OF_TRANSIENTS))


def stability_line(scene: Scene, origin: Origin) -> str:
    """The command that computes the stability of a scene's equilibrium."""
    return shlex.join(_words("stability", scene, origin, _PHYSICS))


def tradeoff_line(scene: Scene, origin: Origin) -> str:
    """The command that measures a scene's trade-off."""
    return shlex.join(_words("tradeoff", scene, origin, _MOTION))


def map_line(result: "StabilityMap", origin: Origin) -> str:
    """The command that computes a map. Raises `InputError` if values are not evenly spaced."""
    scene = dataclasses.replace(
        base_scene(), parameters=result.parameters, separation=result.separation
    )
    said = [name for name in _PHYSICS if name not in result.names]
    words = _words("map", scene, origin, said)
    for name, axis in zip(result.names, result.axes, strict=True):
        words += ["--over", f"{name}={_range_text(name, axis)}"]
    if result.value != _DEFAULT_VALUE:
        words += ["--value", result.value]
    return shlex.join(words)


def _range_text(name: str, values: NDArray[np.float64]) -> str:
    first, last, count = float(values[0]), float(values[-1]), values.size
    ends = f"{number_text(first)}:{number_text(last)}:{count}"
    if np.array_equal(values, np.linspace(first, last, count)):
        return ends
    if min(first, last) > 0.0 and np.array_equal(values, np.geomspace(first, last, count)):
        return f"{ends}:log"
    raise InputError(f"{name}: its values are not evenly spaced; a command cannot say them")


def sweep_line(study: "Study", origin: Origin) -> str:
    """The command that computes a sweep."""
    from fivtui.sweeps import DEFAULT_OUTPUTS

    design, both = study.design, len(study.cases) > 1
    scene = dataclasses.replace(
        base_scene(),
        parameters=study.parameters,
        start=study.start,
        t_end=study.t_end,
        tol=study.tol,
        accuracy=study.accuracy,
        separation=both or study.cases[0],
    )
    # No option of a sweep changes the method, or switches separation on again.
    begin = origin.scene
    stuck = begin.method != scene.method or not (both or begin.separation)
    known = Origin(base_scene(), "") if stuck else origin
    words = _words("sweep", scene, known, _OF_SWEEPS)
    if both or not study.cases[0]:
        words.append("--both" if both else "--ignore-separation")
    for name, axis in design.axes.items():
        words += ["--vary", f"{name}={_axis_text(axis)}"]
    if design.kind != "product":
        words += ["--design", design.kind]
    if design.count is not None:
        words += ["--count", str(design.count), "--seed", str(design.seed)]
    if study.outputs != DEFAULT_OUTPUTS:
        words += [word for name in study.outputs for word in ("--output", name)]
    return shlex.join(words)


def _axis_text(axis: "Axis") -> str:
    from fivtui.sweeps import Range

    if not isinstance(axis, Range):
        return ",".join(map(number_text, axis))
    parts = [number_text(axis.start), number_text(axis.stop)]
    parts += [] if axis.count is None else [str(axis.count)]
    return ":".join([*parts, "log"] if axis.log else parts)


def figure_line(number: int) -> str:
    """The command that makes a figure of the paper and its data."""
    return f"fivtui figures {number} --out figures"


CLAIMS_LINE: Final = "fivtui claims"
