"""The scenes of the paper's figures: what varies, over which range, in which lines.

The paper is *Nonlinear friction-induced vibration of a slider-belt system*.

A figure has one or two panels. A panel has lines, which differ in the parameter `by`; the parameter
`along` varies along each line.

Values are those of the captions and the text. Where the paper gives no range, the range covers the
effects described in its text, and `Panel.choice` describes it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from fivtui.scene import PRESETS, Scene

Kind = Literal["equilibrium", "eigenvalues", "critical mu", "transient", "amplitude"]

# Name and values of a parameter.
_Axis = tuple[str, Sequence[float]]

SEPARATION: Final = "separation"
FIRST_FIGURE: Final = 2
LAST_FIGURE: Final = 16

_BASE: Final = PRESETS["base"]
_CASES: Final = (PRESETS["separation-ignored"], _BASE)
# Amplitudes are compared to a percent with values read from a picture: this tolerance suffices.
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
    """One panel of a figure: `by` distinguishes its lines.

    `choice` describes what was chosen because the paper does not give it. `shown` is the column
    that a panel of the kind ``"transient"`` shows over time.
    """

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
        """Parameters shared by all points, without μ where it varies or is computed."""
        varied = {self.by, self.along}
        if self.kind in {"eigenvalues", "critical mu"}:
            varied.add("mu")
        values = self.lines[0].scene.parameters.as_dict()
        return {name: value for name, value in values.items() if name not in varied}

    def scenes(self) -> list[Scene]:
        """The scenes of all points, line by line."""
        return [scene for line in self.lines for scene in line.scenes()]


def _grid(start: float, stop: float, count: int) -> tuple[float, ...]:
    return tuple(np.linspace(start, stop, count).tolist())


_PRELOADS: Final = ("F", _grid(0.0, 100.0, 201))
_STIFFNESSES: Final = ("k_nl", _grid(0.0, 500.0, 501))
_FRICTION: Final = ("mu", _grid(0.0, 2.0, 401))
# The lines of Figs. 2 to 5, and those of Figs. 6 and 8, N/m³.
_BY_STIFFNESS: Final = ("k_nl", (0.0, 50.0, 100.0, 500.0))
_BY_STIFFNESS_FIG_6: Final = ("k_nl", (0.0, 50.0, 200.0, 500.0))
_BY_PRELOAD: Final = ("F", (0.0, 5.0, 50.0, 100.0))
# With separation ignored the amplitude falls steeply at first: there the values are closer.
_K_NL_VALUES: Final = ("k_nl", _grid(20.0, 95.0, 16) + _grid(100.0, 500.0, 41))
_NO_RANGE: Final = "the range is not given"
_UNSTABLE: Final = "the range lies where the equilibrium is unstable"
_NO_CHANGES: Final[Mapping[str, float]] = {}
_SOFT: Final[Mapping[str, float]] = {"k1": 50.0, "k2": 100.0}


def _panel(
    key: str,
    kind: Kind,
    caption: str,
    along: _Axis,
    by: _Axis,
    *,
    choice: str,
    changes: Mapping[str, float] = _NO_CHANGES,
) -> Panel:
    """A panel over a parameter, with a line per value of a second parameter."""
    scene = replace(_BASE, name=f"fig-{key}").with_values(changes)
    along_name, along_values = along
    by_name, by_values = by
    lines = tuple(
        Line(scene.with_values({by_name: value}), along_name, tuple(along_values))
        for value in by_values
    )
    return Panel(key, caption, kind, lines, by_name, choice=choice)


def _equilibria(key: str, quantity: str, along: _Axis, by: _Axis) -> Panel:
    caption = f"Vertical displacement of the equilibrium against the {quantity}"
    choice = "lines and ranges are those of Figs. 3 to 7, the friction coefficient is 0.7"
    return _panel(key, "equilibrium", caption, along, by, choice=choice)


def _eigenvalues(key: str, condition: str, changes: Mapping[str, float]) -> Panel:
    caption = f"Frequencies and growth rates against the friction coefficient ({condition})"
    choice = f"{_NO_RANGE}; 0 to 2 shows every critical friction coefficient"
    return _panel(
        key, "eigenvalues", caption, _FRICTION, _BY_STIFFNESS, choice=choice, changes=changes
    )


def _critical(
    key: str, along: _Axis, by: _Axis, choice: str, changes: Mapping[str, float] = _NO_CHANGES
) -> Panel:
    quantity = "preload" if along is _PRELOADS else "cubic contact stiffness"
    condition = " (k1 = 50 N/m, k2 = 100 N/m)" if changes else ""
    caption = f"Critical friction coefficient against the {quantity}{condition}"
    return _panel(key, "critical mu", caption, along, by, choice=choice, changes=changes)


def _motion(key: str, meaning: str, column: str) -> Panel:
    lines = tuple(Line(case, "t") for case in _CASES)
    choice = "the start is not given; it is at rest in the static position"
    return Panel(key, f"{meaning} over time", "transient", lines, SEPARATION, column, choice)


def _amplitudes(key: str, along: _Axis, changes: Mapping[str, float], choice: str) -> Panel:
    parameter, values = along
    scenes = [replace(case, name=f"fig-{key}", tol=_AMPLITUDE_TOL) for case in _CASES]
    quantity = "preload" if parameter == "F" else "contact stiffness"
    return Panel(
        key,
        f"Peak of y and half peak-to-peak over the second half of the run against the {quantity}",
        "amplitude",
        tuple(Line(scene.with_values(changes), parameter, tuple(values)) for scene in scenes),
        SEPARATION,
        choice="start, range and the amplitude's definition are not given; static start, 100 s, "
        f"peak of |y| and half peak-to-peak of y over the second half of the run; {choice}",
    )


PANELS: Final[Mapping[str, Panel]] = {
    panel.key: panel
    for panel in (
        _equilibria("2a", "preload", _PRELOADS, _BY_STIFFNESS),
        _equilibria("2b", "cubic contact stiffness", _STIFFNESSES, _BY_PRELOAD),
        _eigenvalues("3", "F = 20 N", {"F": 20.0}),
        _eigenvalues("4", "F = 100 N", {"F": 100.0}),
        _eigenvalues("5", "F = 100 N, non-proportional damping", {"F": 100.0, "c1": 0.8}),
        _critical(
            "6",
            _PRELOADS,
            _BY_STIFFNESS_FIG_6,
            f"{_NO_RANGE}; 0 to 100 N shows that the critical friction exceeds that of the linear "
            "system at 500 N/m^3 alone",
        ),
        _critical(
            "7",
            _STIFFNESSES,
            _BY_PRELOAD,
            f"{_NO_RANGE}; it ends at the greatest stiffness of the text, 500 N/m^3",
        ),
        _critical(
            "8", _PRELOADS, _BY_STIFFNESS_FIG_6, "lines and range are those of Fig. 6", _SOFT
        ),
        _critical("9", _STIFFNESSES, _BY_PRELOAD, "lines and range are those of Fig. 7", _SOFT),
        _motion("10", "Contact force", "P"),
        _motion("11", "Horizontal displacement", "x"),
        _motion("12", "Vertical displacement", "y"),
        _amplitudes("13", ("F", _grid(60.0, 190.0, 66)), {"k_nl": 20.0, "mu": 0.5}, _UNSTABLE),
        _amplitudes("14", ("F", _grid(20.0, 110.0, 46)), {"k_nl": 100.0, "mu": 0.7}, _UNSTABLE),
        _amplitudes("15", _K_NL_VALUES, {"F": 40.0, "mu": 0.7}, _UNSTABLE),
        _amplitudes("16", _K_NL_VALUES, {"F": 60.0, "mu": 1.0}, "the range is that of Fig. 15"),
    )
}


def figure_panels(number: int) -> tuple[Panel, ...]:
    """The panels of a figure, 2 to 16, in order."""
    return tuple(panel for key, panel in PANELS.items() if key.rstrip("ab") == str(number))
