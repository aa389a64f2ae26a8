"""Arithmetic expressions as text that is valid in Python and in C."""

from typing import Any

# Precedences of sums, of products and negative numbers, and of names, calls and other numbers.
SUM, PRODUCT, ATOM = 1, 2, 3


class ReflectedOperators:
    """Operators whose left operand is a number; `_operand` converts it."""

    __slots__ = ()

    def _operand(self, value: object) -> Any:
        raise NotImplementedError

    def __radd__(self, value: object) -> Any:
        return self._operand(value) + self

    def __rsub__(self, value: object) -> Any:
        return self._operand(value) - self

    def __rmul__(self, value: object) -> Any:
        return self._operand(value) * self

    def __rtruediv__(self, value: object) -> Any:
        return self._operand(value) / self


class Expression(ReflectedOperators):
    """An arithmetic expression; products with 0 or 1 and sums with 0 are simplified."""

    __slots__ = ("precedence", "text")

    def __init__(self, text: str, precedence: int = ATOM) -> None:
        self.text, self.precedence = text, precedence

    @property
    def is_zero(self) -> bool:
        """Whether the expression is the number 0."""
        return self.text == _ZERO

    @property
    def is_number(self) -> bool:
        """Whether the expression is a number."""
        return self.text.lstrip("-")[0].isdigit()

    def __neg__(self) -> "Expression":
        text = self._operand_text(PRODUCT)
        if text.startswith("-"):
            return Expression(text[1:], PRODUCT)
        return self if self.is_zero else Expression(f"-{text}", PRODUCT)

    def __add__(self, operand: object) -> "Expression":
        b = expression(operand)
        if self.is_zero or b.is_zero:
            return b if self.is_zero else self
        return Expression(f"{self.text} + {b._operand_text(PRODUCT)}", SUM)

    def __sub__(self, operand: object) -> "Expression":
        b = expression(operand)
        if self.is_zero or b.is_zero:
            return -b if self.is_zero else self
        return Expression(f"{self.text} - {b._operand_text(PRODUCT)}", SUM)

    def __mul__(self, operand: object) -> "Expression":
        b = expression(operand)
        if self.is_zero or b.is_zero:
            return Expression(_ZERO)
        for factor, cofactor in ((self, b), (b, self)):
            if factor.text in (_ONE, _MINUS_ONE):
                return cofactor if factor.text == _ONE else -cofactor
        return Expression(f"{self._operand_text(PRODUCT)} * {b._operand_text(ATOM)}", PRODUCT)

    def __truediv__(self, operand: object) -> "Expression":
        b = expression(operand)
        if self.is_zero or b.text == _ONE:
            return self
        return Expression(f"{self._operand_text(PRODUCT)} / {b._operand_text(ATOM)}", PRODUCT)

    def _operand(self, value: object) -> "Expression":
        return expression(value)

    def exp(self) -> "Expression":
        """The exponential function, named `exponential` in C and Python."""
        return Expression(f"exponential({self.text})")

    def _operand_text(self, min_precedence: int) -> str:
        return self.text if self.precedence >= min_precedence else f"({self.text})"


_ZERO, _ONE, _MINUS_ONE = "0.0", "1.0", "-1.0"


def expression(value: object) -> Expression:
    """The value as an expression."""
    if isinstance(value, Expression):
        return value
    assert isinstance(value, int | float)  # noqa: S101
    # Adding 0.0 removes the sign of −0.0.
    number = float(value) + 0.0
    return Expression(repr(number), ATOM if number >= 0.0 else PRODUCT)
