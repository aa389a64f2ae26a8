"""Figures: their lines, meshes, labels and units agree with the results.

Expected motions, eigenvalues and critical friction come from `paper_model`, an independent model.
"""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from matplotlib.contour import QuadContourSet
from numpy.typing import NDArray

from fivtui.charts import STRONG, figure_colour
from fivtui.charts.sheet import sheet_figure
from fivtui.equilibrium.charts import modes_sheet
from fivtui.equilibrium.eigenvalues import stability
from fivtui.equilibrium.scan import mode_scan
from fivtui.maps import stability_map
from fivtui.model import System
from fivtui.model.parameters import Parameters
from fivtui.orbits.attractor_continuation import BranchPoint, Continuation
from fivtui.orbits.basins import Basin
from fivtui.orbits.explorer import Attractor, Kind
from fivtui.orbits.shooting import PeriodicOrbit, Section
from fivtui.results import Grid
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.rows import Rows
from fivtui.sweeps.run import Sweep
from fivtui.sweeps.study import Study
from fivtui.tradeoffs.measure import Tradeoff
from fivtui.tradeoffs.settings import MeasuredSetting, Setting
from fivtui.transient import START_SPECS
from fivtui.transient.errors import Deviation
from fivtui.transient.result import Transient

from .support import paper_model
from .support.reading import (
    drawn_line,
    drawn_lines,
    handles_by_text,
    labels,
    legend_entries,
    points,
    spans,
    transient_figure,
    without_mathtext,
)

FloatArray = NDArray[np.float64]
# The parameters are in two lines, without a comma between the lines; `without_mathtext` turns the
# line break into a space.
BASE_TITLE = (
    "m = 5 kg, k_1 = 100 N/m, k_2 = 50 N/m, k_3 = 60 N/m, c_1 = 0.32 N s/m "
    "c_2 = 0.32 N s/m, F = 80 N, k_nl = 100 N/m^3, μ = 0.7"
)


# Transients


@pytest.fixture(scope="module")
def runs() -> list[Transient]:
    times = np.linspace(0.0, 40.0, 4001)
    return [
        simulate(t_end=40.0, separation=case, samples=times, tol=1e-9) for case in (True, False)
    ]


def test_panels_of_a_transient_agree_with_their_labels(runs: list[Transient]) -> None:
    figure = transient_figure(runs, quantities=("x", "vx", "y", "vy", "P"))
    legend = legend_entries(figure)
    # The axes are listed column by column.
    overviews, late_panels = figure.axes[:5], figure.axes[5:]
    assert [without_mathtext(axes.get_ylabel()) for axes in overviews] == [
        "Horizontal displacement x (m)",
        "Horizontal velocity vx (m/s)",
        "Vertical displacement y (m)",
        "Vertical velocity vy (m/s)",
        "Contact force P (N)",
    ]
    bottom_panels = overviews[-1], late_panels[-1]
    assert {without_mathtext(axes.get_xlabel()) for axes in bottom_panels} == {"Time t (s)"}
    # Panels are tall enough to read.
    assert figure.get_figheight() > 5 * 1.5
    for case, name in ((True, "separation considered"), (False, "separation ignored")):
        t, motion = paper_model.motion(3.0, separation=case)
        for axes, column in zip(overviews, motion.T, strict=True):
            x, y = points(drawn_line(axes, legend[name]))
            is_compared = x <= 3.0
            assert is_compared.sum() == 301
            scale = np.abs(column).max()
            np.testing.assert_allclose(
                y[is_compared], np.interp(x[is_compared], t, column), rtol=0.0, atol=2e-4 * scale
            )


def test_shading_is_where_the_slider_is_off_the_belt_and_nowhere_else(
    runs: list[Transient],
) -> None:
    figure = transient_figure(runs)
    t, motion = paper_model.motion(3.0, separation=True)
    # Each of two columns has panels of P, x and y.
    overview, late = figure.axes[0], figure.axes[3]
    for axes in (overview, late):
        shaded = np.array(spans(axes))
        np.testing.assert_allclose(shaded, runs[0].separated_intervals)
        for time, y in zip(t[5::10].tolist(), motion[5::10, 2].tolist(), strict=True):
            if abs(y) > 0.1:
                within = (shaded[:, 0] <= time) & (time <= shaded[:, 1])
                assert within.any() == (y > 0.0)
    assert to_hex(legend_entries(figure)["off the belt"].get_facecolor()) == to_hex("0.9")


