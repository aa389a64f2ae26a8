"""The rightmost root of the characteristic quartic, on arrays."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_POLISHES: Final = 3
_DESCENT: Final = 8
_AMISS: Final = 4e-8
# If the slope at a root is less than this part of its terms, another root is close.
_COALESCING: Final = 1e-3


def rightmost_real_part(
    c1: FloatArray, a: FloatArray, c2: FloatArray, b: FloatArray, d: FloatArray
) -> FloatArray:
    """Greatest real part of the roots of (s² + c1 s + a)(s² + c2 s + b) − d.

    Shifted by the mean decay g = (c1 + c2)/4 the quartic has no cubic term, and is the product of
    z² + u z + v and z² − u z + w, where u² is the greatest root of the resolvent cubic (Descartes'
    solution). Equal dampings give u = 0 or a double root of the cubic, so the coefficients are
    formed from the two factors, without the cancellation of the expanded quartic. Where another
    root is close to the one found, the closed form loses accuracy: for these few points the
    eigenvalues of a matrix are computed.

    Coefficients are arrays of equal shape, scaled to the order of one, with c1, c2 ≥ 0. Accurate to
    rounding of the greatest |s|, and to its root where roots coincide.
    """
    g = 0.25 * (c1 + c2)
    e = 0.5 * (c1 - c2)
    a0, b0 = a + g * (g - c1), b + g * (g - c2)
    p = a0 + b0 - e * e
    q = e * (b0 - a0)
    # p² − 4 r for r = a0 b0 − d.
    gap = (a0 - b0) ** 2 + 4.0 * d - e * e * (2.0 * (a0 + b0) - e * e)
    square = _resolvent(p, gap, q)
    u = np.sqrt(square)
    # (w − v)/2 = q/(2u), whose square is also (p + u²)²/4 − r: the one fails at u = 0, the other
    # if its terms cancel.
    mean = 0.5 * (p + square)
    terms = (0.25 * gap, square * (0.5 * p + 0.25 * square))
    total = terms[0] + terms[1]
    cancelled = total < 0.25 * (np.abs(terms[0]) + np.abs(terms[1]))
    apart = np.copysign(np.sqrt(np.maximum(total, 0.0)), q)
    apart = np.divide(0.5 * q, u, out=apart, where=cancelled & (u > 0.0))
    near, far = (
        -0.5 * sign * u + np.sqrt(0.25 * square - (mean - sign * apart) + 0.0j)
        for sign in (1.0, -1.0)
    )
    root = np.where(near.real >= far.real, near, far) - g
    root = _polished(root, (c1, a), (c2, b), d)
    found: FloatArray = root.real
    close = np.flatnonzero(_coalescing(root, (c1, a), (c2, b)))
    if close.size > 0:
        found[close] = _greatest(c1[close], a[close], c2[close], b[close], d[close])
    return found


def _coalescing(
    root: ComplexArray, first: tuple[FloatArray, FloatArray], second: tuple[FloatArray, FloatArray]
) -> NDArray[np.bool_]:
    # Where the slope of the quartic is small beside its terms.
    (c1, a), (c2, b) = first, second

    def slope(s: Any) -> Any:
        return (2.0 * s + c1) * ((s + c2) * s + b) + ((s + c1) * s + a) * (2.0 * s + c2)

    close: NDArray[np.bool_] = np.abs(slope(root)) < _COALESCING * slope(np.abs(root))
    return close


def _greatest(
    c1: FloatArray, a: FloatArray, c2: FloatArray, b: FloatArray, d: FloatArray
) -> FloatArray:
    # The two oscillators with a coupling whose product is d.
    matrices = np.zeros((d.size, 4, 4))
    matrices[:, 0, 1] = matrices[:, 2, 3] = 1.0
    matrices[:, 1, 0], matrices[:, 1, 1] = -a, -c1
    matrices[:, 3, 2], matrices[:, 3, 3] = -b, -c2
    matrices[:, 3, 0] = np.sqrt(np.abs(d))
    matrices[:, 1, 2] = np.copysign(matrices[:, 3, 0], d)
    finite = np.isfinite(matrices).all(axis=(1, 2))
    greatest = np.full(d.size, np.nan)
    greatest[finite] = np.linalg.eigvals(matrices[finite]).real.max(axis=1)
    return greatest


def _polished(
    root: ComplexArray,
    first: tuple[FloatArray, FloatArray],
    second: tuple[FloatArray, FloatArray],
    d: FloatArray,
) -> ComplexArray:
    # Newton's method on the product, where it reduces the residual: with strong damping the
    # shift has cancelled digits.
    (c1, a), (c2, b) = first, second

    def residual(s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        one, other = (s + c1) * s + a, (s + c2) * s + b
        return one * other - d, (2.0 * s + c1) * other + one * (2.0 * s + c2)

    value, slope = residual(root)
    for _ in range(_POLISHES):
        new = root - np.divide(value, slope, out=np.zeros_like(root), where=slope != 0.0)
        new_value, new_slope = residual(new)
        better = np.abs(new_value) < np.abs(value)
        root = np.where(better, new, root)
        value, slope = np.where(better, new_value, value), np.where(better, new_slope, slope)
    return root


def _resolvent(p: FloatArray, gap: FloatArray, q: FloatArray) -> FloatArray:
    # Greatest root U ≥ 0 of U³ + 2 p U² + gap U − q², by Newton's method from the closed form.
    third = -2.0 * p / 3.0
    slope = third * third - gap / 3.0
    value = third * third * third - 0.5 * third * gap + 0.5 * q * q
    radius = np.sqrt(np.maximum(slope, 0.0))
    cosine = np.clip(value / np.where(radius > 0.0, radius**3, 1.0), -1.0, 1.0)
    three = third + 2.0 * radius * np.cos(np.arccos(cosine) / 3.0)
    root = np.sqrt(np.maximum(value * value - slope * slope * slope, 0.0))
    large = np.cbrt(value + np.copysign(root, value))
    one = third + large + np.divide(slope, large, out=np.zeros_like(large), where=large != 0.0)
    single = value * value > slope * slope * slope
    # The closed form is wrong by the root of rounding where roots meet. From a start that lies
    # right of the greatest one, Newton's method converges to it from above.
    found = np.where(single, one, three)
    found = np.maximum(found, 0.0) + _AMISS * (np.abs(third) + radius)
    for _ in range(_DESCENT):
        residual = ((found + 2.0 * p) * found + gap) * found - q * q
        steepness = (3.0 * found + 4.0 * p) * found + gap
        step = np.divide(residual, steepness, out=np.zeros_like(found), where=steepness > 0.0)
        found = np.maximum(found - step, 0.0)
    return found
