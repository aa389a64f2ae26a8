"""Periodic orbits of the kernel equal those in Python, and have the same bits on all processors."""

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

from .test_same_bits import COMPARED_SETS, processor_has

# Unknowns of an orbit: x, ẋ, y and ẏ at its start, its period, and one or two varied parameters.
STATE_AND_PERIOD = 5
# Their units: m, m/s, m, m/s, s, then those of μ and F.
SCALES = np.array([0.7, 4.0, 0.7, 4.0, 1.2, 0.25, 64.0])


def random_searches(varied_count: int) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Guesses near limit cycles of the default parameters, some with lift-off, and normals.

    The normals are those of the planes through the guess in which an orbit is searched.
    """
    count = STATE_AND_PERIOD + varied_count
    rng = np.random.default_rng(varied_count)
    points = branch(None, "mu", low=0.25, high=0.6).points[::9]
    for point in points:
        orbit_values = np.array([*point.start, point.period, point.value, 80.0])
        guess = (orbit_values / SCALES)[:count]
        yield (
            guess * (1.0 + 1e-4 * rng.normal(size=guess.size)),
            np.linalg.qr(rng.normal(size=(guess.size, 1 + varied_count)))[0].T,
        )


def solve_searches(varied_count: int, *, is_normal_to_flow: bool) -> list[OrbitOnCurve | None]:
    """Find orbits; the tangent of their curve is normal to the flow, or to the first normal."""
    flow = SliderBeltFlow(System(Parameters()), ("mu", "F")[:varied_count])
    curve = OrbitCurve(flow, SCALES[: STATE_AND_PERIOD + varied_count])
    return [
        curve.solve(*search, is_normal_to_flow=is_normal_to_flow)
        for search in random_searches(varied_count)
    ]


def orbit_numbers(orbit: OrbitOnCurve | None) -> FloatArray:
    assert orbit is not None
    arrays = (
        orbit.unknowns,
        orbit.tangent,
        orbit.flow_direction,
        orbit.monodromy.ravel(),
        orbit.extremes,
    )
    # The determinant is that of the linearised equations with the tangent as last row.
    return np.concatenate([*arrays, [orbit.determinant]])


@pytest.mark.parametrize("is_normal_to_flow", [True, False])
@pytest.mark.parametrize("varied_count", [1, 2])
def test_the_kernel_finds_the_same_orbits_as_python(
    varied_count: int, is_normal_to_flow: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled_orbits = solve_searches(varied_count, is_normal_to_flow=is_normal_to_flow)
    monkeypatch.setattr(arclength, "why_interpreted", lambda: "the test interprets")
    interpreted_orbits = solve_searches(varied_count, is_normal_to_flow=is_normal_to_flow)
    assert len(compiled_orbits) >= 6
    for compiled_orbit, interpreted_orbit in zip(compiled_orbits, interpreted_orbits, strict=True):
        np.testing.assert_allclose(
            orbit_numbers(compiled_orbit), orbit_numbers(interpreted_orbit), rtol=1e-7, atol=1e-9
        )
        assert compiled_orbit is not None
        assert interpreted_orbit is not None
        assert compiled_orbit.unknowns == pytest.approx(interpreted_orbit.unknowns, abs=1e-11)


@pytest.mark.parametrize("instruction_set", COMPARED_SETS)
def test_instruction_sets_find_the_same_orbits(
    instruction_set: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not processor_has(instruction_set):
        pytest.skip(f"this processor lacks {instruction_set}")
    expected = solve_searches(2, is_normal_to_flow=True)
    monkeypatch.setattr(arclength, "load_kernel", lambda: native.Kernel(instruction_set))
    for orbit, expected_orbit in zip(
        solve_searches(2, is_normal_to_flow=True), expected, strict=True
    ):
        np.testing.assert_array_equal(orbit_numbers(orbit), orbit_numbers(expected_orbit))


@pytest.mark.parametrize(
    "replaced_number",
    [
        (5, -1.0),  # μ below zero
        (4, -1.0),  # a period below zero
        (0, 1e300),  # a motion that overflows
        (4, 1e9),  # a period that is too long
    ],
)
def test_searches_from_invalid_guesses_find_no_orbit(replaced_number: tuple[int, float]) -> None:
    column, value = replaced_number
    curve = OrbitCurve(
        SliderBeltFlow(System(Parameters()), ("mu",)), SCALES[: STATE_AND_PERIOD + 1]
    )
    guess, normals = next(random_searches(1))
    guess[column] = value
    assert curve.solve(guess, normals) is None


def test_structures_have_the_same_size_in_python_and_c() -> None:
    library = native._load_library()
    assert library.fivtui_orbit_request_size_baseline() == ctypes.sizeof(orbits._Request)
    orbit_size = orbits._ORBIT_SIZE * ctypes.sizeof(ctypes.c_double)
    assert library.fivtui_orbit_size_baseline() == orbit_size
