"""What a step does to a block of lanes, after the expansion and between the searches.

A block's part is done for all blocks before the next part is begun: most of these are chains of
operations that wait for each other, and those of several blocks overlap.
"""

from typing import Any, Final

from fivtui.model import BALANCED, LEAST
from fivtui.taylor import LONGEST_STEP, MAX_STALLED, SHORTEST_FLIGHT

from . import rows
from .jit import inner
from .lane_steps import SHARING, bounded_at, hull, hull_of_share, slope_bound, step_sizes, values_at
from .vectors import (
    LANES,
    absolute,
    behind,
    bits,
    choose,
    greatest,
    lanes_of,
    least,
    load_lanes,
    negated,
    splat,
    store_lanes,
)

# The shortest flight that advances, as a part of the longest step.
_SHORTEST: Final = SHORTEST_FLIGHT / LONGEST_STEP


@inner
def set_steps(w: Any, t_end: float, tol: float, degree: int) -> None:
    """Choose the lengths of the steps; the horizon ends the last."""
    h = step_sizes(
        behind(w, rows.SERIES * LANES),
        degree,
        tol,
        load_lanes(w, rows.DEFLECTION),
        load_lanes(w, rows.FREQUENCY),
        load_lanes(w, rows.LONGEST),
    )
    ahead = (t_end - load_lanes(w, rows.T)) - load_lanes(w, rows.REST)
    store_lanes(w, rows.STEP, least(h, ahead))


@inner
def step_y(w: Any, degree: int) -> None:
    """Go to the ends of the steps in y."""
    h = load_lanes(w, rows.STEP)
    y, vy, off = bounded_at(behind(w, rows.SERIES * LANES), 1, 2, degree, h)
    store_lanes(w, rows.Y, y)
    store_lanes(w, rows.VY, vy)
    store_lanes(w, rows.Y_OFF, off)


@inner
def may_switch(w: Any) -> int:
    """The lanes in whose steps there may be a switch."""
    h, side, off = load_lanes(w, rows.STEP), load_lanes(w, rows.SIDE), load_lanes(w, rows.Y_OFF)
    start, slope = load_lanes(w, rows.SERIES + 1), load_lanes(w, rows.SERIES + 3) * h
    final, last_slope = load_lanes(w, rows.Y), load_lanes(w, rows.VY) * h
    bottom, top = hull(start, slope, final, last_slope)
    inside = choose(side > 0.0, bottom, splat(0.0) - top) > off
    # After a switch y starts from zero: then all this is about y/θ.
    bottom, top = hull_of_share(slope, final, last_slope)
    away = choose(side > 0.0, bottom, splat(0.0) - top) > off * SHARING
    far = (inside & (start != 0.0)) | (away & (start == 0.0))
    return bits((load_lanes(w, rows.GUARDED) > 0.0) & negated(far))


@inner
def step_x(w: Any, degree: int, bounded: bool) -> None:
    """Go to the ends of the steps in x, with bounds if these are wanted."""
    c, h = behind(w, rows.SERIES * LANES), load_lanes(w, rows.STEP)
    if bounded:
        x, vx, off = bounded_at(c, 0, 2, degree, h)
        store_lanes(w, rows.X_OFF, off)
        store_lanes(w, rows.VX_OFF, slope_bound(c, 0, 2, degree, h))
    else:
        x, vx = values_at(c, 0, 2, degree, h)
    store_lanes(w, rows.X, x)
    store_lanes(w, rows.VX, vx)


@inner
def is_sound(w: Any) -> int:
    """The lanes in which the end of the step is finite."""
    total = (load_lanes(w, rows.X) + load_lanes(w, rows.Y)) + (
        load_lanes(w, rows.VX) + load_lanes(w, rows.VY)
    )
    return bits((total - total == 0.0) & (load_lanes(w, rows.STEP) > 0.0))


