"""An instance of a Python FMU for co-simulation, FMI 2.0, as pythonfmu's wrapper calls it.

The host calls the wrapper, a library in C, which calls the methods of the instance. The wrapper
passes no exceptions to the host, and no status except that of `do_step`. So every method catches
exceptions, logs them and leaves the state unchanged; after such a refusal the next `do_step` fails.
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

from .experiment import TIME_TOLERANCE, Experiment
from .instance_state import InstanceState, Phase, from_bytes, to_bytes
from .variable import Type, VariableTable

_Method = TypeVar("_Method", bound=Callable[..., Any])
# Python prints warnings and errors to standard error unless the host adds a handler.
LOGGER: Final = "fivtui.fmu"
# Greatest numbers of printed messages and of different logged texts, per instance.
_PRINT_LIMIT: Final = 20
_TEXT_LIMIT: Final = 1000
_MUTED_TEXT: Final = "further messages are not printed; enable the FMU's debug logging to see them"
_OVERFLOW_TEXT: Final = f"refused; only the first {_TEXT_LIMIT} different messages are logged"
# Paths of the wrapper's libraries. At exit each library frees its counter of interpreter uses, then
# decrements it in the freed memory, which may abort the host. If `finalizePythonInterpreter` was
# called before, the library has no counter to decrement at exit. Open handles in place of paths
# would keep the host from unloading the libraries.
_libraries: Final[set[str]] = set()
# pythonfmu has no enumerations; the model description turns integers into them.
_VARIABLE_CLASSES: Final = {
    Type.REAL: Real,
    Type.INTEGER: Integer,
    Type.ENUMERATION: Integer,
    Type.BOOLEAN: Boolean,
}
# Methods whose refusal does not make the next step fail: they only read or step.
_REPORTED_ONCE: Final = {
    "_compute_step",
    "get_real",
    "get_integer",
    "get_boolean",
    "get_string",
    "_get_fmu_state",
}


def refuse_on_error(fallback: Callable[..., object]) -> Callable[[_Method], _Method]:
    """Decorate a method: instead of raising an exception, it refuses the call.

    It then calls ``self.refuse(name, reason)`` and returns `fallback(*args)`. The reason is the
    message of an `InputError` or `ComputationError`, else a traceback.
    """

    def decorate(method: _Method) -> _Method:
        @wraps(method)
        def call(self: Any, /, *args: Any) -> Any:
            try:
                return method(self, *args)
            except (InputError, ComputationError) as error:
                reason = str(error)
            except BaseException:  # noqa: BLE001
                reason = traceback.format_exc()
            self.refuse(method.__name__, reason)
            return fallback(*args)

        return cast("_Method", call)

    return decorate


def return_none(*_: object) -> None:
    """The fallback of methods without a result."""


class MessageLog:
    """The messages of one instance, for the host's log and on standard error.

    Hosts show the log only if debug logging is on, so messages are printed too. The wrapper never
    frees a logged text, so the number of different texts is limited, and equal texts share memory.
    """

    def __init__(self, instance: str) -> None:
        self._instance = instance
        self._text_count = 0
        self._logged: set[str] = set()

    def print_text(self, level: int, text: str) -> str:
        """Print a line or a traceback to standard error, up to a limit of texts.

        `level` is one of Python's ``logging``. Returns the text escaped for the wrapper's logger.
        """
        if self._text_count < _PRINT_LIMIT:
            self._print(level, text)
        elif self._text_count == _PRINT_LIMIT:
            self._print(level, _MUTED_TEXT)
        self._text_count += 1
        if text not in self._logged:
            if len(self._logged) >= _TEXT_LIMIT:
                text = _OVERFLOW_TEXT
            self._logged.add(text)
        # Hosts use the message as a format string.
        return sys.intern(text.replace("%", "%%"))

    def _print(self, level: int, text: str) -> None:
        # Exceptions of the host's logging handlers must not reach the wrapper.
        with suppress(BaseException):
            logging.getLogger(LOGGER).log(
                level, "%s: %s", self._instance, text, extra={"fmu_instance": self._instance}
            )


def release_at_exit(resources: str | None) -> None:
    """Arrange that the wrapper's libraries give up the interpreter when it ends, see `_libraries`.

    The libraries are in a folder beside the FMU's folder of resources.
    """
    # An interpreter that was not started as a program has no arguments: it is embedded in a host,
    # and the wrapper ends it itself.
    if resources is None or sys.platform != "linux" or not sys.orig_argv:
        return
    if not _libraries:
        # Imported late: an embedded interpreter may not find ctypes, and does not need it.
        from ctypes import CDLL

        atexit.register(_release, CDLL)
    _libraries.update(map(str, Path(resources).parent.glob("binaries/linux64/*.so")))


def _release(load_library: Any) -> None:
    for path in _libraries:
        # A library that is not loaded, or does not export the function, is ignored.
        with suppress(OSError, AttributeError):
            load_library(path, mode=os.RTLD_NOLOAD | os.RTLD_LAZY).finalizePythonInterpreter()


class Instance(Fmi2Slave):  # type: ignore[misc]
    """Base of the instances of all components.

    `TABLE` are the variables of the component; a value reference is an index in it. `description`
    is one sentence on the model, `default` its default experiment, `kwargs` are the arguments that
    the wrapper passes.
    """

    TABLE: ClassVar[VariableTable]

    def __init__(self, description: str, default: DefaultExperiment, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        # Remove the FMU's folder, which the wrapper adds to the path again for each instance; only
        # the wrapper passes `logger`.
        if "logger" in kwargs and self.resources in sys.path:
            sys.path.remove(self.resources)
        release_at_exit(self.resources)
        self.description = description
        self.default_experiment = default
        table = self.TABLE
        self._phase = Phase.INSTANTIATED
        self._experiment: Experiment | None = None
        # Values of all variables by value reference.
        self._values: dict[int, float | bool] = {}
        # Whether the motion must begin anew from the values.
        self._needs_motion = True
        # Times, s: current, of the outputs, and up to which steps take the fast path.
        self._t, self._output_time, self._fast_until = 0.0, 0.0, -math.inf
        # Reasons of refusals since the last step, by value reference or name of the method.
        self._refused: dict[int | str, str] = {}
        self._message_log = MessageLog(self.instance_name)
        self._nan_outputs = {
            reference: math.nan
            for reference, variable in enumerate(table.variables)
            if not variable.settable
        }
        for reference, variable in enumerate(table.variables):
            self._values[reference] = variable.start
            self.register_variable(
                _VARIABLE_CLASSES[variable.type](
                    variable.name,
                    causality=Fmi2Causality[variable.role.value],
                    description=variable.meaning,
                    variability=Fmi2Variability[variable.variability],
                    initial=variable.initial and Fmi2Initial[variable.initial],
                )
            )

    @abstractmethod
    def _create_motion(self, experiment: Experiment) -> None:
        """Create the motion at the start time from the values of parameters and inputs."""

    @abstractmethod
    def _advance(self, end: float, experiment: Experiment) -> None:
        """Advance to a later time, s; on an exception, leave the motion unchanged."""

    @abstractmethod
    def _store_outputs(self) -> None:
        """Store the outputs at the current time in the values."""

    def _apply_values(self, values: dict[int, float | bool]) -> None:
        """Use values from now on; raise `InputError` if they contradict each other."""

    def _initialization_warning(self) -> str:
        """Warning about the values, logged at the end of initialization; empty if there is none."""
        return ""

    @abstractmethod
    def _motion_state(self) -> Any:
        """Compute the motion up to now and return its state, immutable, with its time as `t`."""

    @abstractmethod
    def _restore_motion(
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

    def refuse(self, call: int | str, reason: str) -> None:
        """Log why a call is refused, and unless it only reads or steps, make the next step fail.

        `call` is the value reference of a refused value or the name of a method, `reason` a line or
        a traceback.
        """
        if call not in _REPORTED_ONCE:
            self._refused[call] = reason
            self._fast_until = -math.inf
        self._log_text(Fmi2Status.error, logging.ERROR, reason)

    def _log_text(self, status: Fmi2Status, level: int, text: str) -> None:
        # The category is a constant, because the wrapper may keep a reference to it.
        category = "logStatusError" if status is Fmi2Status.error else "logStatusWarning"
        self.log(self._message_log.print_text(level, text), status, category)

    @refuse_on_error(return_none)
    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Set start time, stop time, s, and tolerance of the run."""
        self._require_phase("setup_experiment", Phase.INSTANTIATED)
        self._experiment = Experiment.from_host(
            start_time,
            stop_time,
            tolerance,
            lambda text: self._log_text(Fmi2Status.warning, logging.WARNING, text),
        )
        self._needs_motion = True
        self._refused.pop("setup_experiment", None)

    @refuse_on_error(return_none)
    def enter_initialization_mode(self) -> None:
        """Begin the initialization."""
        self._require_phase("enter_initialization_mode", Phase.INSTANTIATED)
        if self._experiment is None:
            raise InputError(
                "enter_initialization_mode is not allowed before setup_experiment; call it first"
            )
        self._phase = Phase.INITIALIZATION
        self._refused.pop("enter_initialization_mode", None)

    @refuse_on_error(return_none)
    def exit_initialization_mode(self) -> None:
        """Fix the parameters and begin the motion."""
        self._require_phase("exit_initialization_mode", Phase.INITIALIZATION)
        self._refused.pop("exit_initialization_mode", None)
        if self._refused:
            raise InputError("not initialized: " + "; ".join(self._refused.values()))
        self._begin()
        self._apply_values(self._values)
        self._phase = Phase.STEPPING
        if warning := self._initialization_warning():
            self._log_text(Fmi2Status.warning, logging.WARNING, warning)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance by one communication step, s; return False if the step is refused."""
        # Fast path: most steps end within a Taylor step, and need no computation until outputs are
        # read. Nothing here can raise an exception, because the wrapper passes floats.
        t, end = self._t, current_time + step_size
        if (
            t < end < self._fast_until
            and step_size > 0.0
            and -TIME_TOLERANCE <= current_time - t <= TIME_TOLERANCE
        ):
            self._t = end
            return True
        return self._compute_step(current_time, step_size)

    @refuse_on_error(lambda *_: False)
    def _compute_step(self, current_time: float, step_size: float) -> bool:
        if self._refused:
            # The first refusal is the cause of the later ones.
            reason = next(iter(self._refused.values()))
            advice = "correct it, and initialize again"
            if self._phase is Phase.STEPPING:
                self._refused.clear()
                advice = "repeat the step to go on with the values before"
            raise InputError(f"the step is refused: {reason}; {advice}")
        self._require_phase("do_step", Phase.STEPPING)
        experiment = self._experiment or Experiment()
        end = experiment.end_of_step(self._t, current_time, step_size)
        self._advance(end, experiment)
        self._t = end
        return True

    @refuse_on_error(return_none)
    def terminate(self) -> None:
        """End the run; values can still be read."""
        # The wrapper cannot report a refused initialization: the host may continue and terminate.
        has_failed_to_start = (
            self._phase is not Phase.TERMINATED and "exit_initialization_mode" in self._refused
        )
        if not has_failed_to_start:
            self._require_phase("terminate", Phase.STEPPING)
        self._fast_until = -math.inf
        self._phase = Phase.TERMINATED

    @refuse_on_error(lambda references: [math.nan] * len(references))
    def get_real(self, references: Sequence[int]) -> list[float]:
        """Values of variables of any type as numbers."""
        return [float(value) for value in self._read(references)]

    @refuse_on_error(lambda references: [0] * len(references))
    def get_integer(self, references: Sequence[int]) -> list[int]:
        """Values of variables of any type as integers; 0 before the first result."""
        return [0 if math.isnan(value) else int(value) for value in self._read(references)]

    @refuse_on_error(lambda references: [False] * len(references))
    def get_boolean(self, references: Sequence[int]) -> list[bool]:
        """Values of variables of any type as booleans; False before the first result."""
        return [not math.isnan(value) and bool(value) for value in self._read(references)]

    @refuse_on_error(lambda references: [""] * len(references))
    def get_string(self, references: Sequence[int]) -> list[str]:
        """Refuse: no variable is a string."""
        raise InputError(f"value references {list(references)}: no variable is of type String")

    @refuse_on_error(return_none)
    def set_real(self, references: Sequence[int], values: Sequence[float]) -> None:
        """Set parameters and inputs."""
        self._set(references, values, Type.REAL)

    @refuse_on_error(return_none)
    def set_integer(self, references: Sequence[int], values: Sequence[int]) -> None:
        """Refuse: no variable of type Integer can be set."""
        self._set(references, values, Type.INTEGER)

    @refuse_on_error(return_none)
    def set_boolean(self, references: Sequence[int], values: Sequence[bool]) -> None:
        """Set parameters of type Boolean."""
        self._set(references, values, Type.BOOLEAN)

    @refuse_on_error(return_none)
    def set_string(self, references: Sequence[int], values: Sequence[str]) -> None:
        """Refuse: no variable is a string."""
        raise InputError(
            f"{dict(zip(references, values, strict=True))}: no variable is of type String"
        )

    @refuse_on_error(return_none)
    def _get_fmu_state(self) -> InstanceState | None:
        motion_state = None if self._needs_motion else self._motion_state()
        if motion_state is not None:
            self._update_outputs()
        return InstanceState(
            self._phase, self._experiment, tuple(self._values.values()), motion_state
        )

    @refuse_on_error(return_none)
    def _set_fmu_state(self, state: InstanceState | str | None) -> None:
        if not isinstance(state, InstanceState):
            # A text is the reason why `_fmu_state_from_bytes` failed.
            raise InputError(state or "there is no such FMU state")
        values = dict(enumerate(state.values))
        if state.motion_state is not None:
            self._restore_motion(values, state.experiment or Experiment(), state.motion_state)
            self._t = state.motion_state.t
        self._phase, self._experiment = state.phase, state.experiment
        self._values, self._needs_motion = values, state.motion_state is None
        self._output_time, self._fast_until = self._t, -math.inf
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

    def _require_phase(self, call: str, phase: Phase) -> None:
        if self._phase is not phase:
            raise InputError(
                f"{call} is not allowed {self._phase.value}; {self._phase.advice(phase)}"
            )

    def _read(self, references: Sequence[int]) -> list[float | bool]:
        values = self._values
        if self._refused and self._phase in (Phase.INSTANTIATED, Phase.INITIALIZATION):
            # Outputs are NaN, because no motion exists for refused values.
            values = values | self._nan_outputs
        elif self._needs_motion:
            self._begin()
        elif self._t != self._output_time:
            self._update_outputs()
        try:
            return [values[reference] for reference in references]
        except KeyError as missing:
            raise InputError(f"value reference {missing}: there is no such variable") from None

    def _set(self, references: Sequence[int], values: Sequence[object], kind: Type) -> None:
        # Set all values or none. A valid value cancels an earlier refusal of the same variable.
        accepted: dict[int, float | bool] = {}
        refused: dict[int, str] = {}
        for reference, value in zip(references, values, strict=True):
            try:
                accepted[reference] = self._check_value(reference, kind, value)
            except InputError as error:
                refused[reference] = str(error)
        for reference, reason in refused.items():
            self.refuse(reference, reason)
        if refused:
            return
        for reference in accepted:
            self._refused.pop(reference, None)
        if self._phase is not Phase.STEPPING:
            self._values.update(accepted)
            self._needs_motion = True
        elif any(self._values[reference] != value for reference, value in accepted.items()):
            self._fast_until = -math.inf
            # Compute the motion up to now with the old values.
            self._motion_state()
            try:
                self._apply_values({**self._values, **accepted})
            except InputError as error:
                self.refuse(next(iter(accepted)), str(error))
                return
            self._values.update(accepted)
            self._update_outputs()

    def _check_value(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = self.TABLE.check_settable(reference, kind, value)
        variable = self.TABLE.variables[reference]
        is_fixed = variable.variability == "fixed" and self._phase is Phase.STEPPING
        if is_fixed or self._phase is Phase.TERMINATED:
            advice = self._phase.advice(Phase.INSTANTIATED)
            raise InputError(f"{variable.name} cannot be set {self._phase.value}; {advice}")
        return checked

    def _begin(self) -> None:
        experiment = self._experiment or Experiment()
        self._create_motion(experiment)
        self._t, self._needs_motion = experiment.start_time, False
        self._update_outputs()

    def _update_outputs(self) -> None:
        self._store_outputs()
        self._output_time = self._t
