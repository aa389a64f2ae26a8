"""Films of the slider on the belt, drawn by matplotlib and written as GIF or MP4.

A frame shows the slider with its forces, and below it y over time with the current time marked.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from numpy.typing import NDArray

from fivtui.charts import (
    CASE_COLOURS,
    OFF_BELT_COLOUR,
    STYLE,
    drawing_settings,
    figure_colour,
    new_figure,
    shade_times,
)
from fivtui.io import (
    check_output,
    check_suffix,
    describe_files,
    output_path,
    save_bytes,
    temporary_folder,
)
from fivtui.model import ALWAYS_SLIDING, InputError, Mode, OnProgress, Progress
from fivtui.results import Result
from fivtui.signals import motion_at
from fivtui.transient import Trajectory, Transient

from .shapes import MODE_NAMES, Layout, layout_of, shapes_at
from .timing import FRAMES_PER_SECOND, Timing, film_timing, speed_text

_GIF: Final = ".gif"
_MP4: Final = ".mp4"
# Size, inches, and dots per inch: 640 by 540 pixels; MP4 needs even numbers of pixels.
_SIZE: Final = (6.4, 5.4)
_DPI: Final = 100
# Points of the curve of y over time.
_CURVE_POINTS: Final = 2000
# Line styles of the shapes, by name.
_LINE_STYLES: Final[dict[str, dict[str, Any]]] = {
    "belt": {"color": figure_colour("belt"), "linewidth": 2.0},
    "marks": {"color": "0.6", "linewidth": 1.2},
    "walls": {"color": "0.25", "linewidth": 2.5},
    "springs": {"color": "0.45", "linewidth": 1.0},
    "contact spring": {"color": "0.25", "linewidth": 1.2},
    "preload": {"color": "0.25", "linewidth": 1.4},
    "contact force": {"color": figure_colour("series-1"), "linewidth": 1.8},
    "friction": {"color": figure_colour("friction"), "linewidth": 1.8},
}
# Colour of the foot by mode; the title names the mode. CONTACT is sliding on a belt that is always
# faster, FORWARD on one of finite speed that is faster than the slider at the time.
_FOOT_COLOURS: Final = {
    Mode.SEPARATED: "white",
    Mode.CONTACT: figure_colour("series-3", 0.25),
    Mode.FORWARD: figure_colour("series-3", 0.25),
    Mode.BACKWARD: figure_colour("series-6", 0.3),
    Mode.STICK: figure_colour("series-2", 0.6),
}
_BLOCK_COLOUR: Final = figure_colour("series-1", 0.1)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Film(Result):
    """A film that was written.

    Attributes
    ----------
    path : Path
        The file.
    window : tuple of float
        Start and end of the time shown, s.
    speed : float
        Seconds of the motion in a second of the film.
    frames : int
        Number of frames, 25 a second.
    """

    path: Path
    window: tuple[float, float]
    speed: float
    frames: int

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui animate --json`` prints."""
        return {**asdict(self), "path": str(self.path)}

    def _summary(self) -> list[tuple[str, str]]:
        return [
            ("file", describe_files(self.path)),
            ("shown", f"{self.window[0]:.6g} to {self.window[1]:.6g} s"),
            ("speed", f"{self.speed:g} s of the motion a second: {speed_text(self.speed)}"),
            ("frames", f"{self.frames}, {self.frames / FRAMES_PER_SECOND:.3g} s"),
        ]


def check_film_path(path: Path) -> None:
    """Raise `InputError` if a film cannot be written to this path; checks before computing."""
    if check_suffix(path, "film", (_GIF, _MP4)) == _MP4 and not FFMpegWriter.isAvailable():
        raise InputError(f"{path}: MP4 needs ffmpeg, which is not installed; use .gif")
    check_output(path)


def animate(
    run: Transient,
    path: Path | str,
    *,
    window: tuple[float, float] | None = None,
    speed: float | None = None,
    force: bool = False,
    progress: OnProgress | None = None,
) -> Film:
    """Write a film of the slider on the belt.

    The slider moves to scale, with the forces that act on it from the belt; its foot is white off
    the belt, and olive where it sticks. A chart below shows y over time. A belt without a speed in
    the model moves at an arbitrary one.

    Parameters
    ----------
    run : Transient
        Computed with ``samples="dense"``, or with sample times close enough for its motion.
    path : Path or str
        The file: ``.gif``, or ``.mp4`` where ffmpeg is installed.
    window : tuple of float, optional
        Start and end of the time shown, s. By default the last eight cycles. If only `speed` is
        given, the end of the run that fills a film of ten seconds.
    speed : float, optional
        Seconds of the motion in a second of the film, 1 for real time. By default the film lasts
        ten seconds.
    force : bool
        Whether an existing file may be replaced.
    progress : callable, optional
        Called with the fraction done; the film is given up when it returns False.

    Returns
    -------
    Film
        What is shown, how fast, and the number of frames.

    Raises
    ------
    InputError
        If an input is wrong, the film would have more than 1000 frames or show no motion, or the
        file cannot be written.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import animate, simulate
    >>> film = animate(simulate(samples="dense"), "run.gif", window=(20, 20.2), speed=1)
    >>> film.frames
    6
    """
    path = output_path(path, force=force)
    check_film_path(path)
    timing = film_timing(run, window, speed)
    times = timing.times
    with temporary_folder() as folder:
        file = folder / f"film{path.suffix.lower()}"
        with drawing_settings(STYLE):
            renderer = _FrameRenderer(run, timing)
        writer_class = PillowWriter if file.suffix == _GIF else FFMpegWriter
        writer: AbstractMovieWriter = writer_class(fps=FRAMES_PER_SECOND)
        # The writer redraws the figure for every frame, so give it one that holds only an image.
        image_figure = Figure(figsize=_SIZE, dpi=_DPI)
        image = image_figure.figimage(renderer.frame(timing.start))
        with writer.saving(image_figure, str(file), _DPI):
            # Check for cancelling after a frame: a writer needs at least one.
            work = Progress(progress)
            for count, t in enumerate(times.tolist(), 1):
                image.set_data(renderer.frame(t))
                writer.grab_frame()
                work.report(count / times.size)
        save_bytes(file.read_bytes(), path)
    return Film(Path(path), (timing.start, timing.end), timing.speed, times.size)


