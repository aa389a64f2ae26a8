"""Eigenvalues and critical friction coefficients, against known values and scans."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st

from fivtui import Parameters, attractors, safe_friction, simulate, stability, sweep
from fivtui.equilibrium import (
    critical_mu,
    critical_mu_derivatives,
    critical_mu_on_belt,
    flutter_margin,
    stability_rows,
)
from fivtui.equilibrium.critical import _least_nonnegative
from fivtui.equilibrium.eigenvalues import growth_rate
from fivtui.model import ComputationError, System
from fivtui.model.field import tangent_stiffness
from fivtui.model.slider_belt import equilibrium, jacobian
from tests.support.strategies import moderate_parameters, wide_parameters

KNOWN_CRITICAL_MU = [
    ({"F": 20.0, "k_nl": 50.0}, 0.7650),
    ({"F": 20.0, "k_nl": 100.0}, 0.5985),
    ({"F": 20.0, "k_nl": 500.0}, 0.2794),
    ({"F": 100.0, "k_nl": 50.0}, 0.3738),
    ({"F": 100.0, "k_nl": 100.0}, 0.5976),
    ({"F": 100.0, "k_nl": 500.0}, 1.5473),
    ({"F": 80.0, "k_nl": 100.0}, 0.4394),
    ({"F": 50.0, "k_nl": 100.0}, 0.2799),
    ({"k_nl": 0.0}, 1.0181),
    ({"k_nl": 0.0, "c1": 0.8}, 0.9434),
    ({"k_nl": 0.0, "k1": 50.0, "k2": 100.0}, 0.5091),
]


@pytest.mark.parametrize(("changes", "expected"), KNOWN_CRITICAL_MU)
def test_known_critical_friction_coefficients(changes: dict[str, float], expected: float) -> None:
    (critical,) = stability(Parameters(**changes)).critical_mu
    assert critical.mu == pytest.approx(expected, abs=5e-5)
    assert critical.becomes == "unstable"


@pytest.mark.parametrize(
    ("changes", "expected"),
    [({}, 1.0181), ({"c1": 0.8}, 0.9434), ({"k1": 50.0, "k2": 100.0}, 0.5091)],
)
def test_known_linear_critical_friction_coefficients(
    changes: dict[str, float], expected: float
) -> None:
    assert stability(Parameters(**changes)).linear_critical_mu == pytest.approx(expected, abs=5e-5)


def test_the_equilibrium_of_the_coexistence_scene_is_stable() -> None:
    verdict = stability(Parameters(F=120.0))
    assert verdict.stable
    assert verdict.growth_rate == pytest.approx(-0.032, abs=5e-4)


def test_modes_of_the_same_frequency_are_in_the_order_of_growth() -> None:
    for mu in np.linspace(0.5, 1.5, 50):
        verdict = stability(Parameters(mu=float(mu)))
        assert verdict.eigenvalues[0].real == verdict.growth_rate


@given(wide_parameters())
@example(Parameters(k_nl=1e9))
@example(Parameters(m=1e-6))
def test_eigenvalues_are_those_of_the_jacobian_at_the_equilibrium(p: Parameters) -> None:
    verdict = stability(p, separation=False)
    point = equilibrium(System(p))
    matrix = np.array(jacobian(p, point.y, point.mode))
    size = np.abs(verdict.eigenvalues).max()
    quartic = np.poly(matrix)
    for value in verdict.eigenvalues:
        residual = np.polyval(quartic, value)
        # Relative to the sum of the sizes of its terms. Rounding errors of eigenvalues near zero
        # are relative to the greatest one.
        scale = max(abs(value), 1e-3 * size)
        assert abs(residual) <= 1e-8 * np.polyval(np.abs(quartic), scale)
    assert verdict.eigenvalues.sum().real == pytest.approx(
        -(p.c1 + p.c2) / p.m, rel=1e-6, abs=1e-10 * size
    )


def scan_crossings(p: Parameters, highest: float) -> list[float]:
    # Eigenvalues on a grid, each change of sign bisected.
    def rate(mu: float) -> float:
        return growth_rate(System(p.with_values({"mu": mu}), separation=False))

    grid = np.linspace(0.0, highest, 301)
    rates = [rate(mu) for mu in grid]
    crossings = []
    for start, stop, low, high in zip(grid, grid[1:], rates, rates[1:], strict=False):
        if (low > 0.0) != (high > 0.0):
            a, b = float(start), float(stop)
            for _ in range(50):
                middle = 0.5 * (a + b)
                a, b = (a, middle) if (rate(middle) > 0.0) == (high > 0.0) else (middle, b)
            crossings.append(0.5 * (a + b))
    return crossings


@given(moderate_parameters())
def test_the_closed_form_finds_every_crossing_of_an_eigenvalue_scan(p: Parameters) -> None:
    assume(p.c1 + p.c2 > 0.05)
    closed = [
        critical.mu for critical in stability(p, separation=False).critical_mu if critical.mu < 3.0
    ]
    scanned = scan_crossings(p, 3.0)
    # The scan misses two crossings within one cell.
    for mu in scanned:
        assert min(abs(mu - closed_mu) for closed_mu in closed) < 1e-6
    if all(closed_mu - previous_mu > 0.02 for previous_mu, closed_mu in pairwise(closed)):
        assert len(closed) == len(scanned)


@given(wide_parameters(damped_and_coupled=True))
def test_the_growth_rate_vanishes_at_a_critical_friction_coefficient(p: Parameters) -> None:
    for critical in stability(p, separation=False).critical_mu:
        verdict = stability(p.with_values({"mu": critical.mu}), separation=False)
        size = float(np.abs(verdict.eigenvalues).max())
        # Rounding moves the root; near coalescence it moves the growth rate by its square root.
        assert abs(verdict.growth_rate) < 1e-5 * size


@given(st.floats(1e-9, 99.0), st.sampled_from([0.5, 1.0, 3.0, 9.0]))
def test_a_zero_of_an_increasing_function_is_found_to_the_last_bit(
    root: float, power: float
) -> None:
    evaluations: list[float] = []

    def increasing(mu: float) -> float:
        evaluations.append(mu)
        return math.pow(mu, power) - math.pow(root, power)

    crossing = _least_nonnegative(increasing, 0.0, 100.0)
    assert crossing is not None
    assert increasing(crossing) >= 0.0
    assert increasing(float(np.nextafter(crossing, 0.0))) < 0.0
    assert power != 1.0 or len(evaluations) < 30
    # No change of sign: positive, then negative, throughout the interval.
    assert _least_nonnegative(increasing, 100.0, 200.0) is None
    assert _least_nonnegative(increasing, 0.0, 0.5 * root) is None


@given(wide_parameters(damped_and_coupled=True))
def test_along_mu_the_equilibrium_is_stable_below_the_crossing_and_unstable_above(
    p: Parameters,
) -> None:
    (critical,) = stability(p, separation=False).critical_mu or (None,)
    highest = 100.0 if critical is None else critical.mu * 0.999
    for mu in np.geomspace(1e-4, 1.0, 8) * highest:
        assert growth_rate(
            System(p.with_values({"mu": float(mu)}), separation=False)
        ) < 1e-9 * np.sqrt(p.k1 / p.m)
    if critical is not None:
        for mu in np.geomspace(min(critical.mu * 1.001, 100.0), 100.0, 8):
            size = np.abs(
                stability(p.with_values({"mu": float(mu)}), separation=False).eigenvalues
            ).max()
            assert (
                growth_rate(System(p.with_values({"mu": float(mu)}), separation=False))
                > -1e-12 * size
            )


def test_at_no_preload_eigenvalues_give_no_verdict_unless_separation_is_ignored() -> None:
    # Contact is stable there, but a small disturbance leaves the belt and grows.
    p = Parameters(F=0.0)
    run = simulate(p, t_end=200.0, start=(0.0, 0.0, -1e-4, 0.0))
    assert run.peak.y_abs > 1e-3
    system = System(p)
    computations = (
        lambda: stability(p),
        lambda: growth_rate(system),
        lambda: critical_mu(system),
        lambda: critical_mu_on_belt(system),
        lambda: critical_mu_derivatives(system),
        lambda: flutter_margin(system),
        lambda: safe_friction(p),
        lambda: attractors(p),
        lambda: stability(p.with_values({"v_belt": 1.0, "mu_s": 1.0, "v_s": 0.5})),
    )
    for compute in computations:
        with pytest.raises(ComputationError, match=r"^no verdict at F = 0: .*; use F above 0"):
            compute()
    assert equilibrium(system).y == equilibrium(system).P == 0.0
    ignored = stability(p, separation=False)
    assert ignored.stable
    assert ignored.critical_mu[0].mu == pytest.approx(1.0181, abs=5e-5)
    table = sweep(p, vary={"F": [0.0, 10.0]}, outputs=["critical_mu", "safe_mu", "stable"]).table
    assert table.reasons[0].startswith("no verdict at F = 0")
    assert table.reasons[1] == ""
    for name in ("critical_mu", "safe_mu", "stable"):
        assert np.isnan(table.numbers[name]).tolist() == [True, False]


def test_a_growth_rate_that_counts_as_zero_has_no_doubling_time() -> None:
    rows = {row.label: row for row in stability_rows(stability(Parameters(c1=0.0, c2=0.0, mu=0.2)))}
    assert rows["verdict"].value == "NEUTRAL"
    assert rows["growth rate"].note == "zero within rounding"
    rows = {row.label: row for row in stability_rows(stability(Parameters(mu=0.2)))}
    assert rows["growth rate"].note.startswith("amplitude halves every")


def test_an_equilibrium_at_zero_is_printed_without_a_sign() -> None:
    result = stability(Parameters(F=0.0), separation=False)
    rows = {row.label: row.value for row in stability_rows(result)}
    assert (rows["equilibrium x"], rows["equilibrium y"]) == ("0 m", "0 m")
    assert rows["contact force"] == "0 N"


def test_without_coupling_friction_cannot_destabilise() -> None:
    verdict = stability(Parameters(k3=0.0))
    assert verdict.critical_mu == ()
    assert verdict.linear_critical_mu is None
    assert verdict.stable


def test_a_lifted_slider_has_the_stability_of_the_separated_mode() -> None:
    verdict = stability(Parameters(F=-10.0))
    assert verdict.equilibrium.P == 0.0
    assert verdict.critical_mu == ()
    assert verdict.stable


def test_without_damping_critical_friction_is_at_coalescence_and_no_equilibrium_is_stable() -> None:
    p = Parameters(c1=0.0, c2=0.0)
    (critical,) = stability(p).critical_mu
    below = stability(p.with_values({"mu": 0.99 * critical.mu}))
    above = stability(p.with_values({"mu": 1.01 * critical.mu}))
    assert not below.stable
    assert below.growth_rate < 1e-9 < above.growth_rate


@given(moderate_parameters(), st.floats(-3.0, 3.0))
def test_tangent_stiffness_is_the_slope_of_the_contact_law(p: Parameters, y: float) -> None:
    step = 1e-6
    forces = [p.k2 * height + p.k_nl * height**3 for height in (y - step, y + step)]
    expected = (forces[1] - forces[0]) / (2.0 * step)
    assert tangent_stiffness(p, y) == pytest.approx(expected, rel=1e-6)
