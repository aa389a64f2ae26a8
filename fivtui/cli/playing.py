"""Commands for a run as film or sound, and beside measured data: compare, and fit parameters."""

from typing import TYPE_CHECKING, Any, Final

import click

from fivtui.identification import IdentifyOptions
from fivtui.measured import ValidateOptions
from fivtui.model import InputError, parse_number, read_number
from fivtui.options import option, options_class
from fivtui.transient import RunOptions

from .command import Call, command
from .options import progress_bar

_FILM: Final = "Film"
_SOUND: Final = "Sound"
# Exit status if a run and measured data differ by more than the tolerances.
_EXIT_FAILED: Final = 1

if TYPE_CHECKING:
    from fivtui.transient import Samples, Transient

# Samples of an FMU run, which is not available as a function of time.
_FMU_SAMPLES: Final = 20_001


def compute_run(call: Call[Any]) -> "Transient":
    """The run of a command, with its motion as a function of time; an FMU run has samples."""
    from fivtui.scene import scene_transient
    from fivtui.transient import FMU_FLAVOURS

    scene = call.scene()
    # The keys of `FMU_FLAVOURS` are the methods that run an FMU.
    samples: Samples = _FMU_SAMPLES if scene.method in FMU_FLAVOURS else "dense"
    with progress_bar("transient") as progress:
        return scene_transient(scene, samples=samples, progress=progress).transient


def parse_window(text: str | None) -> tuple[float, float] | None:
    """Start and end of the time window in the text of ``--window``, s."""
    if text is None:
        return None
    try:
        start, end = (read_number(part) for part in text.split(":"))
    except ValueError:
        raise InputError(f"--window {text}: must be START:END in s, e.g. 20:30") from None
    return start, end


def parse_positive(flag: str, text: str | None) -> float | None:
    """The number in the text of an option, None if it was not given."""
    return None if text is None else parse_number(flag, text, "a number above 0")


@options_class
class AnimateOptions(RunOptions):
    """Options of ``fivtui animate``."""

    window: str | None = option(
        "--window",
        "Time shown, s; by default the last eight cycles, or with --speed the end of the run that "
        "fills 10 s of film.",
        metavar="START:END",
        group=_FILM,
    )
    speed: str | None = option(
        "--speed",
        "Seconds of the motion in a second of the film, 1 for real time; by default the film lasts "
        "10 s.",
        metavar="N",
        group=_FILM,
    )


@command(AnimateOptions, out="The film (.gif, or .mp4 if ffmpeg is installed).", required=True)
def animate(call: Call[AnimateOptions]) -> None:
    """Write a film of the slider on the belt.

    The slider moves to scale, lifts off, lands and sticks, with the forces on it and y over time.
    """
    from fivtui.film import animate as film, check_film_path

    out = call.outputs.path
    window, speed = parse_window(call.options.window), parse_positive("--speed", call.options.speed)
    check_film_path(out)
    run = compute_run(call)
    with progress_bar("film") as progress:
        result = film(run, out, window=window, speed=speed, progress=progress)
    call.outputs.show("film", result)


@options_class
class SoundOptions(RunOptions):
    """Options of ``fivtui sound``."""

    signal: str = option(
        "--signal",
        "Signal written: x, vx, y, vy or the contact force P, less its mean and normalised.",
        "vy",
        metavar="NAME",
        show_default=True,
        group=_SOUND,
    )
    window: str | None = option(
        "--window",
        "Time written, s; by default the whole run.",
        metavar="START:END",
        group=_SOUND,
    )
    factor: str | None = option(
        "--factor",
        "How far time is compressed; by default such that the vibration late in the run is "
        "heard at 110 Hz.",
        metavar="N",
        group=_SOUND,
    )


@command(SoundOptions, out="The sound, mono, 16 bit, 44100 Hz.", metavar="FILE.wav", required=True)
def sound(call: Call[SoundOptions]) -> None:
    """Write a run as a sound, its time compressed."""
    from fivtui.signals import check_sound_path, sound as write_sound

    out = call.outputs.path
    window, factor = (
        parse_window(call.options.window),
        parse_positive("--factor", call.options.factor),
    )
    check_sound_path(out)
    result = write_sound(
        compute_run(call), out, signal=call.options.signal, factor=factor, window=window
    )
    call.outputs.show("sound", result)


@command(
    IdentifyOptions,
    out="Write the fitted scene, with distributions and correlations (.toml).",
    plot="Draw measured and computed signals, and residuals (.png, .svg, .pdf).",
)
def identify(call: Call[IdentifyOptions]) -> None:
    """Fit parameters to measured signals and features.

    Prints fitted values with 95 % intervals, and what the data do not determine. The written scene
    has the distributions of the fitted values, which fivtui uncertainty takes.
    """
    from fivtui.identification import prepare_fit

    call.outputs.compute_and_deliver("identification", prepare_fit(call.scene(), call.options))


@command(
    ValidateOptions,
    out="Write both signals (.csv, .npz, .parquet).",
    plot="Draw both signals with the tolerance band, and their spectra (.png, .svg, .pdf).",
)
def validate(call: Call[ValidateOptions]) -> None:
    """Compare a run with measured data, within tolerances.

    Passes or fails if a tolerance is given: --band, --frequency or --amplitude. Where it fails the
    exit status is 1.
    """
    from fivtui.measured import prepare_comparison

    call.outputs.check("validation")
    compare = prepare_comparison(call.options)()
    result = compare(compute_run(call))
    call.outputs.finish("validation", result)
    if result.passed is False:
        click.get_current_context().exit(_EXIT_FAILED)
