"""The fields of the form as data. Imports no Textual."""

import dataclasses
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.model import (
    BELT_PARAMETERS,
    MODES,
    NONE,
    PARAMETERS,
    InputError,
    ParameterSpec,
    parse_number,
    unknown_name,
)
from fivtui.ranges import decimal_point, number_text
from fivtui.scene import Accuracy, Scene
from fivtui.simulation import ALL_METHODS
from fivtui.transient import (
    DEFAULT_T_END,
    DEFAULT_TOL,
    MAX_T_END,
    QUANTITIES,
    START_FORM,
    T_END_INTERVAL,
    TOL_INTERVAL,
    Start,
    check_accuracy,
    check_horizon,
    check_start,
    check_step,
    check_tolerance,
)

from .equations import equations_with, symbol_of
from .steps import Step, by_decade, by_digit

CONSIDERED: Final = "considered"
IGNORED: Final = "ignored"

_SEPARATION: Final = {
    CONSIDERED: "Case 1: the slider may leave the belt, then P = 0",
    IGNORED: "Case 2: P = −k2 y − k_nl y³ for all y, even in tension",
}

# A comma that is followed by a blank separates the values of a start.
_START_SEPARATOR: Final = re.compile(r"(,\s+)")
_START_SIZE: Final = 4
# A comma that is followed by a digit does not separate error targets: these begin with a name.
_COMMA_IN_TARGET: Final = re.compile(r"(=\s*[0-9]*),(?=[0-9])")


@dataclass(frozen=True, slots=True, kw_only=True)
class FormField:
    """An input field, edited as text."""

    name: str
    group: str
    symbol: str
    unit: str
    meaning: str
    allowed: str
    default: str
    check: Callable[[str], object]
    text_of: Callable[[Scene], str]
    respell: Callable[[str], str] = decimal_point
    step_by: Step | None = None
    when_empty: str = ""
    choices: Mapping[str, str] | None = None
    details: tuple[tuple[str, str], ...] = ()


def _parameter(spec: ParameterSpec) -> FormField:
    return FormField(
        name=spec.name,
        group="Parameters",
        symbol=symbol_of(spec.name),
        unit=spec.unit,
        meaning=spec.meaning,
        allowed=spec.allowed,
        default=number_text(spec.default),
        check=spec.check,
        text_of=lambda scene: number_text(getattr(scene.parameters, spec.name)),
        step_by=by_digit(spec.default),
        details=tuple(
            (f"Eq. {equation.number}", f"{equation.text}  ({equation.subject})")
            for equation in equations_with(spec)
        ),
    )


_MODES: Final = tuple(
    (mode.name.lower(), f"{row.meaning}; friction {row.friction}") for mode, row in MODES.items()
)


def _belt_parameter(spec: ParameterSpec) -> FormField:
    # Nothing entered is none.
    def text_of(scene: Scene) -> str:
        value = getattr(scene.parameters, spec.name)
        return "" if value is None else number_text(value)

    return dataclasses.replace(
        _parameter(spec),
        default="",
        check=lambda text: spec.read(text or NONE),
        text_of=text_of,
        when_empty=NONE,
        details=_MODES,
    )


def _choice(kind: str, choices: Mapping[str, str]) -> Callable[[str], str]:
    def check(text: str) -> str:
        if text not in choices:
            raise unknown_name(kind, text, choices)
        return text

    return check


def _check_t_end(text: str) -> float:
    return check_horizon(text)


def _check_tol(text: str) -> float:
    return check_tolerance(text)


def _check_step(text: str) -> float | None:
    if not text.strip():
        return None
    return check_step(parse_number("step", text, _STEP_ALLOWED), MAX_T_END)


def _check_accuracy(text: str) -> Accuracy:
    asked = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, error = (word.strip() for word in part.partition("="))
        asked[name] = error
    return tuple(check_accuracy(asked).items())


def _respell_accuracy(text: str) -> str:
    return _COMMA_IN_TARGET.sub(r"\1.", text)


def _respell_start(text: str) -> str:
    parts = _START_SEPARATOR.split(text)
    values = parts[::2]
    if len(values) == _START_SIZE:
        parts[::2] = map(decimal_point, values)
    return "".join(parts)


