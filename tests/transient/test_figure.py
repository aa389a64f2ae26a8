"""Figures of transients."""

import re
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fivtui.charts.figure_style import check_figure_path, save_figure
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.simulation import simulate
from fivtui.transient.charts import run_labels
from fivtui.transient.request import Start
from fivtui.transient.result import Transient
from tests.io.test_files import file_size_limit
from tests.support.reading import transient_figure

SUFFIXES = (".png", ".svg", ".pdf")


def run(
    parameters: Parameters | None = None,
    *,
    t_end: float = 100.0,
    separation: bool = True,
    start: Start = "static",
    samples: int = 4001,
    method: str = "taylor",
) -> Transient:
    times = np.linspace(0.0, t_end, samples)
    return simulate(
        parameters,
        t_end=t_end,
        separation=separation,
        start=start,
        samples=times,
        method=method,
        tol=1e-8,
    )


@pytest.fixture(scope="module")
def separating_run() -> Transient:
    return run()


@pytest.fixture(scope="module")
def bilateral_run() -> Transient:
    return run(separation=False)


def labelled_curves(axes: Axes) -> list[Line2D]:
    return [line for line in axes.lines if not str(line.get_label()).startswith("_")]


def shaded_areas(axes: Axes) -> list[PolyCollection]:
    return [collection for collection in axes.collections if isinstance(collection, PolyCollection)]


def legend_texts(figure: Figure) -> list[str]:
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


def test_the_panels_are_those_of_the_papers_figures_10_to_12_beside_the_last_cycles(
    separating_run: Transient, bilateral_run: Transient
) -> None:
    figure = transient_figure([bilateral_run, separating_run], title="Base scene")
    left_axes, right = figure.axes[:3], figure.axes[3:]
    assert [axes.get_ylabel() for axes in left_axes] == [
        "Contact\nforce $P$ (N)",
        "Horizontal\ndisplacement $x$ (m)",
        "Vertical\ndisplacement $y$ (m)",
    ]
    assert [axes.get_xlim() for axes in left_axes] == [(0.0, 100.0)] * 3
    assert [axes.get_xlim() for axes in right] == [(90.0, 100.0)] * 3
    assert {axes.get_xlabel() for axes in (left_axes[-1], right[-1])} == {"Time $t$ (s)"}
    assert right[0].get_title() == "last 10 s"
    assert figure.get_suptitle() == "Base scene"


def test_every_curve_shows_its_column_to_the_last_extreme(
    separating_run: Transient, bilateral_run: Transient
) -> None:
    runs = [separating_run, bilateral_run]
    figure = transient_figure(runs)
    for axes, name in zip(figure.axes[:3], "Pxy", strict=True):
        for line, plotted in zip(labelled_curves(axes), runs, strict=True):
            assert plotted.trajectory is not None
            values = getattr(plotted.trajectory, name)
            drawn_values = np.asarray(line.get_ydata())
            assert drawn_values.min() == values.min()
            assert drawn_values.max() == values.max()
            low, high = axes.get_ylim()
            assert low <= values.min() < values.max() <= high


@given(samples=st.integers(2, 40_000))
def test_a_line_is_reduced_to_a_bounded_number_of_samples_without_loss_of_extremes(
    samples: int,
) -> None:
    sampled_run = run(t_end=3.0, samples=samples)
    assert sampled_run.trajectory is not None
    figure = transient_figure([sampled_run])
    (line,) = labelled_curves(figure.axes[2])
    t, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    # At most four samples in each of 4000 columns, and the last one.
    assert t.size <= 4 * 4000 + 1
    assert (t[0], t[-1]) == (0.0, 3.0)
    assert np.all(np.diff(t) > 0.0)
    assert (y.min(), y.max()) == (sampled_run.trajectory.y.min(), sampled_run.trajectory.y.max())


def test_separation_considered_is_dashed_green_and_ignored_solid_blue(
    separating_run: Transient, bilateral_run: Transient
) -> None:
    figure = transient_figure([separating_run, bilateral_run])
    for axes in figure.axes:
        dashed, solid = labelled_curves(axes)
        assert (dashed.is_dashed(), solid.is_dashed()) == (True, False)
        assert np.argmax(to_rgb(dashed.get_color())) == 1
        assert np.argmax(to_rgb(solid.get_color())) == 2
        assert dashed.get_zorder() > solid.get_zorder()
    assert legend_texts(figure) == ["separation considered", "separation ignored", "off the belt"]


def test_runs_with_the_same_separation_setting_differ_in_markers() -> None:
    runs = [run(Parameters(F=force), samples=801) for force in (40.0, 60.0, 80.0)]
    figure = transient_figure(runs)
    for axes in figure.axes:
        assert len({str(line.get_marker()) for line in labelled_curves(axes)}) == 3
        assert shaded_areas(axes) == []


def test_intervals_off_the_belt_are_shaded_if_only_one_run_has_them(
    separating_run: Transient, bilateral_run: Transient
) -> None:
    assert len(separating_run.separated_intervals) == 74
    for axes in transient_figure([bilateral_run, separating_run]).axes:
        (collection,) = shaded_areas(axes)
        spans = [path.get_extents().intervalx for path in collection.get_paths()]
        np.testing.assert_allclose(spans, separating_run.separated_intervals, rtol=1e-12)
    for axes in transient_figure([bilateral_run]).axes:
        assert shaded_areas(axes) == []


def test_a_run_of_few_cycles_has_no_panels_of_last_cycles() -> None:
    figure = transient_figure([run(t_end=5.0)])
    assert len(figure.axes) == 3
    assert legend_texts(figure) == ["separation considered", "off the belt"]


