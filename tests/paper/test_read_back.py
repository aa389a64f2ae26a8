"""Figs. 2 to 16: every line agrees with its legend entry, in print and in the terminal."""

import dataclasses
import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fivtui.charts.readout import NearestPoint
from fivtui.paper import results as paper_results
from fivtui.paper.amplitudes import Amplitude
from fivtui.paper.charts import draw, figure_charts
from fivtui.paper.data import DATA_COLUMNS, save_data
from fivtui.paper.panels import PANELS, figure_panels
from fivtui.paper.results import PaperResults
from fivtui.scene.scene import Scene
from fivtui.tui.tabs.paper import figure_row, point_scene
from tests.support import paper_model
from tests.support.reading import (
    drawn_line,
    handles_by_text,
    labels,
    legend_entries,
    points,
    without_mathtext,
)

FloatArray = NDArray[np.float64]
# States (x, ẋ, y, ẏ) of the base set by separation and time in s, from the paper's method: RK4 with
# bisection (`tests/data/make_paper_points.py`).
STATES: Final = {
    bool(point["changes"]["separation"]): point["states"]
    for point in json.loads(
        Path(__file__)
        .parents[1]
        .joinpath("data")
        .joinpath("paper_points.json")
        .read_text(encoding="utf-8")
    )
    if point["key"] == "base"
}
CASES: Final = {"separation ignored": False, "separation considered": True}

# From the captions and the text: the parameter along x with its range, the parameter that
# distinguishes the lines with its values, and the shared parameters.
PRELOADS, STIFFNESSES, FRICTION = ("F", 0.0, 100.0), ("k_nl", 0.0, 500.0), ("mu", 0.0, 2.0)
SOFT: Final = {"k1": 50.0, "k2": 100.0}
FIGURES: Final[Mapping[str, tuple[Any, str, Sequence[float], Mapping[str, float]]]] = {
    "2a": (PRELOADS, "k_nl", (0.0, 50.0, 100.0, 500.0), {}),
    "2b": (STIFFNESSES, "F", (0.0, 5.0, 50.0, 100.0), {}),
    "3": (FRICTION, "k_nl", (0.0, 50.0, 100.0, 500.0), {"F": 20.0}),
    "4": (FRICTION, "k_nl", (0.0, 50.0, 100.0, 500.0), {"F": 100.0}),
    "5": (FRICTION, "k_nl", (0.0, 50.0, 100.0, 500.0), {"F": 100.0, "c1": 0.8}),
    "6": (PRELOADS, "k_nl", (0.0, 50.0, 200.0, 500.0), {}),
    "7": (STIFFNESSES, "F", (0.0, 5.0, 50.0, 100.0), {}),
    "8": (PRELOADS, "k_nl", (0.0, 50.0, 200.0, 500.0), SOFT),
    "9": (STIFFNESSES, "F", (0.0, 5.0, 50.0, 100.0), SOFT),
    "13": (("F", 60.0, 190.0), "", (), {"k_nl": 20.0, "mu": 0.5}),
    "14": (("F", 20.0, 110.0), "", (), {"k_nl": 100.0, "mu": 0.7}),
    "15": (("k_nl", 20.0, 500.0), "", (), {"F": 40.0, "mu": 0.7}),
    "16": (("k_nl", 20.0, 500.0), "", (), {"F": 60.0, "mu": 1.0}),
}
AXIS_LABELS: Final = {
    "F": "Preload F (N)",
    "k_nl": "Cubic contact stiffness k_nl (N/m^3)",
    "mu": "Friction coefficient μ",
}
UNITS: Final = {"F": " N", "k_nl": " N/m^3"}
# The step between points of thinned lines, which include both ends.
THINNING: Final = 25


def amplitude(case: bool, p: Mapping[str, float]) -> tuple[float, float]:
    # A different number for every scene; other tests check the amplitudes themselves.
    size = p["F"] + 0.1 * p["k_nl"] + 7.0 * p["mu"]
    return size + 3.0 * case, 0.5 * size + 5.0 * case


def invented_amplitudes(scenes: Sequence[Scene], **_: Any) -> list[Amplitude]:
    return [
        Amplitude(*amplitude(scene.separation, scene.parameters.as_dict()), 7, 1.0)
        for scene in scenes
    ]


