"""SIMD vectors of floats as numba types: arithmetic on 2 or 8 numbers at once.

A vector is one value of the compiler, so that nothing depends on loops being recognised: where the
machine's registers are narrower, LLVM splits it. Operators and comparisons work element by element;
a number beside a vector stands for a vector of equal elements; comparisons give masks.
"""

import operator
from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, models, register_model, type_callable

from .jit import intrinsic

LANES: Final = 8
# All of them.
LANE_BITS: Final = (1 << LANES) - 1

# A product and a sum may become one fused operation, rounded once.
CONTRACT: Final = ("contract",)
# Bytes; what numpy guarantees of every float64.
ALIGNMENT: Final = 8
_DOUBLE: Final = ir.DoubleType()
_INDEX: Final = ir.IntType(32)
_LONG: Final = ir.IntType(64)


class Vector(types.Type):
    """A vector of float64.

    Parameters
    ----------
    width : int
        Number of elements.
    """

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(f"Vector({width})")


class Mask(types.Type):
    """A vector of truth values.

    Parameters
    ----------
    width : int
        Number of elements.
    """

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(f"Mask({width})")


def vector_type(width: int) -> ir.VectorType:
    """The compiler's type of a vector of float64."""
    return ir.VectorType(_DOUBLE, width)


@register_model(Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, vector: Vector) -> None:
        super().__init__(manager, vector, vector_type(vector.width))


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, mask: Mask) -> None:
        super().__init__(manager, mask, ir.VectorType(ir.IntType(1), mask.width))


def constant(kind: Any, value: float) -> Any:
    """A constant of the compiler: a number, or a vector of equal ones.

    Parameters
    ----------
    kind : llvmlite type
        Double, or a vector of doubles.
    value : float
        Its value.

    Returns
    -------
    llvmlite constant
        Of that type.
    """
    count = kind.count if isinstance(kind, ir.VectorType) else None
    return ir.Constant(kind, value if count is None else [value] * count)


def spread(builder: Any, width: int, value: Any) -> Any:
    """A compiler's vector of equal numbers."""
    kind = vector_type(width)
    empty = ir.Constant(kind, ir.Undefined)
    first = builder.insert_element(empty, value, _INDEX(0))
    return builder.shuffle_vector(first, empty, ir.Constant(ir.VectorType(_INDEX, width), None))


def join(builder: Any, *values: Any) -> Any:
    """A compiler's vector of the numbers given."""
    result = ir.Constant(vector_type(len(values)), ir.Undefined)
    for index, value in enumerate(values):
        result = builder.insert_element(result, value, _INDEX(index))
    return result


def concatenate(builder: Any, vectors: list[Any]) -> Any:
    """A compiler's vector of the elements of others; their number is a power of two."""
    while len(vectors) > 1:
        places = ir.Constant(
            ir.VectorType(_INDEX, 2 * vectors[0].type.count), list(range(2 * vectors[0].type.count))
        )
        vectors = [
            builder.shuffle_vector(one, other, places)
            for one, other in zip(vectors[::2], vectors[1::2], strict=True)
        ]
    return vectors[0]


def extract(builder: Any, vector: Any, index: int) -> Any:
    """A number of a compiler's vector."""
    return builder.extract_element(vector, _INDEX(index))


def _vectors(context: Any, builder: Any, width: int, kinds: Any, values: Any) -> list[Any]:
    # The operands of an operation, numbers spread into vectors.
    return [
        value
        if isinstance(kind, Vector)
        else spread(builder, width, context.cast(builder, value, kind, types.float64))
        for kind, value in zip(kinds, values, strict=True)
    ]


def _width(*kinds: Any) -> int | None:
    # The common width of the vectors among the operands, None if the operation is not ours.
    if not all(isinstance(kind, (Vector, types.Number)) for kind in kinds):
        return None
    widths = {kind.width for kind in kinds if isinstance(kind, Vector)}
    return widths.pop() if len(widths) == 1 else None


def _elementwise(count: int, emit: Callable[..., Any], result: type[Any] = Vector) -> Any:
    # An operation on vectors and numbers, from what it emits for vectors.
    def typed(*kinds: Any) -> Any:
        width = _width(*kinds)
        if width is None:
            return None

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return emit(builder, *_vectors(context, builder, width, signature.args, values))

        return result(width)(*kinds), generate

    if count == 1:

        @intrinsic
        def unary(_typing: Any, a: Any) -> Any:
            return typed(a)

        return unary

    @intrinsic
    def binary(_typing: Any, a: Any, b: Any) -> Any:
        return typed(a, b)

    return binary