def test_the_late_panel_has_about_eight_cycles_of_the_drawn_motion(
    runs: list[Transient],
) -> None:
    t = np.linspace(0.0, 40.0, 4001)
    for period, title, start in ((0.24, "last 2 s", 38.0), (0.6, "last 5 s", 35.0)):
        y = 3.0 + 2.0 * np.sin(2.0 * np.pi * t / period)
        assert runs[0].trajectory is not None
        motion = dataclasses.replace(runs[0].trajectory, y=y)
        run = dataclasses.replace(runs[0], trajectory=motion)
        overview, late = transient_figure([run], quantities=["y"]).axes
        assert late.get_title() == title
        assert late.get_xlim() == (start, 40.0)
        assert overview.get_xlim() == (0.0, 40.0)
    # A run of fewer than 16 cycles has no late panel.
    slow_y = 3.0 + 2.0 * np.sin(2.0 * np.pi * t / 2.6)
    assert runs[0].trajectory is not None
    run = dataclasses.replace(runs[0], trajectory=dataclasses.replace(runs[0].trajectory, y=slow_y))
    assert len(transient_figure([run], quantities=["y"]).axes) == 1


def test_runs_that_differ_in_several_parameters_are_named_in_the_legend() -> None:
    times = np.linspace(0.0, 1.0, 101)
    forces = (40.0, 60.0, 80.0)
    runs = [
        simulate(Parameters(F=force, k_nl=2.0 * force), t_end=1.0, samples=times, tol=1e-9)
        for force in forces
    ]
    figure = transient_figure(runs, quantities=["y"])
    # A whole name fits on one line.
    assert not any("\n" in text.get_text() for text in figure.legends[0].get_texts())
    legend = legend_entries(figure)
    for force in forces:
        name = f"separation considered, F = {force:g} N, k_nl = {2.0 * force:g} N/m^3"
        line = drawn_line(figure.axes[0], legend[name])
        # Runs start from rest under the preload, before friction acts.
        _, y, _ = paper_model.equilibrium(F=force, k_nl=2.0 * force, mu=0.0)
        assert points(line)[1][0] == pytest.approx(y, rel=1e-9)


# Modes


def sort_key(value: complex) -> tuple[float, float]:
    return round(value.imag, 4), value.real


def test_modes_over_mu_are_the_eigenvalues_in_hertz_and_one_over_seconds() -> None:
    p = Parameters()
    result = stability(p)
    figure = sheet_figure(modes_sheet(result, mode_scan(System(p), 1.5)))
    frequency, growth, plane = figure.axes
    assert labels(frequency) == ("Friction coefficient μ", "Frequency Im λ/(2π) (Hz)")
    assert labels(growth) == ("Friction coefficient μ", "Growth rate Re λ (1/s)")
    assert labels(plane) == ("Re λ (1/s)", "Im λ (rad/s)")
    legend = legend_entries(figure)
    # Two modes, critical and present friction, eigenvalues over μ and those at the present μ.
    assert len(legend) == 6
    for index in (0, 40, 80, 160, 240):
        drawn = []
        for name in ("mode 1", "mode 2"):
            mu, hertz = points(drawn_line(frequency, legend[name]))
            growth_mu, rate = points(drawn_line(growth, legend[name]))
            assert mu[index] == growth_mu[index] == pytest.approx(1.5 * index / 240)
            drawn.append(complex(rate[index], 2.0 * np.pi * hertz[index]))
        expected = paper_model.eigenvalues(mu=float(mu[index]))
        expected = expected[expected.imag > 0.0]
        assert sorted(drawn, key=sort_key) == pytest.approx(
            sorted(expected.tolist(), key=sort_key), abs=1e-6
        )
    assert without_mathtext(figure.get_suptitle()) == BASE_TITLE


