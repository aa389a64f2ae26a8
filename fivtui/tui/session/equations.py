"""The model's equations as text, and the parameters in them. Imports no Textual."""

import re
from dataclasses import dataclass
from typing import Final

from fivtui.model import ParameterSpec


@dataclass(frozen=True, slots=True)
class Equation:
    """An equation of the paper, with its number, subject and text in the parameters' names."""

    number: str
    subject: str
    text: str

    def has(self, spec: ParameterSpec) -> bool:
        """Whether a parameter occurs in the equation, by name or symbol."""
        names = "|".join(map(re.escape, (spec.name, spec.symbol)))
        return re.search(rf"(?<!\w)({names})(?!\w)", self.text) is not None


EQUATIONS: Final = (
    Equation("1", "contact force", "P = −k2 y − k_nl y³"),
    Equation("2", "horizontal motion", "m ẍ + c1 ẋ + (k1 + k3/2) x − (k3/2) y = μ P"),
    Equation("2", "vertical motion", "m ÿ + c2 ẏ + (k3/2) y − (k3/2) x = P − F"),
    Equation("4", "separated while", "y > 0, with P = 0 in the motion"),
)


def equations_with(spec: ParameterSpec) -> list[Equation]:
    """The equations in which a parameter occurs."""
    return [equation for equation in EQUATIONS if equation.has(spec)]