def _call(name: str) -> Callable[..., Any]:
    def emit(builder: Any, *values: Any) -> Any:
        kind = values[0].type
        signature = ir.FunctionType(kind, [kind] * len(values))
        function = cgutils.get_or_insert_function(
            builder.module, signature, f"llvm.{name}.v{kind.count}f64"
        )
        return builder.call(function, values)

    return emit


def _arithmetic(name: str) -> Callable[..., Any]:
    return lambda builder, a, b: getattr(builder, name)(a, b, flags=CONTRACT)


def _comparison(symbol: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(symbol, a, b)


def _operator(python: Any, emit: Callable[..., Any], result: type[Any] = Vector) -> None:
    # Teaches numba a Python operator.
    @type_callable(python)
    def _(_context: Any) -> Any:
        def typed(a, b):  # type: ignore[no-untyped-def]  # numba compares names and annotations
            width = _width(a, b)
            return None if width is None else result(width)

        return typed

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        width = signature.return_type.width
        return emit(builder, *_vectors(context, builder, width, signature.args, values))

    for kinds in ((Vector, Vector), (Vector, types.Number), (types.Number, Vector)):
        lower_builtin(python, *kinds)(generate)


for _python, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_python, _arithmetic(_name))
for _python, _symbol in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _operator(_python, _comparison(_symbol), Mask)


def _logical(python: Any, emit: Callable[..., Any]) -> None:
    # Teaches numba a Python operator on masks.
    @type_callable(python)
    def _(_context: Any) -> Any:
        def typed(a, b):  # type: ignore[no-untyped-def]  # numba compares names and annotations
            return a if isinstance(a, Mask) and a == b else None

        return typed

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return emit(builder, *values)

    lower_builtin(python, Mask, Mask)(generate)


_logical(operator.and_, lambda builder, a, b: builder.and_(a, b))
_logical(operator.or_, lambda builder, a, b: builder.or_(a, b))
_logical(operator.xor, lambda builder, a, b: builder.xor(a, b))


@intrinsic
def negated(_typing: Any, mask: Any) -> Any:
    """The mask of what is not in a mask."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return builder.not_(values[0])

    return mask(mask), generate


@intrinsic
def choose(_typing: Any, mask: Any, a: Any, b: Any) -> Any:
    """The elements of `a` where a mask is set, those of `b` elsewhere; numbers are spread."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        a, b = _vectors(context, builder, mask.width, signature.args[1:], values[1:])
        return builder.select(values[0], a, b)

    return Vector(mask.width)(mask, a, b), generate


absolute = _elementwise(1, _call("fabs"))
root = _elementwise(1, _call("sqrt"))
least = _elementwise(2, _call("minnum"))
greatest = _elementwise(2, _call("maxnum"))


@intrinsic
def splat(_typing: Any, number: Any) -> Any:
    """A vector of `LANES` equal numbers."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return spread(builder, LANES, values[0])

    return Vector(LANES)(types.float64), generate


@intrinsic
def powers(_typing: Any, t: Any, square: Any) -> Any:
    """The vector 1, 1, t, t, t², t², t³, t³."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        t, square = values
        one, cube = constant(_DOUBLE, 1.0), builder.fmul(t, square)
        return join(builder, one, one, t, t, square, square, cube, cube)

    return Vector(LANES)(types.float64, types.float64), generate


@intrinsic
def fold(_typing: Any, vector: Any) -> Any:
    """The sums of the elements at even and at odd places."""

    def generate(_context: Any, builder: Any, signature: Any, values: Any) -> Any:
        (value,), width = values, signature.args[0].width
        while width > 2:
            width //= 2
            empty = ir.Constant(value.type, ir.Undefined)
            halves = (
                builder.shuffle_vector(
                    value, empty, ir.Constant(ir.VectorType(_INDEX, width), list(places))
                )
                for places in (range(width), range(width, 2 * width))
            )
            value = builder.fadd(*halves)
        return value

    return Vector(2)(vector), generate


@intrinsic
def element(_typing: Any, vector: Any, index: Any) -> Any:
    """One number of a vector."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        position = context.cast(builder, values[1], signature.args[1], types.int32)
        return builder.extract_element(values[0], position)

    return types.float64(vector, index), generate


@intrinsic
def bits(_typing: Any, mask: Any) -> Any:
    """A mask as an integer, its first element in the lowest bit."""

    def generate(_context: Any, builder: Any, signature: Any, values: Any) -> Any:
        packed = builder.bitcast(values[0], ir.IntType(signature.args[0].width))
        return builder.zext(packed, _LONG)

    return types.int64(mask), generate


@intrinsic
def lanes_of(_typing: Any, number: Any) -> Any:
    """The lowest bits of an integer as a mask of `LANES`."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        packed = builder.trunc(values[0], ir.IntType(LANES))
        return builder.bitcast(packed, ir.VectorType(ir.IntType(1), LANES))

    return Mask(LANES)(types.int64), generate


