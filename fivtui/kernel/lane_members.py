"""How problems come into the lanes, move among them, and leave them with a result."""

from typing import Any, Final

import numpy as np

from . import rows
from .jit import inner
from .steps import EXTREMES, NO_EXTREMES, mode_after
from .vectors import LANES, behind

# Positions and velocities of x and y, the first coefficients.
_STATE: Final = 4


@inner
def lane_of(work: Any, place: int) -> Any:
    """The memory of one lane, its rows `LANES` apart."""
    return behind(work, place // LANES * rows.BLOCK + place % LANES)


@inner
def begin(work: Any, place: int, member: Any) -> None:
    """Put a problem into a lane."""
    w = lane_of(work, place)
    for n in range(rows.FIXED):
        w[(rows.CONTACT + n) * LANES] = member[n]
    for n in range(rows.CONSTANTS):
        w[n * LANES] = member[n]
    for n in range(rows.MOVING, rows.STEP):
        w[n * LANES] = 0.0
    w[rows.FIRST * LANES] = w[rows.LAST * LANES] = np.nan
    for n in range(len(EXTREMES)):
        w[(rows.SEEN + n) * LANES] = NO_EXTREMES[n]
        w[(rows.EARLIER + n) * LANES] = NO_EXTREMES[n]
    x, vx, y, vy = (
        member[rows.FIXED],
        member[rows.FIXED + 1],
        member[rows.FIXED + 2],
        member[rows.FIXED + 3],
    )
    series = behind(w, rows.SERIES * LANES)
    series[0], series[LANES], series[2 * LANES], series[3 * LANES] = x, y, vx, vy
    above = y > 0.0
    if y == 0.0:
        coupling, preload = w[rows.COUPLING * LANES], w[rows.PRELOAD * LANES]
        above = mode_after(x, vx, vy, coupling, preload) == 0
    w[rows.SIDE * LANES] = -1.0
    if above and w[rows.GUARDED * LANES] > 0.0:
        w[rows.SIDE * LANES] = 1.0
        w[rows.XY * LANES], w[rows.YY * LANES] = w[rows.XY_OFF * LANES], w[rows.YY_OFF * LANES]
        w[rows.CUBIC * LANES] = 0.0


@inner
def end(work: Any, place: int, status: int, outcome: Any) -> None:
    """Write the result of a lane and empty it."""
    w = lane_of(work, place)
    series = behind(w, rows.SERIES * LANES)
    outcome[0], outcome[1] = series[0], series[2 * LANES]
    outcome[2], outcome[3] = series[LANES], series[3 * LANES]
    outcome[4], outcome[5] = w[rows.T * LANES], status
    outcome[6] = w[rows.STEPS * LANES]
    outcome[7], outcome[8] = w[rows.LIFTS * LANES], w[rows.LANDINGS * LANES]
    outcome[9] = w[rows.AIR * LANES]
    outcome[10], outcome[11] = w[rows.FIRST * LANES], w[rows.LAST * LANES]
    for n in range(len(EXTREMES)):
        one, other = w[(rows.SEEN + n) * LANES], w[(rows.EARLIER + n) * LANES]
        outcome[12 + n] = min(one, other) if n < 2 else max(one, other)
    outcome[17], outcome[18] = w[rows.Y_LOW * LANES], w[rows.Y_HIGH * LANES]
    _empty(w)


@inner
def move(work: Any, source: int, target: int) -> None:
    """Move a problem into another lane."""
    w, other = lane_of(work, source), lane_of(work, target)
    for n in range(rows.STEP):
        other[n * LANES] = w[n * LANES]
    for n in range(rows.SERIES, rows.SERIES + _STATE):
        other[n * LANES] = w[n * LANES]
    _empty(w)


@inner
def _empty(w: Any) -> None:
    # What has no problem stands still.
    for n in range(rows.STEP):
        w[n * LANES] = 0.0
    for n in range(rows.SERIES, rows.SERIES + _STATE):
        w[n * LANES] = 0.0
    w[rows.LONGEST * LANES] = 1.0
