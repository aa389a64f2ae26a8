"""Options of ``fivtui identify``."""

from pathlib import Path
from typing import Final

from fivtui.measured import SCALE, TIME, TIME_SCALE
from fivtui.options import option, option_field, options_class
from fivtui.transient import VARIABLES, setting

_DATA: Final = "Measured data"


@options_class
class IdentifyOptions:
    """Options of ``fivtui identify``."""

    measured: tuple[Path, ...] = option(
        "--measured",
        "A measured record; may be repeated.",
        metavar="FILE.csv",
        multiple=True,
        file=True,
        group=_DATA,
    )
    signal: tuple[str, ...] = option(
        "--signal",
        "Measured quantity, x, vx, y, vy or P, and its column; may be repeated.  [default: y]",
        metavar="NAME[=COLUMN]",
        multiple=True,
        group=_DATA,
    )
    time: str = option_field(TIME, "")
    scale: str | None = option_field(SCALE)
    time_scale: str | None = option_field(TIME_SCALE)
    noise: str | None = option(
        "--noise",
        "Standard deviation of the noise, SI unit; by default estimated from the residuals.",
        metavar="S",
        group=_DATA,
    )
    target: tuple[str, ...] = option(
        "--target",
        "A measured feature and its standard deviation: frequency, growth-rate, critical-mu, "
        "half-range or cycle-frequency; may be repeated.",
        metavar="NAME=VALUE±SD",
        multiple=True,
        group=_DATA,
    )
    fit: tuple[str, ...] = option(
        "--fit",
        "A parameter, or x0, vx0, y0, vy0 of the start, within bounds; may be repeated.",
        metavar="NAME[=LOW:HIGH]",
        multiple=True,
        completions=lambda: VARIABLES,
    )
    own: tuple[str, ...] = option(
        "--own",
        "As --fit, with a value for each record.",
        metavar="NAME[=LOW:HIGH]",
        multiple=True,
    )
    ignore_separation: bool = setting("separation")
    start: str | None = setting("start")
