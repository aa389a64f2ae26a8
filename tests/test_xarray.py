"""Results as xarray datasets: grids keep their two dimensions, other tables have rows."""

import numpy as np
import pytest

from fivtui import InputError, Parameters, branch, safety_map, stability_map


def test_a_map_is_over_its_two_parameters_with_units() -> None:
    over = {"F": [20.0, 60.0, 80.0], "mu": [0.2, 0.9]}
    result = stability_map(Parameters(k_nl=50.0), over)
    dataset = result.to_xarray()
    assert dataset["growth_rate"].dims == ("F", "mu")
    assert dataset["growth_rate"].attrs["units"] == "1/s"
    np.testing.assert_array_equal(dataset["growth_rate"].values, result.values)
    np.testing.assert_array_equal(dataset["F"].values, result.axes[0])
    assert dataset.attrs["parameters"]["k_nl"] == 50.0
    friction = safety_map(None, {"F": [60.0, 120.0], "k_nl": [50.0, 100.0]}).to_xarray()
    assert set(friction) == {"safe_mu", "critical_mu"}


def test_a_branch_has_one_row_for_each_cycle() -> None:
    result = branch(None, "mu", low=0.3, high=0.6)
    dataset = result.to_xarray()
    assert dataset.sizes == {"row": len(result.points)}
    for name, column in result.to_columns().items():
        np.testing.assert_array_equal(dataset[name].values, column)


def test_without_xarray_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    result = stability_map(None, {"F": [20.0, 60.0], "mu": [0.2, 0.9]})
    monkeypatch.setattr("fivtui.results.tables.find_spec", lambda _name: None)
    with pytest.raises(InputError, match=r"install fivtui\[xarray\]"):
        result.to_xarray()
