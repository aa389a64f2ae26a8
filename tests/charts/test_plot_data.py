"""Data of charts in columns of characters or pixels, and limits and ticks of axes.

An envelope keeps a few samples of each column. Shares are the parts of each column's time that
intervals, such as those off the belt, cover.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui.charts.plot_data import (
    axis_limits,
    covered_shares,
    dense_band,
    envelope,
    round_ticks,
    shade_text,
    tick_labels,
)

FINITE_FLOATS = st.floats(min_value=-1e12, max_value=1e12, allow_subnormal=False)


@given(st.integers(0, 2**32), st.integers(1, 40), st.floats(0.0, 0.4), st.floats(0.5, 1.0))
def test_an_envelope_keeps_the_extremes_of_every_column_in_the_order_of_time(
    seed: int, columns: int, low: float, high: float
) -> None:
    values = np.random.default_rng(seed).standard_cauchy(800)
    t = np.linspace(0.0, 1.0, values.size)
    edges = np.linspace(low, high, columns + 1)
    envelope_t, envelope_values = envelope(t, values, edges)
    # Four samples per column, and a few beyond both ends.
    assert envelope_values.size <= 4 * columns + 8
    assert np.all(np.diff(envelope_t) > 0.0)
    for begin, end in pairwise(edges.tolist()):
        # Slightly inside, so that rounding of the edges does not matter.
        is_in_column = (t > begin + 1e-9) & (t < end - 1e-9)
        is_near_column = (envelope_t > begin - 1e-9) & (envelope_t < end + 1e-9)
        if is_in_column.any():
            assert envelope_values[is_near_column].max() >= values[is_in_column].max()
            assert envelope_values[is_near_column].min() <= values[is_in_column].min()


def test_few_samples_are_drawn_unchanged() -> None:
    t = np.linspace(0.0, 1.0, 11)
    envelope_t, envelope_values = envelope(t, np.sin(t), np.linspace(0.25, 0.55, 101))
    assert envelope_t.tolist() == pytest.approx([0.2, 0.3, 0.4, 0.5, 0.6])
    assert envelope_values == pytest.approx(np.sin(envelope_t))


def test_the_cost_of_drawing_does_not_grow_with_the_run() -> None:
    t = np.linspace(0.0, 1.0, 250_000)
    # Four samples in each of 100 columns, and a few beyond both ends.
    assert envelope(t, np.sin(1e4 * t), np.linspace(0.0, 1.0, 101))[0].size <= 408


def test_shares_of_separation_are_exact_per_column() -> None:
    shares = covered_shares([(0.5, 1.0), (1.5, 3.0)], (0.0, 4.0), 4)
    assert shares.tolist() == [0.5, 0.5, 1.0, 0.0]


@given(st.lists(st.floats(0.0, 10.0), unique=True, max_size=20), st.integers(1, 50))
def test_shares_of_separation_add_up_to_the_separated_time(
    times: list[float], columns: int
) -> None:
    edges = sorted(times)
    intervals = list(zip(edges[::2], edges[1::2], strict=False))
    shares = covered_shares(intervals, (0.0, 10.0), columns)
    total = sum(end - begin for begin, end in intervals)
    assert shares.sum() * 10.0 / columns == pytest.approx(total, abs=1e-9)


def test_no_separation_is_blank_and_no_contact_is_full() -> None:
    assert shade_text(np.array([0.0, 1e-9, 0.34, 0.67, 1.0 - 1e-9, 1.0])) == " ░▒▓▓█"


def test_a_separation_shorter_than_a_column_stays_visible() -> None:
    assert shade_text(covered_shares([(5.0, 5.0001)], (0.0, 100.0), 10)) == "░" + " " * 9


@given(FINITE_FLOATS, FINITE_FLOATS)
def test_axis_limits_include_the_range_and_are_distinct(a: float, b: float) -> None:
    low, high = axis_limits(min(a, b), max(a, b), 0.05)
    assert low < high
    assert low <= min(a, b) <= max(a, b) <= high


def test_rounding_noise_is_drawn_as_a_constant() -> None:
    low, high = axis_limits(56.37, 56.37 * (1.0 + 1e-14), 0.05)
    assert high - low > 1.0


@given(FINITE_FLOATS, st.floats(1e-3, 1e12), st.integers(2, 12))
def test_ticks_are_round_and_inside_the_limits_and_at_most_the_maximum_number(
    low: float, span: float, max_count: int
) -> None:
    high = low + span
    # Limits that nearly coincide are never those of an axis.
    if (high - low) < 1e-9 * abs(low):
        return
    ticks = round_ticks(low, high, max_count)
    assert len(ticks) <= max_count
    tolerance = 1e-9 * max(abs(low), abs(high))
    assert all(low - tolerance <= tick <= high + tolerance for tick in ticks)
    for first, second in pairwise(ticks):
        mantissa = (second - first) / 10.0 ** math.floor(math.log10(1.0001 * (second - first)))
        assert any(mantissa == pytest.approx(factor, rel=1e-3) for factor in (1.0, 2.0, 5.0))


@pytest.mark.parametrize(
    ("ticks", "labels"),
    [
        ([0.0, 20.0, 40.0], ["0", "20", "40"]),
        ([-0.5, 0.0, 0.5], ["-0.5", "0", "0.5"]),
        ([0.0, 1e7, 2e7], ["0", "1e+07", "2e+07"]),
        ([99.98, 99.99, 100.0], ["99.98", "99.99", "100"]),
        ([-0.2, -5.6e-17, 0.2], ["-0.2", "0", "0.2"]),
        ([], []),
    ],
)
def test_tick_labels_are_short_and_distinct(ticks: list[float], labels: list[str]) -> None:
    assert tick_labels(ticks) == labels


def test_the_edges_of_a_dense_signal_follow_its_amplitude_where_it_is_dense() -> None:
    x = np.linspace(0.0, 100.0, 10_001)
    edges = np.linspace(0.0, 100.0, 161)
    centres = 0.5 * (edges[1:] + edges[:-1])
    amplitude = 2.0 + np.sin(0.3 * x)
    # A second, smaller wave has extrema inside of the edges.
    signal = amplitude * (np.sin(5.0 * x) + 0.6 * np.sin(10.0 * x + 1.0))
    period = 2.0 * np.pi / 5.0
    low, high = dense_band(x, signal, edges)
    for centre, bottom, top in list(zip(centres, low, high, strict=True))[6:-6]:
        # In one and a half periods, in which the edges move by up to 0.6.
        values = signal[np.abs(x - centre) <= 0.75 * period]
        assert top == pytest.approx(values.max(), abs=0.6)
        assert bottom == pytest.approx(values.min(), abs=0.6)
    assert np.isfinite(dense_band(x, np.sin(5.0 * x), edges)[1]).all()
    # At rest from half of the time.
    low, high = dense_band(x, np.where(x < 50.0, signal, 0.0), edges)
    assert np.isfinite(high[6:75]).all()
    assert np.isnan(low[85:]).all()
    assert np.isnan(high[85:]).all()
    # Before the end of growing vibration.
    growing = np.exp(0.1 * x) * np.sin(5.0 * x)
    low, high = dense_band(x, growing, edges[:81])
    assert max(-low.min(), high.max()) == pytest.approx(np.abs(growing[x <= 50.0]).max())
    # Long periods, and few samples.
    assert np.isnan(dense_band(x, np.sin(0.5 * x), edges)[1]).all()
    assert np.isnan(dense_band(x[::100], signal[::100], edges)[1]).all()
