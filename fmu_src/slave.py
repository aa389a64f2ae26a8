"""The FMU's side of FMI 2.0 co-simulation, as pythonfmu calls it.

The wrapper around this class cannot carry an exception, nor a status other than that of `do_step`:
every entry point catches what is raised inside, logs it and keeps the state as it was, and what a
call refused is reported by the next `do_step`, which then fails.
"""

import math
import sys
import traceback
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

from fivtui.core.errors import InputError
from fivtui.core.taylor import DEFAULT_TOL

from .experiment import SAME_TIME, Experiment
from .guard import guarded, nothing
from .memory import Memory, Phase, from_bytes, to_bytes
from .motion import Motion
from .settings import fixed_values, motion_from, start_state
from .variable import Role, Type
from .variables import INPUTS, REFERENCES, STATES, VARIABLES, check_settable

_MAKERS: Final = {Type.REAL: Real, Type.INTEGER: Integer, Type.BOOLEAN: Boolean}
_X, _VX, _Y, _VY = (REFERENCES[name] for name in STATES)
_P, _ON_SLIDER, _ON_BELT, _SWITCHING, _MODE, _MODE_INTEGER = (
    REFERENCES[name]
    for name in ("P", "friction_slider", "friction_belt", "switching", "mode", "mode_integer")
)
_SEPARATIONS, _REATTACHMENTS, _LAST_EVENT = (
    REFERENCES[name] for name in ("separations", "reattachments", "last_event")
)
_F, _MU = (REFERENCES[name] for name in INPUTS)
# Calls whose refusal changes nothing that a host could rely on afterwards.
_REPORTED_AT_ONCE: Final = {
    "_computed_step",
    "get_real",
    "get_integer",
    "get_boolean",
    "get_string",
    "_get_fmu_state",
}


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
        self._experiment: Experiment | None = None
        self._values: dict[int, float | bool] = {}
        self._motion: Motion | None = None
        self._stale = True
        # The time reached, and up to where a step does not need the motion.
        self._t, self._free_until = 0.0, -math.inf
        self._published = self._t
        self._refused: dict[int | str, str] = {}
        for reference, variable in enumerate(VARIABLES):
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

    def refuse(self, call: int | str, why: str) -> None:
        """Log why a call is refused; unless it reads or steps, the next step reports it too.

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
        # The message is a format to the host.
        self.log(why.replace("%", "%%"), Fmi2Status.error)

    @guarded(nothing)
    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Take the start time, the stop time and the tolerance of the run."""
        self._require("setup_experiment", Phase.INSTANTIATED)
        self._experiment = Experiment.checked(start_time, stop_time, tolerance)
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
        motion = self._motion
        if self._refused:
            # The first refusal is the cause of those that follow it.
            why = next(iter(self._refused.values()))
            if self._phase is Phase.STEPPING:
                self._refused.clear()
            raise InputError(f"the step is not taken: {why}")
        self._require("do_step", Phase.STEPPING)
        if motion is None or self._experiment is None:
            raise InputError("do_step is not allowed before the initialization")
        end = self._experiment.end_of_step(self._t, current_time, step_size)
        motion.move_to(end, F=self._values[_F], mu=self._values[_MU])
        self._t = end
        self._free_until = min(motion.known_until, self._experiment.stop_time)
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
        """Values of variables of any type as integers."""
        return [int(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [False] * len(vrs))
    def get_boolean(self, vrs: Sequence[int]) -> list[bool]:
        """Values of variables of any type as truth values."""
        return [bool(value) for value in self._read(vrs)]

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
    def _get_fmu_state(self) -> Memory | None:
        motion = None if self._stale else self._motion
        if motion is not None:
            self._catch_up(motion)
            self._publish(motion)
        return Memory(
            self._phase,
            self._experiment,
            tuple(self._values.values()),
            None if motion is None else motion.moment,
        )

    @guarded(nothing)
    def _set_fmu_state(self, state: Memory | str | None) -> None:
        if not isinstance(state, Memory):
            raise InputError(state or "there is no such FMU state")
        values = dict(enumerate(state.values))
        motion = None
        if state.moment is not None:
            motion, at = self._motion, state.moment
            tol = (state.experiment or Experiment()).tol
            if motion is None or self._fixed() != (tol, *fixed_values(values)):
                motion = motion_from(values, at.state, t=at.t, tol=tol)
            motion.restore(at)
        self._phase, self._experiment = state.phase, state.experiment
        self._values, self._motion, self._stale = values, motion, motion is None
        self._t = 0.0 if motion is None else motion.moment.t
        self._published, self._free_until = self._t, -math.inf
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

    def _require(self, call: str, phase: Phase) -> None:
        if self._phase is not phase:
            raise InputError(f"{call} is not allowed {self._phase.value}")

    def _read(self, vrs: Sequence[int]) -> list[float | bool]:
        if self._stale:
            self._begin()
        elif self._t != self._published and self._motion is not None:
            self._publish(self._motion)
        values = self._values
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
        if self._phase is not Phase.STEPPING or self._motion is None:
            self._values.update(accepted)
            self._stale = True
        elif any(self._values[reference] != value for reference, value in accepted.items()):
            self._free_until = -math.inf
            self._catch_up(self._motion)
            self._values.update(accepted)
            self._publish(self._motion)

    def _checked(self, reference: int, kind: Type, value: object) -> float | bool:
        checked = check_settable(reference, kind, value)
        variable = VARIABLES[reference]
        fixed = variable.role is Role.PARAMETER and self._phase is Phase.STEPPING
        if fixed or self._phase is Phase.TERMINATED:
            raise InputError(f"{variable.name} cannot be set {self._phase.value}")
        return checked

    def _fixed(self) -> tuple[float, ...]:
        # What a motion was made of, besides its start and its inputs.
        tol = (self._experiment or Experiment()).tol
        return (tol, *fixed_values(self._values))

    def _begin(self) -> None:
        state = start_state(self._values)
        experiment = self._experiment or Experiment()
        self._motion = motion_from(self._values, state, t=experiment.start_time, tol=experiment.tol)
        self._stale = False
        self._t = self._motion.moment.t
        self._publish(self._motion)

    def _catch_up(self, motion: Motion) -> None:
        at = motion.moment
        if at.t != self._t:
            motion.move_to(self._t, F=at.F, mu=at.mu)

    def _publish(self, motion: Motion) -> None:
        moment, values = motion.moment, self._values
        x, vx, y, vy = motion.state_at(self._t)
        force = motion.contact_force(y)
        friction = values[_MU] * force
        # Unrolled: this is most of what reading costs.
        values[_X], values[_VX], values[_Y], values[_VY] = x, vx, y, vy
        values[_P], values[_ON_SLIDER], values[_ON_BELT] = force, friction, -friction
        values[_SWITCHING] = y
        values[_MODE] = values[_MODE_INTEGER] = moment.mode
        values[_SEPARATIONS], values[_REATTACHMENTS] = moment.separations, moment.reattachments
        values[_LAST_EVENT] = moment.last_event
        self._published = self._t
