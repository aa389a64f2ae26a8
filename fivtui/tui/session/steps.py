"""Steps by which keys change a number. Imports no Textual."""

from collections.abc import Callable
from decimal import Decimal

Step = Callable[[float, int, bool], float]
"""Value, direction (+1 or -1) and whether finely; the new value."""


def by_digit(default: float) -> Step:
    """Steps of one in the second significant digit (1 to 10 %), fine steps in the third.

    A step and the step back restore the number, across powers of ten too. `default` sets the size
    of the step from zero.
    """

    def step(value: float, direction: int, fine: bool) -> float:
        number = Decimal(repr(value))
        size = number or Decimal(repr(default)) or Decimal(1)
        exponent = size.adjusted()
        inwards = number != 0 and (direction > 0) != (number > 0)
        if inwards and abs(number) == Decimal(1).scaleb(exponent):
            exponent -= 1
        return float(number + direction * Decimal(1).scaleb(exponent - (2 if fine else 1)))

    return step


def by_decade(value: float, direction: int, _fine: bool) -> float:
    """Steps by a factor of ten."""
    return float(Decimal(repr(value)).scaleb(direction))