def _check_start(text: str) -> Start:
    parts = [part.strip() for part in text.split(",")]
    if parts == ["static"]:
        return "static"
    if len(parts) != _START_SIZE:
        raise InputError(f"start = {text!r}: must be {START_FORM}")
    return check_start([parse_number("start", part, START_FORM) for part in parts])


def _start_text(scene: Scene) -> str:
    if isinstance(scene.start, str):
        return scene.start
    return ", ".join(number_text(value) for value in scene.start)


_STEP_ALLOWED: Final = "above 0 and at most t_end, or empty"
_ACCURACY_ALLOWED: Final = f"e.g. peak=1e-4, for {', '.join(QUANTITIES)}; or empty"

_OF_THE_RUN: Final = (
    FormField(
        name="separation",
        group="Transient",
        symbol="",
        unit="",
        meaning="whether contact can be lost",
        allowed=" or ".join(_SEPARATION),
        default=CONSIDERED,
        check=_choice("separation", _SEPARATION),
        text_of=lambda scene: CONSIDERED if scene.separation else IGNORED,
        choices=_SEPARATION,
        details=tuple(_SEPARATION.items()),
    ),
    FormField(
        name="start",
        group="Transient",
        symbol="",
        unit="m, m/s",
        meaning="state at t = 0",
        allowed=START_FORM,
        default="static",
        check=_check_start,
        text_of=_start_text,
        respell=_respell_start,
        details=(("static", "at rest at the equilibrium for μ = 0; the belt starts at t = 0"),),
    ),
    FormField(
        name="t_end",
        group="Transient",
        symbol="t_end",
        unit="s",
        meaning="end time",
        allowed=str(T_END_INTERVAL),
        default=number_text(DEFAULT_T_END),
        check=_check_t_end,
        text_of=lambda scene: number_text(scene.t_end),
        step_by=by_digit(DEFAULT_T_END),
        details=(("use", "half peak-to-peak is taken over the second half of the run"),),
    ),
    FormField(
        name="method",
        group="Transient",
        symbol="",
        unit="",
        meaning="integration method",
        allowed=", ".join(ALL_METHODS),
        default="taylor",
        check=_choice("method", ALL_METHODS),
        text_of=lambda scene: scene.method,
        choices=ALL_METHODS,
        details=tuple(ALL_METHODS.items()),
    ),
    FormField(
        name="tol",
        group="Transient",
        symbol="tol",
        unit="",
        meaning="relative tolerance",
        allowed=str(TOL_INTERVAL),
        default=number_text(DEFAULT_TOL),
        check=_check_tol,
        text_of=lambda scene: number_text(scene.tol),
        step_by=by_decade,
        details=(
            ("use", "methods with variable step, unless accuracy is given"),
            ("taylor, fmu", "what it promises is said in examples/trust.md"),
        ),
    ),
    FormField(
        name="accuracy",
        group="Transient",
        symbol="",
        unit="",
        meaning="error targets, in place of tol and step",
        allowed=_ACCURACY_ALLOWED,
        default="",
        check=_check_accuracy,
        text_of=lambda scene: ", ".join(f"{name}={error:g}" for name, error in scene.accuracy),
        respell=_respell_accuracy,
        when_empty="tol or step",
        details=tuple(QUANTITIES.items()),
    ),
    FormField(
        name="step",
        group="Transient",
        symbol="step",
        unit="s",
        meaning="step of rk4 or fmu",
        allowed=_STEP_ALLOWED,
        default="",
        check=_check_step,
        text_of=lambda scene: "" if scene.step is None else number_text(scene.step),
        step_by=by_digit(0.001),
        when_empty="default",
        details=(
            ("rk4", "the integration step"),
            ("fmu, fmu-native", "the communication step"),
            ("others", "choose their own step; leave this empty"),
        ),
    ),
)

FIELDS: Final[Mapping[str, FormField]] = {
    field.name: field
    for field in (
        *map(_parameter, PARAMETERS.values()),
        *map(_belt_parameter, BELT_PARAMETERS.values()),
        *_OF_THE_RUN,
    )
}
