"""The fields of the form as data, made from parameters and settings. Imports no Textual."""

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from typing import Final

from fivtui.model import ALL_PARAMETERS, MODES, NONE_TEXT, ParameterSpec
from fivtui.ranges import number_text, with_decimal_point
from fivtui.results import Row
from fivtui.scene import Scene
from fivtui.transient import DEFAULT_T_END, SETTINGS, RunSetting

from .equations import equations_with, symbol_of

# In a start state, a comma with a blank after it separates values; others are decimal commas.
_START_SEPARATOR: Final = re.compile(r"(,\s+)")
_START_SIZE: Final = 4
# Characters of a number, besides the exponent's letter.
_NUMBER_CHARACTERS: Final = frozenset("0123456789+-.,")
# A decimal comma in an error target such as ``y=0,01``.
_COMMA_IN_TARGET: Final = re.compile(r"(=\s*[0-9]*),(?=[0-9])")

# A function of a value, a direction (+1 or -1) and whether to step finely, to the next value.
StepRule = Callable[[float, int, bool], float]


def digit_step(default: float) -> StepRule:
    """Return a function that changes the second significant digit by one, or the third if fine.

    A step and its reverse restore the number, also across powers of ten. From zero, the size of
    the step is that of a step from `default`.
    """

    def step(value: float, direction: int, fine: bool) -> float:
        number = Decimal(repr(value))
        # Exponent of the first significant digit.
        exponent = (number or Decimal(repr(default)) or Decimal(1)).adjusted()
        is_towards_zero = number != 0 and (direction > 0) != (number > 0)
        if is_towards_zero and abs(number) == Decimal(1).scaleb(exponent):
            # A power of ten: the next number towards zero has one digit less.
            exponent -= 1
        return float(number + direction * Decimal(1).scaleb(exponent - (2 if fine else 1)))

    return step


@dataclass(frozen=True, slots=True, kw_only=True)
class FormField:
    """A text field of the form, for a parameter or a setting of the run."""

    name: str
    symbol: str
    unit: str
    meaning: str
    allowed: str
    default: str
    # Converts a text to a value; raises `InputError` if it is invalid.
    check: Callable[[str], object]
    text_of: Callable[[Scene], str]
    # Returns a typed text with points in place of decimal commas.
    replace_commas: Callable[[str], str] = with_decimal_point
    # Changes a number by a step; None if the field has no number.
    step_rule: StepRule | None = None
    # Meaning of an empty text.
    when_empty: str = ""
    # The allowed texts and their meanings.
    choices: Mapping[str, str] | None = None
    # Further rows of help.
    details: Sequence[Row] = ()

    def accepts(self, before: str, character: str) -> bool:
        """Whether a character may be typed behind the text `before`; a number has few letters."""
        return (
            self.step_rule is None
            or character in _NUMBER_CHARACTERS
            or (character in "eE" and before != "")
            or (self.when_empty == NONE_TEXT and NONE_TEXT.startswith(before + character))
        )


# Help on the parameters of a belt of finite speed, which are the optional ones: each mode of motion
# with its friction.
_MODE_ROWS: Final = tuple(
    Row(mode.name.lower(), f"{row.meaning}; friction {row.friction}") for mode, row in MODES.items()
)


def _parameter_field(spec: ParameterSpec) -> FormField:
    # An optional parameter may have no value: its text is then empty.
    def text_of(scene: Scene) -> str:
        value = getattr(scene.parameters, spec.name)
        return "" if value is None else number_text(value)

    def read(text: str) -> float | None:
        return spec.read(text or NONE_TEXT) if spec.optional else spec.check(text)

    return FormField(
        name=spec.name,
        symbol=symbol_of(spec.name),
        unit=spec.unit,
        meaning=spec.meaning,
        allowed=spec.allowed,
        default="" if spec.optional else number_text(spec.default),
        check=read,
        text_of=text_of,
        step_rule=digit_step(spec.default),
        when_empty=NONE_TEXT if spec.optional else "",
        details=_MODE_ROWS if spec.optional else equations_with(spec),
    )


def _replace_commas_in_start(text: str) -> str:
    # Values and separators in turn. Unless all values are separated by a comma and a blank, a comma
    # without blank may be a separator, too.
    parts = _START_SEPARATOR.split(text)
    values = parts[::2]
    if len(values) == _START_SIZE:
        parts[::2] = map(with_decimal_point, values)
    return "".join(parts)


_COMMA_FUNCTIONS: Final[Mapping[str, Callable[[str], str]]] = {
    "start": _replace_commas_in_start,
    "accuracy": partial(_COMMA_IN_TARGET.sub, r"\1."),
}
_STEP_RULES: Final = {
    "t_end": digit_step(DEFAULT_T_END),
    # Multiplied or divided by ten.
    "tol": lambda value, direction, _fine: float(Decimal(repr(value)).scaleb(direction)),
    # The size of its steps from zero, s, is that of steps from 0.001.
    "step": digit_step(0.001),
}
_DEFAULTS: Final = {field.name: field.default for field in dataclasses.fields(Scene)}


def _setting_field(setting: RunSetting) -> FormField:
    choices = None if setting.choices is None else setting.choices()
    return FormField(
        name=setting.name,
        symbol=setting.symbol,
        unit=setting.unit,
        meaning=setting.meaning,
        allowed=setting.allowed,
        default=setting.to_text(_DEFAULTS[setting.name]),
        check=setting.read,
        text_of=lambda scene: setting.to_text(getattr(scene, setting.name)),
        replace_commas=_COMMA_FUNCTIONS.get(setting.name, with_decimal_point),
        step_rule=_STEP_RULES.get(setting.name),
        when_empty=setting.when_empty,
        choices=choices,
        details=[Row(*texts) for texts in setting.details or (choices or {}).items()],
    )


FIELDS: Final[Mapping[str, FormField]] = {
    field.name: field
    for field in (
        *map(_parameter_field, ALL_PARAMETERS.values()),
        *map(_setting_field, SETTINGS.values()),
    )
}


def scene_texts(scene: Scene) -> dict[str, str]:
    """The texts of all fields for a scene, by name."""
    return {name: field.text_of(scene) for name, field in FIELDS.items()}
