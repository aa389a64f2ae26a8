"""The colours of all charts by role, in figures and in the terminal.

Tests hold that series, and danger, warning and safe, differ with every colour vision deficiency,
and that each colour contrasts with the backgrounds of all themes. Danger has a colour of its own.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Final, NamedTuple


class Ink(NamedTuple):
    """A colour on light backgrounds, as those of figures, and on dark ones."""

    light: str
    dark: str


_SERIES: Final = (
    Ink("#014dec", "#7eb8ff"),
    Ink("#445800", "#afbd1a"),
    Ink("#1e2946", "#e3dcde"),
    Ink("#c44196", "#fc97cd"),
    Ink("#1484bb", "#9cebff"),
    Ink("#882fa1", "#ad7fd6"),
    Ink("#7c7b7c", "#9396a4"),
)
# Number of series with a colour of their own; further series repeat these colours.
SERIES_COUNT: Final = len(_SERIES)
INKS: Final[Mapping[str, Ink]] = {
    "danger": Ink("#b3292f", "#fa5e60"),
    "warning": Ink("#b06d04", "#ffcb70"),
    "safe": Ink("#006d5f", "#3bd5a8"),
    **{f"series-{number}": ink for number, ink in enumerate(_SERIES, 1)},
    "reference": Ink("#666666", "#a0a0a0"),
    "ghost": Ink("#767676", "#959595"),
    "friction": _SERIES[3],
    "belt": Ink("#4a4a4a", "#c8c8c8"),
}
# Role of points, lines and boundaries that lie on other colours.
STRONG: Final = "series-3"


def series_role(index: int) -> str:
    """Role of the series with this index, from 0."""
    return f"series-{index % SERIES_COUNT + 1}"


@dataclass(frozen=True, slots=True)
class PlotColours:
    """Colour codes of a plot, such as ``#1f4fd8``.

    Attributes
    ----------
    background, foreground : str
        Of the plot, and of text.
    roles : mapping
        Colours by role.
    """

    background: str
    foreground: str
    roles: Mapping[str, str]


_PAPER: Final = PlotColours("#ffffff", "#000000", {role: ink.light for role, ink in INKS.items()})
# The colours of the plot that is being drawn; by default those of figures on paper.
_PLOT_COLOURS: Final = ContextVar("plot colours", default=_PAPER)


@contextmanager
def screen_colours(colours: PlotColours) -> Iterator[None]:
    """Draw in the colours of a screen in place of those of figures on paper."""
    token = _PLOT_COLOURS.set(colours)
    try:
        yield
    finally:
        _PLOT_COLOURS.reset(token)


def figure_colour(role: str, strength: float = 1.0) -> str:
    """Code of the colour of a role; a `strength` below 1 mixes it with the background."""
    colours = _PLOT_COLOURS.get()
    return mix(colours.roles[role], colours.background, strength)


def grey(lightness: float) -> str:
    """Code of a colour between those of text (0) and of the background (1)."""
    colours = _PLOT_COLOURS.get()
    return mix(colours.background, colours.foreground, lightness)


def mix(code: str, background: str, share: float) -> str:
    """The mixture of a colour, by its share, with a background, all as codes."""
    front, back = (bytes.fromhex(text.removeprefix("#")) for text in (code, background))
    pairs = zip(front, back, strict=True)
    return f"#{bytes(round(low + share * (high - low)) for high, low in pairs).hex()}"
