"""Where the numbers of the lanes stand: the columns of problems and results, the rows of the work.

A row is one number of all lanes, side by side.
"""

from typing import Final, NamedTuple

from fivtui.taylor import Constants

from .expansion import ROWS
from .steps import EXTREMES, SCRATCH as STEP_SCRATCH
from .vectors import LANES


class Member(NamedTuple):
    """Columns of the problems: what a lane keeps of its parameter set, SI units."""

    xx: float
    xy: float
    yx: float
    yy: float
    xvx: float
    yvy: float
    friction: float
    cubic: float
    load: float
    xy_off: float
    yy_off: float
    coupling: float
    preload: float
    deflection: float
    frequency: float
    longest: float
    separation: float
    x: float
    vx: float
    y: float
    vy: float


class Outcome(NamedTuple):
    """Columns of the results, SI units; `y_low` and `y_high` are of the second half."""

    x: float
    vx: float
    y: float
    vy: float
    t: float
    status: float
    steps: float
    separations: float
    reattachments: float
    separated: float
    first: float
    last: float
    x_min: float
    y_min: float
    x_max: float
    y_max: float
    vx_max: float
    y_low: float
    y_high: float


MEMBER_COLUMNS: Final = len(Member._fields)
OUTCOME_COLUMNS: Final = len(Outcome._fields)
# Blocks of lanes that are stepped side by side: enough of them to fill the queues, few enough for
# the cache next to the processor.
BLOCKS: Final = 6
PLACES: Final = BLOCKS * LANES
# Rows of a block: the constants that the recurrences are given, then those of the problem, …
CONSTANTS: Final = len(Constants._fields)
CONTACT: Final = CONSTANTS
XY, YY, CUBIC = (Constants._fields.index(name) for name in ("xy", "yy", "cubic"))
FIXED: Final = MEMBER_COLUMNS - 4
XY_OFF, YY_OFF, COUPLING, PRELOAD, DEFLECTION, FREQUENCY, LONGEST, GUARDED = (
    CONTACT + Member._fields.index(name) for name in Member._fields[CONSTANTS:FIXED]
)
# … then what changes from step to step, …
MOVING: Final = CONTACT + FIXED
T, REST, SIDE, STEPS, STUCK, LIFTS, LANDINGS, AIR, AIR_REST, FIRST, LAST = range(
    MOVING, MOVING + 11
)
# … the extremes in this half of the horizon and in the first, …
SEEN: Final = MOVING + 11
EARLIER: Final = SEEN + len(EXTREMES)
X_LOW, Y_LOW, X_HIGH, Y_HIGH, VX_HIGH = range(SEEN, EARLIER)
# … a step: its length, its end, and how far x, y and ẋ may leave their chords, …
STEP: Final = EARLIER + len(EXTREMES)
X, Y, VX, VY, X_OFF, Y_OFF, VX_OFF = range(STEP + 1, STEP + 8)
# … and the coefficients of x and y.
SERIES: Final = STEP + 8
BLOCK: Final = (SERIES + 2 * ROWS) * LANES
# Rows of a queue of steps, of which the first switch or an extremum is wanted: where a step comes
# from, its length, side and end, or which extreme is wanted and those seen, and the coefficients.
PLACE, LENGTH, ASIDE, FINAL, FINAL_SLOPE = range(5)
EXTREME, LOW, HIGH = range(2, 5)
QUEUED: Final = 5
ROOTS: Final = BLOCKS * BLOCK
CRESTS: Final = ROOTS + (QUEUED + ROWS) * LANES
# One lane's series and extremes, for the code that knows no lanes.
SINGLE: Final = CRESTS + (QUEUED + ROWS) * LANES
SHIFTED: Final = SINGLE + 2 * ROWS
ROW: Final = SHIFTED + 2 * ROWS
SCRATCH: Final = ROW + LANES
WORK_SIZE: Final = SCRATCH + STEP_SCRATCH
