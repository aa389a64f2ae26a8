"""A sweep's options, parsed from text, and the sweeps that come with the program."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from fivtui.model import InputError, unknown_name
from fivtui.ranges import parse_range
from fivtui.scene import Scene
from fivtui.transient import Start, check_horizon, check_tolerance

from .design import VARIABLES, Axis, Design, Kind, Range
from .scatter import StudyDesign
from .study import DEFAULT_OUTPUTS, Study


@dataclass(frozen=True, slots=True)
class SweepPreset:
    """A sweep that comes with the program."""

    description: str
    varied: tuple[str, ...]


SWEEP_PRESETS: Final[Mapping[str, SweepPreset]] = MappingProxyType(
    {
        "peak-over-belt-speed": SweepPreset(
            "beyond the paper: stick on slow belts; fast ones end in the paper's result",
            ("v_belt=0.1,0.2,0.5,1,2,3,5,7,10,12,14,16,18,20,22,24,26,30",),
        )
    }
)


def varied_texts(preset: str | None, texts: Sequence[str]) -> Sequence[str]:
    """What varies: as given, or as in a preset of this name.

    Raises `InputError` if neither or both are given, or the preset is unknown.
    """
    if preset is None:
        if not texts:
            raise InputError("--vary: must be given, or --preset")
        return texts
    if texts:
        raise InputError("--preset: must be given without --vary")
    if preset not in SWEEP_PRESETS:
        raise unknown_name("sweep", preset, SWEEP_PRESETS)
    return SWEEP_PRESETS[preset].varied


def parse_design(
    texts: Sequence[str], kind: Kind, count: int | None = None, seed: int | None = None
) -> Design:
    """Parse the texts of ``--vary``.

    They are ``NAME=START:STOP:COUNT[:log]`` or ``NAME=V1,V2,…``; in random and Sobol designs
    ``NAME=START:STOP[:log]``. Raises `InputError` as `Design`, or if a text has another form.
    """
    axes: dict[str, Axis] = {}
    for text in texts:
        name, axis = _parse_axis(text, sampled=kind in ("random", "sobol"))
        if name in axes:
            raise InputError(f"--vary {text}: {name} is given twice")
        axes[name] = axis
    return Design(axes, kind, count, seed)


def _parse_axis(text: str, *, sampled: bool) -> tuple[str, Axis]:
    name, equals, rest = text.partition("=")
    if equals and rest and ":" not in rest and not sampled:
        name = name.strip()
        if name not in VARIABLES:
            raise unknown_name("parameter", name, VARIABLES)
        return name, tuple(VARIABLES[name].check(part.strip()) for part in rest.split(","))
    given = parse_range("--vary", text, VARIABLES, counted=not sampled)
    return given.name, Range(given.start, given.stop, None if sampled else given.count, given.log)


def parse_cases(*, ignored: bool, both: bool) -> tuple[bool, ...] | None:
    """The cases of ``--ignore-separation`` and ``--both``, as in `Study`; None for the scene's."""
    if ignored and both:
        raise InputError("--both: must be given without --ignore-separation")
    if both:
        return (True, False)
    return (False,) if ignored else None


def study_of(
    scene: Scene,
    design: StudyDesign,
    *,
    cases: tuple[bool, ...] | None = None,
    start: Start | None = None,
    t_end: float | str | None = None,
    tol: float | str | None = None,
    accuracy: Mapping[str, float] = MappingProxyType({}),
    outputs: Sequence[str] = (),
    method: str | None = None,
) -> Study:
    """The study of a scene; what is given replaces the scene's settings, see `Study`.

    An `accuracy` replaces the tolerance, and a `tol` the scene's accuracy. Raises `InputError` as
    `Study`.
    """
    if accuracy and tol is not None:
        raise InputError("--error: must be given without --tol, which follows from it")
    return Study(
        design=design,
        parameters=scene.parameters,
        cases=(scene.separation,) if cases is None else cases,
        start=scene.start if start is None else start,
        t_end=scene.t_end if t_end is None else check_horizon(t_end),
        tol=scene.tol if tol is None else check_tolerance(tol),
        accuracy=tuple(accuracy.items()) or (scene.accuracy if tol is None else ()),
        outputs=tuple(outputs) or DEFAULT_OUTPUTS,
        method=scene.method if method is None else method,
        over_time=scene.over_time,
    )