def test_the_critical_and_the_present_friction_are_marked() -> None:
    p = Parameters(F=100.0, k_nl=500.0, mu=1.1)
    figure = sheet_figure(modes_sheet(stability(p), mode_scan(System(p), 2.0)))
    legend = legend_entries(figure)
    critical = paper_model.critical_mu(F=100.0, k_nl=500.0)
    assert without_mathtext(figure.get_suptitle()).endswith("F = 100 N, k_nl = 500 N/m^3, μ = 1.1")
    for axes in figure.axes[:2]:
        assert axes.get_xlim() == (0.0, 2.0)
        for label, position in ((f"μ_c = {critical:.4g}", critical), ("μ = 1.1", 1.1)):
            x, y = points(drawn_line(axes, legend[label]))
            assert x.tolist() == pytest.approx([position, position], abs=1e-9)
            assert y.tolist() == [0.0, 1.0]
    zero_lines = [
        line for line in figure.axes[1].lines if np.array_equal(line.get_ydata(), [0.0, 0.0])
    ]
    assert len(zero_lines) == 1
    plane = figure.axes[2]
    x, y = points(drawn_line(plane, legend["at μ = 1.1"]))
    expected = paper_model.eigenvalues(F=100.0, k_nl=500.0, mu=1.1)
    # With the frequency as real part, both are sorted by frequency first.
    np.testing.assert_allclose(
        np.sort_complex(y + 1j * x), np.sort_complex(expected.imag + 1j * expected.real)
    )
    path = points(drawn_line(plane, legend["eigenvalues, μ = 0 to 2"]))
    start = paper_model.eigenvalues(F=100.0, k_nl=500.0, mu=0.0)
    for value in start:
        assert np.abs(path[0] + 1j * path[1] - value).min() < 1e-6


# Maps


def mesh_of(axes: Axes) -> tuple[QuadMesh, dict[tuple[float, float], float]]:
    # The mesh, and its values by the centres of the cells.
    (mesh,) = [collection for collection in axes.collections if isinstance(collection, QuadMesh)]
    corners = np.asarray(mesh.get_coordinates())
    centre_points = 0.25 * (
        corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1]
    )
    values = np.asarray(mesh.get_array()).ravel()
    centres = [tuple(centre) for centre in centre_points.reshape(-1, 2).round(9).tolist()]
    return mesh, dict(zip(centres, values.tolist(), strict=True))


def assert_within(value: float, texts: Sequence[str], level: int) -> None:
    """Hold that the texts of the levels contain a value in this level."""
    text = texts[level]
    bound = float(text.lstrip("≤<>"))
    if text[0] in "≤<":
        assert value <= bound
        lower_text = texts[level - 1] if level else "-inf"
        assert value > float(lower_text.lstrip("≤<"))
    elif text[0] == ">":
        assert value > bound
    else:
        assert value == pytest.approx(bound, rel=2e-3)


MU, FORCE = np.linspace(0.0, 1.5, 31), np.linspace(10.0, 110.0, 5)


@pytest.mark.parametrize(
    ("value", "colours", "reference"),
    [
        ("growth-rate", "Growth rate (1/s)", paper_model.growth_rate),
        ("critical-mu", "Critical friction coefficient", paper_model.critical_mu),
        (
            "unstable-modes",
            "Unstable modes",
            lambda **p: float((paper_model.eigenvalues(**p).real > 0.0).sum() // 2),
        ),
    ],
)
def test_a_map_has_its_levels_over_its_axes(value: str, colours: str, reference: Any) -> None:
    figure = stability_map(Parameters(c1=0.5), {"mu": MU, "F": FORCE}, value).figure()
    axes, bar = figure.axes
    assert labels(axes) == ("Friction coefficient μ", "Preload F (N)")
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "linear")
    assert without_mathtext(bar.get_ylabel()) == colours
    texts = [label.get_text() for label in bar.get_yticklabels()]
    _, levels = mesh_of(axes)
    assert set(levels) == set(itertools.product(MU.round(9).tolist(), FORCE.tolist()))
    for mu, force in itertools.product((0.1, 0.65, 1.45), (10.0, 85.0, 110.0)):
        assert_within(reference(c1=0.5, mu=mu, F=force), texts, int(levels[mu, force]))
    assert without_mathtext(axes.get_title()) == (
        "m = 5 kg, k_1 = 100 N/m, k_2 = 50 N/m, k_3 = 60 N/m c_1 = 0.5 N s/m, "
        "c_2 = 0.32 N s/m, k_nl = 100 N/m^3"
    )
    assert list(legend_entries(figure)) == ["stability boundary"]


