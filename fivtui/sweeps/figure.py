"""Figures of sweeps: amplitude over what varies."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fivtui.charts import (
    CASE_COLOURS,
    CASE_LINES,
    STYLE,
    WIDTH,
    math_unit,
    new_figure,
    quantity_label,
)
from fivtui.model import InputError

from .design import VARIABLES, Range
from .run import Sweep
from .study import OUTPUTS, Study

_CASE_NAMES: Final = {True: "separation considered", False: "separation ignored"}
# Outputs drawn over one name, with line widths.
_AMPLITUDES: Final = {"y_abs": 1.4, "y_half_range": 0.7}
_HEIGHT: Final = 3.2
# Greatest number of points that get markers.
_MARKED: Final = 60
_DOT: Final = 9.0


def check_drawable(study: Study) -> None:
    """Raise `InputError` unless one or two names vary."""
    if len(study.design.axes) not in (1, 2):
        raise InputError("plot: the sweep must be over one name or two")


def sweep_figure(result: Sweep) -> Figure:
    """Draw a sweep over one name as curves, over two as a map for each case.

    Curves show the peak of |y| and its half peak-to-peak over the second half of the run, maps the
    peak; the first output where these were not computed. Failed members are left blank.
    """
    study = result.study
    check_drawable(study)
    names = list(study.design.axes)
    with mpl.rc_context(STYLE):
        figure = new_figure(WIDTH, _HEIGHT)
        if len(names) == 1:
            _draw_curves(figure.add_subplot(), result, names[0])
        else:
            panels = figure.subplots(1, len(study.cases), sharex=True, sharey=True, squeeze=False)
            _draw_maps(figure, list(panels[0]), result, names)
    return figure


def _draw_curves(axes: Axes, result: Sweep, name: str) -> None:
    drawn = [output for output in _AMPLITUDES if output in result.study.outputs]
    for case in result.study.cases:
        here = result.table.separation == case
        order = np.argsort(result.table.numbers[name][here], kind="stable")
        x = result.table.numbers[name][here][order]
        for output in drawn or result.study.outputs[:1]:
            axes.plot(
                x,
                result.table.numbers[output][here][order],
                color=CASE_COLOURS[case][0],
                linestyle=CASE_LINES[case],
                linewidth=_AMPLITUDES.get(output, 1.0),
                marker="." if x.size <= _MARKED else "",
                markersize=4.0,
                label=f"{OUTPUTS[output].meaning}, {_CASE_NAMES[case]}",
            )
        _draw_fast_belt(axes, result, case, (drawn or result.study.outputs[:1])[0])
    if _is_log(result.study, name):
        axes.set_xscale("log")
    axes.set_xlabel(quantity_label(VARIABLES[name]))
    outputs = drawn or list(result.study.outputs[:1])
    axes.set_ylabel("Amplitude (m)" if drawn else _output_label(outputs[0]))
    axes.legend(frameon=False, fontsize=8.0)


def _draw_fast_belt(axes: Axes, result: Sweep, case: bool, output: str) -> None:
    # The limit of fast belts.
    row = result.fast_belt(case)
    if row is not None:
        axes.axhline(
            float(result.table.numbers[output][row]),
            color=CASE_COLOURS[case][0],
            linestyle=":",
            linewidth=0.8,
            zorder=1.5,
            label=f"belt that is always faster, {_CASE_NAMES[case]}",
        )


def _draw_maps(figure: Figure, panels: list[Axes], result: Sweep, names: list[str]) -> None:
    study, table = result.study, result.table
    output = "y_abs" if "y_abs" in study.outputs else study.outputs[0]
    values = table.numbers[output]
    known = values[~np.isnan(values)]
    scale: dict[str, Any] = {"cmap": "viridis"}
    if known.size:
        scale |= {"vmin": float(known.min()), "vmax": float(known.max())}
    image: Any = None
    for axes, case in zip(panels, study.cases, strict=True):
        here = table.separation == case
        x, y, z = (table.numbers[name][here] for name in (*names, output))
        shape = np.unique(x).size, np.unique(y).size
        if min(shape) > 1 and shape[0] * shape[1] == z.size:
            order = np.lexsort((y, x))
            grid = (column[order].reshape(shape) for column in (x, y, z))
            image = axes.pcolormesh(*grid, shading="nearest", rasterized=True, **scale)
        else:
            image = axes.scatter(x, y, c=z, s=_DOT, linewidths=0.0, **scale)
        axes.set_title(_CASE_NAMES[case])
        axes.grid(visible=False)
        axes.set_xlabel(quantity_label(VARIABLES[names[0]]))
        if _is_log(study, names[0]):
            axes.set_xscale("log")
        if _is_log(study, names[1]):
            axes.set_yscale("log")
    panels[0].set_ylabel(quantity_label(VARIABLES[names[1]]))
    figure.colorbar(image, ax=panels, label=_output_label(output))


def _is_log(study: Study, name: str) -> bool:
    axis = study.design.axes[name]
    return isinstance(axis, Range) and axis.log


def _output_label(name: str) -> str:
    column = OUTPUTS[name]
    unit = f" ({math_unit(column.unit)})" if column.unit else ""
    return f"{column.meaning[0].upper()}{column.meaning[1:]}{unit}"
