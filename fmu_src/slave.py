"""The FMU's side of FMI 2.0 co-simulation, as pythonfmu calls it.

The wrapper around this class cannot carry an exception, nor a status other than that of `do_step`:
every entry point catches what is raised inside, logs it and keeps the state as it was, and what a
call refused is reported by the next `do_step`, which then fails.
"""

import math
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any, Concatenate, Final, ParamSpec, TypeVar

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

from fivtui.core.errors import ComputationError, InputError
from fivtui.core.model import State, static_start
from fivtui.core.parameters import PARAMETERS, Parameters, parse_number
from fivtui.core.taylor import DEFAULT_TOL, TOL_RANGE

from .memory import Memory, Phase, from_bytes, to_bytes
from .motion import Motion
from .variables import INPUTS, REFERENCES, STATES, VARIABLES, Role, Type, check_settable

_P = ParamSpec("_P")
_R = TypeVar("_R")
_MAKERS: Final = {Type.REAL: Real, Type.INTEGER: Integer, Type.BOOLEAN: Boolean}
_OUTPUTS: Final = tuple(
    REFERENCES[name]
    for name in (
        *STATES,
        "P",
        "friction_slider",
        "friction_belt",
        "mode",
        "mode_integer",
        "switching",
        "separations",
        "reattachments",
        "last_event",
    )
)
_F, _MU = (REFERENCES[name] for name in INPUTS)
# Communication points of a host and of the slave agree to its rounding.
_SAME_TIME: Final = 1e-9


def _guarded(
    fallback: Callable[..., _R], *, latched: bool = False
) -> Callable[
    [Callable[Concatenate["SliderBelt", _P], _R]], Callable[Concatenate["SliderBelt", _P], _R]
]:
    # An exception that reached the wrapper would corrupt its reference counts.
    def decorate(
        method: Callable[Concatenate["SliderBelt", _P], _R],
    ) -> Callable[Concatenate["SliderBelt", _P], _R]:
        @wraps(method)
        def call(self: "SliderBelt", /, *args: _P.args, **kwargs: _P.kwargs) -> _R:
            try:
                return method(self, *args, **kwargs)
            except (InputError, ComputationError) as error:
                why = str(error)
            except BaseException:  # noqa: BLE001
                why = traceback.format_exc()
            if latched:
                self._refused[method.__name__] = why
            self._complain(why)
            return fallback(*args, **kwargs)

        return call

    return decorate


def _nothing(*_: object) -> None:
    return None


def _no_state(*_: object) -> Memory | None:
    return None


def _failed(*_: object) -> bool:
    return False


def _unknown(references: Sequence[int]) -> list[Any]:
    return [0] * len(references)


