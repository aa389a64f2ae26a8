"""What the sweep tab computes and shows: amplitudes over a parameter. Imports no Textual."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.core.errors import InputError
from fivtui.core.parameters import PARAMETERS
from fivtui.scene import Scene

from .chart import Chart, Found, Guide, Trace
from .fields import CONSIDERED, IGNORED
from .nudges import number_text

if TYPE_CHECKING:
    from fivtui.core.study import Study
    from fivtui.core.sweep import Rows

FloatArray = NDArray[np.float64]

EXAMPLE: Final = "F=10:120:56"
# Members that are computed before their points are shown.
_PIECE: Final = 16
_CASES: Final = {True: CONSIDERED, False: IGNORED}
_OUTPUTS: Final = {"y_abs": "peak", "y_half_range": "steady"}
_MARKS: Final = {
    ("y_abs", True): "●",
    ("y_abs", False): "○",
    ("y_half_range", True): "◆",
    ("y_half_range", False): "◇",
}


@dataclass(frozen=True, slots=True, eq=False)
class SweepPoints:
    """What is known of a sweep by now.

    Attributes
    ----------
    name : str
        The parameter that varies.
    values : dict of ((str, bool), (ndarray, ndarray))
        By output and case: the parameter, ascending, and the amplitude, m; NaN where a member
        failed.
    failed : int
        How many members failed.
    reason : str
        Why the first of them did.
    """

    name: str
    values: dict[tuple[str, bool], tuple[FloatArray, FloatArray]]
    failed: int
    reason: str

    @property
    def count(self) -> int:
        """How many members are computed."""
        return sum(x.size for (name, _), (x, _) in self.values.items() if name == "y_abs")


def sweep_request(scene: Scene, text: str) -> "Study":
    """Read what is to be swept.

    Parameters
    ----------
    scene : Scene
        What every member has in common.
    text : str
        One parameter: ``NAME=START:STOP:COUNT``, ``…:log``, or ``NAME=V1,V2,…``.

    Returns
    -------
    Study
        Both cases of every value.

    Raises
    ------
    InputError
        If the text or the scene will not do.
    """
    from fivtui.sweep_request import parse_design, study_of

    try:
        design = parse_design([text.strip()], "product")
    except InputError as error:
        raise InputError(str(error).replace("--vary ", "")) from None
    (name,) = design.axes
    if name not in PARAMETERS:
        raise InputError(f"{name}: allowed is a parameter: {', '.join(PARAMETERS)}")
    return study_of(scene, design, cases=tuple(_CASES), outputs=tuple(_OUTPUTS))


def sweep_parts(study: "Study", progress: Callable[[float], bool]) -> Iterator["Rows"]:
    """Compute a sweep part by part.

    Parameters
    ----------
    study : Study
        The sweep.
    progress : callable
        Called with the fraction done; the sweep is cancelled when it returns False.

    Yields
    ------
    Rows
        The next members.

    Raises
    ------
    Cancelled
        If `progress` returned False.
    """
    from fivtui.core.sweep import compute_rows

    members = study.members
    for first in range(0, members, _PIECE):
        last = min(first + _PIECE, members)

        def within(fraction: float, first: int = first, last: int = last) -> bool:
            return progress((first + fraction * (last - first)) / members)

        yield compute_rows(study, first, last, within)


def points_of(name: str, parts: Sequence["Rows"]) -> SweepPoints:
    """The points of all parts.

    Parameters
    ----------
    name : str
        The parameter that varies.
    parts : sequence of Rows
        At least one.

    Returns
    -------
    SweepPoints
        Ascending, whatever the order of the sweep.
    """
    from fivtui.core.sweep import joined

    rows = joined(list(parts))
    along = rows.numbers[name]
    order = np.argsort(along, kind="stable")
    values = {}
    for case in _CASES:
        own = order[rows.separation[order] == case]
        for output in _OUTPUTS:
            values[output, case] = along[own], rows.numbers[output][own]
    reason = next((reason for reason in rows.reasons if reason), "")
    return SweepPoints(name, values, rows.failed, reason)


def sweep_chart(points: SweepPoints, now: float | None) -> Chart:
    """Peak and steady half range over the parameter, for both cases.

    Parameters
    ----------
    points : SweepPoints
        What is known.
    now : float or None
        The value of the parameter that is edited.

    Returns
    -------
    Chart
        Four traces.
    """
    traces = []
    for (output, case), (x, y) in points.values.items():
        name, mark = f"{_OUTPUTS[output]} {_CASES[case]}", _MARKS[output, case]
        traces.append(Trace(name, x, y, look="marked", mark=mark))
    guides = () if now is None else (Guide(now, f"{now:g}"),)
    unit = PARAMETERS[points.name].unit
    label = f"{points.name} / {unit}" if unit else points.name
    return Chart(label, "amplitude of y / m", tuple(traces), guides=guides, tight=False)


def point_texts(points: SweepPoints, point: Found) -> dict[str, str]:
    """The fields' texts of a point.

    Parameters
    ----------
    points : SweepPoints
        The sweep.
    point : Found
        A point of its chart.

    Returns
    -------
    dict of str
        The parameter, and whether separation is considered.
    """
    _, case = list(points.values)[point.trace]
    return {points.name: number_text(point.x), "separation": _CASES[case]}


def count_words(points: SweepPoints) -> str:
    """How many members there are, and what became of those that failed."""
    words = f"{points.count} transients"
    if points.failed:
        words += f", {points.failed} not finished: {points.reason}"
    return words
