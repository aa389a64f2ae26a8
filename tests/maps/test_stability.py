"""Stability maps against the stability of single points.

`EIGENVALUE_VALUES` are the map values that follow from eigenvalues, such as growth-rate.
"""

import math
import re
from contextlib import suppress
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from fivtui import Parameters, stability
from fivtui.equilibrium.arrays import judge_stability
from fivtui.equilibrium.quartic import rightmost_real_part
from fivtui.maps import stability_map
from fivtui.maps.stability import EIGENVALUE_VALUES
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.model.parameters import PARAMETERS
from tests.support.strategies import wide_parameters


def value_at(p: Parameters, value: str, over: tuple[str, str] = ("F", "mu")) -> float:
    axes = {name: [getattr(p, name)] for name in over}
    # Eigenvalues decide at F = 0, too.
    result = stability_map(p, axes, value, separation=False)
    return float(result.values[0, 0])


@given(wide_parameters())
@example(Parameters(m=1e3, k1=1.0, k2=1.0, k3=0.0, c1=0.0, c2=0.01, F=0.0, k_nl=0.0, mu=0.0))
@example(Parameters(m=1.0, k1=1.0, k2=1.0, k3=1.0, c1=0.0, c2=0.0, F=0.0, k_nl=0.0, mu=0.5))
def test_a_map_agrees_with_the_eigenvalues_of_single_points(p: Parameters) -> None:
    verdict = stability(p, separation=False)
    size = float(np.abs(verdict.eigenvalues).max())
    gaps = np.abs(np.subtract.outer(verdict.eigenvalues, verdict.eigenvalues))
    nearest = gaps[~np.eye(4, dtype=bool)].min()
    # Neighbouring roots move by the square root of the rounding error.
    tolerance = 1e-9 if nearest > 1e-3 * size else 1e-5
    assert value_at(p, "growth-rate") == pytest.approx(verdict.growth_rate, abs=tolerance * size)
    critical = value_at(p, "critical-mu")
    if verdict.critical_mu:
        mu_c = verdict.critical_mu[0].mu
        assert critical == pytest.approx(mu_c, rel=1e-12)
        # Exactly at the boundary rounding decides.
        if abs(p.mu - mu_c) > 1e-12 * mu_c:
            assert value_at(p, "unstable-modes") == float(p.mu > mu_c)
    else:
        assert math.isnan(critical)


@settings(max_examples=30)
@given(
    st.lists(wide_parameters(), min_size=1, max_size=8),
    st.lists(st.tuples(st.booleans(), st.booleans()), min_size=8, max_size=8),
)
@example([Parameters(F=1.0, k3=0.0), Parameters(k3=0.0)], [(True, True)] * 8)
@example([Parameters(m=1e-6, k1=1e9, k3=1e9, k2=1e9, k_nl=1e9, F=1e6)], [(False, False)] * 8)
def test_growth_rates_of_many_sets_agree_with_those_of_single_sets(
    sets: list[Parameters], flags: list[tuple[bool, bool]]
) -> None:
    # A flag lifts the slider by a negative preload, another considers separation.
    loaded_sets = [
        p.with_values({"F": -p.F if lifted else p.F})
        for p, (lifted, _) in zip(sets, flags, strict=False)
    ]
    separations = np.array([separation for _, separation in flags[: len(sets)]])
    varied = {name: np.array([getattr(p, name) for p in loaded_sets]) for name in PARAMETERS}
    growth, stable, reasons = judge_stability(Parameters(), varied, separations)
    for row, (p, separation) in enumerate(zip(loaded_sets, separations.tolist(), strict=True)):
        if row in reasons:
            assert math.isnan(growth[row])
            with pytest.raises(ComputationError, match=re.escape(reasons[row])):
                stability(p, separation=separation)
            continue
        verdict = stability(p, separation=separation)
        values = verdict.eigenvalues
        size = float(np.abs(values).max())
        gaps = np.abs(np.subtract.outer(values, values))[~np.eye(4, dtype=bool)]
        tolerance = (1e-9 if gaps.min() > 1e-3 * size else 1e-5) * size
        assert growth[row] == pytest.approx(verdict.growth_rate, abs=tolerance)
        if abs(verdict.growth_rate) > tolerance:
            assert stable[row] == verdict.stable


