"""FMI 2.0 co-simulation of a component, as pythonfmu calls it.

The wrapper can pass on neither exceptions nor a status other than that of `do_step`: every entry
point catches exceptions, logs them and keeps the state as it was. The next `do_step` reports a
refused call by failing.
"""

import atexit
import logging
import math
import os
import sys
import traceback
from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import wraps
from pathlib import Path
from typing import Any, ClassVar, Final, TypeVar, cast

from pythonfmu.default_experiment import DefaultExperiment
from pythonfmu.enums import Fmi2Causality, Fmi2Initial, Fmi2Status, Fmi2Variability
from pythonfmu.fmi2slave import Fmi2Slave
from pythonfmu.variables import Boolean, Integer, Real

from fivtui.model.errors import ComputationError, InputError

from .experiment import SAME_TIME, Experiment
from .instance_state import InstanceState, Phase, from_bytes, to_bytes
from .variable import Role, Type, VariableTable

_Method = TypeVar("_Method", bound=Callable[..., Any])
# Python prints warnings and errors to standard error unless the host adds a handler.
LOGGER: Final = "fivtui.fmu"
_PRINTED: Final = 20
_DIFFERENT: Final = 1000
_UNPRINTED: Final = "further refusals are not printed here; switch on the FMU's debug logging"
_UNLOGGED: Final = f"refused, for another reason than the first {_DIFFERENT} that were logged"
# Paths of the wrapper's libraries: open handles would keep the host from unloading them. At exit
# the wrapper destroys its counter of interpreter uses, then decrements it in freed memory, which
# may abort the host. Calling its exported release function before that is safe, even repeatedly.
_libraries: Final[set[str]] = set()
# pythonfmu has no enumerations; the model description turns integers into them.
_MAKERS: Final = {
    Type.REAL: Real,
    Type.INTEGER: Integer,
    Type.ENUMERATION: Integer,
    Type.BOOLEAN: Boolean,
}
# Calls that only read or step: their refusal is not reported again by the next step.
_REPORTED_AT_ONCE: Final = {
    "_computed_step",
    "get_real",
    "get_integer",
    "get_boolean",
    "get_string",
    "_get_fmu_state",
}


def guarded(fallback: Callable[..., object]) -> Callable[[_Method], _Method]:
    """Decorator for an entry point: instead of raising it calls ``self.refuse(call, why)``.

    It then returns `fallback` of its arguments. `why` is the message of an `InputError` or
    `ComputationError`, else a traceback.
    """

    def decorate(method: _Method) -> _Method:
        @wraps(method)
        def call(self: Any, /, *args: Any) -> Any:
            try:
                return method(self, *args)
            except (InputError, ComputationError) as error:
                why = str(error)
            except BaseException:  # noqa: BLE001
                why = traceback.format_exc()
            self.refuse(method.__name__, why)
            return fallback(*args)

        return cast("_Method", call)

    return decorate


def nothing(*_: object) -> None:
    """Fallback for calls that return None."""


class Notices:
    """Messages of one instance: to the host's log, and always to standard error.

    Hosts show the log only if debug logging is on. The wrappers never free a logged text, so an
    instance logs few different ones, and equal ones are one object.
    """

    def __init__(self, instance: str) -> None:
        self._instance = instance
        self._printed = 0
        self._logged: set[str] = set()

    def print_text(self, level: int, text: str) -> str:
        """Print a text (a line or a traceback) to standard error, unless there were too many.

        `level` is one of Python's ``logging``. Returns the text as the wrapper's logger needs it.
        """
        if self._printed <= _PRINTED:
            self._print(level, text if self._printed < _PRINTED else _UNPRINTED)
            self._printed += 1
        if text not in self._logged:
            if len(self._logged) >= _DIFFERENT:
                text = _UNLOGGED
            self._logged.add(text)
        # Hosts use the message as a format string.
        return sys.intern(text.replace("%", "%%"))

    def _print(self, level: int, text: str) -> None:
        # Exceptions of the host's handlers must not leave an entry point of the FMU, either.
        with suppress(BaseException):
            logging.getLogger(LOGGER).log(
                level, "%s: %s", self._instance, text, extra={"fmu_instance": self._instance}
            )


def release_at_exit(resources: str | None) -> None:
    """Release the wrapper's libraries that are still loaded when the interpreter ends.

    They lie next to the FMU's folder of resources, whose path the host spells.
    """
    # Without arguments the interpreter is embedded, and the wrapper itself releases it in time.
    if resources is None or sys.platform != "linux" or not sys.orig_argv:
        return
    if not _libraries:
        # Imported here: an embedded interpreter may not find it, and does not need it.
        from ctypes import CDLL

        atexit.register(_release, CDLL)
    _libraries.update(map(str, Path(resources).parent.glob("binaries/linux64/*.so")))


def _release(load: Any) -> None:
    for path in _libraries:
        # A library that is not loaded, or does not export the function, is ignored.
        with suppress(OSError, AttributeError):
            load(path, mode=os.RTLD_NOLOAD | os.RTLD_LAZY).finalizePythonInterpreter()


