"""Units of the model for FMI: exponents of SI base units, and display units."""

from collections import Counter
from typing import Final

# Exponents of the base units, in the order in which FMI names their attributes.
_BASE: Final = {
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "1": {},
}
# One display unit used by engineers; value in it = factor times SI value.
_READ_IN: Final = {
    "kg": ("g", 1e3),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "m/s^2": ("mm/s^2", 1e3),
    "s": ("ms", 1e3),
    "N": ("kN", 1e-3),
    "N/m": ("N/mm", 1e-3),
    "N/m^3": ("N/mm^3", 1e-9),
    "N/s": ("kN/s", 1e-3),
    "N s/m": ("N s/mm", 1e-3),
}


def base_exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units in a unit, without zeros.

    `unit` is factors separated by spaces, then divisors each after a slash; "^" precedes an
    exponent. Raises `KeyError` if a factor is not a unit of this model.
    """
    total: Counter[str] = Counter()
    numerator, *divisors = unit.split("/")
    for sign, factors in ((1, numerator.split()), (-1, divisors)):
        for factor in factors:
            name, _, power = factor.partition("^")
            for base, exponent in _BASE[name].items():
                total[base] += sign * exponent * int(power or 1)
    return {base: exponent for base, exponent in total.items() if exponent}


def display_units(unit: str) -> dict[str, float]:
    """Display units of an SI unit, itself first, with their factors from the SI unit."""
    return {unit: 1.0, **dict([_READ_IN[unit]] if unit in _READ_IN else [])}
