"""Scenes: what to compute, by name."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Self

from fivtui.distributions import Distribution, truncate_at_bounds
from fivtui.model import (
    InputError,
    Parameters,
    System,
    build_course,
    check_known,
    check_names,
    check_parameters,
    check_separation,
    initial_values,
)
from fivtui.transient import (
    ALL_METHODS,
    DEFAULT_T_END,
    DEFAULT_TOL,
    VARIABLES,
    Accuracy,
    Request,
    Start,
    check_accuracy,
    check_horizon,
    check_start,
    check_step,
    check_tolerance,
    check_uses_step,
)

from .over_time import OverTime

# Correlations: names of two scattered quantities, and the coefficient.
Correlation = tuple[tuple[str, str, float], ...]
# Names of scattered quantities, with their distributions.
Distributions = tuple[tuple[str, Distribution], ...]

# Greatest lengths of name and description, characters.
_MAX_NAME: Final = 255
_MAX_DESCRIPTION: Final = 2000

# Fields that a scene shares with a request for a transient.
_REQUEST_FIELDS: Final = ("t_end", "tol", "start", "method", "step")

# Outputs that a scene can require, with their meanings.
OUTPUTS: Final = {
    "stability": "equilibrium, eigenvalues and critical friction coefficient",
    "transient": "extremes, events and final state",
    "trajectory": "the motion over time",
}


@dataclass(frozen=True, slots=True)
class Scene:
    """A named set of parameters with the settings of its transient.

    Attributes
    ----------
    name, description : str
        One line of printable characters each; the name is not empty.
    parameters : Parameters
        The parameter set.
    separation : bool
        Whether separation is considered (the paper's Case 1) or ignored (Case 2).
    start : "static" or tuple of four floats
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s.
    t_end : float
        Horizon, s; at most 1e7.
    tol : float
        Relative tolerance of the variable-step methods, 1e-13 to 1e-2.
    method : str
        A name in `ALL_METHODS`.
    step : float or None
        Step of a fixed-step method, communication step of the FMU, s; None for its default.
    accuracy : tuple of (str, float)
        Error targets by quantity, see `fivtui.transient.errors.check_accuracy`. `tol` and `step`
        are then not used.
    outputs : tuple of str
        Names in `OUTPUTS`; only these are computed and stored.
    scatter : tuple of (str, Distribution)
        Distributions of parameters, and of ``x0``, ``vx0``, ``y0``, ``vy0`` of the start, from
        which an uncertainty study draws; anything else is computed at the values of the scene.
    correlation : tuple of (str, str, float)
        Correlations of two quantities that an uncertainty study draws at random: those of their
        normal scores (a Gaussian copula).
    over_time : tuple of (str, TimeTable)
        Parameters that follow tables; `parameters` gets their values at the start.

    Raises
    ------
    InputError
        If a value is not allowed.

    Examples
    --------
    >>> from fivtui import Parameters, Scene
    >>> Scene(name="mine", description="half the preload", parameters=Parameters(F=40.0)).t_end
    100.0
    """

    name: str
    description: str
    parameters: Parameters
    separation: bool = True
    start: Start = "static"
    t_end: float = DEFAULT_T_END
    tol: float = DEFAULT_TOL
    method: str = "taylor"
    step: float | None = None
    accuracy: Accuracy = ()
    outputs: tuple[str, ...] = ("stability", "transient")
    scatter: Distributions = ()
    correlation: Correlation = ()
    over_time: OverTime = ()

    def __post_init__(self) -> None:
        _check_line("name", self.name, _MAX_NAME)
        _check_line("description", self.description, _MAX_DESCRIPTION)
        if not self.name.strip():
            raise InputError("name is empty: must be one line of printable characters")
        check_known("method", self.method, ALL_METHODS)
        if self.step is not None:
            check_uses_step(self.method)
        p, over_time = check_parameters(self.parameters), dict(self.over_time)
        if over_time:
            p = build_course(p, over_time).initial
        t_end = check_horizon(self.t_end)
        checked = {
            "parameters": p,
            "separation": check_separation(self.separation),
            "t_end": t_end,
            "tol": check_tolerance(self.tol),
            "step": None if self.step is None else check_step(self.step, t_end),
            # A static start that does not exist is refused when the scene is computed.
            "start": check_start(self.start),
            "accuracy": tuple(check_accuracy(dict(self.accuracy)).items()),
        }
        for name, distribution in self.scatter:
            truncate_at_bounds(name, distribution, VARIABLES)
            if distribution != Distribution(distribution.name, distribution.numbers):
                raise InputError(f"scatter of {name}: must not be truncated; its bounds do that")
        if len(dict(self.scatter)) < len(self.scatter):
            raise InputError("scatter: every name must be given once")
        for first, second, correlation in self.correlation:
            _check_correlation(first, second, correlation)
        for name in check_names("outputs", self.outputs):
            check_known("output", name, OUTPUTS)
        for key, value in checked.items():
            object.__setattr__(self, key, value)

    @property
    def system(self) -> System:
        """The system, with tables over time."""
        return System(self.parameters, self.separation, dict(self.over_time))

    def request(self, **changes: Any) -> Request:
        """The request for the transient of this scene, with changes to its fields."""
        fields: dict[str, Any] = {key: getattr(self, key) for key in _REQUEST_FIELDS}
        return Request(self.system, **(fields | changes))

    def check_constant(self, subject: str) -> None:
        """Raise `InputError` if a parameter changes with time; the message names the `subject`."""
        if self.over_time:
            names = ", ".join(name for name, _ in self.over_time)
            raise InputError(
                f"{names} over time: must be constant for {subject}; simulate and sweep take tables"
            )

    def with_values(self, values: Mapping[str, object], over_time: OverTime = ()) -> Self:
        """A checked copy with new values by parameter name; `InputError` as for `Parameters`.

        The tables of `over_time` replace those of the same parameters.
        """
        tables = dict(self.over_time) | dict(over_time)
        for name in tables:
            if name in values:
                raise InputError(f"{name}: follows a table over time; must not be set")
        # `mu_s` is compared with the values of the tables, not with those they replace.
        p = self.parameters.with_values({**initial_values(tables), **values})
        return dataclasses.replace(self, parameters=p, over_time=tuple(tables.items()))


def _check_correlation(first: str, second: str, value: float) -> None:
    for name in (first, second):
        check_known("correlated name", name, VARIABLES)
    if first == second or not -1.0 < value < 1.0:
        raise InputError(
            f"correlation of {first} and {second} = {value:g}: must be of two names, between "
            "-1 and 1"
        )


def _check_line(key: str, text: str, max_length: int) -> None:
    if not text.isprintable():
        raise InputError(f"{key} = {text!r}: must be one line of printable characters")
    if len(text) > max_length:
        raise InputError(f"{key}: must be of at most {max_length} characters, not {len(text)}")


def make_scene(source: Scene | Parameters | None, **changes: object) -> Scene:
    """A scene, or parameters as a scene, with the changes that are not None."""
    if not isinstance(source, Scene):
        p = Parameters() if source is None else check_parameters(source)
        source = Scene(name="unnamed", description="", parameters=p)
    updates: dict[str, Any] = {key: value for key, value in changes.items() if value is not None}
    return dataclasses.replace(source, **updates)
