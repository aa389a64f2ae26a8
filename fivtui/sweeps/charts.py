"""Charts of sweeps: outputs over one or two varied quantities.

A case is True if separation is considered and False if it is ignored.
"""

from functools import lru_cache
from typing import Final

import numpy as np

from fivtui.charts import (
    FIGURE_WIDTH,
    Backdrop,
    Chart,
    Guide,
    Label,
    Sheet,
    Trace,
    axis_label,
    colour_scale_of,
    grade_values,
    hide_unused,
    math_symbol,
    meaning_label,
    plateau_labels,
)
from fivtui.model import InputError, Parameters
from fivtui.transient import VARIABLES

from .design import Design, Range
from .rows import compute_rows
from .run import Sweep
from .study import OUTPUTS, VIBRATES, Study

_SIZE: Final = (FIGURE_WIDTH, 3.2)
_CASE_NAMES: Final = {True: "considered", False: "ignored"}
# Outputs that curves show if they were computed: labels in the terminal, and roles in figures. With
# the case, such as "peak, considered", a role names the style of a curve or guide.
_AMPLITUDES: Final = {"y_abs": "peak", "y_half_range": "±y 2nd half"}
_ROLES: Final = {"y_abs": "peak", "y_half_range": "half range"}
# Roles of the ends of the interval of a share.
_INTERVAL_ROLES: Final = {"vibrates_low": "limit", "vibrates_high": "limit"}
# Marks by index of the output and by case.
_MARKS: Final = ({True: "●", False: "○"}, {True: "◆", False: "◇"}, {True: "◆", False: "◇"})


def check_drawable(study: Study) -> None:
    """Raise `InputError` unless one or two quantities vary."""
    if len(study.design.axes) not in (1, 2):
        raise InputError("plot: the sweep must be over one name or two")


def sweep_sheet(result: Sweep) -> Sheet:
    """A sweep over one quantity as curves, over two quantities as a map for each case.

    Curves show the peak of |y| and the half peak-to-peak of y over the second half of the run, maps
    show the peak. Without these outputs, the first output is shown. Failed members are blank.
    """
    study = result.study
    check_drawable(study)
    if len(study.design.axes) == 1:
        return Sheet([[sweep_chart(result)]], _SIZE)
    return Sheet([[grid_chart(result, case)] for case in study.cases], _SIZE)


def sweep_curves(study: Study) -> list[tuple[str, bool]]:
    """Output and case of every curve of a sweep over one quantity."""
    outputs = [name for name in _AMPLITUDES if name in study.outputs] or study.outputs[:1]
    if study.design.starts is not None:
        outputs = [VIBRATES, *_INTERVAL_ROLES]
    return [(output, case) for case in sorted(study.cases, reverse=True) for output in outputs]


def sweep_chart(result: Sweep, present: float | None = None) -> Chart:
    """Outputs over the varied quantity, a trace per output and case.

    A line marks `present`, the value in the edited scene.
    """
    study, rows = result.study, result.table
    (name,) = study.design.axes
    order = np.argsort(rows.numbers[name], kind="stable")
    curves = sweep_curves(study)
    outputs = list(dict.fromkeys(output for output, _ in curves))
    traces = []
    for output, case in curves:
        members = order[rows.separation[order] == case]
        traces.append(
            Trace(
                Label(
                    f"{_AMPLITUDES.get(output, output)}, {_CASE_NAMES[case]}",
                    f"{OUTPUTS[output].meaning}, separation {_CASE_NAMES[case]}",
                ),
                rows.numbers[name][members],
                rows.numbers[output][members],
                look="line" if output in _INTERVAL_ROLES else "marked",
                mark=_MARKS[outputs.index(output)][case],
                role=_role((_ROLES | _INTERVAL_ROLES).get(output, "output"), case),
            )
        )
    guides = [] if present is None else [Guide(present, f"{present:g}")]
    for case in study.cases:
        # The belt speed from which on the slider never reaches the belt's speed.
        row = result.fast_belt(case)
        if row is not None:
            belt_text = f"always faster, separation {_CASE_NAMES[case]}"
            value = float(rows.numbers[outputs[0]][row])
            label = Label(belt_text, f"belt that is {belt_text}")
            guides.append(Guide(value, label, vertical=False, role=_role("limit", case)))
    if (name, outputs[0]) == ("mu", VIBRATES):
        guides += _mu_guides(study.parameters, study.cases)
    y_label = _output_label(outputs[0])
    if outputs[0] in _AMPLITUDES:
        y_label = Label("|y| peak, ±y 2nd half (m)", "Amplitude (m)")
    return Chart(
        axis_label(VARIABLES[name]),
        y_label,
        tuple(traces),
        guides=tuple(guides),
        x_margins=True,
        log=_log_axes(study, x=name),
        legend="inside" if study.design.starts is None else "below",
    )


