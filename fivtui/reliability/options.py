"""Options of ``fivtui uncertainty``.

A piece (`PIECE`) is the number of members that are computed and written at once.
"""

from typing import TYPE_CHECKING

from fivtui.model import Interval
from fivtui.options import ANY_INTEGER, option, option_field, options_class
from fivtui.sweeps import PIECE, SCHEDULER, WORKERS
from fivtui.transient import VARIABLES, setting

if TYPE_CHECKING:
    from fivtui.sweeps import ScatterKind


@options_class
class UncertaintyOptions:
    """Options of ``fivtui uncertainty``."""

    varied: tuple[str, ...] = option(
        "--vary",
        "Scatter a parameter, or x0, vx0, y0, vy0 of the start; may be repeated. "
        "uniform:LOW:HIGH, normal:MEAN:SD, lognormal:MEAN:SD (not of the logarithm), "
        "triangular:LOW:MODE:HIGH, beta:LOW:HIGH:A:B, or NAME:SHAPE:…:LOC:SCALE of scipy.stats; "
        "truncated at the bounds of the parameter. Adds to the table [scatter] of the scene, or "
        "replaces an entry.",
        metavar="NAME~DISTRIBUTION:…",
        multiple=True,
        completions=lambda: (f"{name}~" for name in VARIABLES),
    )
    samples: int | None = option(
        "--samples",
        "Number of samples, rounded up to a power of two in every scrambling.  [default: 16384]",
        metavar="N",
        integers=Interval(1),
    )
    until: str | None = option(
        "--until",
        "Double the samples until the ends of the 95 % interval of every probability are within E "
        "of its value.",
        metavar="E",
    )
    design: "ScatterKind" = option(
        "--design",
        "Scrambled Sobol sequences, or Latin hypercubes.",
        "sobol",
        choices=("sobol", "lhs"),
        show_default=True,
    )
    repeats: int = option(
        "--repeats",
        "Number of independent scramblings, whose differences give the intervals.",
        16,
        metavar="N",
        integers=Interval(1),
        show_default=True,
    )
    seed: int = option(
        "--seed",
        "First scrambling's seed.",
        0,
        metavar="S",
        integers=ANY_INTEGER,
        show_default=True,
    )
    indices: bool | None = option(
        "--indices/--no-indices",
        "Whether to compute Sobol indices.  [default: unless the scene correlates inputs]",
    )
    # A flag: separation is considered without it.
    ignore_separation: bool = setting("separation")
    t_end: str | None = setting("t_end")
    tol: str | None = setting("tol")
    start: str | None = setting("start")
    outputs: tuple[str, ...] = option(
        "--output",
        "An output to compute besides the growth rate, in place of the default ones (critical_mu, "
        "safe_mu, y_half_range, P_max); vibrates gives the probability that the run ends in "
        "vibration; may be repeated.",
        metavar="NAME",
        multiple=True,
    )
    workers: int | None = option_field(WORKERS)
    scheduler: str | None = option_field(SCHEDULER)
    piece: int | None = option_field(PIECE)