def test_the_boundary_of_a_map_is_at_the_critical_friction() -> None:
    axes, _ = stability_map(Parameters(), {"mu": MU, "F": FORCE}).figure().axes
    (line,) = axes.lines
    vertices = np.asarray(line.get_xydata())
    for force in FORCE.tolist():
        index = np.flatnonzero(np.isclose(vertices[:, 1], force))[0]
        critical = paper_model.critical_mu(F=force)
        assert vertices[index, 0] == pytest.approx(critical, abs=MU[1] - MU[0])


def test_growth_is_red_and_decay_is_green() -> None:
    result = stability_map(Parameters(), {"mu": MU, "F": FORCE})
    mesh, levels = mesh_of(result.figure().axes[0])
    for (mu, force), level in levels.items():
        red, green, *_ = mesh.to_rgba(np.array([level]))[0]
        assert bool(red > green) is (paper_model.growth_rate(mu=mu, F=force) > 0.0)


def test_the_legend_of_a_map_of_critical_friction_gives_the_friction() -> None:
    over = {"k_nl": np.geomspace(10.0, 1000.0, 9), "F": FORCE}
    figure = stability_map(Parameters(mu=0.55), over, "critical-mu").figure()
    axes = figure.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
    assert labels(axes) == ("Cubic contact stiffness k_nl (N/m^3)", "Preload F (N)")
    assert list(legend_entries(figure)) == ["stability boundaries, μ = 0.55"]
    assert "μ" not in axes.get_title()


# Sweeps


def invented_sweep(
    axes: dict[str, Any], outputs: Sequence[str], cases: Sequence[bool] = (True, False)
) -> Sweep:
    study = Study(Design(axes), Parameters(), tuple(cases), outputs=tuple(outputs))
    grids: Sequence[Any] = np.meshgrid(*axes.values(), indexing="ij")
    point_values = {
        name: np.repeat(grid.ravel(), len(cases)) for name, grid in zip(axes, grids, strict=True)
    }
    size = next(iter(point_values.values())).size
    case = np.tile(np.array(cases), size // len(cases))
    columns = {name: values.astype(float) for name, values in point_values.items()}
    for output_index, output in enumerate(outputs):
        columns[output] = output_value(output_index, case, *point_values.values())
    return Sweep(study, Rows(columns, case, reasons=("",) * size))


def output_value(output_index: int, case: Any, *coordinates: Any) -> Any:
    # A different function of the coordinates for each output and case.
    weighted = sum((1.0 + 2.0 * index) * value for index, value in enumerate(coordinates))
    return 1.0 + 100.0 * output_index + 10.0 * case + weighted


def test_curves_of_a_sweep_are_the_outputs_and_cases_that_their_legend_names() -> None:
    figure = invented_sweep({"F": (80.0, 20.0, 50.0)}, ("x_abs", "y_half_range", "y_abs")).figure()
    (axes,) = figure.axes
    legend = axes.get_legend()
    assert legend is not None
    shown = handles_by_text(legend)
    # Both amplitudes of y, with and without separation; the peak of |x| is not drawn.
    assert len(shown) == len(axes.lines) == 4
    for text, handle in shown.items():
        is_peak, is_half_range = text.startswith("peak of |y|"), "half" in text
        assert is_peak != is_half_range
        output_index = 2 if is_peak else 1
        # The case is whether separation is considered.
        case = text.endswith("considered")
        assert case != text.endswith("ignored")
        line = next(
            candidate
            for candidate in drawn_lines(axes, handle)
            if candidate.get_linewidth() == handle.get_linewidth()
        )
        x, y = points(line)
        assert x.tolist() == [20.0, 50.0, 80.0]
        np.testing.assert_allclose(y, output_value(output_index, case, x))
        # Lines with separation considered are dashed.
        assert line.is_dashed() == case
    assert labels(axes) == ("Preload F (N)", "Amplitude (m)")
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "linear")