class SliderBelt(Fmi2Slave):  # type: ignore[misc]
    """One instance of the slider-belt model.

    Parameters
    ----------
    **kwargs
        What the wrapper knows of the instance.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        # The wrapper, which passes its logger, has put the FMU's folder on the host's path again.
        if "logger" in kwargs and self.resources in sys.path:
            sys.path.remove(self.resources)
        self.author = "The fivtui developers"
        self.license = "MIT"
        self.description = (
            "Slider pressed on a moving belt: friction-induced vibration by mode coupling, "
            "with a cubic contact stiffness and separation"
        )
        self.default_experiment = DefaultExperiment(0.0, 100.0, 0.01, DEFAULT_TOL)
        self._phase = Phase.INSTANTIATED
        self._configured = False
        self._tol = DEFAULT_TOL
        self._start_time, self._stop_time = 0.0, math.inf
        self._values: dict[int, float | bool] = {}
        self._motion: Motion | None = None
        self._stale = True
        self._refused: dict[int | str, str] = {}
        for reference, variable in enumerate(VARIABLES):
            self._values[reference] = variable.start
            self.register_variable(
                _MAKERS[variable.type](
                    variable.name,
                    causality=Fmi2Causality[variable.role.value],
                    description=variable.meaning,
                    variability=_variability(variable.role, discrete=variable.discrete),
                    initial=_initial(variable.role),
                )
            )

    @_guarded(_nothing, latched=True)
    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Take the start time, the stop time and the tolerance of the run."""
        self._require("setup_experiment", Phase.INSTANTIATED)
        start = parse_number("start time", start_time, "a finite number of seconds")
        stop = math.inf
        if stop_time is not None:
            stop = parse_number("stop time", stop_time, f"a number of seconds above {start:g}")
            if stop < start:
                raise InputError(f"stop time = {stop:g}: allowed is not before {start:g} s")
        tol = DEFAULT_TOL
        if tolerance is not None:
            allowed = f"{TOL_RANGE[0]:g} <= tolerance <= {TOL_RANGE[1]:g}"
            tol = parse_number("tolerance", tolerance, allowed)
            if not TOL_RANGE[0] <= tol <= TOL_RANGE[1]:
                raise InputError(f"tolerance = {tol:g}: allowed is {allowed}")
        self._start_time, self._stop_time, self._tol = start, stop, tol
        self._configured, self._stale = True, True
        self._refused.pop("setup_experiment", None)

    @_guarded(_nothing, latched=True)
    def enter_initialization_mode(self) -> None:
        """Begin the initialization."""
        self._require("enter_initialization_mode", Phase.INSTANTIATED)
        if not self._configured:
            raise InputError("enter_initialization_mode is not allowed before setup_experiment")
        self._phase = Phase.INITIALIZATION

    @_guarded(_nothing, latched=True)
    def exit_initialization_mode(self) -> None:
        """Fix the parameters and begin the motion."""
        self._require("exit_initialization_mode", Phase.INITIALIZATION)
        self._refused.pop("exit_initialization_mode", None)
        if self._refused:
            raise InputError("not initialized: " + "; ".join(self._refused.values()))
        self._begin()
        self._phase = Phase.STEPPING

    @_guarded(_failed)
    def do_step(self, current_time: float, step_size: float) -> bool:
        """Go on by one communication step."""
        motion = self._motion
        if self._refused:
            why = "; ".join(self._refused.values())
            if self._phase is Phase.STEPPING:
                self._refused.clear()
            raise InputError(f"the step is not taken: {why}")
        self._require("do_step", Phase.STEPPING)
        if motion is None:
            raise InputError("do_step is not allowed before the initialization")
        t = motion.moment.t
        if not math.isclose(current_time, t, rel_tol=_SAME_TIME, abs_tol=_SAME_TIME):
            raise InputError(f"current time = {current_time!r}: the instance is at {t!r} s")
        target = current_time + step_size
        if not (0.0 < step_size < math.inf and target > t):
            raise InputError(f"step size = {step_size!r}: allowed is a positive number of seconds")
        if target > self._stop_time and not math.isclose(
            target, self._stop_time, rel_tol=_SAME_TIME, abs_tol=_SAME_TIME
        ):
            raise InputError(f"time = {target!r}: the stop time is {self._stop_time!r} s")
        motion.move_to(target, F=self._values[_F], mu=self._values[_MU])
        self._publish(motion)
        return True

    @_guarded(_nothing, latched=True)
    def terminate(self) -> None:
        """End the run; the values stay readable."""
        self._phase = Phase.TERMINATED

    @_guarded(_unknown)
    def get_real(self, vrs: Sequence[int]) -> list[float]:
        """Values of variables of any type as numbers."""
        if self._stale:
            self._begin()
        values = self._values
        return [float(values[reference]) for reference in vrs]

    @_guarded(_unknown)
    def get_integer(self, vrs: Sequence[int]) -> list[int]:
        """Values of variables of any type as integers."""
        if self._stale:
            self._begin()
        return [int(self._values[reference]) for reference in vrs]

    @_guarded(_unknown)
    def get_boolean(self, vrs: Sequence[int]) -> list[bool]:
        """Values of variables of any type as truth values."""
        if self._stale:
            self._begin()
        return [bool(self._values[reference]) for reference in vrs]

    @_guarded(lambda vrs: [""] * len(vrs))
    def get_string(self, vrs: Sequence[int]) -> list[str]:
        """Refuse: no variable is a string."""
        raise InputError(f"value references {list(vrs)}: no variable is of type String")

    @_guarded(_nothing, latched=True)
    def set_real(self, vrs: Sequence[int], values: Sequence[float]) -> None:
        """Set parameters and inputs."""
        self._set(vrs, values, Type.REAL)

    @_guarded(_nothing, latched=True)
    def set_integer(self, vrs: Sequence[int], values: Sequence[int]) -> None:
        """Refuse: no variable that can be set is an integer."""
        self._set(vrs, values, Type.INTEGER)

    @_guarded(_nothing, latched=True)
    def set_boolean(self, vrs: Sequence[int], values: Sequence[bool]) -> None:
        """Set the switches of the model."""
        self._set(vrs, values, Type.BOOLEAN)

    @_guarded(_nothing, latched=True)
    def set_string(self, vrs: Sequence[int], values: Sequence[str]) -> None:
        """Refuse: no variable is a string."""
        raise InputError(f"{dict(zip(vrs, values, strict=True))}: no variable is of type String")

    @_guarded(_no_state)
    def _get_fmu_state(self) -> Memory | None:
        moment = None if self._motion is None else self._motion.moment
        return Memory(
            self._phase,
            self._configured,
            self._tol,
            self._start_time,
            self._stop_time,
            tuple(self._values.values()),
            None if self._stale else moment,
        )

    @_guarded(_nothing, latched=True)
    def _set_fmu_state(self, state: Memory | str | None) -> None:
        if not isinstance(state, Memory):
            raise InputError(state or "there is no such FMU state")
        values = dict(enumerate(state.values))
        motion = None
        if state.moment is not None:
            motion = self._motion
            if motion is None or _fixed(self._values, self._tol) != _fixed(values, state.tol):
                motion = _motion(values, state.tol, state.moment.state, state.moment.t)
            motion.restore(state.moment)
        self._phase, self._configured, self._tol = state[:3]
        self._start_time, self._stop_time = state.start_time, state.stop_time
        self._values, self._motion, self._stale = values, motion, motion is None
        self._refused.clear()

    @staticmethod
    def _fmu_state_to_bytes(state: Memory | str) -> bytes:
        return to_bytes(state) if isinstance(state, Memory) else b""

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> Memory | str:
        try:
            return from_bytes(state)
        except InputError as error:
            return str(error)
        except BaseException:  # noqa: BLE001
            return traceback.format_exc()

    def _complain(self, why: str) -> None:
        # The message is a format to the host.
        self.log(why.replace("%", "%%"), Fmi2Status.error)

    def _require(self, call: str, phase: Phase) -> None:
        if self._phase is not phase:
            raise InputError(f"{call} is not allowed {self._phase.value}")

    def _set(self, vrs: Sequence[int], values: Sequence[object], kind: Type) -> None:
        # All of a call or nothing; a valid value takes back the refusal of an earlier one.
        accepted: dict[int, float | bool] = {}
        refused: dict[int | str, str] = {}
        for reference, value in zip(vrs, values, strict=True):
            try:
                accepted[reference] = self._checked(reference, kind, value)
            except InputError as error:
                refused[reference] = str(error)
        if refused:
            self._refused.update(refused)
            self._complain("; ".join(refused.values()))
            return
        self._values.update(accepted)
        for reference in accepted:
            self._refused.pop(reference, None)
        if self._phase is Phase.STEPPING and self._motion is not None:
            self._publish(self._motion)
        else:
            self._stale = True

    def _checked(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = check_settable(reference, kind, value)
        variable = VARIABLES[reference]
        fixed = variable.role is Role.PARAMETER and self._phase is Phase.STEPPING
        if fixed or self._phase is Phase.TERMINATED:
            raise InputError(f"{variable.name} cannot be set {self._phase.value}")
        return checked

    def _begin(self) -> None:
        values = self._values
        if values[REFERENCES["start_static"]]:
            separation = bool(values[REFERENCES["separation"]])
            state = static_start(_parameters(values), separation=separation)
        else:
            x, vx, y, vy = (float(values[REFERENCES[f"{name}_start"]]) for name in STATES)
            state = (x, vx, y, vy)
        self._motion = _motion(values, self._tol, state, self._start_time)
        self._stale = False
        self._publish(self._motion)

    def _publish(self, motion: Motion) -> None:
        moment, values = motion.moment, self._values
        force = motion.contact_force
        friction = values[_MU] * force
        values.update(
            zip(
                _OUTPUTS,
                (
                    *moment.state,
                    force,
                    friction,
                    -friction,
                    moment.mode,
                    moment.mode,
                    moment.state[2],
                    moment.separations,
                    moment.reattachments,
                    moment.last_event,
                ),
                strict=True,
            )
        )


def _parameters(values: Mapping[int, float | bool]) -> Parameters:
    return Parameters(**{name: float(values[REFERENCES[name]]) for name in PARAMETERS})


def _motion(values: Mapping[int, float | bool], tol: float, state: State, t: float) -> Motion:
    separation = bool(values[REFERENCES["separation"]])
    return Motion(_parameters(values), state, t=t, separation=separation, tol=tol)


def _fixed(values: Mapping[int, float | bool], tol: float) -> tuple[float, ...]:
    # What two motions must share so that one can take up where the other was.
    return (tol, *(values[r] for r, v in enumerate(VARIABLES) if v.role is Role.PARAMETER))


def _variability(role: Role, *, discrete: bool) -> Fmi2Variability:
    if role is Role.PARAMETER:
        return Fmi2Variability.fixed
    return Fmi2Variability.discrete if discrete else Fmi2Variability.continuous


def _initial(role: Role) -> Fmi2Initial | None:
    if role is Role.INPUT:
        return None
    return Fmi2Initial.exact if role is Role.PARAMETER else Fmi2Initial.calculated
