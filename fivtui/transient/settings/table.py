"""The settings of a transient: one table for scene files, form and command line.

A row has a parser of text (form and command line), a check of values in scene files, an option of
commands, and texts of help. The paper, with its Cases 1 and 2, is "Nonlinear friction-induced
vibration of a slider-belt system".
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from fivtui.model import InputError, Interval, check_known, parse_number
from fivtui.options import ACCURACY, SCENE, Option, option_field

from .checks import (
    MAX_T_END,
    QUANTITIES,
    START_TEXT,
    STATIC,
    T_END_INTERVAL,
    Start,
    check_accuracy,
    check_horizon,
    check_start,
    check_step,
    check_tolerance,
    tolerance_interval,
)

# Largest allowed error of each quantity, as (quantity, error).
Accuracy = tuple[tuple[str, float], ...]

WITH_SEPARATION: Final = "considered"
WITHOUT_SEPARATION: Final = "ignored"
_SEPARATION_MEANINGS: Final = {
    WITH_SEPARATION: "Case 1: the slider may leave the belt, then P = 0",
    WITHOUT_SEPARATION: "Case 2: P = −k2 y − k_nl y³ for all y, even in tension",
}
_STEP_TEXT: Final = "above 0 and at most t_end, or empty"
# The starts that a scene file allows, for messages and comments.
_FILE_START_TEXT: Final = (
    "static (at rest at the equilibrium of μ = 0) or [x, vx, y, vy] in m and m/s"
)


def _choice_reader(kind: str, choices: Callable[[], Mapping[str, str]]) -> Callable[[str], str]:
    # A parser that accepts the names of choices; messages call them by `kind`.
    def read_choice(text: str) -> str:
        check_known(kind, text, choices())
        return text

    return read_choice


def _methods() -> Mapping[str, str]:
    from fivtui.transient.methods import ALL_METHODS

    return ALL_METHODS


def _read_separation(text: str) -> bool:
    return _choice_reader("separation", lambda: _SEPARATION_MEANINGS)(text) == WITH_SEPARATION


def _read_start(text: str) -> Start:
    if text.strip() == STATIC:
        return STATIC
    parts = [part.strip() for part in text.split(",")]
    return check_start([parse_number("start", part, START_TEXT) for part in parts])


def _read_step(text: str) -> float | None:
    if not text.strip():
        return None
    # The horizon is not known here; the request of a run compares the step with it.
    return check_step(parse_number("step", text, _STEP_TEXT), MAX_T_END)


def _read_accuracy(text: str) -> Accuracy:
    # Entries such as ``peak=1e-4``, separated by commas.
    errors = {}
    for entry in filter(None, (entry.strip() for entry in text.split(","))):
        name, _, error = (token.strip() for token in entry.partition("="))
        errors[name] = error
    return tuple(check_accuracy(errors).items())


def _number_text(value: float | None) -> str:
    from fivtui.ranges import number_text

    return "" if value is None else number_text(value)


def _start_text(start: Start) -> str:
    return start if isinstance(start, str) else ", ".join(map(_number_text, start))


def check_file_boolean(key: str, value: object) -> bool:
    """A boolean of a scene file; raises `InputError` for any other type."""
    if not isinstance(value, bool):
        raise InputError(f"{key} = {value!r}: must be true or false")
    return value


def check_file_text(key: str, value: object) -> str:
    """A text of a scene file; raises `InputError` for any other type."""
    if not isinstance(value, str):
        raise InputError(f"{key} = {value!r}: must be text in quotes")
    return value


def check_file_number(key: str, value: object) -> float:
    """A number of a scene file; raises `InputError` for any other type."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key} = {value!r}: not a number")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{key}: the number is too large") from None


def _check_file_start(key: str, value: object) -> str | tuple[float, ...]:
    if isinstance(value, str):
        return value
    if not isinstance(value, list | tuple):
        raise InputError(f"{key} = {value!r}: must be {_FILE_START_TEXT}")
    return tuple(check_file_number(f"{key}[{index}]", entry) for index, entry in enumerate(value))


