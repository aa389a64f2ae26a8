"""Scattered designs: layout, independence of pieces, copula, and provenance."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from fivtui.distributions import parse_distribution
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.sweeps.design import Design
from fivtui.sweeps.provenance import study_from_dict, study_to_dict
from fivtui.sweeps.scatter import Scatter
from fivtui.sweeps.study import Study

AXES = {"mu": parse_distribution("uniform:0:1"), "F": parse_distribution("normal:80:8")}
KINDS = ["sobol", "lhs"]


def all_members(scatter: Scatter) -> dict[str, np.ndarray]:
    return scatter.columns(np.arange(scatter.size))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("indices", [True, False])
def test_a_range_of_members_is_that_of_the_whole_design(kind: str, indices: bool) -> None:
    scatter = Scatter(AXES, kind, count=8, repeats=3, indices=indices)  # type: ignore[arg-type]
    complete = all_members(scatter)
    # For Sobol indices a point has the samples A and B, and a mixed member for each input.
    point_members = 2 + len(AXES) if indices else 1
    assert scatter.size == 8 * 3 * point_members
    for first, end in ((0, 1), (5, 17), (scatter.size - 1, scatter.size)):
        part = scatter.columns(np.arange(first, end))
        for name in AXES:
            np.testing.assert_array_equal(part[name], complete[name][first:end])


def test_scramblings_are_those_of_scipy_by_their_seeds() -> None:
    scatter = Scatter(AXES, count=16, repeats=2, seed=7)
    assert scatter.seeds == [7, 8]
    # By point, scrambling and member; members 0 and 1 are the samples A and B.
    mu = scatter.split_values(all_members(scatter)["mu"])
    for index, seed in enumerate(scatter.seeds):
        # Coordinates are μ and F of sample A, then those of sample B.
        points = qmc.Sobol(4, scramble=True, bits=32, rng=seed).random(16)
        np.testing.assert_allclose(mu[:, index, 0], points[:, 0], atol=2.0**-32)
        np.testing.assert_allclose(mu[:, index, 1], points[:, 2], atol=2.0**-32)


def test_a_mixed_member_has_one_value_of_sample_b_and_the_others_of_a() -> None:
    scatter = Scatter(AXES, count=4, repeats=2)
    for name, values in all_members(scatter).items():
        sample_a, sample_b, *mixed = np.moveaxis(scatter.split_values(values), 2, 0)
        for replaced_name, mixed_values in zip(AXES, mixed, strict=True):
            expected = sample_b if replaced_name == name else sample_a
            np.testing.assert_array_equal(mixed_values, expected, name)


@pytest.mark.parametrize("count", [1, 2, 16])
def test_fewer_sobol_points_are_the_beginning_of_more(count: int) -> None:
    smaller, larger = (Scatter(AXES, count=points) for points in (count, 64))
    for name, values in all_members(smaller).items():
        np.testing.assert_array_equal(values, all_members(larger)[name][: smaller.size])


def test_a_hypercube_has_one_point_in_every_slice() -> None:
    scatter = Scatter({"mu": AXES["mu"]}, "lhs", count=64, repeats=4, indices=False)
    # A row of samples for each of the four scramblings.
    samples = scatter.sample_values(all_members(scatter)["mu"])
    np.testing.assert_array_equal(np.sort(np.floor(samples * 64), axis=1), [list(range(64))] * 4)


def test_correlations_are_those_of_the_normal_scores_and_keep_the_distributions() -> None:
    scatter = Scatter(AXES, count=1024, indices=False, correlations=(("F", "mu", -0.6),))
    values = all_members(scatter)
    scores = [stats.norm.ppf(values["mu"]), (values["F"] - 80.0) / 8.0]
    assert np.corrcoef(scores)[0, 1] == pytest.approx(-0.6, abs=2e-3)
    assert np.quantile(values["mu"], 0.3) == pytest.approx(0.3, abs=2e-3)
    assert values["F"].std() == pytest.approx(8.0, rel=5e-3)


def test_values_are_within_the_bounds_of_the_parameter() -> None:
    axes = {"m": parse_distribution("normal:0:1"), "mu": parse_distribution("normal:0:1")}
    scatter = Scatter(axes, count=256)
    assert scatter.axes["mu"].truncated_share == pytest.approx(0.5)
    values = all_members(scatter)
    assert values["m"].min() > 0.0
    assert values["mu"].min() >= 0.0
    Parameters(m=float(values["m"].min()))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"correlations": (("F", "mu", 0.5),)}, "independent, but F and mu are correlated"),
        ({"indices": False, "correlations": (("F", "m", 0.5),)}, "unknown correlated name 'm'"),
        ({"indices": False, "correlations": (("F", "F", 0.5),)}, "of two different names"),
        ({"indices": False, "correlations": (("F", "mu", 1.0),)}, "between -1 and 1"),
        ({"indices": False, "correlations": (("F", "mu", 0.1), ("mu", "F", 0.2))}, "given twice"),
        ({"count": 12}, "must be a power of two"),
        ({"repeats": 1}, "must be from 2 to 256"),
        ({"seed": -1}, "seed = -1"),
        ({"kind": "grid"}, "unknown design 'grid'"),
        ({"axes": {}}, "at least one name"),
        ({"axes": {"Mu": AXES["mu"]}}, "did you mean mu"),
        ({"axes": {"mu": parse_distribution("uniform:-2:-1")}}, "mu: .*must have values from 0"),
    ],
)
def test_invalid_designs_are_refused(changes: dict[str, object], message: str) -> None:
    arguments: dict[str, object] = {
        "axes": AXES,
        "kind": "sobol",
        "count": 8,
        "seed": 0,
        "repeats": 4,
    }
    with pytest.raises(InputError, match=message):
        Scatter(**(arguments | changes))  # type: ignore[arg-type]


def test_impossible_correlations_are_refused() -> None:
    axes = AXES | {"m": parse_distribution("uniform:4:6")}
    pairs = (("mu", "F", 0.9), ("F", "m", 0.9), ("mu", "m", -0.9))
    with pytest.raises(InputError, match="positive definite"):
        Scatter(axes, count=8, indices=False, correlations=pairs)


def test_a_study_is_restored_from_its_plain_data() -> None:
    scatter = Scatter(AXES, "lhs", count=4, seed=3, repeats=2, indices=False,
                      correlations=(("mu", "F", 0.25),))  # fmt: skip
    study = Study(scatter, Parameters(), outputs=("critical_mu",))
    for variant in (study, replace(study, design=replace(scatter, indices=True, correlations=()))):
        assert study_from_dict(json.loads(json.dumps(study_to_dict(variant)))) == variant


def test_values_that_a_design_cannot_use_are_refused_with_what_to_give() -> None:
    with pytest.raises(InputError, match=r"mu: must be two ends .*: give Range\(0\.3, 0\.6\)"):
        Design({"mu": (0.3, 0.6)}, "random", 4)
    axis: Any = "normal:80:8"
    with pytest.raises(InputError, match="its draws with design='list', or use `uncertainty`"):
        Design({"F": axis})
