"""How runs are told apart: a colour and a marker each. Imports no Textual."""

from dataclasses import dataclass
from typing import Final

# Okabe and Ito's colours, told apart with colour vision deficiencies too, on dark and light.
COLOURS: Final = ("#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#D55E00", "#0072B2", "#B8A800")
MARKERS: Final = "●■▲◆▼★"


@dataclass(slots=True)
class RunStyle:
    """How a run is drawn and marked in lists.

    Attributes
    ----------
    colour, marker : int
        Places in `COLOURS` and `MARKERS`, counted round.
    """

    colour: int
    marker: int

    @property
    def colour_code(self) -> str:
        """The colour, such as ``#E69F00``."""
        return COLOURS[self.colour % len(COLOURS)]

    @property
    def marker_sign(self) -> str:
        """The marker: one character."""
        return MARKERS[self.marker % len(MARKERS)]


def usual_style(number: int) -> RunStyle:
    """The style that a run has unless the user chooses another.

    Parameters
    ----------
    number : int
        Number of the run, from 1.

    Returns
    -------
    RunStyle
        Different for any 42 runs in a row.
    """
    return RunStyle(number - 1, number - 1)