def extreme_sets(count: int) -> dict[str, np.ndarray]:
    """Parameters over their full ranges, mostly unrealistic for a brake."""
    rng = np.random.default_rng(13)

    def decades(low: float, high: float, zero_share: float = 0.0) -> np.ndarray:
        values = 10.0 ** rng.uniform(low, high, count)
        return np.where(rng.random(count) < zero_share, 0.0, values)

    return {
        "m": decades(-12.0, 9.0),
        "k1": decades(-12.0, 12.0),
        "k2": decades(-12.0, 12.0),
        "k3": decades(-300.0, 12.0, 0.1),
        "c1": decades(-300.0, 9.0, 0.3),
        "c2": decades(-300.0, 9.0, 0.3),
        "F": decades(-5.0, 9.0) * rng.choice([1.0, -1.0], count),
        "k_nl": decades(-300.0, 24.0, 0.3),
        "mu": decades(-3.0, 2.0),
    }


def test_growth_rates_at_the_ends_of_the_ranges_need_no_eigenvalue_solver(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    varied = extreme_sets(1500)
    expected: dict[int, np.ndarray] = {}
    for row in range(1500):
        p = Parameters(**{name: float(column[row]) for name, column in varied.items()})
        with suppress(ComputationError), np.errstate(all="ignore"):
            expected[row] = stability(p).eigenvalues
    monkeypatch.setattr(np.linalg, "eigvals", None)
    growth, _, reasons = judge_stability(Parameters(), varied, np.ones(1500, dtype=bool))
    assert set(reasons) == set(np.flatnonzero(np.isnan(growth)).tolist())
    assert not set(reasons) & set(expected)
    for row, values in expected.items():
        # A fourfold root moves by the fourth root of the rounding error.
        tolerance = 1e-3 * float(np.abs(values).max())
        assert growth[row] == pytest.approx(float(values.real.max()), abs=tolerance)


@given(wide_parameters(), st.permutations(list(PARAMETERS)))
def test_any_two_parameters_span_a_map(p: Parameters, names: list[str]) -> None:
    first_name, second_name = names[:2]
    axes = {first_name: [getattr(p, first_name)] * 2, second_name: [getattr(p, second_name)] * 3}
    for value in EIGENVALUE_VALUES:
        values = stability_map(p, axes, value, separation=False).values
        assert values.shape == (2, 3)
        assert np.array_equal(values, np.full((2, 3), value_at(p, value)), equal_nan=True)


# `rightmost_real_part` is that of the roots of (s² + c1 s + a)(s² + c2 s + b) − d.


def test_the_rightmost_root_is_accurate_to_rounding_for_very_different_dampings() -> None:
    rng = np.random.default_rng(1)
    c1, c2 = 10.0 ** rng.uniform(-4.0, 3.0, (2, 60))
    a, d = rng.uniform(0.05, 0.95, 60), rng.uniform(-3.0, 0.5, 60)
    b = 1.0 - a
    real_parts = rightmost_real_part(c1, a, c2, b, d)
    with mpmath.workdps(40):
        for case in range(60):
            damping, second_damping = mpmath.mpf(c1[case]), mpmath.mpf(c2[case])
            first_factor, second_factor = (
                (1, damping, mpmath.mpf(a[case])),
                (1, second_damping, mpmath.mpf(b[case])),
            )
            quartic = [
                sum(
                    first_factor[i] * second_factor[power - i]
                    for i in range(3)
                    if 0 <= power - i < 3
                )
                for power in range(5)
            ]
            quartic[4] -= mpmath.mpf(d[case])
            slope = [(4 - power) * value for power, value in enumerate(quartic[:4])]
            roots = [mpmath.mpmathify(root) for root in np.roots([float(v) for v in quartic])]
            for _ in range(6):
                roots = [s - horner(quartic, s) / horner(slope, s) for s in roots]
            error = abs(real_parts[case] - max(mpmath.re(root) for root in roots))
            assert error <= 2e-15 * max(map(abs, roots))


def horner(polynomial: list[Any], s: Any) -> Any:
    value = mpmath.mpf(0)
    for coefficient in polynomial:
        value = value * s + coefficient
    return value


@given(st.integers(0, 2**32 - 1))
def test_the_rightmost_root_is_that_of_the_quartic(seed: int) -> None:
    rng = np.random.default_rng(seed)
    c1, c2 = 10.0 ** rng.uniform(-4.0, 1.0, (2, 50))
    a = rng.uniform(0.05, 0.95, 50)
    b, d = 1.0 - a, rng.uniform(-3.0, 0.5, 50)
    real_parts = rightmost_real_part(c1, a, c2, b, d)
    for case in range(50):
        first_factor, second_factor = [1.0, c1[case], a[case]], [1.0, c2[case], b[case]]
        roots = np.roots(np.polysub(np.polymul(first_factor, second_factor), [d[case]]))
        tolerance = 1e-5 * np.abs(roots).max()
        assert real_parts[case] == pytest.approx(roots.real.max(), abs=tolerance)


def rightmost_in_many_digits(c: float, a: float, b: float, d: float) -> float:
    # With equal dampings the quartic is (z + a)(z + b) − d, where z = s² + c s. So z is
    # −(a + b)/2 ± w, and s = (−c ± √(c² + 4 z))/2.
    with mpmath.workdps(60):
        rate, first_stiffness, second_stiffness, coupling = map(mpmath.mpf, (c, a, b, d))
        half_difference = mpmath.sqrt((first_stiffness - second_stiffness) ** 2 / 4 + coupling)
        discriminant_roots = [
            mpmath.sqrt(rate**2 - 2 * (first_stiffness + second_stiffness) + 4 * w)
            for w in (half_difference, -half_difference)
        ]
        return float(max(abs(root.real) - rate for root in map(mpmath.mpc, discriminant_roots)) / 2)


@pytest.mark.parametrize("distance", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2])
def test_growth_rates_of_coalescing_modes_agree_with_sixty_digits(distance: float) -> None:
    # Equal dampings: the undamped frequencies meet where d = -(a - b)²/4. At this relative distance
    # below that d the modes flutter, above it they have two frequencies.
    rng = np.random.default_rng(5)
    count = 12
    a = rng.uniform(0.05, 0.95, count)
    b, c = 1.0 - a, 10.0 ** rng.uniform(-4.0, 0.3, count)
    d = -0.25 * (a - b) ** 2 * (1.0 + distance * rng.choice([-1.0, 1.0], count))
    real_part = rightmost_real_part(c, a, c, b, d)
    expected = [rightmost_in_many_digits(*case) for case in np.stack([c, a, b, d], 1).tolist()]
    # The error is the square root of rounding for a double root, else rounding over the distance.
    tolerance = 6e-8 if distance < 1e-14 else 3e-15 / math.sqrt(distance) + 1e-14
    assert np.abs(real_part - expected).max() <= tolerance