def _check_file_accuracy(key: str, value: object) -> Accuracy:
    if not isinstance(value, Mapping):
        raise InputError(f"{key} = {value!r}: must be a table such as {{peak = 1e-4}}")
    return tuple(
        (str(name), check_file_number(f"{key}.{name}", error)) for name, error in value.items()
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSetting:
    """A row of the table: a field of a scene that is not a parameter."""

    name: str
    meaning: str
    # Parser of the text in a form or option.
    read: Callable[[str], Any]
    # Check of a key and its value in a scene file; returns the value.
    check_file_value: Callable[[str, object], Any]
    option: Option
    to_text: Callable[[Any], str] = _number_text
    # The allowed values, as text, as an interval or as names with their meanings.
    allowed_text: str = ""
    interval: Callable[[], Interval] | None = None
    choices: Callable[[], Mapping[str, str]] | None = None
    # Comment in a scene file; by default meaning and allowed values.
    comment: str = ""
    symbol: str = ""
    unit: str = ""
    # Rows of help: name and text.
    details: tuple[tuple[str, str], ...] = ()
    # Text of the form for an empty field.
    when_empty: str = ""

    @property
    def allowed(self) -> str:
        """Description of the allowed values."""
        if self.interval is not None:
            return str(self.interval())
        return self.allowed_text or ", ".join(self.choices() if self.choices else ())

    def command_options(self, text: str) -> list[str]:
        """The command-line options that set the value with this text."""
        if self.option.metavar is None:
            # The one flag, --ignore-separation, stands for a false value.
            return [] if self.read(text) else [self.option.flag]
        texts = text.split(",") if self.option.multiple else [text]
        return [f"{self.option.flag}={part.replace(' ', '')}" for part in texts if part.strip()]


SETTINGS: Final[Mapping[str, RunSetting]] = {
    setting.name: setting
    for setting in (
        RunSetting(
            name="separation",
            meaning="whether contact can be lost",
            read=_read_separation,
            to_text=lambda considered: WITH_SEPARATION if considered else WITHOUT_SEPARATION,
            check_file_value=check_file_boolean,
            comment="true: separation considered (Case 1), false: ignored (Case 2)",
            allowed_text=" or ".join(_SEPARATION_MEANINGS),
            choices=lambda: _SEPARATION_MEANINGS,
            option=Option(
                flag="--ignore-separation",
                group=SCENE,
                help="Contact never breaks, even in tension (Case 2 of the paper).",
            ),
        ),
        RunSetting(
            name="start",
            unit="m, m/s",
            meaning="state at t = 0",
            allowed_text=START_TEXT,
            read=_read_start,
            to_text=_start_text,
            check_file_value=_check_file_start,
            comment=_FILE_START_TEXT,
            details=((STATIC, "at rest at the equilibrium for μ = 0; the belt starts at t = 0"),),
            option=Option(
                flag="--start",
                group=SCENE,
                metavar="static|x,vx,y,vy",
                help="Start state, m and m/s.",
            ),
        ),
        RunSetting(
            name="t_end",
            symbol="t_end",
            unit="s",
            meaning="end time",
            interval=lambda: T_END_INTERVAL,
            read=check_horizon,
            check_file_value=check_file_number,
            details=(("use", "half peak-to-peak is taken over the second half of the run"),),
            option=Option(
                flag="--t-end", group=SCENE, metavar="S", help="Duration of the transient, s."
            ),
        ),
        RunSetting(
            name="method",
            meaning="integration method",
            read=_choice_reader("method", _methods),
            to_text=str,
            check_file_value=check_file_text,
            choices=_methods,
            option=Option(
                flag="--method",
                group=ACCURACY,
                metavar="NAME",
                help="Integration method (see fivtui methods).",
                completions=_methods,
            ),
        ),
        RunSetting(
            name="tol",
            symbol="tol",
            meaning="relative tolerance",
            interval=tolerance_interval,
            read=check_tolerance,
            check_file_value=check_file_number,
            details=(
                ("use", "by methods with variable step, unless there are error targets"),
                ("taylor, fmu", "the manual explains what a tolerance promises"),
                ("scipy-…", "the relative error of a step, no promise for the run"),
            ),
            option=Option(
                flag="--tol", group=ACCURACY, metavar="R", help="Relative tolerance, 1e-13 to 1e-2."
            ),
        ),
        RunSetting(
            name="accuracy",
            meaning="error targets, in place of tol and step",
            allowed_text=f"e.g. peak=1e-4, for {', '.join(QUANTITIES)}; or empty",
            read=_read_accuracy,
            to_text=lambda errors: ", ".join(f"{name}={error:g}" for name, error in errors),
            check_file_value=_check_file_accuracy,
            comment=f"errors allowed, in place of tol: {', '.join(QUANTITIES)}",
            details=tuple(QUANTITIES.items()),
            when_empty="tol or step",
            option=Option(
                flag="--error",
                group=ACCURACY,
                metavar="QUANTITY=R",
                help="Error target in place of --tol or --step: refine until the error of QUANTITY "
                "is below R. QUANTITY: final (state), peak, half_range (half peak-to-peak over the "
                "second half of the run) or events (times of separation and reattachment, s).",
                multiple=True,
                completions=lambda: (f"{name}=" for name in QUANTITIES),
            ),
        ),
        RunSetting(
            name="step",
            symbol="step",
            unit="s",
            meaning="step of rk4 or fmu",
            allowed_text=_STEP_TEXT,
            read=_read_step,
            check_file_value=check_file_number,
            comment="step of rk4 or communication step of fmu; above 0 and at most t_end, s",
            details=(
                ("rk4", "the integration step"),
                ("fmu, fmu-native", "the communication step"),
                ("others", "choose their own step; leave this empty"),
            ),
            when_empty="default",
            option=Option(
                flag="--step",
                group=ACCURACY,
                metavar="S",
                help="Step of rk4, or communication step of fmu, s.",
            ),
        ),
    )
}


def setting(name: str, help: str = "", *, for_scene: bool = True) -> Any:  # noqa: A002
    """The dataclass field of a setting's option; `help` replaces its help text.

    With `for_scene` the option sets the field of the scene.
    """
    option = SETTINGS[name].option
    option = replace(option, help=help or option.help, setting=name if for_scene else "")
    return option_field(option, False if option.metavar is None else None)
