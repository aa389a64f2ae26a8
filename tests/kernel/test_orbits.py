"""Periodic orbits of the compiled kernel, against the equations in Python; bits of all variants."""

import ctypes
from collections.abc import Iterator

import numpy as np
import pytest

from fivtui import Parameters, branch
from fivtui.kernel import native, orbits
from fivtui.model import System
from fivtui.orbits.curves import arclength
from fivtui.orbits.curves.arclength import OrbitCurve, OrbitOnCurve
from fivtui.orbits.curves.flow import FloatArray, SliderBeltFlow

from .test_same_bits import processor_has

SCALES = np.array([0.7, 4.0, 0.7, 4.0, 1.2, 0.25, 64.0])


def searches(count: int) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Guesses near limit cycles of the base set, off the belt too, and planes through them."""
    random = np.random.default_rng(count)
    points = branch(None, "mu", low=0.25, high=0.6).points[::9]
    for point in points:
        exact = np.array([*point.start, point.period, point.value, 80.0])[: 5 + count]
        guess = exact / SCALES[: 5 + count]
        yield (
            guess * (1.0 + 1e-4 * random.normal(size=guess.size)),
            np.linalg.qr(random.normal(size=(guess.size, 1 + count)))[0].T,
        )


def solved(count: int, *, turning: bool) -> list[OrbitOnCurve | None]:
    flow = SliderBeltFlow(System(Parameters()), ("mu", "F")[:count])
    curve = OrbitCurve(flow, SCALES[: 5 + count])
    return [curve.solve(*search, tangent_across=turning) for search in searches(count)]


def parts(orbit: OrbitOnCurve | None) -> FloatArray:
    assert orbit is not None
    arrays = (
        orbit.unknowns,
        orbit.tangent,
        orbit.flow_direction,
        orbit.monodromy.ravel(),
        orbit.extremes,
    )
    return np.concatenate([*arrays, [orbit.determinant]])


@pytest.mark.parametrize("turning", [True, False])
@pytest.mark.parametrize("count", [1, 2])
def test_the_kernel_finds_what_the_equations_in_python_find(
    count: int, turning: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = solved(count, turning=turning)
    monkeypatch.setattr(arclength, "why_interpreted", lambda: "not looked at")
    plain = solved(count, turning=turning)
    assert len(compiled) >= 6
    for compiled_orbit, plain_orbit in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(parts(compiled_orbit), parts(plain_orbit), rtol=1e-7, atol=1e-9)
        assert compiled_orbit is not None
        assert plain_orbit is not None
        assert compiled_orbit.unknowns == pytest.approx(plain_orbit.unknowns, abs=1e-11)


@pytest.mark.parametrize("instruction_set", native.INSTRUCTION_SETS[:-1])
def test_instruction_sets_find_the_same_orbits(
    instruction_set: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not processor_has(instruction_set):
        pytest.skip(f"this processor lacks {instruction_set}")
    expected = solved(2, turning=True)
    monkeypatch.setattr(arclength, "load_kernel", lambda: native.Kernel(instruction_set))
    for orbit, expected_orbit in zip(solved(2, turning=True), expected, strict=True):
        np.testing.assert_array_equal(parts(orbit), parts(expected_orbit))


@pytest.mark.parametrize(
    "change",
    [
        (5, -1.0),  # μ below zero
        (4, -1.0),  # a period below zero
        (0, 1e300),  # a motion that overflows
        (4, 1e9),  # a period that is too long
    ],
)
def test_searches_from_invalid_guesses_find_no_orbit(change: tuple[int, float]) -> None:
    column, value = change
    curve = OrbitCurve(SliderBeltFlow(System(Parameters()), ("mu",)), SCALES[:6])
    guess, planes = next(searches(1))
    guess[column] = value
    assert curve.solve(guess, planes) is None


def test_python_and_the_kernel_mean_the_same_structures() -> None:
    library = native._load_library()
    assert library.fivtui_orbit_request_size_baseline() == ctypes.sizeof(orbits._Request)
    assert library.fivtui_orbit_found_size_baseline() == 8 * orbits._RESULT_SIZE
