"""The scenes of the paper's figures: what varies, over which range, in which lines.

Values are those of the captions and the text. Where the paper gives no range, the range here shows
what its text says of the figure, and `Panel.choice` says what was chosen.
"""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from fivtui.scene import PRESETS, Scene

Kind = Literal["equilibrium", "eigenvalues", "critical mu", "transient", "amplitude"]

# A parameter and its values.
_Steps = tuple[str, Sequence[float]]

SEPARATION: Final = "separation"
FIRST_FIGURE: Final = 2
LAST_FIGURE: Final = 16

_BASE: Final = PRESETS["base"]
_CASES: Final = (PRESETS["separation-ignored"], _BASE)
# Amplitudes are compared with values read from a picture, to a percent.
_AMPLITUDE_TOL: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a panel: a scene, and ascending values of the parameter that varies along it.

    `along` is ``"t"``, and `values` is empty, if the line is one run.
    """

    scene: Scene
    along: str
    values: tuple[float, ...] = ()

    def scenes(self) -> Iterator[Scene]:
        """The scenes of the points, in order."""
        for value in self.values:
            yield self.scene.with_values({self.along: value})


@dataclass(frozen=True, slots=True)
class Panel:
    """What one panel of a figure shows."""

    key: str
    caption: str
    kind: Kind
    lines: tuple[Line, ...]
    by: str
    shown: str = ""
    choice: str = ""

    @property
    def along(self) -> str:
        """The parameter along which the lines are drawn."""
        return self.lines[0].along

    @property
    def fixed(self) -> dict[str, float]:
        """Parameters that all points share, without μ where it varies or is what is found."""
        varied = {self.by, self.along}
        if self.kind in {"eigenvalues", "critical mu"}:
            varied.add("mu")
        values = self.lines[0].scene.parameters.as_dict()
        return {name: value for name, value in values.items() if name not in varied}

    def scenes(self) -> list[Scene]:
        """The scenes of all points, line by line."""
        return [scene for line in self.lines for scene in line.scenes()]


def _scene(key: str, changes: Mapping[str, float], scene: Scene = _BASE, **more: Any) -> Scene:
    return dataclasses.replace(scene, name=f"fig-{key}", **more).with_values(changes)


def _grid(start: float, stop: float, count: int) -> tuple[float, ...]:
    return tuple(np.linspace(start, stop, count).tolist())


def _by_parameter(
    key: str,
    changes: Mapping[str, float],
    along: _Steps,
    by: _Steps,
) -> tuple[Line, ...]:
    parameter, values = along
    name, steps = by
    return tuple(
        Line(_scene(key, {**changes, name: step}), parameter, tuple(values)) for step in steps
    )


def _by_case(key: str, changes: Mapping[str, float], along: _Steps) -> tuple[Line, ...]:
    parameter, values = along
    return tuple(
        Line(_scene(key, changes, case, tol=_AMPLITUDE_TOL), parameter, tuple(values))
        for case in _CASES
    )


_PRELOADS: Final = ("F", _grid(0.0, 100.0, 201))
_STIFFNESSES: Final = ("k_nl", _grid(0.0, 500.0, 501))
_FRICTION: Final = ("mu", _grid(0.0, 2.0, 401))
_STIFFNESS_STEPS: Final = ("k_nl", (0.0, 50.0, 100.0, 500.0))
_PRELOAD_STEPS: Final = ("F", (0.0, 5.0, 50.0, 100.0))
_RANGE: Final = "the range is not given"


def _equilibria() -> Iterator[Panel]:
    choice = "lines and ranges are those of Figs. 3 to 7, the friction coefficient is 0.7"
    yield Panel(
        "2a",
        "Vertical displacement of the equilibrium against the preload",
        "equilibrium",
        _by_parameter("2a", {}, _PRELOADS, _STIFFNESS_STEPS),
        "k_nl",
        choice=choice,
    )
    yield Panel(
        "2b",
        "Vertical displacement of the equilibrium against the cubic contact stiffness",
        "equilibrium",
        _by_parameter("2b", {}, _STIFFNESSES, _PRELOAD_STEPS),
        "F",
        choice=choice,
    )


def _eigenvalues() -> Iterator[Panel]:
    rows: tuple[tuple[str, Mapping[str, float], str], ...] = (
        ("3", {"F": 20.0}, "F = 20 N"),
        ("4", {"F": 100.0}, "F = 100 N"),
        ("5", {"F": 100.0, "c1": 0.8}, "F = 100 N, non-proportional damping"),
    )
    for key, changes, condition in rows:
        yield Panel(
            key,
            f"Frequencies and growth rates against the friction coefficient ({condition})",
            "eigenvalues",
            _by_parameter(key, changes, _FRICTION, _STIFFNESS_STEPS),
            "k_nl",
            choice=f"{_RANGE}; 0 to 2 shows every critical friction coefficient",
        )


def _critical() -> Iterator[Panel]:
    preload = "Critical friction coefficient against the preload"
    stiffness = "Critical friction coefficient against the cubic contact stiffness"
    soft = {"k1": 50.0, "k2": 100.0}
    condition = " (k1 = 50 N/m, k2 = 100 N/m)"
    to_100 = f"{_RANGE}; to 100 N the line of 500 N/m^3 alone passes the linear one"
    to_500 = f"{_RANGE}; it ends at the greatest stiffness of the text, 500 N/m^3"
    same = "lines and range are those of "
    by_stiffness = (_PRELOADS, ("k_nl", (0.0, 50.0, 200.0, 500.0)))
    by_preload = (_STIFFNESSES, _PRELOAD_STEPS)
    rows: tuple[tuple[str, str, Mapping[str, float], tuple[_Steps, _Steps], str], ...] = (
        ("6", preload, {}, by_stiffness, to_100),
        ("7", stiffness, {}, by_preload, to_500),
        ("8", preload + condition, soft, by_stiffness, f"{same}Fig. 6"),
        ("9", stiffness + condition, soft, by_preload, f"{same}Fig. 7"),
    )
    for key, caption, changes, (along, by), choice in rows:
        lines = _by_parameter(key, changes, along, by)
        yield Panel(key, caption, "critical mu", lines, by[0], choice=choice)


def _transients() -> Iterator[Panel]:
    rows = (
        ("10", "Contact force", "P"),
        ("11", "Horizontal displacement", "x"),
        ("12", "Vertical displacement", "y"),
    )
    for key, what, shown in rows:
        yield Panel(
            key,
            f"{what} over time",
            "transient",
            tuple(Line(case, "t") for case in _CASES),
            SEPARATION,
            shown,
            choice="the start is not given; it is at rest in the static position",
        )


def _amplitudes() -> Iterator[Panel]:
    preload = "Peak of y and half peak-to-peak over the second half of the run against the preload"
    stiffness = (
        "Peak of y and half peak-to-peak over the second half of the run against the contact "
        "stiffness"
    )
    start = (
        "start, range and the amplitude's definition are not given; static start, 100 s, peak of "
        "|y| and half peak-to-peak of y over the second half of the run"
    )
    unstable = "the range lies where the equilibrium is unstable"
    # With separation ignored the amplitude falls steeply at first.
    soft_to_hard = _grid(20.0, 95.0, 16) + _grid(100.0, 500.0, 41)
    rows: tuple[tuple[str, str, Mapping[str, float], _Steps, str], ...] = (
        ("13", preload, {"k_nl": 20.0, "mu": 0.5}, ("F", _grid(60.0, 190.0, 66)), unstable),
        ("14", preload, {"k_nl": 100.0, "mu": 0.7}, ("F", _grid(20.0, 110.0, 46)), unstable),
        ("15", stiffness, {"F": 40.0, "mu": 0.7}, ("k_nl", soft_to_hard), unstable),
        (
            "16",
            stiffness,
            {"F": 60.0, "mu": 1.0},
            ("k_nl", soft_to_hard),
            "the range is that of Fig. 15",
        ),
    )
    for key, caption, changes, along, choice in rows:
        yield Panel(
            key,
            caption,
            "amplitude",
            _by_case(key, changes, along),
            SEPARATION,
            choice=f"{start}; {choice}",
        )


PANELS: Final[Mapping[str, Panel]] = {
    panel.key: panel
    for make in (_equilibria, _eigenvalues, _critical, _transients, _amplitudes)
    for panel in make()
}


def panels_of(number: int) -> tuple[Panel, ...]:
    """The panels of a figure, 2 to 16, that have scenes of their own, in order."""
    return tuple(panel for key, panel in PANELS.items() if key.rstrip("ab") == str(number))
