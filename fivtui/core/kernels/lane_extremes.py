"""Running extremes of the lanes, exact to rounding: `steps.include` on vectors."""

from typing import Any

import numpy as np

from . import rows
from .jit import inner
from .lane_steps import bounded_at, widened
from .polynomials import CALLER, widen
from .steps import EXTREMES, NO_EXTREMES, include_part
from .vectors import (
    LANES,
    behind,
    bits,
    choose,
    greatest,
    lanes_of,
    least,
    load_lanes,
    splat,
    store_lanes,
)


@inner
def _settle_range(
    w: Any, first: int, stride: int, size: int, h: float, low: int, high: int, lane: int
) -> None:
    # Exact extremes of a lane's polynomial, into its rows.
    scratch = behind(w, rows.SCRATCH)
    q = behind(scratch, CALLER)
    power = 1.0
    for n in range(size):
        q[n] = w[(first + stride * n) * LANES + lane] * power
        power *= h
    q[size] = 0.0
    least_value = w[low * LANES + lane] if low >= 0 else -np.inf
    found = widen(q, size, least_value, w[high * LANES + lane], scratch)
    if low >= 0:
        w[low * LANES + lane] = found[0]
    w[high * LANES + lane] = found[1]


@inner
def settle_half(w: Any, degree: int, lane: int, middle: float, h: float) -> None:
    """Take the step in which half the horizon lies into the extremes, which begin anew there."""
    c, row, scratch = behind(w, rows.SINGLE), behind(w, rows.ROW), behind(w, rows.SCRATCH)
    shifted = behind(w, rows.SHIFTED)
    for n in range(2 * degree + 2):
        c[n] = w[(rows.SERIES + n) * LANES + lane]
    for n in range(len(EXTREMES)):
        row[n] = w[(rows.SEEN + n) * LANES + lane]
    include_part(c, degree, 0.0, middle, row, scratch, shifted)
    for n in range(len(EXTREMES)):
        w[(rows.EARLIER + n) * LANES + lane] = row[n]
        row[n] = NO_EXTREMES[n]
    include_part(c, degree, middle, h, row, scratch, shifted)
    for n in range(len(EXTREMES)):
        w[(rows.SEEN + n) * LANES + lane] = row[n]


@inner
def observe_column(w: Any, degree: int, h: Any, column: int, ends: Any, wanted: int) -> None:
    """Take x (0) or y (1) over the steps into the extremes."""
    final, final_slope, bend, twist = ends
    low, high = load_lanes(w, rows.SEEN + column), load_lanes(w, rows.SEEN + 2 + column)
    start = load_lanes(w, rows.SERIES + column)
    below = least(start, final) - bend < low
    wanted &= bits(below | (greatest(start, final) + bend > high))
    if wanted == 0:
        return
    slope = load_lanes(w, rows.SERIES + 2 + column) * h
    low, high, doubtful = widened(
        w,
        rows.SERIES + column,
        2,
        degree,
        h,
        (start, final, slope, final_slope * h, twist),
        (low, high),
        wanted,
    )
    there = lanes_of(wanted)
    store_lanes(w, rows.SEEN + column, choose(there, low, load_lanes(w, rows.SEEN + column)))
    store_lanes(
        w, rows.SEEN + 2 + column, choose(there, high, load_lanes(w, rows.SEEN + 2 + column))
    )
    if doubtful != 0:
        store_lanes(w, rows.STEP, h)
        for lane in range(LANES):
            if doubtful >> lane & 1:
                duration = w[rows.STEP * LANES + lane]
                low_row, high_row = rows.SEEN + column, rows.SEEN + 2 + column
                first = rows.SERIES + column
                _settle_range(w, first, 2, degree + 1, duration, low_row, high_row, lane)


@inner
def observe_speed(w: Any, degree: int, h: Any, final: Any, twist: Any, wanted: int) -> None:
    """Take ẋ over the steps into its greatest value."""
    high = load_lanes(w, rows.VX_HIGH)
    start = load_lanes(w, rows.SERIES + 2)
    wanted &= bits(greatest(start, final) * h + twist > high * h)
    if wanted == 0:
        return
    for n in range(degree):
        store_lanes(w, rows.RATES + n, load_lanes(w, rows.SERIES + 2 * n + 2) * (n + 1.0))
    final, final_slope, _, twist = bounded_at(w, rows.RATES, 1, degree - 1, h)
    slope = load_lanes(w, rows.RATES + 1) * h
    ends = (start, final, slope, final_slope * h, twist)
    _, found, doubtful = widened(
        w, rows.RATES, 1, degree - 1, h, ends, (splat(-np.inf), high), wanted
    )
    store_lanes(w, rows.VX_HIGH, choose(lanes_of(wanted), found, high))
    if doubtful != 0:
        store_lanes(w, rows.STEP, h)
        for lane in range(LANES):
            if doubtful >> lane & 1:
                duration = w[rows.STEP * LANES + lane]
                _settle_range(w, rows.RATES, 1, degree, duration, -1, rows.VX_HIGH, lane)
