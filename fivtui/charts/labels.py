"""Labels of quantities: plain text for the terminal, and mathtext of matplotlib for figures."""

from collections.abc import Sequence
from typing import Final, Self

from fivtui.model import NONE_TEXT, Parameters, ParameterSpec, parameter_spec

_NO_BREAK: Final = "\N{NO-BREAK SPACE}"


class Label(str):
    """A label: the string itself is for the terminal, its attribute `math` for figures."""

    __slots__ = ("math",)
    math: str

    def __new__(cls, text: str, math: str) -> Self:
        """Create a label from the texts for the terminal and for figures."""
        label = super().__new__(cls, text)
        label.math = math
        return label


def axis_label(spec: ParameterSpec) -> Label:
    """Label of an axis: symbol and unit in the terminal; in figures the meaning, too."""
    # A symbol such as k_1 is written as the name of the parameter, k1; Greek letters stay.
    symbol = spec.name if spec.symbol.isascii() else spec.symbol
    return Label(f"{symbol} ({spec.unit})" if spec.unit else symbol, quantity_label(spec))


def label_with_unit(text: str, unit: str) -> Label:
    """A text with its unit in brackets; without brackets if `unit` is empty."""
    return Label(f"{text} ({unit})", f"{text} ({math_unit(unit)})") if unit else Label(text, text)


def meaning_label(meaning: str, unit: str, text: str = "") -> Label:
    """Label of a quantity with unit: its meaning; in the terminal `text`, unless it is empty."""
    capitalised = f"{meaning[0].upper()}{meaning[1:]}"
    return Label(label_with_unit(text or meaning, unit), label_with_unit(capitalised, unit).math)


def value_label(name: str, value: float | None) -> str:
    """A parameter and its value in matplotlib's mathtext, such as ``F = 80 N``."""
    spec = parameter_spec(name)
    value_text = NONE_TEXT if value is None else f"{value:g} {math_unit(spec.unit)}".rstrip()
    text = f"{math_symbol(spec.symbol)} = {value_text}"
    return text.replace(" ", _NO_BREAK)


def quantity_label(spec: ParameterSpec) -> str:
    """Axis label of a quantity in matplotlib's mathtext: meaning, symbol and unit."""
    unit = f" ({math_unit(spec.unit)})" if spec.unit else ""
    # The meaning without details, which follow a comma or semicolon.
    meaning = spec.meaning.partition(",")[0].partition(";")[0]
    return f"{meaning.capitalize()} {math_symbol(spec.symbol)}{unit}"


def parameter_text(parameters: Parameters, omitted: Sequence[str] = ()) -> str:
    """All parameters except the `omitted` ones, in two lines of matplotlib's mathtext."""
    values = parameters.as_dict().items()
    texts = [value_label(name, value) for name, value in values if name not in omitted]
    middle = (len(texts) + 1) // 2
    return "\n".join(", ".join(part) for part in (texts[:middle], texts[middle:]))


def math_symbol(symbol: str) -> str:
    """A symbol such as ``k_nl`` in matplotlib's mathtext, its index upright."""
    head, _, index = symbol.partition("_")
    return f"${head}_{{\\mathrm{{{index}}}}}$" if index else f"${head}$"


def math_unit(unit: str) -> str:
    """A unit such as ``N/m^3`` in matplotlib's mathtext."""
    base, _, power = unit.partition("^")
    return f"{base}$^{power}$" if power else base