@pytest.fixture(scope="module")
def results() -> PaperResults:
    # All lines with fewer points.
    thinned_panels = {
        key: dataclasses.replace(
            panel,
            lines=tuple(
                dataclasses.replace(line, values=line.values[::THINNING]) for line in panel.lines
            ),
        )
        for key, panel in PANELS.items()
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper_results, "compute_amplitudes", invented_amplitudes)
        patch.setattr(paper_results, "PANELS", thinned_panels)
        # Number of samples of a run.
        patch.setattr(paper_results, "_SAMPLES", 2001)
        paper = PaperResults()
        for key in PANELS:
            paper.table(key)
    return paper


def legend_names(key: str) -> dict[str, float]:
    """Names of the lines in the legend of a figure, and the values that they state."""
    _, by, values, _ = FIGURES[key]
    if not by:
        return {name: float(case) for name, case in CASES.items()}
    symbol = f"{by} = {{:g}}{UNITS[by]}"
    linear = "linear, " if by == "k_nl" else ""
    return {(linear if v == 0.0 else "") + symbol.format(v): v for v in values}


def check_ends(key: str, x: FloatArray) -> None:
    (_, low, high), *_ = FIGURES[key]
    assert x[0] == low
    last_value = PANELS[key].lines[0].values[-1]
    assert last_value == high
    assert np.all(np.diff(x) > 0.0)