def grid_chart(result: Sweep, case: bool, present: tuple[float, float] | None = None) -> Chart:
    """A map of a sweep over two quantities: the peak, or without it the first output.

    If `case` was not computed, the other case is shown. `present` is the point of the edited scene.
    Points that form no grid are drawn only in figures.
    """
    study, rows = result.study, result.table
    first, second = study.design.axes
    output = next((name for name in _AMPLITUDES if name in study.outputs), study.outputs[0])
    shown_case = case if case in study.cases else study.cases[0]
    members = rows.separation == shown_case
    x, x_indices = np.unique(rows.numbers[first][members], return_inverse=True)
    y, y_indices = np.unique(rows.numbers[second][members], return_inverse=True)
    results = rows.numbers[output]
    label = _output_label(output)
    traces, backdrop = [], None
    if study.design.kind == "product":
        values = np.full((x.size, y.size), np.nan)
        values[x_indices, y_indices] = results[members]
        # The shades of both cases are the same.
        grading, shades = grade_values(results)
        shades = hide_unused(grading.levels, shades)
        levels = np.full(values.shape, len(grading.bands), dtype=np.intp)
        levels[x_indices, y_indices] = grading.levels[members]
        labels = plateau_labels(x, y, grading._replace(levels=levels))
        backdrop = Backdrop(x, y, levels, shades, values, label, labels=labels)
    else:
        point_x, point_y = x[x_indices], y[y_indices]
        traces.append(
            Trace("", point_x, point_y, look="points", ordered=False, values=results[members])
        )
    if present is not None:
        present_x, present_y = (np.array([value]) for value in present)
        traces.append(Trace("now", present_x, present_y, look="points", ordered=False, mark="◆"))
    return Chart(
        axis_label(VARIABLES[first]),
        axis_label(VARIABLES[second]),
        tuple(traces),
        backdrop=backdrop,
        colour_scale=None if backdrop is not None else colour_scale_of(label, results),
        note=f"{label}, separation {_CASE_NAMES[shown_case]}",
        title=f"separation {_CASE_NAMES[shown_case]}",
        log=_log_axes(study, x=first, y=second),
    )


def _role(name: str, case: bool) -> str:
    return f"{name}, {'considered' if case else 'ignored'}"


def _log_axes(study: Study, **names: str) -> str:
    # The letters of the axes whose quantity has logarithmic spacing; `names` maps x and y to names.
    axes = {letter: study.design.axes[name] for letter, name in names.items()}
    return "".join(letter for letter, axis in axes.items() if isinstance(axis, Range) and axis.log)


def _output_label(name: str) -> Label:
    return meaning_label(OUTPUTS[name].meaning, OUTPUTS[name].unit)


@lru_cache(maxsize=8)
def _mu_guides(p: Parameters, cases: tuple[bool, ...]) -> tuple[Guide, ...]:
    # Lines at the critical μ in each case and, without a finite belt speed, at the
    # least μ of limit cycles on the branch from there.
    names = ("critical_mu", "safe_mu")[: 2 if p.v_belt is None else 1]
    rows = compute_rows(Study(Design({"mu": (0.0,)}), p, cases, outputs=names), 0, len(cases))
    labels = Label("μ_c", math_symbol("μ_c")), Label("cycles from", "cycles from $μ$")
    return tuple(
        Guide(mu, Label(f"{label} {mu:.4g}", f"{label.math} = {mu:.4g}"), role=role)
        for name, label, role in zip(names, labels, ("critical", "safe"), strict=False)
        for mu in np.unique(rows.numbers[name]).tolist()
        if not np.isnan(mu)
    )
