"""A brake actuator: the preload follows a commanded force, with a lag and with feedback.

    tau dF/dt = command + gain (command − P) − F

Inputs are held over a communication step, so that the solution is an exact exponential and does not
depend on the step size.
"""

import math
from typing import Any, Final, NamedTuple

from pythonfmu.default_experiment import DefaultExperiment

from fivtui.model.advice import advise_one_of
from fivtui.model.errors import ComputationError
from fivtui.taylor.stepper import DEFAULT_TOL

from .actuator_variables import ACTUATOR_SUMMARY, ACTUATOR_TABLE
from .experiment import Experiment
from .instance import Instance

# Value references of the variables.
_COMMAND, _FEEDBACK, _TAU, _GAIN, _F_START, _F, _RATE = (
    ACTUATOR_TABLE.references[name]
    for name in ("command", "P", "tau", "gain", "F_start", "F", "F_rate")
)
# Remedies for a preload that overflows: without and with feedback of the contact force.
_REMEDIES: Final = ("a smaller command",)
_FEEDBACK_REMEDIES: Final = (*_REMEDIES, "a smaller gain", "a smaller contact force")


class ActuatorState(NamedTuple):
    """State of an actuator: time, s, and preload, N."""

    t: float
    F: float


class BrakeActuator(Instance):
    """One instance of the brake actuator."""

    TABLE = ACTUATOR_TABLE

    def __init__(self, **kwargs: Any) -> None:
        default = DefaultExperiment(
            start_time=0.0, stop_time=100.0, step_size=0.01, tolerance=DEFAULT_TOL
        )
        super().__init__(ACTUATOR_SUMMARY, default, **kwargs)
        self._state = ActuatorState(0.0, 0.0)

    def _create_motion(self, experiment: Experiment) -> None:
        self._state = ActuatorState(experiment.start_time, self._values[_F_START])

    def _advance(self, end: float, _experiment: Experiment) -> None:
        target = self._target_force()
        decay = math.exp((self._state.t - end) / self._values[_TAU])
        force = target + (self._state.F - target) * decay
        if not math.isfinite(force):
            raise ComputationError(
                f"the preload grows beyond the floating-point range at t = {end:.6g} s",
                advise_one_of(_FEEDBACK_REMEDIES if self._values[_GAIN] > 0.0 else _REMEDIES),
            )
        self._state = ActuatorState(end, force)

    def _store_outputs(self) -> None:
        self._values[_F] = self._state.F
        self._values[_RATE] = (self._target_force() - self._state.F) / self._values[_TAU]

    def _target_force(self) -> float:
        # The preload that the actuator approaches under constant inputs, N.
        values = self._values
        return values[_COMMAND] + values[_GAIN] * (values[_COMMAND] - values[_FEEDBACK])

    def _motion_state(self) -> ActuatorState:
        return self._state

    def _restore_motion(
        self, _values: dict[int, float | bool], _experiment: Experiment, motion_state: ActuatorState
    ) -> None:
        self._state = motion_state

    @staticmethod
    def _to_json(motion_state: ActuatorState) -> Any:
        return motion_state

    @staticmethod
    def _from_json(content: Any) -> ActuatorState:
        return ActuatorState(*content)
