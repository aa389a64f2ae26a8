"""The table of modes of the slider and of their transitions, for integrators and help texts.

A guard is a function of the state that is positive while its mode lasts. On a Taylor step, where x
and y are polynomials in time, so is every guard, and its first root ends the mode. The guards are
y, −y, v_r, −v_r, μ_s P − f and μ_s P + f, with v_r = v_belt − ẋ and the contact force P. The belt's
holding force is f = c1 v_belt + a x − h y, with a = k1 + k3/2 and h = k3/2.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final


class Mode(IntEnum):
    """State of the contact, by the number in files: see `MODES`."""

    SEPARATED = 0
    CONTACT = 1
    FORWARD = 2
    BACKWARD = 3
    STICK = 4


class Guard(Enum):
    """Function of the state that is positive while a mode lasts; the value is its formula."""

    HEIGHT = "y"
    DEPTH = "-y"
    BELT_FASTER = "v_r"
    BELT_SLOWER = "-v_r"
    # Margins of static friction: when one falls to zero, the mode FORWARD or BACKWARD follows.
    HELD_FORWARD = "mu_s P - f"
    HELD_BACKWARD = "mu_s P + f"


@dataclass(frozen=True, slots=True)
class Transition:
    """How a mode ends: the guard that falls to zero, and the modes that may follow."""

    guard: Guard
    next_modes: tuple[Mode, ...]


@dataclass(frozen=True, slots=True)
class ModeRow:
    """A row of the table of modes: meaning, friction force on the slider, and ends."""

    meaning: str
    friction: str
    in_contact: bool
    # Direction of sliding friction: 1 along the motion of the belt, −1 against it, 0 for none.
    friction_sign: float
    # Whether the mode occurs on belts of finite speed only, see `Parameters.v_belt`.
    finite_belt: bool
    # If several modes may follow a transition, the state decides between them.
    ends: tuple[Transition, ...]

    @property
    def sticks(self) -> bool:
        """Whether the slider moves with the belt."""
        return self.in_contact and self.friction_sign == 0.0

    @property
    def slips(self) -> bool:
        """Whether the slider slides on a belt of finite speed."""
        return self.finite_belt and self.friction_sign != 0.0


_SEPARATION: Final = Transition(Guard.DEPTH, (Mode.SEPARATED,))

MODES: Final[Mapping[Mode, ModeRow]] = {
    Mode.SEPARATED: ModeRow(
        "off the belt",
        "0",
        in_contact=False,
        friction_sign=0.0,
        finite_belt=False,
        # CONTACT follows on a belt that is always faster, slip or stick on one of finite speed.
        ends=(Transition(Guard.HEIGHT, (Mode.CONTACT, Mode.FORWARD, Mode.BACKWARD, Mode.STICK)),),
    ),
    Mode.CONTACT: ModeRow(
        "in contact with a belt that is always faster",
        "mu P",
        in_contact=True,
        friction_sign=1.0,
        finite_belt=False,
        ends=(_SEPARATION,),
    ),
    Mode.FORWARD: ModeRow(
        "the belt slides forward under the slider",
        "mu(v_r) P",
        in_contact=True,
        friction_sign=1.0,
        finite_belt=True,
        ends=(_SEPARATION, Transition(Guard.BELT_FASTER, (Mode.STICK, Mode.BACKWARD))),
    ),
    Mode.BACKWARD: ModeRow(
        "the slider is faster than the belt",
        "-mu(|v_r|) P",
        in_contact=True,
        friction_sign=-1.0,
        finite_belt=True,
        ends=(_SEPARATION, Transition(Guard.BELT_SLOWER, (Mode.STICK, Mode.FORWARD))),
    ),
    Mode.STICK: ModeRow(
        "the slider moves with the belt",
        "f = c1 v_belt + a x - h y",
        in_contact=True,
        friction_sign=0.0,
        finite_belt=True,
        ends=(
            _SEPARATION,
            Transition(Guard.HELD_FORWARD, (Mode.FORWARD,)),
            Transition(Guard.HELD_BACKWARD, (Mode.BACKWARD,)),
        ),
    ),
}

# The modes in which the slider touches the belt, and those of a belt that is always faster.
IN_CONTACT: Final = frozenset(mode for mode, row in MODES.items() if row.in_contact)
ALWAYS_SLIDING: Final = tuple(mode for mode, row in MODES.items() if not row.finite_belt)


def transition_name(first: Mode, second: Mode) -> str:
    """Name of a transition in results, such as ``"stick-forward"``."""
    return f"{first.name}-{second.name}".lower()
