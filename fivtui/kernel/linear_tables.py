"""Linear motions: their coefficients all at once, from a table that is made once a run.

Off the belt, and in a contact without a cubic term, the coefficients from the second degree on are
linear in the velocities and accelerations at the start of a step. They need not wait for one
another, as they do in the recurrences that fill the table.
"""

from typing import Any, Final

from fivtui.taylor import MAX_ORDER, Constants

from .expansion import GROUP, ROWS, expand_linear
from .jit import inner, part
from .steps import is_finite
from .vectors import LANES, behind, load_lanes, splat, store_lanes

# For every group of rows there are the vectors that belong to ẋ, ẏ, ẍ and ÿ.
_INPUTS: Final = 4
TABLE_SIZE: Final = _INPUTS * 2 * MAX_ORDER
_CONSTANTS: Final = len(Constants._fields)
_LOAD: Final = Constants._fields.index("load")


@part
def constants_of(given: Any) -> Any:
    """The constants of a mode as values: what is made of them alone is made once a run."""
    return (
        given[0],
        given[1],
        given[2],
        given[3],
        given[4],
        given[5],
        given[6],
        given[7],
        given[8],
    )


@inner
def tabulate(table: Any, given: Any, order: int, work: Any) -> bool:
    """Fill the table of a mode; returns whether all of it is finite.

    `work` has room for two series of coefficients.
    """
    rates, unloaded = work, behind(work, 2 * ROWS)
    for n in range(_CONSTANTS):
        unloaded[n] = given[n]
    # The rates of change of a linear motion follow the same field without the load.
    unloaded[_LOAD] = 0.0
    total = 0.0
    for one in range(_INPUTS):
        for n in range(_INPUTS):
            rates[n] = 1.0 if n == one else 0.0
        expand_linear(rates, unloaded, order)
        for n in range(2 * order):
            group, place = n // LANES, n % LANES
            share = rates[n + 2] / (n // 2 + 2)
            table[(_INPUTS * group + one) * LANES + place] = share
            total += abs(share)
    return is_finite(total)


@part
def expand_tabulated(c: Any, given: Any, table: Any, tabulated: bool, order: int) -> None:
    """Continue the first two coefficients to an order, by the recurrences if there is no table."""
    if not tabulated:
        expand_linear(c, given, order)
        return
    xx, xy, yx, yy, xvx, yvy, _, _, load = constants_of(given)
    x, y, vx, vy = c[0], c[1], c[2], c[3]
    ax, ay = splat(xx * x + xy * y + xvx * vx), splat((yx * x + yy * y - load) + yvy * vy)
    rx, ry = splat(vx), splat(vy)
    groups = behind(c, 4)
    for k in range(order // GROUP):
        term = load_lanes(table, _INPUTS * k) * rx + load_lanes(table, _INPUTS * k + 1) * ry
        more = load_lanes(table, _INPUTS * k + 2) * ax + load_lanes(table, _INPUTS * k + 3) * ay
        store_lanes(groups, k, term + more)
