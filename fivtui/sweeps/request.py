"""What is asked of a sweep, read from text: ranges and lists of values, design, cases."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

from fivtui.model import InputError, unknown_name
from fivtui.ranges import parse_range
from fivtui.scene import Scene
from fivtui.transient import Start, check_horizon, check_tolerance

from .design import VARIABLES, Axis, Design, Kind, Range
from .study import DEFAULT_OUTPUTS, Study

_METHOD: Final = "taylor"


def parse_design(
    texts: Sequence[str], kind: Kind, count: int | None = None, seed: int | None = None
) -> Design:
    """Read a design.

    Parameters
    ----------
    texts : sequence of str
        ``NAME=START:STOP:COUNT``, with ``:log`` for logarithmic spacing, or ``NAME=V1,V2,…``; in
        random and Sobol designs ``NAME=START:STOP``, with ``:log`` for a logarithmic scale.
    kind : str
        A name in `fivtui.sweeps.design.KINDS`.
    count, seed : int, optional
        See `Design`.

    Returns
    -------
    Design
        The checked design.

    Raises
    ------
    InputError
        If a text has another form, a value is out of bounds, or a name appears twice.
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
    """Read which cases are asked for: separation considered, ignored, or both.

    Parameters
    ----------
    ignored, both : bool
        Whether ``--ignore-separation`` and ``--both`` are given.

    Returns
    -------
    tuple of bool or None
        As in `Study`; None for that of the scene.

    Raises
    ------
    InputError
        If both are given.
    """
    if ignored and both:
        raise InputError("--both: must be given without --ignore-separation")
    if both:
        return (True, False)
    return (False,) if ignored else None


def study_of(
    scene: Scene,
    design: Design,
    *,
    cases: tuple[bool, ...] | None = None,
    start: Start | None = None,
    t_end: float | str | None = None,
    tol: float | str | None = None,
    accuracy: Mapping[str, float] = MappingProxyType({}),
    outputs: Sequence[str] = (),
) -> Study:
    """The sweep of a scene.

    Parameters
    ----------
    scene : Scene
        What every member has in common.
    design : Design
        What varies.
    cases : tuple of bool, optional
        See `Study`; that of the scene if not given.
    start, t_end, tol : optional
        In place of those of the scene.
    accuracy : mapping of str to float, optional
        See `Study`; that of the scene if neither this nor `tol` is given.
    outputs : sequence of str
        See `Study`; all of the transient if none is given.

    Returns
    -------
    Study
        The checked sweep.

    Raises
    ------
    InputError
        If a value is not allowed, or the scene asks for another method than ``taylor``.
    """
    if scene.method != _METHOD:
        raise InputError(f"method = {scene.method}: sweeps are computed by {_METHOD} alone")
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
    )
