"""Options of the commands that compute one run.

Each field is an option: of a setting of scenes (`setting`), of one command (`option`), or an
`Option` that several commands share (`option_field`).
"""

from pathlib import Path
from typing import Final

from fivtui.model import ALL_PARAMETERS, Interval
from fivtui.options import OUTPUT, SCENE, Option, option, option_field, options_class

from .table import setting

_START_HELP: Final = "Start state, m and m/s; static: at rest at the equilibrium of μ = 0."

OVER_TIME: Final = Option(
    flag="--over-time",
    metavar="FILE.csv",
    help="Parameters over time: columns time (s) and F, mu, k2, …",
    # The value is the name of an input file.
    file=True,
    group=SCENE,
)


@options_class
class RunOptions:
    """Options of commands that analyse one run."""

    # A flag that sets `separation` to false.
    ignore_separation: bool = setting("separation")
    t_end: str | None = setting("t_end")
    method: str | None = setting("method")
    tol: str | None = setting("tol")
    step: str | None = setting("step")
    start: str | None = setting("start", _START_HELP)
    over_time: Path | None = option_field(OVER_TIME)


@options_class
class SimulateOptions:
    """Options of ``fivtui simulate``."""

    ignore_separation: bool = setting("separation")
    t_end: str | None = setting("t_end")
    method: str | None = setting(
        "method", "Integration method: taylor, rk4, scipy-dop853, … (see fivtui methods)."
    )
    tol: str | None = setting("tol")
    step: str | None = setting("step")
    error: tuple[str, ...] = setting("accuracy")
    start: str | None = setting("start", _START_HELP)
    sensitivities: tuple[str, ...] = option(
        "--sensitivity",
        "Add derivatives of final state and peaks by this parameter; may be repeated.",
        metavar="NAME",
        multiple=True,
        completions=lambda: ALL_PARAMETERS,
        group=OUTPUT,
    )
    points: int = option(
        "--points",
        "Points of the trajectory written or drawn.",
        5001,
        metavar="N",
        integers=Interval(2, 10_000_000),
        show_default=True,
        group=OUTPUT,
    )
    over_time: Path | None = option_field(OVER_TIME)
