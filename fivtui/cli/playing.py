"""Commands that show and sound a run, and set it beside measured data."""

from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import click

from fivtui.model import InputError, parse_number, read_number

from .arguments import option
from .completion import METHOD_NAMES
from .deliver import check_outputs, show, warn, write
from .group import commands
from .options import (
    force_option,
    ignore_option,
    input_option,
    json_option,
    output_option,
    over_time_option,
    progress_bar,
    scene_argument,
    scene_of,
    set_option,
    start_option,
    t_end_option,
    tol_option,
)
from .transients import changed_scene

# Exit status where a run and measured data differ by more than the tolerances.
_EXIT_FAILED: Final = 1

if TYPE_CHECKING:
    from fivtui.transient import Samples, Transient

# Of an FMU, which hands out no function of time.
_POINTS: Final = 20_001

_RUN_OPTIONS: Final = (
    scene_argument,
    set_option,
    ignore_option,
    t_end_option,
    option(
        "--method",
        metavar="NAME",
        help="Integration method (see fivtui methods).",
        shell_complete=METHOD_NAMES,
    ),
    tol_option,
    option("--step", metavar="S", help="Step of rk4, or communication step of fmu, s."),
    start_option("Start state, m and m/s; static: at rest at the equilibrium of μ = 0."),
    over_time_option,
)


def run_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Adds the options of one run."""
    return reduce(lambda made, add: add(made), reversed(_RUN_OPTIONS), command)


def run_of(given: dict[str, Any]) -> "Transient":
    """The run that the options ask for, known at any time."""
    from fivtui.scene import scene_transient
    from fivtui.transient import FMU_FLAVOURS

    scene = changed_scene(
        scene_of(given["scene"], given["assignments"], over_time=True),
        {"error_targets": (), **given},
    )
    samples: Samples = _POINTS if scene.method in FMU_FLAVOURS else "dense"
    with progress_bar("transient") as progress:
        return scene_transient(scene, samples=samples, progress=progress).transient


def window_of(text: str | None) -> tuple[float, float] | None:
    """Start and end of a window of time, s, from the text of ``--window``."""
    if text is None:
        return None
    try:
        start, end = (read_number(part) for part in text.split(":"))
    except ValueError:
        raise InputError(f"--window {text}: must be START:END in s, e.g. 20:30") from None
    return start, end


def number_of(flag: str, text: str | None) -> float | None:
    """The number in the text of an option, if it was given."""
    return None if text is None else parse_number(flag, text, "a number above 0")


def window_option(text: str) -> Callable[..., Any]:
    """The option --window, a part of the run."""
    return option("--window", metavar="START:END", help=text)


@commands.command()
@run_options
@window_option(
    "What is shown, s; by default the last eight cycles, or what 10 s of film show at --speed."
)
@option(
    "--speed",
    metavar="N",
    help="Seconds of the motion in a second of the film, 1 for real time; by default the film "
    "lasts 10 s.",
)
@output_option("--out", "FILE", "The film (.gif; .mp4 where ffmpeg is).", required=True)
@force_option
@json_option
def animate(**given: Any) -> None:
    """Write a film of the slider on the belt.

    The slider moves to scale, lifts off, lands and sticks, with the forces on it and y over time.
    """
    from fivtui.film import animate as film, check_film_path

    out: Path = given["out"]
    window, speed = window_of(given["window"]), number_of("--speed", given["speed"])
    check_film_path(out, force=given["force"])
    run = run_of(given)
    with progress_bar("film") as progress:
        made = film(run, out, window=window, speed=speed, force=given["force"], progress=progress)
    show("film", made, as_json=given["as_json"])


@commands.command()
@run_options
@option(
    "--signal",
    metavar="NAME",
    default="vy",
    show_default=True,
    help="What is heard: x, vx, y, vy or P, less its mean and normalised.",
)
@window_option("What is heard, s; by default the whole run.")
@option(
    "--factor",
    metavar="N",
    help="How far time is compressed; by default such that the late motion is heard at 110 Hz.",
)
@output_option("--out", "FILE.wav", "The sound, mono, 16 bit, 44100 Hz.", required=True)
@force_option
@json_option
def sound(**given: Any) -> None:
    """Write a run as a sound, its time compressed."""
    from fivtui.signals import check_sound_path, sound as write_sound

    out: Path = given["out"]
    window, factor = window_of(given["window"]), number_of("--factor", given["factor"])
    check_sound_path(out, force=given["force"])
    made = write_sound(
        run_of(given),
        out,
        signal=given["signal"],
        factor=factor,
        window=window,
        force=given["force"],
    )
    show("sound", made, as_json=given["as_json"])


@commands.command()
@run_options
@input_option("--measured", "FILE.csv", "The measured data.")
@option(
    "--time",
    metavar="NAME|N",
    default="",
    help="Column of the times, by name or number; t, time or the first if not given.",
)
@option(
    "--signal",
    metavar="NAME|N",
    default="",
    help="Column of the signal; the one of that quantity's name or the second if not given.",
)
@option(
    "--quantity",
    metavar="NAME",
    default="y",
    show_default=True,
    help="What was measured: x, vx, y, vy or P.",
)
@option(
    "--scale",
    metavar="N",
    help="SI units in a unit of the signal.",
)
@option("--offset", metavar="N", help="Added to the scaled signal, in SI units.")
@option("--time-scale", metavar="N", help="Seconds in a unit of the time column.")
@option(
    "--shift",
    metavar="S|auto",
    default="0",
    show_default=True,
    help="Added to the measured times, s; auto: where both correlate best.",
)
@option(
    "--band",
    metavar="N|N%",
    help="Half width of the tolerance band, in SI units or in percent of half peak-to-peak.",
)
@option("--share", metavar="N%", help="Least share of samples within the band, 100 % if not given.")
@option("--frequency", metavar="N%", help="Greatest relative deviation of the frequency.")
@option("--amplitude", metavar="N%", help="Greatest relative deviation of half peak-to-peak.")
@output_option("--out", "FILE", "Write both signals (.csv, .npz, .parquet).")
@output_option("--plot", "FILE", "Draw both with the band, and their spectra (.png, .svg, .pdf).")
@force_option
@json_option
def validate(**given: Any) -> None:
    """Compare a run with measured data: overlay, spectra, tolerances.

    Passes or fails if a tolerance is given: --band, --frequency or --amplitude. Where it fails the
    exit status is 1.
    """
    from fivtui.measured import read_measurement, read_tolerances, validate as compare

    if given["measured"] is None:
        raise InputError("--measured FILE.csv: must be given")
    shift = given["shift"]
    moved: float | Literal["auto"]
    moved = "auto" if shift == "auto" else parse_number("--shift", shift, "a time in s, or auto")
    tolerances = read_tolerances(given, "--")
    numbers = {
        name: parse_number(f"--{name.replace('_', '-')}", given[name], "a number")
        for name in ("scale", "offset", "time_scale")
        if given[name] is not None
    }
    check_outputs("validation", given["out"], given["plot"], force=given["force"])
    measurement = read_measurement(
        given["measured"],
        time=given["time"],
        signal=given["signal"],
        quantity=given["quantity"],
        **numbers,
    )
    found = compare(
        run_of(given),
        measurement,
        quantity=given["quantity"],
        shift=moved,
        tolerances=tolerances,
    )
    write("validation", found, given["out"], given["plot"], force=given["force"])
    warn("validation", found)
    show("validation", found, as_json=given["as_json"])
    if found.passed is False:
        click.get_current_context().exit(_EXIT_FAILED)
