"""Options of ``fivtui validate``.

Quantities are columns of a trajectory: displacements, velocities, and the contact force P.
"""

from pathlib import Path
from typing import Final

from fivtui.options import Option, option, option_field, options_class
from fivtui.transient import RunOptions

_DATA: Final = "Measured data"
# Options of all commands that read measured data.
TIME: Final = Option(
    flag="--time",
    help="Time column, by name or number; by default t, time or the first.",
    metavar="NAME|N",
    group=_DATA,
)
SCALE: Final = Option(
    flag="--scale", help="Factor from the signal to SI units.", metavar="N", group=_DATA
)
TIME_SCALE: Final = Option(
    flag="--time-scale", help="Factor from the time column to seconds.", metavar="N", group=_DATA
)
_TOLERANCES: Final = "Tolerances"


@options_class
class ValidateOptions(RunOptions):
    """Options of ``fivtui validate``."""

    measured: Path | None = option(
        "--measured", "The measured data.", metavar="FILE.csv", file=True, group=_DATA
    )
    time: str = option_field(TIME, "")
    signal: str = option(
        "--signal",
        "Column of the signal; by default the column named as --quantity, else the second.",
        "",
        metavar="NAME|N",
        group=_DATA,
    )
    quantity: str = option(
        "--quantity",
        "Measured quantity: x, vx, y, vy or P.",
        "y",
        metavar="NAME",
        show_default=True,
        group=_DATA,
    )
    scale: str | None = option_field(SCALE)
    offset: str | None = option(
        "--offset", "Added to the scaled signal, in SI units.", metavar="N", group=_DATA
    )
    time_scale: str | None = option_field(TIME_SCALE)
    shift: str = option(
        "--shift",
        "Added to the measured times, s; auto: the shift of highest correlation.",
        "0",
        metavar="S|auto",
        show_default=True,
        group=_DATA,
    )
    band: str | None = option(
        "--band",
        "Half width of the tolerance band, in SI units or in percent of the run's half "
        "peak-to-peak.",
        metavar="N|N%",
        group=_TOLERANCES,
    )
    share: str | None = option(
        "--share",
        "Required share of samples in the band; by default 100 %.",
        metavar="N%",
        group=_TOLERANCES,
    )
    frequency: str | None = option(
        "--frequency",
        "Allowed relative deviation of the frequency.",
        metavar="N%",
        group=_TOLERANCES,
    )
    amplitude: str | None = option(
        "--amplitude",
        "Allowed relative deviation of half peak-to-peak.",
        metavar="N%",
        group=_TOLERANCES,
    )
