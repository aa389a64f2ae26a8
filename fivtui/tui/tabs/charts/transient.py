"""Charts of the transient tab: time histories, phase portraits, spectra. Imports no Textual."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Chart, Guide, Strip, Trace
from fivtui.model import COLUMNS, Mode
from fivtui.scene import Scene
from fivtui.signals import Spectrum, spectrum
from fivtui.transient import Trajectory, Transient

FloatArray = NDArray[np.float64]
Intervals = Sequence[tuple[float, float]]

SYMBOLS: Final = {"vx": "ẋ", "vy": "ẏ"}
_UNITS: Final = {column.name: column.unit for column in COLUMNS}
TIME_LABEL: Final = "t (s)"
# Harmonics displayed, and marked, in the spectrum.
_HARMONICS: Final = 8.0
_MARKED: Final = 3
# Of the points at which the slider sticks, in phase portraits.
_STICK_MARK: Final = "■"


def label_of(quantity: str) -> str:
    """Symbol and unit of a trajectory's column."""
    return f"{SYMBOLS.get(quantity, quantity)} ({_UNITS[quantity]})"


@dataclass(frozen=True, slots=True, eq=False)
class PlottedRun:
    """A trajectory and how it is plotted."""

    name: str
    trajectory: Trajectory
    separated: Intervals
    t_end: float
    mark: str = ""
    colour: str = ""
    v_belt: float | None = None
    stuck: Intervals | None = None
    number: int = 0


def plotted_run(
    result: Transient, name: str = "", mark: str = "", colour: str = "", number: int = 0
) -> PlottedRun | None:
    """A transient ready for plotting; None if it has no samples."""
    if result.trajectory is None:
        return None
    p, of_time = result.parameters, "v_belt" in result.over_time
    return PlottedRun(
        name,
        result.trajectory,
        result.separated_intervals,
        result.t_end,
        mark,
        colour,
        v_belt=None if of_time else p.v_belt,
        stuck=None if p.v_belt is None else result.stick_intervals,
        number=number,
    )


def growing_run(
    trajectory: Trajectory, scene: Scene, name: str = "", mark: str = "", colour: str = ""
) -> PlottedRun:
    """The part computed so far of a run, with the intervals that its samples resolve."""
    v_belt = scene.parameters.v_belt
    return PlottedRun(
        name,
        trajectory,
        _sampled(trajectory, Mode.SEPARATED),
        scene.t_end,
        mark,
        colour,
        v_belt=None if "v_belt" in dict(scene.over_time) else v_belt,
        stuck=None if v_belt is None else _sampled(trajectory, Mode.STICK),
    )


def _sampled(trajectory: Trajectory, mode: Mode) -> list[tuple[float, float]]:
    # Intervals in a mode, as far as the samples resolve them.
    inside = np.concatenate(([False], trajectory.mode == mode, [False]))
    changes = np.flatnonzero(np.diff(inside))
    times = np.append(trajectory.t, trajectory.t[-1])[changes].tolist()
    return list(zip(times[::2], times[1::2], strict=True))


def contact_strips(separated: Intervals, stuck: Intervals | None) -> tuple[Strip, ...]:
    """When a slider is off the belt, and when it sticks to a belt of finite speed."""
    off = Strip("off belt", "off the belt", separated)
    return (off,) if stuck is None else (off, Strip("stick", "stuck to the belt", stuck))


def time_chart(quantity: str, runs: Sequence[PlottedRun], *, strip: bool, x_axis: bool) -> Chart:
    """A quantity over time, a trace per run, the first on top.

    `strip` marks when the first run is off the belt, and when it sticks to it.
    """
    traces = tuple(
        Trace(
            run.name,
            run.trajectory.t,
            getattr(run.trajectory, quantity),
            mark=run.mark,
            colour=run.colour,
            number=run.number,
        )
        for run in reversed(runs)
    )
    return Chart(
        TIME_LABEL,
        label_of(quantity),
        traces,
        guides=(Guide(0.0, vertical=False), *_belt_guide(quantity, runs[0])),
        strips=contact_strips(runs[0].separated, runs[0].stuck) if strip else (),
        x_axis=x_axis,
        x_range=(0.0, max(run.t_end for run in runs)),
    )


def _belt_guide(quantity: str, run: PlottedRun) -> tuple[Guide, ...]:
    # The speed of the belt, on which a slider that sticks stays.
    if quantity != "vx" or run.v_belt is None:
        return ()
    return (Guide(run.v_belt, "belt", vertical=False),)