@intrinsic
def ones(_typing: Any, number: Any) -> Any:
    """How many bits of an integer are set."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return builder.ctpop(values[0])

    return types.int64(types.int64), generate


@intrinsic
def lowest(_typing: Any, number: Any) -> Any:
    """The place of the lowest bit that is set; there is one."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return builder.cttz(values[0], ir.IntType(1)(1))

    return types.int64(types.int64), generate


@intrinsic
def as_integer(_typing: Any, number: Any) -> Any:
    """The 64 bits of a float64, read as an integer."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return builder.bitcast(values[0], _LONG)

    return types.int64(types.float64), generate


@intrinsic
def as_float(_typing: Any, number: Any) -> Any:
    """64 bits of an integer, read as a float64."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return builder.bitcast(values[0], _DOUBLE)

    return types.float64(types.int64), generate


@intrinsic
def bit_numbers(_typing: Any, vector: Any) -> Any:
    """The 64 bits of every element, read as an integer, as a float again."""

    def generate(_context: Any, builder: Any, signature: Any, values: Any) -> Any:
        integers = builder.bitcast(values[0], ir.VectorType(_LONG, signature.args[0].width))
        return builder.sitofp(integers, vector_type(signature.args[0].width))

    return vector(vector), generate


@intrinsic
def from_bit_numbers(_typing: Any, vector: Any) -> Any:
    """The inverse of `bit_numbers`, fractions cut off."""

    def generate(_context: Any, builder: Any, signature: Any, values: Any) -> Any:
        integers = builder.fptosi(values[0], ir.VectorType(_LONG, signature.args[0].width))
        return builder.bitcast(integers, vector_type(signature.args[0].width))

    return vector(vector), generate


@intrinsic
def memory(_typing: Any, array: Any) -> Any:
    """A C-contiguous array of float64 as bare memory.

    Its elements are `m[i]`, i >= 0. Neither are they counted from the end, nor is the array kept
    alive: both would cost the kernels more than the arithmetic.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    return types.CPointer(types.float64)(array), generate


@intrinsic
def behind(_typing: Any, start: Any, count: Any) -> Any:
    """The memory that begins `count` elements behind the beginning of another."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        step = context.cast(builder, values[1], signature.args[1], types.int64)
        return builder.gep(values[0], [step])

    return start(start, count), generate


@intrinsic
def aligned(_typing: Any, start: Any) -> Any:
    """The memory from the next multiple of `LANES` numbers on: vectors in whole cache lines."""

    def generate(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        line = 8 * LANES
        address = builder.ptrtoint(values[0], _LONG)
        address = builder.add(address, ir.Constant(_LONG, line - 1))
        address = builder.and_(address, ir.Constant(_LONG, -line))
        return builder.inttoptr(address, values[0].type)

    return start(start), generate


def pointer(builder: Any, memory: Any, place: int | Any, width: int) -> Any:
    """Address of one number or vector in memory.

    Parameters
    ----------
    builder : llvmlite builder
        Of the code being generated.
    memory : llvmlite value
        Memory of float64.
    place : int or llvmlite value
        Its position, in units of `width` numbers.
    width : int
        1 for a number, otherwise the width of a vector.

    Returns
    -------
    llvmlite value
        Typed pointer.
    """
    if isinstance(place, int):
        place = ir.Constant(_LONG, place)
    start = builder.gep(memory, [builder.mul(place, ir.Constant(_LONG, width))])
    return builder.bitcast(start, (_DOUBLE if width == 1 else vector_type(width)).as_pointer())


def _loading(width: int) -> Any:
    @intrinsic
    def load(_typing: Any, memory: Any, place: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            index = context.cast(builder, values[1], signature.args[1], types.int64)
            return builder.load(pointer(builder, values[0], index, width), align=ALIGNMENT)

        return Vector(width)(memory, place), generate

    return load


def _storing(width: int) -> Any:
    @intrinsic
    def store(_typing: Any, memory: Any, place: Any, vector: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            index = context.cast(builder, values[1], signature.args[1], types.int64)
            builder.store(values[2], pointer(builder, values[0], index, width), align=ALIGNMENT)
            return context.get_dummy_value()

        return types.void(memory, place, vector), generate

    return store


# Vectors in memory, one after the other, counted from 0.
load_pair, store_pair = _loading(2), _storing(2)
load_lanes, store_lanes = _loading(LANES), _storing(LANES)
