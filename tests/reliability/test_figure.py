"""The figure of an uncertainty study holds its numbers.

Samples are counted in regions by their outcome: no squeal, squeal after a knock (a disturbance), or
squeal by itself. Safe μ is the friction coefficient below which no knock was found to cause squeal.
"""

from itertools import chain

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from fivtui import uncertainty
from fivtui.reliability.result import Uncertainty
from fivtui.reliability.statistics import rank_inputs


@pytest.fixture(scope="module")
def result() -> Uncertainty:
    # The growth rate and the probability of `unstable` are always outputs, too.
    vary = {"mu": "uniform:0.2:0.8", "F": "uniform:79:81"}
    return uncertainty(vary=vary, samples=256, repeats=4, outputs=("critical_mu", "safe_mu"))


def bar_patches(axes: Axes) -> list[Rectangle]:
    return [patch for patch in axes.patches if isinstance(patch, Rectangle)]


def sum_of_bin_heights(axes: Axes) -> float:
    """Sum of the heights of all 40 bins of a histogram, of all regions.

    The bins of a region are one filled outline. The areas of all outlines, by the trapezoidal rule
    along them, are the bin width times the sum of heights.
    """
    low, high = axes.dataLim.intervalx
    bin_width = (high - low) / 40.0
    area = 0.0
    for collection in axes.collections:
        for path in collection.get_paths():
            x, y = np.asarray(path.vertices).T
            area += abs(np.trapezoid(y, x))
    return float(area / bin_width)


def panel_position(axes: Axes) -> int:
    """Index of a panel in its grid, row by row."""
    cell = axes.get_subplotspec()
    assert cell is not None
    return cell.num1


def panels(figure: Figure) -> list[list[Axes]]:
    """The panels of every part, row by row."""
    return [sorted(part.axes, key=panel_position) for part in figure.subfigs]


def test_histograms_indices_and_samples_agree_with_the_study(result: Uncertainty) -> None:
    histograms, index_panels, matrix = panels(result.figure())
    assert [axes.get_xlabel() for axes in histograms] == [
        "Greatest real part of the eigenvalues (1/s)",
        "Critical friction coefficient",
        "Least μ on the branch from the Hopf point",
    ]
    for axes in histograms:
        assert sum_of_bin_heights(axes) == pytest.approx(1.0)
    titles = [axes.get_title().replace("\n", " ") for axes in index_panels]
    assert titles[0].startswith("Sobol indices of: unstable")
    assert len(set(titles)) == len(result.indices)
    for axes, (output, indices) in zip(index_panels, result.indices.items(), strict=True):
        # Rows of the panel from the bottom: the input with the least influence first.
        rows = list(reversed(rank_inputs(indices)))
        drawn = [bar.get_width() for bar in bar_patches(axes)]
        expected = chain(
            (index.first.value for _, index in rows),
            (index.total.value for _, index in rows),
        )
        np.testing.assert_allclose(drawn, list(expected), err_msg=output)
        diamonds: list[float] = []
        for line in axes.lines:
            if line.get_marker() == "D":
                diamonds += np.asarray(line.get_xdata(), dtype=float).tolist()
        # Diamonds are the indices that the inputs would have if the output were linear, `share` in
        # `result.local`: from the derivatives of the output at the means of all inputs. Events,
        # such as unstable, have no derivatives and no diamonds.
        if output in result.local:
            assert diamonds == [result.local[output][name].share for name, _ in rows]
        else:
            assert diamonds == []
    # Two histograms on the diagonal, one panel of dots below it.
    assert len(matrix) == 3
    assert sum(np.size(line.get_xdata()) for axes in matrix for line in axes.lines) == 256


def test_without_indices_and_safe_friction_there_are_two_parts_and_two_regions() -> None:
    result = uncertainty(vary={"mu": "uniform:0.2:0.8"}, samples=64, indices=False,
                        outputs=("growth_rate",))  # fmt: skip
    figure = result.figure()
    # Histograms and samples, but no indices.
    assert len(panels(figure)) == 2
    # Without safe μ it is not known which samples squeal after a knock.
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["stable", "squeals by itself"]
