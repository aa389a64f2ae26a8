"""A component's side of FMI 2.0 co-simulation, as pythonfmu calls it: calls, values, refusals.

The wrapper around these classes cannot carry an exception, nor a status other than that of
`do_step`: every entry point catches what is raised inside, logs it and keeps the state as it was,
and what a call refused is reported by the next `do_step`, which then fails.
"""

import logging
import math
import sys
import traceback
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, Final

from pythonfmu import (
    Boolean,
    DefaultExperiment,
    Fmi2Causality,
    Fmi2Initial,
    Fmi2Slave,
    Fmi2Variability,
    Integer,
    Real,
)
from pythonfmu.enums import Fmi2Status

from fivtui.model.errors import InputError

from .experiment import SAME_TIME, Experiment
from .guard import guarded, nothing
from .instance_state import InstanceState, Phase, from_bytes, to_bytes
from .notices import Notices
from .process_end import let_go_in_time
from .variable import Role, Type, VariableTable

# pythonfmu has no enumerations; the model description makes them of integers.
_MAKERS: Final = {
    Type.REAL: Real,
    Type.INTEGER: Integer,
    Type.ENUMERATION: Integer,
    Type.BOOLEAN: Boolean,
}
# Calls whose refusal changes nothing that a host could rely on afterwards.
_REPORTED_AT_ONCE: Final = {
    "_computed_step",
    "get_real",
    "get_integer",
    "get_boolean",
    "get_string",
    "_get_fmu_state",
}