def test_a_sweep_without_amplitudes_shows_its_first_output_with_its_unit() -> None:
    (axes,) = invented_sweep({"k1": (10.0, 20.0)}, ("vx_max", "P_max"), (True,)).figure().axes
    # The model holds for belts faster than vx_max, the greatest speed of the slider.
    assert labels(axes) == ("Horizontal stiffness k_1 (N/m)", "Least valid belt speed (m/s)")
    (line,) = axes.lines
    np.testing.assert_allclose(points(line)[1], output_value(0, True, np.array([10.0, 20.0])))


def test_maps_of_a_sweep_have_their_axes_and_a_shared_scale() -> None:
    forces = (20.0, 40.0, 60.0)
    result = invented_sweep({"F": forces, "mu": (0.9, 0.1)}, ("x_abs", "y_abs"))
    figure = result.figure()
    *maps, bar = figure.axes
    assert without_mathtext(bar.get_ylabel()) == "Peak of |y| (m)"
    texts = [label.get_text() for label in bar.get_yticklabels()]
    assert without_mathtext(maps[0].get_ylabel()) == "Friction coefficient μ"
    for axes, case in zip(maps, (True, False), strict=True):
        assert axes.get_title() == f"separation {'considered' if case else 'ignored'}"
        assert without_mathtext(axes.get_xlabel()) == "Preload F (N)"
        _, levels = mesh_of(axes)
        assert set(levels) == set(itertools.product(forces, (0.1, 0.9)))
        for point, level in levels.items():
            assert_within(output_value(1, case, *point), texts, int(level))


def test_points_of_a_sweep_without_grid_are_drawn_where_they_were_computed() -> None:
    axes = {"k2": Range(20.0, 80.0), "k_nl": Range(0.1, 1.0, log=True)}
    study = Study(Design(axes, "sobol", 4), Parameters(), outputs=("P_max",))
    k2, k_nl = np.array([20.0, 30.0, 40.0, 50.0]), np.array([0.4, 0.1, 0.9, 0.2])
    force = np.array([5.0, 6.0, 7.0, 8.0])
    columns = {"k2": k2, "k_nl": k_nl, "P_max": force}
    rows = Rows(columns, separation=np.ones(4, dtype=bool), reasons=("",) * 4)
    figure = Sweep(study, rows).figure()
    (dots,) = figure.axes[0].collections
    np.testing.assert_allclose(np.asarray(dots.get_offsets()), np.transpose([k2, k_nl]))
    np.testing.assert_allclose(np.asarray(dots.get_array()), force)
    assert (figure.axes[0].get_xscale(), figure.axes[0].get_yscale()) == ("linear", "log")
    assert labels(figure.axes[0]) == (
        "Linear contact stiffness k_2 (N/m)",
        "Cubic contact stiffness k_nl (N/m^3)",
    )
    assert without_mathtext(figure.axes[1].get_ylabel()) == "Greatest contact force (N)"


# Trade-offs


# Figures draw smaller errors, also zero, at this value: their axes are logarithmic.
LEAST_DRAWN_ERROR = 1e-16


def deviation(final: float, peak: float, half_range: float, events: float) -> Deviation:
    return Deviation(final, peak, half_range, events, separations=0)


