"""Variations of sign of Bernstein coefficients, of one polynomial in each lane, straight-line."""

import math
from typing import Any, Final

from llvmlite import ir
from numba import types

from .expansion import ROWS
from .jit import intrinsic
from .vectors import ALIGNMENT, CONTRACT, LANES, Vector, constant, pointer

# Coefficients of a slope; those of a lower degree are followed by zeros.
_SIZE: Final = ROWS - 1


@intrinsic
def slope_variations(_typing: Any, c: Any, first: Any, stride: Any, h: Any) -> Any:
    """Variations of sign of the slope's Bernstein coefficients on [0, h]; many if one is zero.

    The polynomial's coefficients are every `stride`-th vector from `first`, `ROWS` of them. Without
    a variation the slope has no root inside; with one it has exactly one.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        start, place, step, h = values
        place = context.cast(builder, place, signature.args[1], types.int64)
        step = context.cast(builder, step, signature.args[2], types.int64)
        kind, power = h.type, h
        b = []
        for n in range(_SIZE):
            place = builder.add(place, step)
            term = builder.load(pointer(builder, start, place, LANES), align=ALIGNMENT)
            # Divided by its binomial, a coefficient is a difference of Bernstein coefficients.
            factor = constant(kind, (n + 1) / math.comb(_SIZE - 1, n))
            b.append(builder.fmul(builder.fmul(term, power, flags=CONTRACT), factor))
            power = builder.fmul(power, h)
        for least in range(1, _SIZE):
            for n in range(_SIZE - 1, least - 1, -1):
                b[n] = builder.fadd(b[n], b[n - 1])
        one, many = constant(kind, 1.0), constant(kind, float(_SIZE))
        zero = count = constant(kind, 0.0)
        none = ir.Constant(ir.VectorType(ir.IntType(1), LANES), None)
        vanishing, last = none, None
        for value in b:
            positive = builder.fcmp_ordered(">", value, zero)
            vanishing = builder.or_(vanishing, builder.fcmp_ordered("==", value, zero))
            if last is not None:
                changed = builder.xor(positive, last)
                count = builder.select(changed, builder.fadd(count, one), count)
            last = positive
        return builder.select(vanishing, many, count)

    return Vector(LANES)(c, first, stride, h), generate
