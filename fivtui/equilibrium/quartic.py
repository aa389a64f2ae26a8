"""The rightmost root of the characteristic quartic, on arrays.

Only arithmetic and square roots are used, which IEEE 754 defines to the last bit. Growth rates are
then the same on every machine, unlike those of a mathematical library or LAPACK. Complex numbers
are pairs of real arrays: NumPy fuses products and sums of its complex numbers where it can.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Complex = tuple[FloatArray, FloatArray]
# (c1, a), (c2, b) and d of (s² + c1 s + a)(s² + c2 s + b) − d.
Quartic = tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray], FloatArray]

# Iterations of Newton's method for a root of the quartic, and for one of its resolvent cubic.
_ROOT_ITERATIONS: Final = 3
_RESOLVENT_ITERATIONS: Final = 8
# Distance above the closed form at which the resolvent's iteration starts, relative to the root.
_START_MARGIN: Final = 4e-8
# Slope at a root, relative to the terms of the slope, below which another root is close.
_COALESCING_SLOPE: Final = 1e-3
# Iterations of Newton's method, which converges quadratically: in `_outer_root`, from a start of at
# most 2 · 1.07 times the root (see `cube_root_bound`), and for two close roots.
_OUTER_ROOT_ITERATIONS: Final = 9
_CLOSE_ROOT_ITERATIONS: Final = 6
_ROUNDING: Final = 2.0**-50
# The bits of a positive float, read as an integer, grow like its logarithm: a third of them plus
# this constant are the bits of its cube root to 3.3 %. The factor makes that an upper bound.
_CUBE_ROOT_BITS: Final = 0x2A9F7893_00000000
_CUBE_ROOT_MARGIN: Final = 1.034


def rightmost_real_part(
    c1: FloatArray, a: FloatArray, c2: FloatArray, b: FloatArray, d: FloatArray
) -> FloatArray:
    """Greatest real part of the roots of (s² + c1 s + a)(s² + c2 s + b) − d.

    Shifted by the mean decay g = (c1 + c2)/4 the quartic has no cubic term. It is the product of
    z² + u z + v and z² − u z + w, where u² is the greatest root of the resolvent cubic (Descartes'
    solution). With equal dampings u is 0 or the cubic has a double root, which errors of its
    coefficients change most. So these are formed from the two given factors: those of the expanded
    quartic would lose digits by cancellation. The closed form loses accuracy where two roots are
    close. Both are then solved for again, from the point between them at which the slope vanishes.

    Coefficients are arrays of equal shape, scaled to the order of one, with c1, c2 ≥ 0. The error
    relative to the greatest |s| is of the order of rounding, 1e-16; where roots coincide, 1e-8.
    """
    # z = s + g turns the factors into z² + e z + a0 and z² − e z + b0, and the quartic into
    # z⁴ + p z² + q z + r.
    g = 0.25 * (c1 + c2)
    e = 0.5 * (c1 - c2)
    a0, b0 = a + g * (g - c1), b + g * (g - c2)
    p = a0 + b0 - e * e
    q = e * (b0 - a0)
    # p² − 4 r for r = a0 b0 − d.
    gap = (a0 - b0) ** 2 + 4.0 * d - e * e * (2.0 * (a0 + b0) - e * e)
    u_squared = _resolvent(p, gap, q)
    u = np.sqrt(u_squared)
    # (w − v)/2 = q/(2u), whose square is also (p + u²)²/4 − r: the first form fails at u = 0, the
    # second if its terms cancel.
    mean = 0.5 * (p + u_squared)
    terms = (0.25 * gap, u_squared * (0.5 * p + 0.25 * u_squared))
    total = terms[0] + terms[1]
    cancelled = total < 0.25 * (np.abs(terms[0]) + np.abs(terms[1]))
    half_difference = np.copysign(np.sqrt(np.maximum(total, 0.0)), q)
    half_difference = np.divide(0.5 * q, u, out=half_difference, where=cancelled & (u > 0.0))
    # The greater roots −u/2 + √(u²/4 − v) and u/2 + √(u²/4 − w): v, w = mean ∓ half_difference.
    first_root, second_root = (
        _factor_root(-0.5 * sign * u, 0.25 * u_squared - (mean - sign * half_difference))
        for sign in (1.0, -1.0)
    )
    root = _select(first_root[0] >= second_root[0], first_root, second_root)
    quartic = (c1, a), (c2, b), d
    root = _polish_root((root[0] - g, root[1]), quartic)
    real_part = root[0]
    close = np.flatnonzero(_is_coalescing(root, quartic))
    if close.size > 0:
        coefficients = (c1[close], a[close]), (c2[close], b[close]), d[close]
        real_part[close] = _rightmost_of_two((root[0][close], root[1][close]), coefficients)
    return real_part


def cube_root_bound(value: FloatArray) -> FloatArray:
    """An upper bound of the cube root of a positive number, at most 7 % above it."""
    bits = value.view(np.int64) // 3 + _CUBE_ROOT_BITS
    return _CUBE_ROOT_MARGIN * bits.view(np.float64)


def _factor_root(mean: FloatArray, radicand: FloatArray) -> Complex:
    # mean + √radicand
    return mean + np.sqrt(np.maximum(radicand, 0.0)), np.sqrt(np.maximum(-radicand, 0.0))


def _is_coalescing(root: Complex, quartic: Quartic) -> NDArray[np.bool_]:
    # Whether the slope of the quartic is small relative to its terms, as close to another root.
    (c1, a), (c2, b), _ = quartic
    slope, s = _size(_value_and_slope(root, quartic)[1]), _size(root)
    terms = (2.0 * s + c1) * ((s + c2) * s + b) + ((s + c1) * s + a) * (2.0 * s + c2)
    close: NDArray[np.bool_] = slope < _COALESCING_SLOPE * terms
    return close


def _polish_root(root: Complex, quartic: Quartic) -> Complex:
    # Newton's method on the product, where it reduces the residual: with strong damping the shift
    # by the mean decay loses digits.
    value, slope = _value_and_slope(root, quartic)
    for _ in range(_ROOT_ITERATIONS):
        new = _difference(root, _ratio(value, slope))
        new_value, new_slope = _value_and_slope(new, quartic)
        better = _size(new_value) < _size(value)
        root = _select(better, new, root)
        value, slope = _select(better, new_value, value), _select(better, new_slope, slope)
    return root


def _rightmost_of_two(root: Complex, quartic: Quartic) -> FloatArray:
    # The greater real part of a root and its close neighbour. Both are c + δ near the centre c, at
    # which the slope vanishes to rounding: (bend + third δ + δ²) δ² + slope δ + value = 0, where
    # `bend` is half the second and `third` a sixth of the third derivative.
    centre = root
    for _ in range(_CLOSE_ROOT_ITERATIONS):
        _, slope = _value_and_slope(centre, quartic)
        bend, _ = _bend_and_third(centre, quartic)
        centre = _difference(centre, _ratio(_multiple(0.5, slope), bend))
    value, slope = _value_and_slope(centre, quartic)
    bend, third = _bend_and_third(centre, quartic)
    roots = []
    for sign in (1.0, -1.0):
        offset = _multiple(0.0, centre)
        for _ in range(_CLOSE_ROOT_ITERATIONS):
            leading = _sum(bend, _product(_sum(third, offset), offset))
            half = _multiple(0.5, _ratio(slope, leading))
            radicand = _difference(_product(half, half), _ratio(value, leading))
            offset = _difference(_multiple(sign, _square_root(radicand)), half)
        roots.append(_sum(centre, offset))
    residual = np.maximum(*(_size(_value_and_slope(candidate, quartic)[0]) for candidate in roots))
    tolerance = _size(_value_and_slope(root, quartic)[0]) + _ROUNDING * _term_sum(root, quartic)
    # A pair that solves the quartic less well than the given root has not converged.
    return np.where(residual <= tolerance, np.maximum(roots[0][0], roots[1][0]), root[0])


def _term_sum(s: Complex, quartic: Quartic) -> FloatArray:
    # Sum of the absolute values of the terms of the quartic at s.
    (c1, a), (c2, b), d = quartic
    size = _size(s)
    return ((size + c1) * size + a) * ((size + c2) * size + b) + np.abs(d)


def _value_and_slope(s: Complex, quartic: Quartic) -> tuple[Complex, Complex]:
    first, second, first_slope, second_slope = _factors(s, quartic)
    real, imaginary = _product(first, second)
    slope = _sum(_product(first_slope, second), _product(first, second_slope))
    return (real - quartic[2], imaginary), slope


def _bend_and_third(s: Complex, quartic: Quartic) -> tuple[Complex, Complex]:
    # `bend`, half the second derivative, and `third`, a sixth of the third derivative.
    first, second, first_slope, second_slope = _factors(s, quartic)
    bend = _sum(_sum(first, second), _product(first_slope, second_slope))
    return bend, _sum(first_slope, second_slope)


def _factors(s: Complex, quartic: Quartic) -> tuple[Complex, Complex, Complex, Complex]:
    # Both quadratic factors, and their slopes.
    (c1, a), (c2, b), _ = quartic
    first, second = (_product((s[0] + damping, s[1]), s) for damping in (c1, c2))
    slopes = [(2.0 * s[0] + damping, 2.0 * s[1]) for damping in (c1, c2)]
    return (first[0] + a, first[1]), (second[0] + b, second[1]), slopes[0], slopes[1]


def _resolvent(p: FloatArray, gap: FloatArray, q: FloatArray) -> FloatArray:
    # Greatest root U ≥ 0 of U³ + 2 p U² + gap U − q², by Newton's method from a closed form. With
    # U = t − 2 p/3 the cubic is t³ − 3 slope t − 2 value.
    shift = -2.0 * p / 3.0
    slope = shift * shift - gap / 3.0
    value = shift * shift * shift - 0.5 * shift * gap + 0.5 * q * q
    outer = _outer_root(slope, np.abs(value))
    # Where value < 0, −outer is a root: the only one, or the least of three. The other two solve
    # t² − outer t + outer² − 3 slope = 0.
    has_single_root = value * value > slope * slope * slope
    inner = 0.5 * (outer + np.sqrt(np.maximum(12.0 * slope - 3.0 * outer * outer, 0.0)))
    greatest = np.where(value >= 0.0, outer, np.where(has_single_root, -outer, inner))
    # Where roots meet, the closed form is wrong by the square root of rounding. From a start above
    # the greatest root Newton's method converges to it from above.
    root = np.maximum(shift + greatest, 0.0) + _START_MARGIN * (np.abs(shift) + outer)
    for _ in range(_RESOLVENT_ITERATIONS):
        residual = ((root + 2.0 * p) * root + gap) * root - q * q
        steepness = (3.0 * root + 4.0 * p) * root + gap
        step = np.divide(residual, steepness, out=np.zeros_like(root), where=steepness > 0.0)
        root = np.maximum(root - step, 0.0)
    return root


def _outer_root(slope: FloatArray, value: FloatArray) -> FloatArray:
    # Greatest root of t³ − 3 slope t − 2 value for value ≥ 0, by Newton's method from above, where
    # the cubic is convex.
    t = 2.0 * np.maximum(np.sqrt(np.maximum(slope, 0.0)), cube_root_bound(value))
    # For slope < 0 the root is also below that of −3 slope t − 2 value.
    linear = np.divide(value, -1.5 * slope, out=np.full_like(t, np.inf), where=slope < 0.0)
    t = np.minimum(t, linear)
    for _ in range(_OUTER_ROOT_ITERATIONS):
        residual = (t * t - 3.0 * slope) * t - 2.0 * value
        steepness = 3.0 * (t * t - slope)
        step = np.divide(residual, steepness, out=np.zeros_like(t), where=steepness > 0.0)
        t = np.maximum(t - np.maximum(step, 0.0), 0.0)
    return t


def _size(x: Complex) -> FloatArray:
    # The greater absolute value of real and imaginary part.
    size: FloatArray = np.maximum(np.abs(x[0]), np.abs(x[1]))
    return size


def _select(condition: NDArray[np.bool_], x: Complex, y: Complex) -> Complex:
    return np.where(condition, x[0], y[0]), np.where(condition, x[1], y[1])


def _multiple(factor: float, x: Complex) -> Complex:
    return factor * x[0], factor * x[1]


def _sum(x: Complex, y: Complex) -> Complex:
    return x[0] + y[0], x[1] + y[1]


def _difference(x: Complex, y: Complex) -> Complex:
    return x[0] - y[0], x[1] - y[1]


def _product(x: Complex, y: Complex) -> Complex:
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]


def _ratio(x: Complex, y: Complex) -> Complex:
    # Zero where the divisor is zero.
    size = _size(y)
    real, imaginary = _direction(y, size)
    divisor = size * (real * real + imaginary * imaginary)
    parts = x[0] * real + x[1] * imaginary, x[1] * real - x[0] * imaginary
    first, second = (
        np.divide(part, divisor, out=np.zeros_like(divisor), where=divisor > 0.0) for part in parts
    )
    return first, second


def _square_root(x: Complex) -> Complex:
    # The root with a nonnegative real part.
    size = _size(x)
    real, imaginary = _direction(x, size)
    length = np.sqrt(real * real + imaginary * imaginary)
    larger = np.sqrt(0.5 * (length + np.abs(real)))
    smaller = np.divide(0.5 * imaginary, larger, out=np.zeros_like(size), where=larger > 0.0)
    swapped = np.abs(smaller), np.copysign(larger, imaginary)
    first, second = _select(real >= 0.0, (larger, smaller), swapped)
    return first * np.sqrt(size), second * np.sqrt(size)


def _direction(x: Complex, size: FloatArray) -> Complex:
    # x/size, zero where the size is zero: squares of small numbers would underflow.
    first, second = (np.divide(part, size, out=np.zeros_like(size), where=size > 0.0) for part in x)
    return first, second