def test_nearly_coalescing_modes_agree_with_the_eigenvalues() -> None:
    # Kinds of dampings: equal (0), nearly critical for the first mode, and so on.
    critical, nearly_equal, independent = 1, 2, 3
    rng = np.random.default_rng(6)
    count = 4000
    a = rng.uniform(0.05, 0.95, count)
    b, c1 = 1.0 - a, 10.0 ** rng.uniform(-5.0, 1.0, count)
    factor = 1.0 + 10.0 ** rng.uniform(-14.0, -1.0, count)
    kind = rng.integers(0, 4, count)
    independent_c2 = 10.0 ** rng.uniform(-5.0, 1.0, count)
    c2 = np.select(
        [kind == nearly_equal, kind == independent], [c1 * factor, independent_c2], default=c1
    )
    c1 = np.where(kind == critical, 2.0 * np.sqrt(a) * factor, c1)
    # The modes would coalesce without the last factor, which is as close to 1 as `factor`.
    d = -0.25 * (a - b) ** 2 * (2.0 - factor)
    real_part = rightmost_real_part(c1, a, c2, b, d)
    matrices = np.zeros((count, 4, 4))
    matrices[:, [0, 2], [1, 3]] = 1.0
    for entry, value in (((1, 0), -a), ((1, 1), -c1), ((3, 2), -b), ((3, 3), -c2)):
        matrices[:, *entry] = value
    matrices[:, 3, 0], matrices[:, 1, 2] = 1.0, d
    values = np.linalg.eigvals(matrices)
    errors = np.abs(real_part - values.real.max(axis=1)) / np.abs(values).max(axis=1)
    assert errors.max() < 2e-7


@pytest.mark.parametrize(
    ("F", "k_nl", "expected"),
    [(20.0, 50.0, 0.7650), (20.0, 500.0, 0.2794), (100.0, 100.0, 0.5976), (100.0, 500.0, 1.5473)],
)
def test_known_critical_friction_coefficients(F: float, k_nl: float, expected: float) -> None:
    assert value_at(Parameters(F=F, k_nl=k_nl), "critical-mu") == pytest.approx(expected, abs=5e-5)


