"""Colours and markers of runs. Imports no Textual."""

from dataclasses import dataclass
from typing import Final

# Okabe and Ito's colours, distinct also with colour vision deficiencies, on dark and light.
COLOURS: Final = ("#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#D55E00", "#0072B2", "#B8A800")
MARKERS: Final = "●■▲◆▼★"


@dataclass(slots=True)
class RunStyle:
    """Colour and marker of a run: indices into `COLOURS` and `MARKERS`, modulo their lengths."""

    colour: int
    marker: int

    @property
    def colour_code(self) -> str:
        """The colour as hex code."""
        return COLOURS[self.colour % len(COLOURS)]

    @property
    def marker_sign(self) -> str:
        """The marker character."""
        return MARKERS[self.marker % len(MARKERS)]


def usual_style(number: int) -> RunStyle:
    """The default style of a run; different for any 42 consecutive numbers."""
    return RunStyle(number - 1, number - 1)