def invented_tradeoff() -> Tradeoff:
    def row(
        method: str, tol: float, cpu_s: float, errors: tuple[float, float, float, float]
    ) -> MeasuredSetting:
        # The knob is the name of the option whose value is measured, tol or step.
        setting = Setting(method, kernel="", knob="tol", value=tol)
        return MeasuredSetting(setting, cpu_s, steps=7, error=deviation(*errors))

    rows = [
        row("taylor", 1e-6, 0.01, (1e-6, 2e-7, 3e-7, 4e-5)),
        row("taylor", 1e-9, 0.02, (1e-9, 2e-10, 3e-10, 4e-8)),
        row("rk4", 0.01, 0.3, (5e-4, 6e-5, 7e-5, float("inf"))),
        row("rk4", 0.001, 3.0, (5e-8, 0.0, 7e-9, 8e-7)),
        MeasuredSetting(Setting("lost", "", "step", 1.0), 9.0, 7, error=None, failure="why"),
    ]
    # Errors below the floor are within the uncertainty of the reference: the figure has a band
    # there. It shows neither the reference itself nor the costs of a scene's features.
    floor = deviation(1e-13, 2e-14, 3e-14, 4e-12)
    return Tradeoff(PRESETS["base"], reference=None, floor=floor, rows=rows, features=[])


def test_errors_of_every_method_are_drawn_over_cpu_time() -> None:
    result = invented_tradeoff()
    figure = result.figure()
    legend = legend_entries(figure)
    assert list(legend) == ["taylor", "rk4"]
    for axes, name, label in zip(
        figure.axes,
        ("final", "peak", "events"),
        ("Error of the final state (1)", "Error of the peak of |y| (1)", None),
        strict=True,
    ):
        assert labels(axes) == ("CPU time of a run (s)", label or "Error of the switch times (s)")
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        for method, handle in legend.items():
            x, y = points(drawn_line(axes, handle))
            rows = [
                (row.cpu_s, max(getattr(row.error, name), LEAST_DRAWN_ERROR))
                for row in result.rows
                if row.setting.method == method and np.isfinite(getattr(row.error, name))
            ]
            assert list(zip(x, y, strict=True)) == rows
        floor = getattr(result.floor, name)
        (band,) = axes.patches
        low, high = band.get_extents().transformed(axes.transData.inverted()).intervaly
        assert low < LEAST_DRAWN_ERROR
        assert high == pytest.approx(floor)
        (pareto_front,) = [line for line in axes.lines if line.get_linewidth() == 4.0]
        # Both rows of taylor; the finer rk4 is more accurate only in the peak.
        front_rows = [result.rows[k] for k in ((0, 1, 3) if name == "peak" else (0, 1))]
        assert points(pareto_front)[0].tolist() == [row.cpu_s for row in front_rows]
        assert points(pareto_front)[1].tolist() == [
            max(getattr(row.error, name), LEAST_DRAWN_ERROR) for row in front_rows
        ]


# Attractors


def cycle_attractor(kind: Kind, half_range: float, period: float = 1.25) -> Attractor:
    orbit = PeriodicOrbit(
        section=Section.LIFT_OFF,
        start=(0.0, 0.0, 0.0, 0.0),
        period=period,
        multipliers=np.array([0.5 + 0.2j, 0.5 - 0.2j, 0.1]),
        y_min=1.0 - half_range,
        y_max=1.0 + half_range,
        x_abs=2.0,
        vx_max=3.0,
        force_max=4.0,
        separations=1,
        separated_time=0.5,
        residual=0.0,
    )
    return Attractor(kind, orbit)


REST = Attractor(Kind.EQUILIBRIUM)