def test_rows_follow_the_first_parameter_and_values_do_not_depend_on_chunks() -> None:
    # These are more points than a chunk has, 8192: they are computed in two chunks.
    forces, frictions = np.linspace(1.0, 150.0, 123), np.linspace(0.0, 1.0, 97)
    result = stability_map(Parameters(), {"F": forces, "mu": frictions})
    swapped = stability_map(Parameters(), {"mu": frictions, "F": forces})
    assert result.values.shape == (123, 97)
    assert np.array_equal(result.values, swapped.values.T)
    for row, column in ((0, 0), (61, 50), (84, 33), (122, 96)):
        p = Parameters(F=float(forces[row]), mu=float(frictions[column]))
        assert result.values[row, column] == pytest.approx(stability(p).growth_rate, abs=1e-7)
        critical = stability(p).critical_mu[0].mu
        # The excess is positive where the equilibrium is unstable.
        assert (result.excess[row, column] > 0.0) == (p.mu > critical)


def test_points_without_a_value_are_nan() -> None:
    # F < 0 lifts the slider, and with k3 = 0 no spring holds it: there is no equilibrium. Either of
    # them alone excludes a critical μ.
    over = {"F": [-1.0, 1.0], "k3": [0.0, 60.0]}
    growth = stability_map(Parameters(), over).values
    assert np.isnan(growth).tolist() == [[True, False], [False, False]]
    assert np.isnan(stability_map(Parameters(), over, "unstable-modes").values).sum() == 1
    critical = stability_map(Parameters(), over, "critical-mu").values
    assert np.isnan(critical).tolist() == [[True, True], [True, False]]
    values_in_contact = stability_map(Parameters(), over, separation=False).values
    assert not np.any(np.isnan(values_in_contact))


@pytest.mark.parametrize("value", EIGENVALUE_VALUES)
@pytest.mark.parametrize("belt", [{}, {"v_belt": 1.0}])
def test_at_no_preload_a_map_has_values_only_where_separation_is_ignored(
    value: str, belt: dict[str, float]
) -> None:
    p, over = Parameters(**belt), {"F": [0.0, 10.0], "k2": [50.0, 60.0]}
    result = stability_map(p, over, value)
    assert np.isnan(result.values).tolist() == [[True, True], [False, False]]
    assert np.isnan(result.excess).tolist() == [[True, True], [False, False]]
    assert ("without verdict", "2 of them") in [(row.label, row.value[:9]) for row in result.rows()]
    assert not np.isnan(stability_map(p, over, value, separation=False).values).any()


def test_progress_is_reported_and_can_cancel() -> None:
    over = {"F": np.linspace(0.0, 1.0, 300), "mu": np.linspace(0.0, 1.0, 300)}
    fractions: list[float] = []

    def record(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    stability_map(Parameters(), over, progress=record)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    with pytest.raises(Cancelled):
        stability_map(Parameters(), over, progress=lambda fraction: fraction < 0.5)


@pytest.mark.parametrize(
    ("over", "value", "message"),
    [
        ({"F": [1.0]}, "growth-rate", "two different parameters"),
        ({"F": [1.0], "nu": [1.0]}, "growth-rate", "unknown parameter 'nu'"),
        ({"F": [1.0], "mu": [-1.0, 1.0]}, "growth-rate", "must be from 0"),
        ({"F": [1.0], "mu": [math.nan]}, "growth-rate", "not a finite number"),
        ({"F": [], "mu": [1.0]}, "growth-rate", "one or more numbers"),
        ({"F": [1.0], "mu": [1.0]}, "growth", "did you mean growth-rate?"),
        ({"F": np.zeros(20000), "mu": np.zeros(20000)}, "growth-rate", "400000000 points"),
    ],
)
def test_a_wrong_request_is_refused(over: dict[str, list[float]], value: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        stability_map(Parameters(), over, value)
    assert message in str(caught.value)


def test_a_figure_without_a_stability_boundary_has_no_legend() -> None:
    over = {"F": np.linspace(1.0, 2.0, 3), "mu": np.linspace(0.0, 0.01, 3)}
    for value in EIGENVALUE_VALUES:
        assert stability_map(Parameters(), over, value).figure().legends == []


def test_a_share_counts_only_points_with_a_value() -> None:
    p = Parameters(k3=0.0)
    # F < 0 lifts the slider, and without k3 no spring holds it.
    result = stability_map(p, {"F": [-10.0, 40.0, 80.0], "mu": [0.1, 0.5]})
    rows = {row.label: row.value for row in result.rows()}
    assert rows["unstable"] == "0.0% of 4 points, 2 without value"
    assert result.failure is None
    lifted = stability_map(p, {"F": [-10.0, -5.0], "mu": [0.1, 0.5]})
    assert lifted.rows()[-1].value == "no point has a value"
    assert lifted.failure is not None