@inner
def _switch(w: Any, end: Any, cut: Any, going: Any) -> None:
    # Change the mode of the lanes that are `cut` at a root, by the first derivative that is not 0.
    x, vx, vy = load_lanes(w, rows.X), load_lanes(w, rows.VX), load_lanes(w, rows.VY)
    side = load_lanes(w, rows.SIDE)
    coupling = load_lanes(w, rows.COUPLING)
    held, preload = coupling * x, load_lanes(w, rows.PRELOAD)
    pull = held - preload
    rounding = (absolute(held) + absolute(preload)) * BALANCED
    pull = choose(absolute(pull) > greatest(rounding, splat(LEAST)), pull, 0.0)
    push = coupling * vx
    third = choose(absolute(push) > LEAST, push, splat(0.0) - coupling * x)
    direction = choose(vy != 0.0, vy, choose(pull != 0.0, pull, third))
    new_side = choose(cut, choose(direction > 0.0, 1.0, -1.0), side)
    switched = (new_side != side) & going
    lifted = choose(switched & (side < 0.0), 1.0, 0.0)
    landed = choose(switched & (side > 0.0), 1.0, 0.0)
    lifts, landings = load_lanes(w, rows.LIFTS), load_lanes(w, rows.LANDINGS)
    none_yet = switched & (lifts + landings == 0.0)
    store_lanes(w, rows.LIFTS, lifts + lifted)
    store_lanes(w, rows.LANDINGS, landings + landed)
    store_lanes(w, rows.FIRST, choose(none_yet, end, load_lanes(w, rows.FIRST)))
    store_lanes(w, rows.LAST, choose(switched, end, load_lanes(w, rows.LAST)))
    store_lanes(w, rows.SIDE, new_side)
    off = new_side > 0.0
    contact = rows.CONTACT
    xy, yy = load_lanes(w, contact + rows.XY), load_lanes(w, contact + rows.YY)
    store_lanes(w, rows.XY, choose(off, load_lanes(w, rows.XY_OFF), xy))
    store_lanes(w, rows.YY, choose(off, load_lanes(w, rows.YY_OFF), yy))
    store_lanes(w, rows.CUBIC, choose(off, 0.0, load_lanes(w, contact + rows.CUBIC)))


@inner
def go_on(w: Any, t_end: float, rooted: int, live: int, max_steps: float) -> Any:
    """End the steps of the lanes that are live, `rooted` ones at a switch.

    Returns the lanes that are at the end of the horizon, that stall, and that have made too many
    steps.
    """
    t, rest, h = load_lanes(w, rows.T), load_lanes(w, rows.REST), load_lanes(w, rows.STEP)
    cut, going = lanes_of(rooted), lanes_of(live)
    reached = negated(h < (t_end - t) - rest) & negated(cut)
    increment = h + rest
    end = t + increment
    lost = end - t
    new_rest = (t - (end - lost)) + (increment - lost)
    last = reached | (end >= t_end)
    end = choose(last, t_end, end)
    part = choose((load_lanes(w, rows.SIDE) > 0.0) & going, h, 0.0) + load_lanes(w, rows.AIR_REST)
    air = load_lanes(w, rows.AIR)
    longer = air + part
    store_lanes(w, rows.AIR_REST, part - (longer - air))
    store_lanes(w, rows.AIR, longer)
    if rooted != 0:
        _switch(w, end, cut, going)
    made = load_lanes(w, rows.STEPS) + choose(going, 1.0, 0.0)
    short = cut & (h < load_lanes(w, rows.LONGEST) * _SHORTEST)
    stuck = choose(short | (end == t), load_lanes(w, rows.STUCK) + 1.0, 0.0)
    store_lanes(w, rows.STEPS, made)
    store_lanes(w, rows.STUCK, stuck)
    store_lanes(w, rows.T, choose(going, end, t))
    store_lanes(w, rows.REST, new_rest)
    for n, row in enumerate((rows.X, rows.Y, rows.VX, rows.VY)):
        old = load_lanes(w, rows.SERIES + n)
        store_lanes(w, rows.SERIES + n, choose(going, load_lanes(w, row), old))
    ended = live & bits(last)
    stalled = live & bits(stuck > float(MAX_STALLED))
    return ended, stalled, live & bits(made >= max_steps)
