"""Options of ``fivtui sweep``, its presets, and options shared with uncertainty studies.

The paper is "Nonlinear friction-induced vibration of a slider-belt system".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from fivtui.model import InputError, Interval, check_known
from fivtui.options import (
    ANY_INTEGER,
    COMPUTATION,
    SCENE,
    Option,
    flag,
    option,
    option_field,
    options_class,
)
from fivtui.transient import OVER_TIME, VARIABLES, setting

if TYPE_CHECKING:
    from .design import DesignKind


@dataclass(frozen=True, slots=True)
class SweepPreset:
    """A sweep that comes with the program."""

    description: str
    varied: tuple[str, ...]


SWEEP_PRESETS: Final[Mapping[str, SweepPreset]] = MappingProxyType(
    {
        "peak-over-belt-speed": SweepPreset(
            "beyond the paper: stick on slow belts, the result of the paper on fast belts",
            ("v_belt=0.1,0.2,0.5,1,2,3,5,7,10,12,14,16,18,20,22,24,26,30",),
        )
    }
)


# Options for how members are computed and stored, shared with uncertainty studies.
WORKERS: Final = Option(
    flag="--workers",
    metavar="N",
    help="Number of threads.  [default: all processors]",
    integers=ANY_INTEGER,
    group=COMPUTATION,
)
SCHEDULER: Final = Option(
    flag="--scheduler",
    metavar="ADDRESS",
    help="Address of a Dask cluster to compute on.",
    group=COMPUTATION,
)
PIECE: Final = Option(
    flag="--piece",
    metavar="N",
    help="Number of members per stored piece.  [default: about a second of work]",
    integers=Interval(1),
    group=COMPUTATION,
)


@options_class
class SweepOptions:
    """Options of ``fivtui sweep``."""

    varied: tuple[str, ...] = option(
        "--vary",
        "Vary a parameter, or x0, vx0, y0, vy0 of the start; may be repeated. NAME=V1,V2,… gives "
        "single values; designs random and sobol take NAME=START:STOP[:log].",
        metavar="NAME=START:STOP:COUNT[:log]",
        multiple=True,
        completions=lambda: (f"{name}=" for name in VARIABLES),
    )
    preset: str | None = option(
        "--preset",
        "Use the variations of a built-in sweep: peak-over-belt-speed.",
        metavar="NAME",
        completions=lambda: SWEEP_PRESETS,
    )
    design: "DesignKind" = option(
        "--design",
        "product: all combinations; list: first values, then second values, …; random, sobol: "
        "--count points between START and STOP.",
        "product",
        choices=("product", "list", "random", "sobol"),
        show_default=True,
    )
    count: int | None = option(
        "--count", "Number of points of random and sobol.", metavar="N", integers=ANY_INTEGER
    )
    seed: int | None = option(
        "--seed",
        "Seed of random, sobol and --starts.  [default: 0]",
        metavar="S",
        integers=ANY_INTEGER,
    )
    # The flag turns the setting, which is on by default, off.
    ignore_separation: bool = setting("separation")
    starts: int | None = option(
        "--starts",
        "Number of random starts around the equilibrium from which to compute vibrates, instead of "
        "the start of the scene; adds its interval and the number of undecided starts.",
        metavar="N",
        integers=Interval(1),
    )
    both: bool = flag(
        "--both", "Compute each member with separation considered and ignored.", group=SCENE
    )
    t_end: str | None = setting("t_end")
    tol: str | None = setting("tol")
    error: tuple[str, ...] = setting(
        "accuracy",
        "Error target in place of --tol: refine each member until the error of QUANTITY is below "
        "R. QUANTITY: final (state), peak or half_range (half peak-to-peak over the second half of "
        "the run).",
    )
    start: str | None = setting("start")
    method: str | None = setting(
        "method",
        "taylor, or a run of the FMU per member: fmu (Python), fmu-native (compiled).  "
        "[default: the scene's]",
    )
    over_time: Path | None = option_field(OVER_TIME)
    outputs: tuple[str, ...] = option(
        "--output",
        "Compute only this output; may be repeated. In m: y_abs (peak), y_max, y_min, x_abs, "
        "y_half_range (second half of the run), x_end, y_end; in m/s: vx_max, vx_end, vy_end; in "
        "N: P_min, P_max; in s: separated_time (off the belt, summed over the run), stick_time, "
        "final_stick (its beginning); in 1/s: growth_rate; numbers: separations, reattachments, "
        "sticks, critical_mu (below it small disturbances die out), safe_mu (least μ on the branch "
        "of limit cycles from the Hopf point, without the search of stability and maps beside it), "
        "vibrates (share of starts that end in vibration), vibrates_low, vibrates_high (its 95 % "
        "interval), undecided (starts); yes or no: stable.",
        metavar="NAME",
        multiple=True,
    )
    workers: int | None = option_field(WORKERS)
    scheduler: str | None = option_field(SCHEDULER)
    piece: int | None = option_field(PIECE)


def varied_texts(preset: str | None, texts: Sequence[str]) -> Sequence[str]:
    """The texts of ``--vary``, or those of the preset.

    Raises `InputError` if neither or both are given, or the preset is unknown.
    """
    if preset is None:
        if not texts:
            raise InputError("--vary: must be given, or --preset")
        return texts
    if texts:
        raise InputError("--preset: must be given without --vary")
    check_known("sweep", preset, SWEEP_PRESETS)
    return SWEEP_PRESETS[preset].varied