def test_attractors_along_a_parameter_are_drawn_by_kind_and_direction() -> None:
    contact, separating = (
        cycle_attractor(Kind.CONTACT_CYCLE, 0.5),
        cycle_attractor(Kind.SEPARATING_CYCLE, 4.0),
    )
    result = Continuation(
        System(Parameters()),
        "k_nl",
        np.array([10.0, 20.0, 40.0]),
        (
            BranchPoint(10.0, ("up", "down"), REST),
            BranchPoint(20.0, ("up",), REST),
            BranchPoint(20.0, ("down",), separating),
            BranchPoint(40.0, ("up",), contact),
        ),
    )
    figure = result.figure()
    (axes,) = figure.axes
    legend = legend_entries(figure)
    expected = {
        "equilibrium, up": ("^", STRONG, [(10.0, 0.0), (20.0, 0.0)]),
        "equilibrium, down": ("v", STRONG, [(10.0, 0.0)]),
        "separating limit cycle, down": ("v", "series-4", [(20.0, 4.0)]),
        "contact limit cycle, up": ("^", "series-1", [(40.0, 0.5)]),
    }
    assert set(legend) == {*expected, "coexistence"}
    for name, (marker, colour, positions) in expected.items():
        line = drawn_line(axes, legend[name])
        assert (line.get_marker(), line.get_color()) == (marker, figure_colour(colour))
        assert list(zip(*points(line), strict=True)) == positions
        assert line.get_linestyle() == "None"
    # Coexistence: up and down reach different attractors only at 20. The span ends half-way to the
    # neighbouring values.
    assert spans(axes) == [(15.0, 30.0)]
    x, y = labels(axes)
    assert x == "Cubic contact stiffness k_nl (N/m^3)"
    assert y.startswith("Half ")
    assert y.endswith("(m)")
    assert axes.get_ylim()[0] <= 0.0
    title = without_mathtext(axes.get_title())
    assert "F = 80 N" in title
    assert "k_nl" not in title


def test_starts_of_a_basin_have_the_colour_of_the_attractor_they_reach() -> None:
    separating, contact = (
        cycle_attractor(Kind.SEPARATING_CYCLE, 4.0),
        cycle_attractor(Kind.CONTACT_CYCLE, 0.5, 2.5),
    )
    reached = np.array([[0, 1, 1], [2, 0, 1]])
    first, second = np.array([-1.0, 1.0]), np.array([2.0, 4.0, 6.0])
    result = Basin(
        System(Parameters()),
        (0.1, 0.2, 0.3, 0.4),
        Grid((START_SPECS["y0"], START_SPECS["vx0"]), (first, second)),
        (separating, REST, contact),
        reached,
    )
    figure = result.figure()
    (axes,) = figure.axes
    assert labels(axes) == (
        "Vertical displacement at the start y_0 (m)",
        "Horizontal velocity at the start vx_0 (m/s)",
    )
    mesh, values = mesh_of(axes)
    assert values == {
        (x, y): reached[i, j]
        for (i, x), (j, y) in itertools.product(
            enumerate(first.tolist()), enumerate(second.tolist())
        )
    }
    legend = legend_entries(figure)
    assert [name.partition(",")[0] for name in legend] == [
        "separating limit cycle",
        "equilibrium",
        "contact limit cycle",
    ]
    assert "period 1.25 s" in next(iter(legend))
    assert "period 2.5 s" in list(legend)[2]
    for position, patch in enumerate(legend.values()):
        assert to_hex(mesh.to_rgba(float(position))) == to_hex(patch.get_facecolor())  # type: ignore[arg-type]
        assert bool(patch.get_hatch()) == (position != 1)
    # The hatching of a cycle covers exactly its starts. Outer starts lie on the edge of the map:
    # test points that are slightly nearer to its centre.
    filled = [
        collection
        for collection in axes.collections
        if isinstance(collection, QuadContourSet) and collection.filled
    ]
    grid = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1)
    map_centre = np.array([first.mean(), second.mean()])
    tested_points = map_centre + 0.99 * (grid.reshape(-1, 2) - map_centre)
    hatched = [patch.get_hatch() for patch in legend.values() if patch.get_hatch()]
    for contours, hatch, index in zip(filled, hatched, (0, 2), strict=True):
        assert list(contours.hatches) == [hatch]
        inside = sum(path.contains_points(tested_points) for path in contours.get_paths()) > 0
        np.testing.assert_array_equal(inside, reached.ravel() == index)
    assert to_hex(legend["equilibrium"].get_facecolor()) == "#ffffff"
    assert without_mathtext(axes.get_title()).endswith("x_0 = 0.1 m, vy_0 = 0.4 m/s")
    assert "vx_0 =" not in without_mathtext(axes.get_title())