def test_a_crowded_run_has_dashes_and_shading_only_in_the_panels_of_the_last_cycles() -> None:
    figure = transient_figure([run(t_end=300.0)])
    full_axes, last_cycles_axes = figure.axes[0], figure.axes[3]
    assert not labelled_curves(full_axes)[0].is_dashed()
    assert shaded_areas(full_axes) == []
    assert labelled_curves(last_cycles_axes)[0].is_dashed()
    assert len(shaded_areas(last_cycles_axes)) == 1


def test_a_slider_at_rest_has_no_cycles_to_enlarge() -> None:
    figure = transient_figure([run(Parameters(mu=0.0))])
    assert len(figure.axes) == 3


def test_runs_of_different_length_share_the_longest_time(separating_run: Transient) -> None:
    figure = transient_figure([run(Parameters(F=60.0), t_end=20.0), separating_run])
    assert figure.axes[0].get_xlim() == (0.0, 100.0)


def test_labels_name_only_the_differences(
    separating_run: Transient, bilateral_run: Transient
) -> None:
    assert run_labels([separating_run]) == ["separation considered"]
    assert run_labels([separating_run, bilateral_run]) == [
        "separation considered",
        "separation ignored",
    ]
    stiff = run(Parameters(k_nl=200.0, mu=0.5), t_end=1.0, samples=2)
    labels = [
        label.replace("\N{NO-BREAK SPACE}", " ") for label in run_labels([separating_run, stiff])
    ]
    assert labels == [
        r"separation considered, $k_{\mathrm{nl}}$ = 100 N/m$^3$, $μ$ = 0.7",
        r"separation considered, $k_{\mathrm{nl}}$ = 200 N/m$^3$, $μ$ = 0.5",
    ]


def test_labels_differ_by_method_start_or_number(separating_run: Transient) -> None:
    rk4_run = run(t_end=1.0, samples=2, method="rk4")
    assert run_labels([separating_run, rk4_run]) == [
        "separation considered, taylor",
        "separation considered, rk4",
    ]
    moved_start_run = run(t_end=1.0, samples=2, start=(0.0, 0.0, -1.5, 0.0))
    assert run_labels([moved_start_run, separating_run]) == [
        "separation considered, start (0, 0, −1.5, 0)",
        "separation considered, start (−0.156, 0, −0.675, 0)",
    ]
    assert run_labels([separating_run, separating_run]) == [
        "separation considered, run 1",
        "separation considered, run 2",
    ]


def test_even_the_longest_legend_stays_inside_the_figure() -> None:
    first = run(t_end=5.0)
    changed = Parameters(**{name: 1.1 * value for name, value in Parameters().as_dict().items()})
    second = run(changed, t_end=5.0, separation=False)
    figure = transient_figure([first, second])
    figure.draw_without_rendering()
    legend_box = figure.legends[0].get_window_extent()
    assert 0.0 <= legend_box.x0 < legend_box.x1 <= figure.bbox.x1
    axes_boxes = [bounds for axes in figure.axes if (bounds := axes.get_tightbbox()) is not None]
    assert legend_box.y1 <= min(bounds.y0 for bounds in axes_boxes)


def test_without_run_or_trajectory_there_is_no_figure() -> None:
    with pytest.raises(InputError, match="no run to draw"):
        transient_figure([])
    with pytest.raises(InputError, match="no trajectory"):
        transient_figure([simulate(t_end=1.0)])


@pytest.mark.parametrize(
    ("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_a_figure_is_saved_in_the_format_and_size_of_its_suffix_with_the_same_bytes(
    separating_run: Transient, tmp_path: Path, suffix: str, start: bytes
) -> None:
    paths = [tmp_path / f"{name}{suffix}" for name in "ab"]
    settings_before = dict(mpl.rcParams)
    figures = [transient_figure([separating_run]) for _ in paths]
    for figure, path in zip(figures, paths, strict=True):
        save_figure(figure, path)
        assert isinstance(figure.canvas, FigureCanvasAgg)
    assert dict(mpl.rcParams) == settings_before
    first, second = (path.read_bytes() for path in paths)
    assert first.startswith(start)
    assert first == second
    # Names of the date in SVG, PDF and PNG; shorter text occurs in compressed data by chance.
    assert not re.search(rb"dc:date|CreationDate|Creation Time", first)
    with pytest.raises(InputError, match="exists already"):
        save_figure(figures[0], paths[0])
    if suffix == ".png":
        # Width and height follow the signature and the name of the first chunk.
        size = [int.from_bytes(first[16:20]), int.from_bytes(first[20:24])]
        assert size == [round(200 * inches) for inches in figures[0].get_size_inches()]


def test_an_unknown_suffix_is_refused_with_the_allowed_ones(
    separating_run: Transient, tmp_path: Path
) -> None:
    path, message = tmp_path / "run.jpg", r"run\.jpg: .* \.png, \.svg, \.pdf$"
    with pytest.raises(InputError, match=message):
        check_figure_path(path)
    with pytest.raises(InputError, match=message):
        save_figure(transient_figure([separating_run]), path)
    check_figure_path(tmp_path / "run.svg")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_leaves_no_file(separating_run: Transient, tmp_path: Path, suffix: str) -> None:
    figure = transient_figure([separating_run])
    with file_size_limit(10_000), pytest.raises(InputError, match="cannot be written"):
        save_figure(figure, tmp_path / f"run{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_pyplot_is_never_imported_and_charts_need_no_matplotlib() -> None:
    code = (
        "import sys, fivtui.transient.charts, fivtui.measured.charts, fivtui.paper.charts\n"
        "assert 'matplotlib' not in sys.modules\n"
        "import fivtui.charts.sheet; sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
