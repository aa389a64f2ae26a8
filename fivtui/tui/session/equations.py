"""Displayed symbols of parameters, and the model's equations. Imports no Textual.

Equations are numbered as in the paper "Nonlinear friction-induced vibration of a slider-belt
system".
"""

import re
from typing import Final

from fivtui.model import ALL_PARAMETERS, ParameterSpec
from fivtui.results import Row


def symbol_of(name: str) -> str:
    """The displayed symbol of a parameter: μ for ``mu``; the name if the symbol is ASCII."""
    spec = ALL_PARAMETERS.get(name)
    return name if spec is None or spec.symbol.isascii() else spec.symbol


# Users may type symbols in place of names.
_NAME_BY_SYMBOL: Final = {spec.symbol: name for name, spec in ALL_PARAMETERS.items()}
_SYMBOLS: Final = re.compile(rf"(?<!\w)({'|'.join(map(re.escape, _NAME_BY_SYMBOL))})(?!\w)")


def replace_symbols(text: str) -> str:
    """Replace symbols of parameters by their names, e.g. ``k_1=1:9:3`` by ``k1=1:9:3``."""
    return _SYMBOLS.sub(lambda match: _NAME_BY_SYMBOL[match[0]], text)


EQUATIONS: Final = (
    Row("Eq. 1", "P = −k2 y − k_nl y³", "contact force"),
    Row("Eq. 2", "m ẍ + c1 ẋ + (k1 + k3/2) x − (k3/2) y = μ P", "horizontal motion"),
    Row("Eq. 2", "m ÿ + c2 ẏ + (k3/2) y − (k3/2) x = P − F", "vertical motion"),
    Row("Eq. 4", "y > 0, with P = 0 in the motion", "separated while"),
)


def equations_with(spec: ParameterSpec) -> list[Row]:
    """The equations in which a parameter occurs, by name or symbol."""
    names = "|".join(map(re.escape, (spec.name, spec.symbol)))
    pattern = re.compile(rf"(?<!\w)({names})(?!\w)")
    return [equation for equation in EQUATIONS if pattern.search(equation.value)]