class _FrameRenderer:
    # Draws frames: the static part of the figure once, the moving artists for every frame.

    def __init__(self, run: Transient, timing: Timing) -> None:
        self._run, self._timing = run, timing
        # Decimals of the displayed time: three digits of the window's length.
        self._decimals = max(2 - math.floor(math.log10(timing.end - timing.start)), 0)
        motion = motion_at(run, np.linspace(timing.start, timing.end, _CURVE_POINTS))
        self._layout = layout_of(motion)
        figure = new_figure(*_SIZE)
        figure.set_dpi(_DPI)
        self._canvas = _new_canvas(figure)
        axes, curve_axes = figure.subplots(2, 1, height_ratios=(3.4, 1.0))
        _set_limits(axes, self._layout)
        # Initial text that reserves space in the layout.
        self._title: Text = axes.set_title("t", loc="left")
        self._lines = {name: axes.plot([], [], **style)[0] for name, style in _LINE_STYLES.items()}
        self._areas = {
            name: axes.fill([0.0], [0.0], edgecolor="0.15", linewidth=1.2)[0]
            for name in ("foot", "block")
        }
        _add_legend(axes, run, self._lines)
        self._time_line = _draw_curve(curve_axes, motion, run, timing)
        self._moving = [*self._lines.values(), *self._areas.values(), self._title, self._time_line]
        # The first drawing fixes the layout; the second one omits the moving artists.
        self._canvas.draw()
        for artist in self._moving:
            artist.set_animated(True)
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(figure.bbox)

    def frame(self, t: float) -> NDArray[np.uint8]:
        """The picture at a time, s, shape (height, width, 4)."""
        self._move(t)
        self._canvas.restore_region(self._background)
        for artist in self._moving:
            artist.axes.draw_artist(artist)
        return np.array(self._canvas.buffer_rgba())

    def _move(self, t: float) -> None:
        run, layout = self._run, self._layout
        state = motion_at(run, np.array([t]))
        shapes = shapes_at(run, layout, state, self._timing.belt_travel(run, t, layout.width))
        mode = Mode(int(state.mode[0]))
        for name, line in self._lines.items():
            shape = shapes.get(name)
            line.set_visible(shape is not None)
            if shape is not None:
                line.set_data(shape.x, shape.y)
        for name, area in self._areas.items():
            area.set_xy(np.column_stack([shapes[name].x, shapes[name].y]))
            area.set_facecolor(_FOOT_COLOURS[mode] if name == "foot" else _BLOCK_COLOUR)
        force = f"P = {float(state.P[0]):.3g} N"
        self._title.set_text(f"t = {t:.{self._decimals}f} s    {MODE_NAMES[mode]}    {force}")
        self._time_line.set_xdata([t, t])


def _new_canvas(figure: Figure) -> Any:
    # Typed as Any: the methods of a canvas have no types.
    return FigureCanvasAgg(figure)


def _set_limits(axes: Axes, layout: Layout) -> None:
    axes.set_xlim(*layout.x_range)
    axes.set_ylim(*layout.y_range)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("$x$ (m)")
    axes.set_yticks([])


def _add_legend(axes: Axes, run: Transient, lines: Mapping[str, Line2D]) -> None:
    # The legend names the forces and the foot's colours in the modes that occur in the run.
    modes = [mode for mode in MODE_NAMES if mode in _run_modes(run)]
    handles: list[Artist] = [lines[name] for name in ("preload", "contact force", "friction")]
    handles += [Patch(facecolor=_FOOT_COLOURS[mode], edgecolor="0.15") for mode in modes]
    labels = ["preload", "contact force", "friction", *(MODE_NAMES[mode] for mode in modes)]
    axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.02, 1.0), frameon=False)


def _run_modes(run: Transient) -> set[Mode]:
    # Mode changes are stored for belts of finite speed only. On a belt that is always faster, a run
    # with switches has both of its modes: contact and separation.
    if run.mode_changes:
        return {run.first_mode, *(change.then for change in run.mode_changes)}
    return {run.first_mode, *ALWAYS_SLIDING} if run.switch_times.size else {run.first_mode}


def _draw_curve(axes: Axes, motion: Trajectory, run: Transient, timing: Timing) -> Line2D:
    # Draw y over time, shaded off the belt and in stick; return the line of the current time. The
    # colour tells whether separation is considered (Case 1 of the paper) or ignored (Case 2).
    axes.plot(
        motion.t, motion.y, color=figure_colour(CASE_COLOURS[run.separation][0]), linewidth=1.0
    )
    shade_times(axes, run.separated_intervals, OFF_BELT_COLOUR)
    shade_times(axes, run.stick_intervals, _FOOT_COLOURS[Mode.STICK])
    axes.set_xlim(timing.start, timing.end)
    axes.set_ylabel("$y$ (m)")
    axes.set_xlabel(f"$t$ (s), {speed_text(timing.speed)}")
    return axes.axvline(timing.start, color=figure_colour("friction"), linewidth=1.2)