def difference_chart(
    quantity: str, run: PlottedRun, baseline: PlottedRun, *, strip: bool, x_axis: bool
) -> Chart:
    """Difference of a quantity between a run and a baseline over their common time.

    `strip` marks when the run is off the belt, and when it sticks to it.
    The baseline is interpolated linearly where the sample times differ.
    """
    t, there = run.trajectory.t, baseline.trajectory.t
    t = t[t <= there[-1]]
    own = getattr(run.trajectory, quantity)[: t.size]
    other = getattr(baseline.trajectory, quantity)
    same = np.array_equal(t, there[: t.size])
    values = own - (other[: t.size] if same else np.interp(t, there, other))
    note = f"{run.name} − {baseline.name}" + ("" if same else ", interpolated")
    return Chart(
        TIME_LABEL,
        f"Δ{label_of(quantity)}",
        (Trace("", t, values, colour=run.colour),),
        guides=(Guide(0.0, vertical=False),),
        strips=contact_strips(run.separated, run.stuck) if strip else (),
        note=note,
        x_axis=x_axis,
        x_range=(0.0, float(t[-1])),
    )


def second_half(t_end: float) -> tuple[float, float]:
    """Start and end of the second half of a run, over which half peak-to-peak is taken."""
    return 0.5 * t_end, t_end


def _part(t: FloatArray, window: tuple[float, float]) -> slice:
    first, stop = np.searchsorted(t, window, side="left").tolist()
    return slice(first, stop + 1)


def _span(window: tuple[float, float]) -> str:
    return f"t {window[0]:.4g} to {window[1]:.4g} s"


def phase_chart(quantity: str, runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """Velocity against displacement within a time window, a trace per run; stick is marked."""
    return _portrait(quantity, f"v{quantity}", runs, window)


def path_chart(runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """The path of the slider, y over x, within a time window; stick is marked."""
    return _portrait("x", "y", runs, window)


def _portrait(
    across: str, up: str, runs: Sequence[PlottedRun], window: tuple[float, float]
) -> Chart:
    paths, stuck = [], []
    for run in reversed(runs):
        motion, part = run.trajectory, _part(run.trajectory.t, window)
        x, y = getattr(motion, across)[part], getattr(motion, up)[part]
        paths.append(
            Trace(
                run.name,
                x,
                y,
                ordered=False,
                mark=run.mark,
                colour=run.colour,
                along=motion.t[part],
                number=run.number,
            )
        )
        held = motion.mode[part] == Mode.STICK
        if held.any():
            stuck.append(
                Trace(
                    f"{run.name} stick" if len(runs) > 1 else "stick",
                    x[held],
                    y[held],
                    look="points",
                    ordered=False,
                    mark=_STICK_MARK,
                    colour=run.colour,
                )
            )
    guides = _belt_guide(up, runs[0])
    if "y" in (across, up):
        guides = (Guide(0.0, "y = 0", vertical=across == "y"), *guides)
    return Chart(
        label_of(across),
        label_of(up),
        (*paths, *stuck),
        guides=guides,
        note=_span(window),
        tight=False,
        along=TIME_LABEL,
    )


def spectrum_of(run: PlottedRun, window: tuple[float, float]) -> Spectrum:
    """The spectrum of y within a time window."""
    part = _part(run.trajectory.t, window)
    return spectrum(run.trajectory.t[part], run.trajectory.y[part])


def spectrum_chart(runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """Spectra of y within a time window, with the first harmonics of the first run marked."""
    spectra = [spectrum_of(run, window) for run in runs]
    first = spectra[0]
    traces = tuple(
        Trace(
            run.name,
            found.frequency,
            found.amplitude,
            mark=run.mark,
            colour=run.colour,
            number=run.number,
        )
        for run, found in reversed(list(zip(runs, spectra, strict=True)))
    )
    base, note = first.fundamental, f"{_span(window)}, no vibration"
    guides: tuple[Guide, ...] = ()
    top = float(first.frequency[-1])
    if base > 0.0:
        top = min(top, _HARMONICS * base)
        guides = tuple(
            Guide(number * base, "f₁" if number == 1 else f"{number}f₁")
            for number in range(1, _MARKED + 1)
        )
        note = f"f₁ {base:.4g} Hz, period {1.0 / base:.4g} s, {_span(window)}"
    return Chart("f (Hz)", "|y| (m)", traces, guides=guides, note=note, x_range=(0.0, top))
