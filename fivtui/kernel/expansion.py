"""The recurrences as machine code: straight-line, for one parameter set or one in each lane.

`recurrences` is run on values of the compiler. The code can leave after every order that
`taylor.stepper` chooses, so that one kernel serves them all.
"""

from collections.abc import Sequence
from functools import reduce
from itertools import islice
from operator import add
from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.core import cgutils

from fivtui.taylor import (
    MAX_ORDER,
    MIN_ORDER,
    ORDER_STEP,
    Constants,
    RightHandSide,
    Values,
    newest_last,
    recurrences,
)

from .jit import intrinsic
from .vectors import (
    ALIGNMENT,
    CONTRACT,
    LANES,
    concatenate,
    constant,
    extract,
    join,
    pointer,
    spread,
)

# Rows of a workspace: coefficients of a degree one above the order.
ROWS: Final = MAX_ORDER + 2
# From the second degree on the rows of one parameter set, x and y, come in vectors of four.
GROUP: Final = LANES // 2


class _Value:
    # A number of the compiler, with the arithmetic that `recurrences` asks for.

    __slots__ = ("builder", "value")

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder = builder
        self.value = value

    def __add__(self, other: Any) -> Any:
        return self._with(self.builder.fadd(self.value, other.value, flags=CONTRACT))

    def __sub__(self, other: Any) -> Any:
        return self._with(self.builder.fsub(self.value, other.value, flags=CONTRACT))

    def __mul__(self, other: Any) -> Any:
        return self._with(self.builder.fmul(self.value, self._factor(other), flags=CONTRACT))

    def _with(self, value: Any) -> Any:
        return type(self)(self.builder, value)

    def _factor(self, other: Any) -> Any:
        return constant(self.value.type, other) if isinstance(other, float) else other.value


class _Both(_Value):
    # x and y side by side in one register.

    __slots__ = ()

    @property
    def x(self) -> _Value:
        return self._element(0)

    @property
    def y(self) -> _Value:
        return self._element(1)

    def _element(self, index: int) -> _Value:
        return _Value(self.builder, extract(self.builder, self.value, index))

    def _factor(self, other: Any) -> Any:
        factor = super()._factor(other)
        return factor if factor.type == self.value.type else spread(self.builder, 2, factor)


class _Registers(Values[_Value]):
    # One parameter set: numbers, and pairs in one register.

    def both(self, x: _Value, y: _Value) -> Any:
        return _Both(x.builder, join(x.builder, x.value, y.value))

    def fused(self, value: Any, factor: float, rest: Any) -> Any:
        builder, kind = value.builder, value.value.type
        signature = ir.FunctionType(kind, [kind] * 3)
        name = f"llvm.fmuladd.v{kind.count}f64"
        function = cgutils.get_or_insert_function(builder.module, signature, name)
        share = constant(kind, factor)
        return _Both(builder, builder.call(function, [value.value, share, rest.value]))

    def products(self, y: Sequence[_Value], r: Sequence[_Value], n: int) -> tuple[_Value, _Value]:
        # Both sums in one register, but for the newest terms: the sums wait for one another there.
        if n == 2:
            return y[1] * y[1], y[1] * r[1]
        square, product = y[n - 1] * (y[1] * 2.0), y[n - 1] * r[1]
        if n > 3:
            older = [self.both(y[n - i], r[n - i]) * y[i] for i in newest_last(n)[:-2]]
            sums = reduce(add, older)
            square, product = sums.x + square, sums.y + product
        return square, product + y[1] * r[n - 1]


def _expansion(field: RightHandSide, width: int) -> Any:
    backend: Any = _Registers() if width == 1 else Values[_Value]()

    @intrinsic
    def expand(_typing: Any, series: Any, given: Any, order: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            memory, given, order = values

            def load(start: Any, place: int) -> _Value:
                address = pointer(builder, start, place, width)
                return _Value(builder, builder.load(address, align=ALIGNMENT))

            # The coefficients of x and y alternate.
            state = [load(memory, place) for place in (0, 2, 1, 3)]
            if isinstance(signature.args[1], types.BaseTuple):
                constants = [
                    _Value(builder, value) for value in cgutils.unpack_tuple(builder, given)
                ]
            else:
                constants = [load(given, place) for place in range(len(Constants._fields))]
            done = builder.append_basic_block("expanded")
            terms = islice(recurrences(field, state, constants, backend), MAX_ORDER)
            rows = list[Any]()
            for reached, term in enumerate(terms, 1):
                if isinstance(term, _Both):
                    # What is stored at once can be loaded at once.
                    rows.append(term.value)
                    if len(rows) == GROUP:
                        address = pointer(builder, memory, 2 * (reached + 2 - GROUP), 1)
                        group = concatenate(builder, rows)
                        address = builder.bitcast(address, group.type.as_pointer())
                        builder.store(group, address, align=ALIGNMENT)
                        rows = []
                else:
                    for place, value in enumerate((term.x, term.y), 2 * (reached + 1)):
                        address = pointer(builder, memory, place, width)
                        builder.store(value.value, address, align=ALIGNMENT)
                if MIN_ORDER <= reached < MAX_ORDER and reached % ORDER_STEP == 0:
                    further = builder.append_basic_block(f"order_{reached + 1}")
                    wanted = builder.icmp_signed(">", order, order.type(reached))
                    builder.cbranch(wanted, further, done)
                    builder.position_at_end(further)
            builder.branch(done)
            builder.position_at_end(done)
            return context.get_dummy_value()

        return types.void(series, given, order), generate

    return expand


expand_linear = _expansion(RightHandSide.LINEAR, 1)
expand_cubic = _expansion(RightHandSide.CUBIC, 1)
expand_cubic_lanes = _expansion(RightHandSide.CUBIC, LANES)
expand_linear_lanes = _expansion(RightHandSide.LINEAR, LANES)
