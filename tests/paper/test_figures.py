"""The paper's figures, drawn and saved."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fivtui.io import is_replaceable, output_path
from fivtui.model.errors import Cancelled, InputError
from fivtui.paper.amplitudes import Amplitude
from fivtui.paper.charts import draw as paper_figure
from fivtui.paper.export import NUMBERS, figure_files, figure_numbers, save_figures
from fivtui.paper.panels import PANELS
from fivtui.paper.results import PaperResults
from fivtui.scene.scene import Scene
from tests.support.reading import transient_figure

# Numbers of figures by kind. Of those of amplitudes, 13 and 14 are over F, 15 and 16 over k_nl: one
# of each is tested.
EIGENVALUES, CRITICAL, TRANSIENTS, AMPLITUDES = (3, 4, 5), (6, 7, 8, 9), (10, 11, 12), (13, 16)


def invented_amplitudes(scenes: Sequence[Scene], **options: Any) -> list[Amplitude]:
    # Invented amplitudes, which cost no time: drawing does not depend on their origin.
    progress = options.get("progress")
    if progress is not None and not progress(1.0):
        raise Cancelled
    return [
        Amplitude(scene.parameters.F + scene.separation, scene.parameters.k_nl, 7, 1.0)
        for scene in scenes
    ]


@cache
def draw(number: int, results: PaperResults) -> Figure:
    """Draw a figure once for all tests; they only read it."""
    return paper_figure(number, results)


@pytest.fixture(scope="module")
def results() -> PaperResults:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fivtui.paper.results.compute_amplitudes", invented_amplitudes)
        paper = PaperResults()
        # Tables are computed once, here with the invented amplitudes.
        for key in ("13", "14", "15", "16"):
            paper.table(key)
        return paper


def curves_in(axes: Axes) -> list[Line2D]:
    # Lines with many points; others mark single points or zero.
    return [line for line in axes.get_lines() if np.size(line.get_xdata()) > 2]


def line_style(line: Line2D) -> tuple[Any, ...]:
    # Properties of a line that are visible in black and white.
    dashes = line._unscaled_dash_pattern  # type: ignore[attr-defined]
    return (line.get_marker(), str(dashes))


@pytest.mark.parametrize("number", NUMBERS)
def test_lines_differ_without_colour(number: int, results: PaperResults) -> None:
    figure = draw(number, results)
    for axes in figure.axes:
        named = [line for line in curves_in(axes) if not str(line.get_label()).startswith("_")]
        assert len({line_style(line) for line in named}) == len(named) >= 2


@pytest.mark.parametrize("number", NUMBERS)
def test_every_axis_has_a_label_with_a_unit_unless_dimensionless(
    number: int, results: PaperResults
) -> None:
    for axes in draw(number, results).axes:
        labels = [axes.get_xlabel()]
        # Both axes of these figures show the same quantity: only the first has a label of y.
        if number not in (2, *TRANSIENTS) or axes is axes.figure.axes[0]:
            labels.append(axes.get_ylabel())
        for label in labels:
            assert label.endswith(")") or "friction coefficient" in label.lower()


@pytest.mark.parametrize("number", NUMBERS)
def test_a_figure_has_no_window_and_fits_its_frame(number: int, results: PaperResults) -> None:
    figure = draw(number, results)
    assert isinstance(figure.canvas, FigureCanvasAgg)
    figure.draw_without_rendering()
    box = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    assert box.x0 >= -0.01
    assert box.y0 >= -0.01
    assert box.x1 <= width + 0.01
    assert box.y1 <= height + 0.01


def legend_texts(figure: Figure) -> list[str]:
    holders = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    return [
        text.get_text() for holder in holders if holder is not None for text in holder.get_texts()
    ]


def test_legends_name_the_lines(results: PaperResults) -> None:
    entries = legend_texts(draw(6, results))
    assert [entry.replace("\N{NO-BREAK SPACE}", " ") for entry in entries] == [
        "linear, $k_{\\mathrm{nl}}$ = 0 N/m$^3$",
        "$k_{\\mathrm{nl}}$ = 50 N/m$^3$",
        "$k_{\\mathrm{nl}}$ = 200 N/m$^3$",
        "$k_{\\mathrm{nl}}$ = 500 N/m$^3$",
    ]
    assert legend_texts(draw(13, results)) == ["separation ignored", "separation considered"]
    assert "off the belt" in legend_texts(draw(12, results))


@pytest.mark.parametrize("number", CRITICAL)
def test_lines_are_those_of_the_data(number: int, results: PaperResults) -> None:
    data = results.table(str(number))
    (axes,) = draw(number, results).axes
    for line, (_, columns) in zip(curves_in(axes), data.lines(), strict=True):
        np.testing.assert_array_equal(line.get_xdata(), columns[data.along])
        np.testing.assert_array_equal(line.get_ydata(), columns["mu_c"])


@pytest.mark.parametrize("number", EIGENVALUES)
def test_merged_modes_are_drawn_once(number: int, results: PaperResults) -> None:
    data = results.table(str(number))
    frequencies, _ = draw(number, results).axes
    for line, (_, columns) in zip(curves_in(frequencies), data.lines(), strict=True):
        # A NaN separates the two modes.
        gap = columns["omega_1"].size
        second = np.asarray(line.get_ydata(), dtype=float)[gap + 1 :]
        hidden = np.isnan(second)
        merged = np.isclose(columns["omega_1"], columns["omega_2"], rtol=1e-6)
        assert np.all(merged[hidden])
        # With the damping of Fig. 5 the frequencies do not merge.
        assert hidden.any() == (number != 5)
        np.testing.assert_array_equal(second[~hidden], columns["omega_2"][~hidden])


def test_critical_friction_is_marked_where_the_growth_rate_is_zero(results: PaperResults) -> None:
    _, growth = draw(4, results).axes
    marks = [line for line in growth.get_lines() if line.get_marker() == "o"]
    # The last mark is the legend's entry.
    positions = [float(np.asarray(line.get_xdata())[0]) for line in marks[:-1]]
    assert positions == pytest.approx([1.0181, 0.3738, 0.5976, 1.5473], abs=5e-5)


@pytest.mark.parametrize("number", AMPLITUDES)
def test_amplitudes_show_peak_and_half_range(number: int, results: PaperResults) -> None:
    peak, half_range = draw(number, results).axes
    data = results.table(str(number))
    for axes, name in ((peak, "y_peak"), (half_range, "y_half_range")):
        for line, separation in zip(curves_in(axes), (0.0, 1.0), strict=True):
            np.testing.assert_array_equal(line.get_ydata(), data.line(separation)[name])
    assert "Peak" in peak.get_ylabel()
    assert "Half peak-to-peak" in half_range.get_ylabel()


def test_runs_are_drawn_in_full_and_enlarged_at_their_end(results: PaperResults) -> None:
    overview, late = draw(10, results).axes
    assert overview.get_xlim() == (0.0, 100.0)
    assert late.get_xlim() == (90.0, 100.0)


def test_an_unknown_quantity_of_a_run_is_refused(results: PaperResults) -> None:
    with pytest.raises(InputError, match="unknown quantity 'z'"):
        transient_figure(results.runs(PANELS["10"]), quantities=["z"])


@pytest.mark.slow
def test_all_figures_are_written_with_their_data(results: PaperResults, tmp_path: Path) -> None:
    fractions: list[float] = []

    def progress(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    written = save_figures(
        NUMBERS, tmp_path / "new", formats=["svg"], results=results, progress=progress
    )
    assert [files.number for files in written] == list(range(2, 17))
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {f"fig-{n:02d}.svg" for n in range(2, 17)} | {
        f"fig-{n:02d}.csv" for n in range(3, 17)
    } | {"fig-02a.csv", "fig-02b.csv"}
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)


def test_the_same_figure_has_the_same_bytes(results: PaperResults, tmp_path: Path) -> None:
    for name in ("one", "other"):
        save_figures([6], tmp_path / name, formats=["pdf", "svg", "png"], results=results)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes()


def test_an_existing_file_stops_all_figures_before_the_work(
    results: PaperResults, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(results, "prepare", lambda *_: pytest.fail("computed all the same"))
    (tmp_path / "fig-07.csv").write_text("mine")
    with pytest.raises(InputError, match=r"fig-07\.csv: exists"):
        save_figures([6, 7], tmp_path, results=results)
    assert [path.name for path in tmp_path.iterdir()] == ["fig-07.csv"]
    assert (tmp_path / "fig-07.csv").read_text() == "mine"


def test_force_replaces_existing_files(results: PaperResults, tmp_path: Path) -> None:
    (tmp_path / "fig-06.csv").write_text("mine")
    (files,) = save_figures(
        [6], output_path(tmp_path, force=True), formats=["png"], results=results
    )
    # Permission to replace files is a property of the path of the folder, and ends with the call.
    assert not any(map(is_replaceable, (*files.pictures, *files.data)))
    assert "mine" not in (tmp_path / "fig-06.csv").read_text()


def test_a_folder_that_is_a_file_is_refused(results: PaperResults, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    with pytest.raises(InputError, match="taken"):
        save_figures([6], tmp_path / "taken", results=results)


@pytest.mark.parametrize("stop_share", [0.0, 0.5])
def test_cancelled_work_leaves_only_complete_files(
    results: PaperResults, tmp_path: Path, stop_share: float
) -> None:
    with pytest.raises(Cancelled):
        save_figures(
            [6, 8],
            tmp_path,
            formats=["png"],
            results=results,
            progress=lambda share: share < stop_share,
        )
    expected = set() if stop_share == 0.0 else {"fig-06.png", "fig-06.csv"}
    assert {path.name for path in tmp_path.iterdir()} == expected


def test_numbers_are_read_with_ranges() -> None:
    assert figure_numbers([]) == tuple(range(2, 17))
    assert figure_numbers(["3-5", "2", "4"]) == (2, 3, 4, 5)


@pytest.mark.parametrize(
    "text", ["1", "17", "0", "-3", "9-3", "two", "2-", "2.0", "", "٣", "999999"]
)
def test_numbers_that_are_no_figures_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="must be 2 to 16"):
        figure_numbers([text])


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(InputError, match="did you mean pdf"):
        figure_files(2, Path(), ["pdff"])
