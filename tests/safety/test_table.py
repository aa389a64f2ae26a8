"""Tables of safe μ against folds that are continued one by one.

A table spans the dimensionless groups of the parameters that vary. A cell is a box with a
polynomial: over several groups there is one, fitted at random draws.
"""

import json
from functools import cache
from typing import Final

import numpy as np
import pytest

from fivtui.equilibrium.critical import critical_mu
from fivtui.model import System
from fivtui.model.errors import Cancelled, ComputationError
from fivtui.model.parameters import Parameters
from fivtui.results import from_data, to_data
from fivtui.safety.table import MAX_FOLDS, SafeTable, safe_mus, safe_table
from fivtui.safety.verdict import safe_friction

BASE: Final = Parameters()
# Safe μ by preload: μ at the fold of separating cycles; None if the Hopf point is supercritical.
SAFE_MU_BY_PRELOAD: Final = {80.0: 0.277876613, 120.0: 0.277935093, 40.0: None}


def safe_mus_at(p: Parameters, table: SafeTable | None = None, **varied: list[float]) -> np.ndarray:
    columns = {name: np.array(values) for name, values in varied.items()}
    size = len(next(iter(varied.values())))
    return safe_mus(p, columns, np.ones(size, dtype=bool), table)


def safe_mu_of(p: Parameters) -> float:
    return float(safe_mus(p, {}, np.array([True]))[0])


def test_safe_friction_is_the_least_fold_or_the_hopf_point() -> None:
    safe_mu = safe_mus_at(BASE, F=list(SAFE_MU_BY_PRELOAD))
    for mu, (force, fold_mu) in zip(safe_mu.tolist(), SAFE_MU_BY_PRELOAD.items(), strict=True):
        p = Parameters(F=force)
        expected = critical_mu(System(p))[0].mu if fold_mu is None else fold_mu
        assert mu == pytest.approx(expected, abs=2e-9)
    assert safe_mu[0] == pytest.approx(safe_friction(BASE).safe_mu, rel=1e-9)


def test_safe_friction_does_not_depend_on_units() -> None:
    # Scale mass by 0.1, lengths by 1e-3 and times by 1e-2.
    scaled = Parameters(m=0.5, k1=1e5, k2=5e4, k3=6e4, c1=3.2, c2=3.2, F=80.0, k_nl=1e11)
    assert safe_mu_of(scaled) == pytest.approx(SAFE_MU_BY_PRELOAD[80.0], abs=2e-9)


def test_safe_friction_is_nan_without_preload_or_coupling_and_critical_without_cycles() -> None:
    assert np.isnan(safe_mus_at(BASE, F=[-5.0, 0.0])).all()
    assert np.isnan(safe_mus_at(BASE, k3=[0.0])).all()
    # The critical μ is 84. A branch ends at twice the critical μ, here at the greatest allowed μ.
    weak = Parameters(k3=0.3)
    assert 0.1 < safe_mu_of(weak) < critical_mu(System(weak))[0].mu
    linear = Parameters(k_nl=0.0)
    assert safe_mu_of(linear) == pytest.approx(critical_mu(System(linear))[0].mu, rel=1e-9)


def draw_values(
    ranges: dict[str, tuple[float, float]], size: int, seed: int
) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(seed)
    return {name: generator.uniform(*span, size) for name, span in ranges.items()}


def build_table(ranges: dict[str, tuple[float, float]], size: int) -> SafeTable:
    return _build_cached_table(tuple(ranges.items()), size)


@cache
def _build_cached_table(items: tuple[tuple[str, tuple[float, float]], ...], size: int) -> SafeTable:
    ranges = dict(items)
    table = safe_table(System(BASE), ranges, draw_values(ranges, size, 1))
    assert table is not None
    assert table.folds <= MAX_FOLDS
    return table


WIDE: Final = {
    name: (0.9 * value, 1.1 * value) for name, value in BASE.as_dict().items() if name != "mu"
}


@pytest.mark.parametrize(
    ("ranges", "size", "error"),
    [
        # F and k_nl vary the same group.
        ({"F": (74.0, 86.0), "k_nl": (95.0, 105.0)}, 1, 1e-9),
        ({"F": (74.0, 86.0), "k1": (95.0, 105.0)}, 24, 1e-4),
        pytest.param({"F": (-20.0, 150.0)}, 1, 5e-5, marks=pytest.mark.whole),
        # Safe μ has a kink near F = 47 N: it is the critical μ below, the μ of the fold above.
        pytest.param({"k2": (45.0, 55.0), "F": (46.0, 114.0)}, 512, 2e-3, marks=pytest.mark.whole),
        pytest.param(WIDE, 512, 1e-3, marks=pytest.mark.whole),
    ],
    ids=["one group", "two parameters", "folds and Hopf points", "kinks", "five groups"],
)
def test_a_table_has_the_error_that_it_reports(
    ranges: dict[str, tuple[float, float]], size: int, error: float
) -> None:
    table = build_table(ranges, size)
    columns = {name: values.tolist() for name, values in draw_values(ranges, 12, 3).items()}
    exact, fitted = safe_mus_at(BASE, None, **columns), safe_mus_at(BASE, table, **columns)
    np.testing.assert_array_equal(np.isnan(exact), np.isnan(fitted))
    # The 95 % quantile and the greatest of the errors at test folds.
    assert table.usual_error <= table.error
    assert table.usual_error < error
    errors = np.abs(fitted - exact)
    assert np.nanquantile(errors, 0.75) <= table.usual_error + 1e-13
    assert np.nanmax(errors) < max(error, 2.0 * table.error)
    # A value does not depend on the other points; saving and loading keeps the table.
    last_point = {name: values[-1:] for name, values in columns.items()}
    np.testing.assert_array_equal(safe_mus_at(BASE, table, **last_point), fitted[-1:])
    assert from_data(json.loads(json.dumps(to_data(table))), SafeTable) == table


def test_a_table_is_clipped_far_from_its_draws() -> None:
    ranges = {"F": (74.0, 86.0), "k1": (95.0, 105.0)}
    table = build_table(ranges, 24)
    (cell,) = table.cells
    # Values of the polynomial are clipped to the limits `least` and `greatest` of the cell.
    far = safe_mus_at(BASE, table, F=[1.0, 1e4, 74.0], k1=[50.0, 300.0, 105.0])
    assert np.all((far >= 0.0) & (far <= cell.greatest))


def test_a_table_needs_varying_groups_and_a_preload_and_can_be_cancelled() -> None:
    assert safe_table(System(BASE), {}, {}) is None
    below, near = {"F": (-5.0, -1.0)}, {"F": (70.0, 90.0)}
    with pytest.raises(ComputationError, match="no safe μ in the ranges"):
        safe_table(System(BASE), below, draw_values(below, 4, 1))
    with pytest.raises(Cancelled):
        safe_table(System(BASE), near, draw_values(near, 4, 1), progress=lambda _: False)
