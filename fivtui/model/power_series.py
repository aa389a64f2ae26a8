"""Truncated power series, from which derivatives of any order are read."""

import math
from collections.abc import Sequence
from typing import Self


class PowerSeries:
    """The series c₀ + c₁ s + … + cₙ sⁿ of a small s; higher powers are dropped.

    Operands are numbers, or series of the same order n.
    """

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Sequence[float]) -> None:
        self.coefficients = tuple(coefficients)

    @classmethod
    def variable(cls, value: float, order: int) -> Self:
        """The series value + s up to an order of at least 1."""
        return cls((value, 1.0, *[0.0] * (order - 1)))

    def derivatives(self) -> tuple[float, ...]:
        """The value and the derivatives by s at s = 0, up to the order of the series."""
        return tuple(math.factorial(n) * value for n, value in enumerate(self.coefficients))

    def _operand(self, value: Self | float) -> tuple[float, ...]:
        # The coefficients of the second operand.
        if isinstance(value, PowerSeries):
            return value.coefficients
        return (value, *[0.0] * (len(self.coefficients) - 1))

    def __neg__(self) -> Self:
        return type(self)([-value for value in self.coefficients])

    def __add__(self, addend: Self | float) -> Self:
        pairs = zip(self.coefficients, self._operand(addend), strict=True)
        return type(self)([first + second for first, second in pairs])

    __radd__ = __add__

    def __sub__(self, subtrahend: Self | float) -> Self:
        return self + -subtrahend

    def __rsub__(self, minuend: float) -> Self:
        return -self + minuend

    def __mul__(self, factor: Self | float) -> Self:
        if not isinstance(factor, PowerSeries):
            return type(self)([a * factor for a in self.coefficients])
        first, second = self.coefficients, factor.coefficients
        # The coefficient of sⁿ in the product is Σ aₖ bₙ₋ₖ, k = 0 … n.
        ends = range(1, len(first) + 1)
        pairs = [zip(first[:end], reversed(second[:end]), strict=True) for end in ends]
        return type(self)([sum(a * b for a, b in terms) for terms in pairs])

    __rmul__ = __mul__

    def __truediv__(self, divisor: Self | float) -> Self:
        if not isinstance(divisor, PowerSeries):
            return type(self)([value / divisor for value in self.coefficients])
        # From quotient times divisor: qₙ = (cₙ − Σ qₙ₋ₖ dₖ)/d₀, k = 1 … n.
        first, *higher = divisor.coefficients
        quotient: list[float] = []
        for value in self.coefficients:
            terms = zip(reversed(quotient), higher, strict=False)
            quotient.append((value - sum(a * b for a, b in terms)) / first)
        return type(self)(quotient)

    def __rtruediv__(self, dividend: float) -> Self:
        return type(self)(self._operand(dividend)) / self

    def exp(self) -> Self:
        """The exponential, by the recurrence of coefficients from (exp f)′ = f′ exp f."""
        first, *higher = self.coefficients
        derivative = [n * value for n, value in enumerate(higher, start=1)]
        exponential = [math.exp(first)]
        for n in range(1, len(self.coefficients)):
            terms = zip(derivative, reversed(exponential), strict=False)
            exponential.append(sum(slope * value for slope, value in terms) / n)
        return type(self)(exponential)