class Instance(Fmi2Slave):  # type: ignore[misc]
    """One instance of a component.

    Parameters
    ----------
    table : VariableTable
        Its variables.
    description : str
        What it is, in one sentence.
    default : DefaultExperiment
        The run that it suggests.
    **kwargs
        What the wrapper knows of the instance.
    """

    def __init__(
        self, table: VariableTable, description: str, default: DefaultExperiment, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        # The wrapper, which passes its logger, has put the FMU's folder on the host's path again.
        if "logger" in kwargs and self.resources in sys.path:
            sys.path.remove(self.resources)
        let_go_in_time(self.resources)
        self.author = "The fivtui developers"
        self.license = "MIT"
        self.description = description
        self.default_experiment = default
        self._table = table
        self._phase = Phase.INSTANTIATED
        self._experiment: Experiment | None = None
        self._values: dict[int, float | bool] = {}
        self._stale = True
        # The time reached, that of the outputs, and up to where a step computes nothing.
        self._t, self._published, self._free_until = 0.0, 0.0, -math.inf
        self._refused: dict[int | str, str] = {}
        self._notices = Notices(self.instance_name)
        self._undefined = {r: math.nan for r, v in enumerate(table.variables) if not v.settable}
        for reference, variable in enumerate(table.variables):
            self._values[reference] = variable.start
            self.register_variable(
                _MAKERS[variable.type](
                    variable.name,
                    causality=Fmi2Causality[variable.role.value],
                    description=variable.meaning,
                    variability=Fmi2Variability[variable.variability],
                    initial=variable.initial and Fmi2Initial[variable.initial],
                )
            )

    @abstractmethod
    def _begin_motion(self, experiment: Experiment) -> None:
        """Make the motion that the values describe, at the start time."""

    @abstractmethod
    def _go_on(self, end: float, experiment: Experiment) -> None:
        """Take the motion from the time reached to a later one, or leave it where it is."""

    @abstractmethod
    def _publish(self) -> None:
        """Put the outputs at the time reached into the values."""

    @abstractmethod
    def _motion_state(self) -> Any:
        """Where the motion is, as a value that never changes."""

    @abstractmethod
    def _resume(
        self, values: dict[int, float | bool], experiment: Experiment, motion_state: Any
    ) -> None:
        """Take the motion to where one of these values was."""

    @staticmethod
    @abstractmethod
    def _to_json(motion_state: Any) -> Any:
        """A motion_state as JSON can hold it."""

    @staticmethod
    @abstractmethod
    def _from_json(content: Any) -> Any:
        """A motion_state from what JSON holds."""

    def refuse(self, call: int | str, why: str) -> None:
        """Tell why a call is refused; unless it reads or steps, the next step reports it too.

        Parameters
        ----------
        call : int or str
            Value reference that was to be set, or name of the call.
        why : str
            A line, or a traceback.
        """
        if call not in _REPORTED_AT_ONCE:
            self._refused[call] = why
            self._free_until = -math.inf
        self._tell(Fmi2Status.error, logging.ERROR, why)

    def _tell(self, status: Fmi2Status, level: int, text: str) -> None:
        # A category that is given is one object, which the wrapper may keep.
        category = "logStatusError" if status is Fmi2Status.error else "logStatusWarning"
        self.log(self._notices.tell(level, text), status, category)

    @guarded(nothing)
    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Take the start time, the stop time and the tolerance of the run."""
        self._require("setup_experiment", Phase.INSTANTIATED)
        self._experiment = Experiment.checked(
            start_time,
            stop_time,
            tolerance,
            lambda text: self._tell(Fmi2Status.warning, logging.WARNING, text),
        )
        self._stale = True
        self._refused.pop("setup_experiment", None)

    @guarded(nothing)
    def enter_initialization_mode(self) -> None:
        """Begin the initialization."""
        self._require("enter_initialization_mode", Phase.INSTANTIATED)
        if self._experiment is None:
            raise InputError("enter_initialization_mode is not allowed before setup_experiment")
        self._phase = Phase.INITIALIZATION
        self._refused.pop("enter_initialization_mode", None)

    @guarded(nothing)
    def exit_initialization_mode(self) -> None:
        """Fix the parameters and begin the motion."""
        self._require("exit_initialization_mode", Phase.INITIALIZATION)
        self._refused.pop("exit_initialization_mode", None)
        if self._refused:
            raise InputError("not initialized: " + "; ".join(self._refused.values()))
        self._begin()
        self._phase = Phase.STEPPING

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Go on by one communication step."""
        # Most steps end inside of a Taylor step, where nothing is to be computed until it is read.
        # They pay for no guard: the wrapper passes floats, whose comparison cannot fail.
        t, end = self._t, current_time + step_size
        if (
            t < end < self._free_until
            and step_size > 0.0
            and -SAME_TIME <= current_time - t <= SAME_TIME
        ):
            self._t = end
            return True
        return self._computed_step(current_time, step_size)

    @guarded(lambda *_: False)
    def _computed_step(self, current_time: float, step_size: float) -> bool:
        if self._refused:
            # The first refusal is the cause of those that follow it.
            why = next(iter(self._refused.values()))
            if self._phase is Phase.STEPPING:
                self._refused.clear()
            raise InputError(f"the step is not taken: {why}")
        self._require("do_step", Phase.STEPPING)
        experiment = self._experiment or Experiment()
        end = experiment.end_of_step(self._t, current_time, step_size)
        self._go_on(end, experiment)
        self._t = end
        return True

    @guarded(nothing)
    def terminate(self) -> None:
        """End the run; the values stay readable."""
        self._free_until = -math.inf
        self._phase = Phase.TERMINATED

    @guarded(lambda vrs: [math.nan] * len(vrs))
    def get_real(self, vrs: Sequence[int]) -> list[float]:
        """Values of variables of any type as numbers."""
        return [float(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [0] * len(vrs))
    def get_integer(self, vrs: Sequence[int]) -> list[int]:
        """Values of variables of any type as integers; 0 where there is none yet."""
        return [0 if math.isnan(value) else int(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [False] * len(vrs))
    def get_boolean(self, vrs: Sequence[int]) -> list[bool]:
        """Values of variables of any type as truth values; false where there is none yet."""
        return [not math.isnan(value) and bool(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [""] * len(vrs))
    def get_string(self, vrs: Sequence[int]) -> list[str]:
        """Refuse: no variable is a string."""
        raise InputError(f"value references {list(vrs)}: no variable is of type String")

    @guarded(nothing)
    def set_real(self, vrs: Sequence[int], values: Sequence[float]) -> None:
        """Set parameters and inputs."""
        self._set(vrs, values, Type.REAL)

    @guarded(nothing)
    def set_integer(self, vrs: Sequence[int], values: Sequence[int]) -> None:
        """Refuse: no variable that can be set is an integer."""
        self._set(vrs, values, Type.INTEGER)

    @guarded(nothing)
    def set_boolean(self, vrs: Sequence[int], values: Sequence[bool]) -> None:
        """Set the switches of the model."""
        self._set(vrs, values, Type.BOOLEAN)

    @guarded(nothing)
    def set_string(self, vrs: Sequence[int], values: Sequence[str]) -> None:
        """Refuse: no variable is a string."""
        raise InputError(f"{dict(zip(vrs, values, strict=True))}: no variable is of type String")

    @guarded(nothing)
    def _get_fmu_state(self) -> InstanceState | None:
        motion_state = None if self._stale else self._motion_state()
        if motion_state is not None:
            self._publish_now()
        return InstanceState(
            self._phase, self._experiment, tuple(self._values.values()), motion_state
        )

    @guarded(nothing)
    def _set_fmu_state(self, state: InstanceState | str | None) -> None:
        if not isinstance(state, InstanceState):
            raise InputError(state or "there is no such FMU state")
        values = dict(enumerate(state.values))
        if state.motion_state is not None:
            self._resume(values, state.experiment or Experiment(), state.motion_state)
            self._t = state.motion_state.t
        self._phase, self._experiment = state.phase, state.experiment
        self._values, self._stale = values, state.motion_state is None
        self._published, self._free_until = self._t, -math.inf
        self._refused.clear()

    @classmethod
    def _fmu_state_to_bytes(cls, state: InstanceState | str) -> bytes:
        return to_bytes(state, cls._to_json) if isinstance(state, InstanceState) else b""

    @classmethod
    def _fmu_state_from_bytes(cls, state: bytes) -> InstanceState | str:
        try:
            return from_bytes(state, cls._from_json)
        except InputError as error:
            return str(error)
        except BaseException:  # noqa: BLE001
            return traceback.format_exc()

    def _require(self, call: str, phase: Phase) -> None:
        if self._phase is not phase:
            raise InputError(f"{call} is not allowed {self._phase.value}")

    def _read(self, vrs: Sequence[int]) -> list[float | bool]:
        values = self._values
        if self._refused and self._phase in (Phase.INSTANTIATED, Phase.INITIALIZATION):
            # There is no motion with the values that the host has set: nothing that looks like one.
            values = values | self._undefined
        elif self._stale:
            self._begin()
        elif self._t != self._published:
            self._publish_now()
        try:
            return [values[reference] for reference in vrs]
        except KeyError as unknown:
            raise InputError(f"value reference {unknown}: there is no such variable") from None

    def _set(self, vrs: Sequence[int], values: Sequence[object], kind: Type) -> None:
        # All of a call or nothing; a valid value takes back the refusal of an earlier one.
        accepted: dict[int, float | bool] = {}
        refused: dict[int, str] = {}
        for reference, value in zip(vrs, values, strict=True):
            try:
                accepted[reference] = self._checked(reference, kind, value)
            except InputError as error:
                refused[reference] = str(error)
        for reference, why in refused.items():
            self.refuse(reference, why)
        if refused:
            return
        for reference in accepted:
            self._refused.pop(reference, None)
        if self._phase is not Phase.STEPPING:
            self._values.update(accepted)
            self._stale = True
        elif any(self._values[reference] != value for reference, value in accepted.items()):
            # What has been left uncomputed belongs to the inputs until now.
            self._free_until = -math.inf
            self._motion_state()
            self._values.update(accepted)
            self._publish_now()

    def _checked(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = self._table.check_settable(reference, kind, value)
        variable = self._table.variables[reference]
        fixed = variable.role is Role.PARAMETER and self._phase is Phase.STEPPING
        if fixed or self._phase is Phase.TERMINATED:
            raise InputError(f"{variable.name} cannot be set {self._phase.value}")
        return checked

    def _begin(self) -> None:
        experiment = self._experiment or Experiment()
        self._begin_motion(experiment)
        self._t, self._stale = experiment.start_time, False
        self._publish_now()

    def _publish_now(self) -> None:
        self._publish()
        self._published = self._t
