"""The equations of the model as text, and which parameters enter them. Imports no Textual."""

import re
from dataclasses import dataclass
from typing import Final

from fivtui.model.parameters import ParameterSpec


@dataclass(frozen=True, slots=True)
class Equation:
    """An equation of the paper.

    Attributes
    ----------
    number : str
        Its number there.
    subject : str
        What it says, one phrase.
    text : str
        The equation, in the parameters' names.
    """

    number: str
    subject: str
    text: str

    def has(self, spec: ParameterSpec) -> bool:
        """Whether a parameter enters, by its name or symbol."""
        names = "|".join(map(re.escape, (spec.name, spec.symbol)))
        return re.search(rf"(?<!\w)({names})(?!\w)", self.text) is not None


EQUATIONS: Final = (
    Equation("1", "contact force", "P = −k2 y − k_nl y³"),
    Equation("2", "horizontal motion", "m ẍ + c1 ẋ + (k1 + k3/2) x − (k3/2) y = μ P"),
    Equation("2", "vertical motion", "m ÿ + c2 ẏ + (k3/2) y − (k3/2) x = P − F"),
    Equation("4", "separated while", "y > 0, with P = 0 in the motion"),
)


def equations_with(spec: ParameterSpec) -> list[Equation]:
    """The equations that a parameter enters.

    Parameters
    ----------
    spec : ParameterSpec
        The parameter.

    Returns
    -------
    list of Equation
        In the paper's order.
    """
    return [equation for equation in EQUATIONS if equation.has(spec)]