def check_line(
    key: str,
    line: tuple[FloatArray, FloatArray],
    value: float,
    reference: Callable[..., float],
    may_be_hidden: bool = False,
) -> None:
    # Compare points of a line with values computed from its legend and the figure's caption. The
    # second mode may be hidden, as NaN, where it coincides with the first.
    (along, *_), by, _, shared = FIGURES[key]
    x, y = line
    check_ends(key, x)
    for index in {0, x.size // 3, x.size // 2, x.size - 1}:
        if may_be_hidden and np.isnan(y[index]):
            continue
        changes = {**shared, **({by: value} if by else {}), along: float(x[index])}
        assert y[index] == pytest.approx(reference(**changes), rel=1e-7, abs=1e-7), (key, changes)


def named_lines(
    axes: Axes, handles: Mapping[str, Any]
) -> list[tuple[str, tuple[FloatArray, FloatArray]]]:
    return [(name, points(drawn_line(axes, handle))) for name, handle in handles.items()]


def split_modes(line: Line2D) -> list[tuple[FloatArray, FloatArray]]:
    # Split a line into its two modes, which a missing point in its middle separates.
    x, y = points(line)
    gap = x.size // 2
    return [(x[:gap], y[:gap]), (x[gap + 1 :], y[gap + 1 :])]


def test_fig_2_has_the_equilibria_of_its_lines(results: PaperResults) -> None:
    figure = draw(2, results)
    for key, axes in zip(("2a", "2b"), figure.axes, strict=True):
        assert axes.get_title() == f"({key[1]})"
        # Both panels share the y axis of the first.
        label = "Vertical displacement y_e (m)" if key == "2a" else ""
        assert labels(axes) == (AXIS_LABELS[FIGURES[key][0][0]], label)
        assert axes.get_ylim() == figure.axes[0].get_ylim()
        legend = axes.get_legend()
        assert legend is not None
        names = legend_names(key)
        shown = handles_by_text(legend)
        assert list(shown) == list(names)
        for name, line in named_lines(axes, shown):
            check_line(key, line, names[name], lambda **p: paper_model.equilibrium(**p)[1])
        assert len(axes.lines) == len(names)


def modes(**p: float) -> tuple[complex, complex]:
    values = [value for value in paper_model.eigenvalues(**p).tolist() if value.imag > 0.0]
    lower, upper = sorted(values, key=lambda value: value.imag)
    # Of modes with merged frequencies, the growing one comes first.
    if upper.imag - lower.imag < 1e-6 * upper.imag and upper.real > lower.real:
        return upper, lower
    return lower, upper


@pytest.mark.parametrize("key", ["3", "4", "5"])
def test_figs_3_to_5_have_both_modes_of_every_line_and_its_critical_friction(
    key: str, results: PaperResults
) -> None:
    figure = draw(int(key), results)
    left_axes, right = figure.axes
    assert labels(left_axes) == (AXIS_LABELS["mu"], "Frequency Im λ (rad/s)")
    assert labels(right) == (AXIS_LABELS["mu"], "Growth rate Re λ (1/s)")
    names, shown = legend_names(key), legend_entries(figure)
    assert list(shown) == [*names, "μ_c"]
    for name, value in names.items():
        for axes, part in ((left_axes, "imag"), (right, "real")):
            first, second = split_modes(drawn_line(axes, shown[name]))
            check_line(key, first, value, lambda part=part, **p: getattr(modes(**p)[0], part))
            check_line(
                key,
                second,
                value,
                lambda part=part, **p: getattr(modes(**p)[1], part),
                may_be_hidden=True,
            )
        critical = paper_model.critical_mu(**FIGURES[key][3], k_nl=value)
        (mark,) = [
            line
            for line in right.lines
            if line.get_marker() == "o" and line.get_color() == shown[name].get_color()
            # Skip the legend's entry, which has no finite points.
            if np.isfinite(points(line)[0]).all()
        ]
        x, y = points(mark)
        assert (x.tolist(), y.tolist()) == ([pytest.approx(critical, abs=1e-8)], [0.0])
    # A line of two points marks the growth rate zero.
    zero_lines = [line for line in right.lines if points(line)[1].tolist() == [0.0, 0.0]]
    assert len(zero_lines) == 1
    assert not any(line.get_marker() == "o" for line in left_axes.lines)


@pytest.mark.parametrize("key", ["6", "7", "8", "9"])
def test_figs_6_to_9_have_the_critical_friction_of_every_line(
    key: str, results: PaperResults
) -> None:
    figure = draw(int(key), results)
    (axes,) = figure.axes
    assert labels(axes) == (AXIS_LABELS[FIGURES[key][0][0]], "Critical friction coefficient μ_c")
    names, shown = legend_names(key), legend_entries(figure)
    assert list(shown) == list(names)
    for name, line in named_lines(axes, shown):
        check_line(key, line, names[name], paper_model.critical_mu)
    assert len(axes.lines) == len(names)
    assert axes.get_ylim()[0] == 0.0


@pytest.mark.parametrize(
    ("number", "label", "column"),
    [
        (10, "Contact force P (N)", None),
        (11, "Horizontal displacement x (m)", 0),
        (12, "Vertical displacement y (m)", 2),
    ],
)
def test_figs_10_to_12_have_the_motions_of_the_papers_method(
    number: int, label: str, column: int | None, results: PaperResults
) -> None:
    figure = draw(number, results)
    overview, late = figure.axes
    assert labels(overview) == ("Time t (s)", label)
    assert labels(late)[0] == "Time t (s)"
    shown = legend_entries(figure)
    assert list(shown) == [*CASES, "off the belt"]
    for name, case in CASES.items():
        for axes, times in ((overview, (5.0, 25.0, 50.0)), (late, (99.0,))):
            line = drawn_line(axes, shown[name])
            x, drawn = points(line)
            assert x[-1] == 100.0
            for time in times:
                state = STATES[case][str(time)]
                y = state[2]
                pressed = y < 0.0 or not case
                force = -50.0 * y - 100.0 * y**3 if pressed else 0.0
                expected = force if column is None else state[column]
                (index,) = np.flatnonzero(np.isclose(x, time))
                assert drawn[index] == pytest.approx(expected, abs=2e-3)
            assert line.is_dashed() == case


@pytest.mark.parametrize("key", ["13", "14", "15", "16"])
def test_figs_13_to_16_have_both_amplitudes_of_both_cases(key: str, results: PaperResults) -> None:
    figure = draw(int(key), results)
    left_axes, right = figure.axes
    along = AXIS_LABELS[FIGURES[key][0][0]]
    assert labels(left_axes) == (along, "Peak |y| (m)")
    assert labels(right)[0] == along
    assert "half" in labels(right)[1]
    assert labels(right)[1].endswith("(m)")
    shown = legend_entries(figure)
    assert list(shown) == list(CASES)
    for axes, index in ((left_axes, 0), (right, 1)):
        assert axes.get_ylim()[0] == 0.0
        assert len(axes.lines) == 2
        for name, line in named_lines(axes, shown):
            case = CASES[name]
            check_line(
                key,
                line,
                float(case),
                lambda case=case, index=index, **p: amplitude(case, paper_model.BASE | p)[index],
            )
            assert drawn_line(axes, shown[name]).is_dashed() == case


PARAMETER_TEXTS: Final = {
    "m": "m = {:g} kg", "k1": "k_1 = {:g} N/m", "k2": "k_2 = {:g} N/m", "k3": "k_3 = {:g} N/m",
    "c1": "c_1 = {:g} N s/m", "c2": "c_2 = {:g} N s/m", "F": "F = {:g} N",
    "k_nl": "k_nl = {:g} N/m^3", "mu": "μ = {:g}",
}  # fmt: skip


@pytest.mark.parametrize("number", range(2, 17))
def test_figures_name_their_fixed_parameters(number: int, results: PaperResults) -> None:
    varied: set[str] = {"mu"} if 3 <= number <= 9 else set()
    shared: Mapping[str, float] = {}
    if number not in (10, 11, 12):
        (along, *_), by, _, shared = FIGURES["2a" if number == 2 else str(number)]
        varied |= {along, by}
    figure = draw(number, results)
    title = figure.get_suptitle() or figure.axes[0].get_title()
    assert without_mathtext(title.replace("\n", ", ")).split(", ") == [
        PARAMETER_TEXTS[name].format(value)
        for name, value in {**paper_model.BASE, **shared}.items()
        if name not in varied
    ]


# Charts in the terminal

Y_LABELS: Final = {
    "equilibrium": ("y_e (m)",),
    "eigenvalues": ("Im λ (rad/s)", "Re λ (1/s)"),
    "critical mu": ("μ_c",),
}
X_LABELS: Final = {"F": "F (N)", "k_nl": "k_nl (N/m^3)", "mu": "μ"}


@pytest.mark.parametrize("key", [key for key in FIGURES if FIGURES[key][1]])
def test_charts_of_the_paper_have_every_line_under_its_name(
    key: str, results: PaperResults
) -> None:
    (along, *_), by, values, shared = FIGURES[key]
    panel = PANELS[key]
    charts = figure_charts(panel, results.table(key))
    assert tuple(chart.y_label for chart in charts) == Y_LABELS[panel.kind]
    for chart, part in zip(charts, ("imag", "real"), strict=False):
        assert chart.x_label == X_LABELS[along]
        spelled = {"mu": "μ"}.get(by, by)
        assert [trace.name for trace in chart.traces] == [f"{spelled} {v:g}" for v in values]
        # Guides are straight lines across a chart, here at the growth rate zero.
        expected_guides = [0.0] if chart.y_label == "Re λ (1/s)" else []
        assert [guide.value for guide in chart.guides] == expected_guides
        for trace, value in zip(chart.traces, values, strict=True):
            # NaN separates the two modes.
            has_modes = panel.kind == "eigenvalues"
            size = (trace.x.size - 1) // 2 if has_modes else trace.x.size
            assert np.isnan(trace.y).sum() == (1 if has_modes else 0)
            check_ends(key, trace.x[:size])
            for index in (0, size // 2, size - 1):
                p = {**shared, by: value, along: float(trace.x[index])}
                if has_modes:
                    drawn = [trace.y[index], trace.y[size + 1 + index]]
                    expected = [getattr(mode, part) for mode in modes(**p)]
                    assert trace.x[size + 1 + index] == trace.x[index]
                    assert sorted(drawn) == pytest.approx(sorted(expected), abs=1e-7)
                    continue
                expected_y = (
                    paper_model.equilibrium(**p)[1]
                    if panel.kind == "equilibrium"
                    else paper_model.critical_mu(**p)
                )
                assert trace.y[index] == pytest.approx(expected_y, abs=1e-7)


def test_charts_of_amplitudes_and_motions_have_both_cases(results: PaperResults) -> None:
    for key in ("13", "14", "15", "16"):
        (along, *_), _, _, shared = FIGURES[key]
        peak, steady = figure_charts(PANELS[key], results.table(key))
        assert peak.y_label == "peak |y| (m)"
        assert "half" in steady.y_label
        assert steady.y_label.endswith("(m)")
        for chart, index in ((peak, 0), (steady, 1)):
            assert chart.x_label == X_LABELS[along]
            for trace, case in zip(chart.traces, (False, True), strict=True):
                assert trace.name == f"separation {'considered' if case else 'ignored'}"
                p = {**paper_model.BASE, **shared, along: float(trace.x[1])}
                assert trace.y[1] == pytest.approx(amplitude(case, p)[index])
    for key, label, column in (("10", "P (N)", None), ("11", "x (m)", 0), ("12", "y (m)", 2)):
        (chart,) = figure_charts(PANELS[key], results.table(key))
        assert (chart.x_label, chart.y_label) == ("t (s)", label)
        assert [guide.value for guide in chart.guides] == [0.0]
        for trace, case in zip(chart.traces, (False, True), strict=True):
            assert trace.name == f"separation {'considered' if case else 'ignored'}"
            state = STATES[case]["5.0"]
            force = -50.0 * state[2] - 100.0 * state[2] ** 3 if state[2] < 0 or not case else 0.0
            expected = force if column is None else state[column]
            assert trace.y[np.isclose(trace.x, 5.0)] == pytest.approx([expected], abs=1e-3)


def test_a_point_of_a_chart_opens_the_scene_of_its_line() -> None:
    panel = PANELS["4"]
    scene = point_scene(panel, NearestPoint(trace=2, x=0.25, y=5.0))
    assert scene.parameters.as_dict() == paper_model.BASE | {"F": 100.0, "mu": 0.25, "k_nl": 100.0}
    ignored = point_scene(PANELS["10"], NearestPoint(trace=0, x=12.0, y=1.0))
    assert (ignored.separation, ignored.parameters.as_dict()) == (False, paper_model.BASE)


def test_the_list_of_figures_names_the_parameters_of_their_lines() -> None:
    # The mark ✓ means that the figure has been computed.
    rows = {key: figure_row(panel, is_computed=key == "3") for key, panel in PANELS.items()}
    assert rows["3"][0] == "3 ✓"
    assert rows["7"][0] == "7"
    assert rows["3"][1] == "k_nl 0, 50, 100, 500"
    assert rows["7"][1] == "F 0, 5, 50, 100"
    assert rows["13"][1] == "both cases"
    assert "contact force" in rows["10"][2].lower()


# Data files beside the figures


@pytest.mark.parametrize("number", range(2, 17))
def test_data_beside_a_figure_have_its_parameters_and_units(
    number: int, results: PaperResults, tmp_path: Path
) -> None:
    for panel in figure_panels(number):
        path = tmp_path / f"{panel.key}.csv"
        save_data(results.table(panel.key), path)
        lines = path.read_text(encoding="utf-8").splitlines()
        header = {
            name: json.loads(text)
            for name, text in re.findall(r"^# (\w+): (.*)$", "\n".join(lines), re.MULTILINE)
        }
        names = lines[len(header)].split(",")
        assert header["figure"] == panel.key
        for name in names:
            expected = {
                "F": "N", "k_nl": "N/m^3", "mu": "1", "t": "s", "P": "N", "x": "m", "y": "m",
                "x_e": "m", "y_e": "m", "mu_c": "1", "separation": "1", "separations": "1",
                "separated_time": "s", "growth_rate": "1/s", "y_peak": "m", "y_half_range": "m",
                "omega_1": "rad/s", "omega_2": "rad/s", "sigma_1": "1/s", "sigma_2": "1/s",
            }[name]  # fmt: skip
            assert header["units"][name] == expected
            assert header["meanings"][name] == DATA_COLUMNS[name].meaning
        shared = FIGURES[panel.key][3] if panel.key in FIGURES else {}
        parameters = {**paper_model.BASE, **shared}
        assert header["parameters"] == {
            name: value
            for name, value in parameters.items()
            if name not in names and not (name == "mu" and panel.kind == "critical mu")
        }
        if panel.kind in ("transient", "amplitude"):
            # The static start is at rest at the equilibrium for μ = 0.
            assert (header["start"], header["t_end"]) == ("static", 100.0)
        if panel.kind == "amplitude":
            rows = np.loadtxt(lines[len(header) + 1 :], delimiter=",")
            index = rows.shape[0] // 3
            values = dict(zip(names, rows[index].tolist(), strict=True))
            p = {name: values[name] for name in paper_model.BASE if name in values}
            assert values["growth_rate"] == pytest.approx(
                paper_model.growth_rate(**{**shared, **p}), abs=1e-8
            )
            assert (values["y_peak"], values["y_half_range"]) == pytest.approx(
                amplitude(bool(values["separation"]), {**parameters, **p})
            )
            assert (values["separations"], values["separated_time"]) == (7.0, 1.0)


def test_captions_agree_with_the_axes(results: PaperResults) -> None:
    for key, (along, by, _, _) in FIGURES.items():
        caption = results.table(key).caption
        term = {"F": "preload", "k_nl": "stiffness", "mu": "friction coefficient"}[along[0]]
        assert term in caption.partition(" against ")[2], key
        assert without_mathtext(caption) == caption
        assert PANELS[key].by == (by or "separation")
    # Other captions do not give all values that differ from the base set.
    for key in ("3", "4", "8", "9"):
        for name, value in FIGURES[key][3].items():
            assert (
                PARAMETER_TEXTS[name].format(value).replace("_", "") in results.table(key).caption
            )
