"""What a tab shows before its first result: a sketch of it, its question, and how to start."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from textwrap import wrap
from typing import Final

import numpy as np
from numpy.typing import NDArray
from textual.content import Content
from textual.widgets import Static

from fivtui.scene import scene_transient
from fivtui.tui.chart import Raster
from fivtui.tui.session import base_scene, duration_text

FILE_FORMAT: Final = "A file has a line of names, such as t,y, and lines such as 0.01,0.0031."
# CPU time of a step of the base scene where the usual durations of studies were measured, s; and
# number and length of the runs that measure it on this machine, s of simulated time.
_REFERENCE_STEP_S: Final = 2.7e-7
_TIMED_RUNS, _TIMED_S = 5, 20.0
_Values = Sequence[float] | NDArray[np.float64]

# Columns and rows of the plot of a sketch.
_MIN_COLUMNS: Final = 30
_MAX_COLUMNS: Final = 56
_MIN_ROWS: Final = 2
_MAX_ROWS: Final = 10
# Rows of a sketch beside its plot: names of the axes, and a blank line below them.
_OTHER_ROWS: Final = 3
# Columns beside the sketch and the texts.
_MARGIN: Final = 4
_MAX_TEXT_COLUMNS: Final = 72
_CURVE_STYLE: Final = "$primary"
_AXIS_STYLE: Final = "$foreground-muted"
_KEY_STYLE: Final = "bold $text-accent"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sketch:
    """The shape of a typical result; its axes have no numbers, because nothing was computed."""

    # What the result answers.
    question: str
    # Names of the axes.
    x: str
    y: str
    # Coordinates from 0 to 1 of points, joined by lines or not.
    curves: Sequence[tuple[_Values, _Values]]
    dots: Sequence[tuple[_Values, _Values]] = ()
    # Texts, and the position of their first character.
    labels: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def lines(self, columns: int, rows: int) -> Iterator[tuple[str, str]]:
        """Axis and plot of every line."""
        raster = Raster(columns, rows)
        for x, y in self.curves:
            raster.draw_lines(np.array(x), np.array(y))
        for x, y in self.dots:
            raster.draw_dots(np.array(x), np.array(y))
        plot = np.where(raster.cells, raster.cells + Raster.BLANK, ord(" "))
        for text, (start_x, start_y) in self.labels.items():
            row, column = round((1.0 - start_y) * (rows - 1)), round(start_x * (columns - 1))
            plot[row, column : column + len(text)] = list(map(ord, text[: columns - column]))
        yield self.y.ljust(columns + 1), ""
        for cells in plot:
            yield "│", "".join(map(chr, cells))
        yield f"└{f' {self.x}'.rjust(columns, '─')}", ""
        yield " ", ""


_TIMES: Final = np.linspace(0.0, 1.0, 161)
# A growing vibration: a run, and measured data that deviate from it.
_MOTION: Final = 0.5 + 0.45 * _TIMES * np.sin(8.0 * np.pi * _TIMES)
MEASURED_SKETCH: Final = Sketch(
    question="How near does the model come to a measurement?",
    x="t",
    y="y",
    curves=((_TIMES, _MOTION),),
    dots=((_TIMES[::4], (_MOTION + 0.12 * np.cos(70.0 * _TIMES))[::4]),),
    labels={"computed and measured": (0.02, 1.0)},
)


def about(seconds: float) -> str:
    """A typical duration as a phrase."""
    if seconds < 1.0:
        return "usually within 1 s"
    return f"usually in about {duration_text(float(f'{seconds:.1g}')).replace('.0 s', ' s')}"


@cache
def relative_duration() -> float:
    """Computing time on this machine, relative to that where usual durations were measured."""
    scene = replace(base_scene(), t_end=_TIMED_S)
    stats = [scene_transient(scene).transient.stats for _ in range(_TIMED_RUNS)]
    return min((run.cpu_s or 0.0) / run.steps for run in stats) / _REFERENCE_STEP_S


def about_here(seconds: float) -> str:
    """A typical duration on this machine, from that where `relative_duration` is 1."""
    return about(seconds * relative_duration())


class Preview(Static):
    """A sketch, its question, and notes, in place of the views of a tab.

    A note is a key, which may be empty, and a text.
    """

    def __init__(self, sketch: Sketch, *notes: tuple[str, str]) -> None:
        super().__init__(classes="preview")
        self._sketch, self._notes = sketch, notes

    def show(self, sketch: Sketch, *notes: tuple[str, str]) -> None:
        """Display another sketch or other notes."""
        if (sketch, notes) != (self._sketch, self._notes):
            self._sketch, self._notes = sketch, notes
            self.refresh()

    def render(self) -> Content:
        """The sketch in the rows that the texts leave, if they are enough."""
        width, height = self.size
        text_width = max(min(width - _MARGIN, _MAX_TEXT_COLUMNS), 1)
        lines = [Content.styled(line, "bold") for line in wrap(self._sketch.question, text_width)]
        for key, text in self._notes:
            first, *rest = wrap(f"{key} {text}".lstrip(), text_width)
            lines += [Content(first).stylize(_KEY_STYLE, 0, len(key)), *map(Content, rest)]
        columns = min(width - _MARGIN, _MAX_COLUMNS)
        rows = min(height - len(lines) - _OTHER_ROWS, _MAX_ROWS)
        if rows >= _MIN_ROWS and columns >= _MIN_COLUMNS:
            lines[:0] = [
                Content.assemble((axis, _AXIS_STYLE), (plot, _CURVE_STYLE))
                for axis, plot in self._sketch.lines(columns, rows)
            ]
        return Content("\n").join(lines)