class Instance(Fmi2Slave):  # type: ignore[misc]
    """One instance of a component, whose variables are `TABLE`.

    `description` is one sentence, `default` the experiment that it suggests, `kwargs` those of the
    wrapper.
    """

    TABLE: ClassVar[VariableTable]

    def __init__(self, description: str, default: DefaultExperiment, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        # The wrapper, which passes its logger, adds the FMU's folder to the host's path each time.
        if "logger" in kwargs and self.resources in sys.path:
            sys.path.remove(self.resources)
        release_at_exit(self.resources)
        self.author = "The fivtui developers"
        self.license = "MIT"
        self.description = description
        self.default_experiment = default
        table = self.TABLE
        self._phase = Phase.INSTANTIATED
        self._experiment: Experiment | None = None
        self._values: dict[int, float | bool] = {}
        self._stale = True
        # Times, s: reached, of the outputs, and up to which a step needs no computation.
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
        """Create the motion from the values, at the start time."""

    @abstractmethod
    def _move_on(self, end: float, experiment: Experiment) -> None:
        """Move on to a later time, s; on an exception, leave the motion where it is."""

    @abstractmethod
    def _publish(self) -> None:
        """Store the outputs at the time reached in the values."""

    def _remark(self) -> str:
        """Warning about the values at the end of initialization; empty if none."""
        return ""

    @abstractmethod
    def _motion_state(self) -> Any:
        """State of the motion, immutable, with its time as `t`."""

    @abstractmethod
    def _resume(
        self, values: dict[int, float | bool], experiment: Experiment, motion_state: Any
    ) -> None:
        """Return to a state of the motion."""

    @staticmethod
    @abstractmethod
    def _to_json(motion_state: Any) -> Any:
        """A state of the motion as JSON data."""

    @staticmethod
    @abstractmethod
    def _from_json(content: Any) -> Any:
        """A state of the motion from JSON data."""

    def refuse(self, call: int | str, why: str) -> None:
        """Log why a call is refused; unless it reads or steps, the next step reports it too.

        `call` is the value reference that was to be set, or the name of the call; `why` is a line
        or a traceback.
        """
        if call not in _REPORTED_AT_ONCE:
            self._refused[call] = why
            self._free_until = -math.inf
        self._log_text(Fmi2Status.error, logging.ERROR, why)

    def _log_text(self, status: Fmi2Status, level: int, text: str) -> None:
        # A constant: the wrapper may keep a reference to the category.
        category = "logStatusError" if status is Fmi2Status.error else "logStatusWarning"
        self.log(self._notices.print_text(level, text), status, category)

    @guarded(nothing)
    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Set start time, stop time, s, and tolerance of the run."""
        self._require("setup_experiment", Phase.INSTANTIATED)
        self._experiment = Experiment.checked(
            start_time,
            stop_time,
            tolerance,
            lambda text: self._log_text(Fmi2Status.warning, logging.WARNING, text),
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
        if remark := self._remark():
            self._log_text(Fmi2Status.warning, logging.WARNING, remark)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Move on by one communication step, s. Returns False if the step is refused."""
        # Most steps end within a Taylor step, where nothing is computed until outputs are read.
        # They need no guard: the wrapper passes floats, whose comparison cannot raise.
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
        self._move_on(end, experiment)
        self._t = end
        return True

    @guarded(nothing)
    def terminate(self) -> None:
        """End the run; values can still be read."""
        # The wrapper cannot report a refused initialization: a host may continue, then terminate.
        if self._phase is Phase.TERMINATED or "exit_initialization_mode" not in self._refused:
            self._require("terminate", Phase.STEPPING)
        self._free_until = -math.inf
        self._phase = Phase.TERMINATED

    @guarded(lambda vrs: [math.nan] * len(vrs))
    def get_real(self, vrs: Sequence[int]) -> list[float]:
        """Values of variables of any type as numbers."""
        return [float(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [0] * len(vrs))
    def get_integer(self, vrs: Sequence[int]) -> list[int]:
        """Values of variables of any type as integers; 0 if there is none yet."""
        return [0 if math.isnan(value) else int(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [False] * len(vrs))
    def get_boolean(self, vrs: Sequence[int]) -> list[bool]:
        """Values of variables of any type as booleans; False if there is none yet."""
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
        """Refuse: no variable of type Integer can be set."""
        self._set(vrs, values, Type.INTEGER)

    @guarded(nothing)
    def set_boolean(self, vrs: Sequence[int], values: Sequence[bool]) -> None:
        """Set parameters of type Boolean."""
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
            # No motion exists for the refused values: outputs are NaN.
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
        # Sets all values or none; a valid value cancels the refusal of an earlier one.
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
            # Steps not yet computed are computed with the old inputs.
            self._free_until = -math.inf
            self._motion_state()
            self._values.update(accepted)
            self._publish_now()

    def _checked(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = self.TABLE.check_settable(reference, kind, value)
        variable = self.TABLE.variables[reference]
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
