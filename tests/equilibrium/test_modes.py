"""Modes of vibration, margins and coalescence, against the equations of motion and eigenvalues.

Equations, sections and figures are numbered as in the paper *Nonlinear friction-induced vibration
of a slider-belt system*.
"""

import cmath
import math

import numpy as np
import pytest
from hypothesis import assume, given

from fivtui import Parameters, stability
from fivtui.equilibrium.eigenvalues import growth_rate
from fivtui.equilibrium.modes import VibrationMode
from fivtui.model import System
from fivtui.model.modes import Mode
from fivtui.model.parameters import PARAMETERS
from fivtui.model.slider_belt import jacobian
from tests.support.strategies import moderate_parameters, wide_parameters


def eigenvector_residual(
    p: Parameters, mode: VibrationMode, equilibrium_y: float, contact_mode: Mode
) -> float:
    # Residual of (x, λx, y, λy) as an eigenvector of Eq. 8: of its two accelerations, relative to
    # the greater sum of the sizes of their terms.
    x, y = mode.shape
    s = mode.eigenvalue
    vector = np.array([x, s * x, y, s * y])
    matrix = np.array(jacobian(p, equilibrium_y, contact_mode))
    difference = np.abs(matrix @ vector - s * vector)
    size = np.abs(matrix) @ np.abs(vector) + abs(s) * np.abs(vector)
    accelerations = [1, 3]
    return float(difference[accelerations].max() / size[accelerations].max())


@given(moderate_parameters())
def test_every_mode_is_an_eigenvector_of_the_jacobian(p: Parameters) -> None:
    verdict = stability(p, separation=False)
    point = verdict.equilibrium
    for mode in verdict.modes:
        # An eigenvalue near another is accurate only to the square root of the rounding error.
        assert eigenvector_residual(p, mode, point.y, point.mode) < 1e-6
        assert max(map(abs, mode.shape)) == pytest.approx(1.0)


@given(wide_parameters())
def test_modes_and_their_conjugates_are_the_eigenvalues(p: Parameters) -> None:
    verdict = stability(p, separation=False)
    values = [m.eigenvalue for m in verdict.modes]
    values += [v.conjugate() for v in values if v.imag > 0.0]
    assert sorted(values, key=lambda v: (v.real, v.imag)) == sorted(
        verdict.eigenvalues.tolist(), key=lambda v: (v.real, v.imag)
    )
    assert max(m.growth_rate for m in verdict.modes) == verdict.growth_rate


def test_without_coupling_and_friction_the_modes_are_two_oscillators() -> None:
    p = Parameters(k3=0.0, k_nl=0.0, mu=0.0)
    vertical, horizontal = sorted(stability(p).modes, key=lambda mode: mode.frequency)
    for mode, stiffness, damping in ((horizontal, p.k1, p.c1), (vertical, p.k2, p.c2)):
        natural = math.sqrt(stiffness / p.m)
        assert mode.damping_ratio == pytest.approx(damping / (2.0 * p.m * natural))
        assert mode.angular_frequency == pytest.approx(
            natural * math.sqrt(1.0 - mode.damping_ratio**2)
        )
        assert mode.frequency == pytest.approx(mode.angular_frequency / (2.0 * math.pi))
    assert horizontal.shape == (1.0, 0.0)
    assert vertical.shape == (0.0, 1.0)


def test_an_overdamped_motion_is_a_mode_without_frequency() -> None:
    verdict = stability(Parameters(c1=500.0))
    overdamped = [mode for mode in verdict.modes if mode.frequency == 0.0]
    assert len(verdict.modes) == 3
    assert len(overdamped) == 2
    assert all(mode.damping_ratio == 1.0 for mode in overdamped)


def test_a_lifted_slider_has_the_modes_of_the_separated_field() -> None:
    p = Parameters(F=-10.0)
    verdict = stability(p)
    for mode in verdict.modes:
        assert eigenvector_residual(p, mode, verdict.equilibrium.y, Mode.SEPARATED) < 1e-12
    assert verdict.margin.mu is None
    assert verdict.coalescence.mu is None


@given(moderate_parameters())
def test_the_margins_are_the_distances_to_the_boundary(p: Parameters) -> None:
    verdict = stability(p, separation=False)
    assert verdict.margin.growth_rate == -verdict.growth_rate
    if verdict.margin.mu is not None:
        critical = stability(
            p.with_values({"mu": max(p.mu + verdict.margin.mu, 0.0)}), separation=False
        )
        size = float(np.abs(critical.eigenvalues).max())
        assert abs(critical.growth_rate) < 1e-5 * size
        # Without damping no equilibrium is stable; with tiny damping rounding decides.
        assume(abs(verdict.margin.mu) > 1e-6 and min(p.c1, p.c2) > 0.01)
        assert (verdict.margin.mu > 0.0) == verdict.stable


@given(moderate_parameters())
def test_at_coalescence_the_undamped_frequencies_meet(p: Parameters) -> None:
    mu = stability(p, separation=False).coalescence.mu
    assume(mu is not None)
    assert mu is not None
    undamped = p.with_values({"c1": 0.0, "c2": 0.0})
    coalesced, below = (
        stability(undamped.with_values({"mu": value}), separation=False) for value in (mu, 0.9 * mu)
    )
    size = float(np.abs(coalesced.eigenvalues).max())
    # Roots that coalesce are accurate only to the square root of the rounding error.
    assert coalesced.coalescence.frequency_distance < 1e-5 * size
    assert below.coalescence.frequency_distance > 1e-5 * size
    assume(1.1 * mu <= PARAMETERS["mu"].upper)
    assert (
        growth_rate(System(undamped.with_values({"mu": 1.1 * mu}), separation=False)) > 1e-5 * size
    )


def test_with_equal_damping_the_modes_coalesce_and_with_unequal_damping_they_do_not() -> None:
    # Section 4.2: Figs. 3 and 4, and Fig. 5.
    equal, unequal = (
        stability(Parameters(F=100.0, mu=0.9, c1=c1)).coalescence for c1 in (0.32, 0.8)
    )
    assert equal.frequency_distance < 1e-7
    assert unequal.frequency_distance > 1e-2
    assert equal.mu == unequal.mu


def test_in_the_growing_mode_x_and_y_are_out_of_phase() -> None:
    (mode,) = [m for m in stability(Parameters()).modes if m.growth_rate > 0.0]
    # The work of friction over a cycle is positive only if x lags or leads y.
    x, y = mode.shape
    assert abs(math.degrees(cmath.phase(y / x))) == pytest.approx(48.03, abs=0.01)
