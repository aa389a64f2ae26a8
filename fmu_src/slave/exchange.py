"""The slider-belt model for FMI 3.0 model exchange: the importer integrates and finds the events.

The wrapper of pythonfmu3 can pass on neither exceptions nor refusals: a refused call is logged, and
the next update of the discrete states asks the importer to end the simulation.
"""

import logging
import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, Final

from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import Mode, State, accelerations, contact_force, mode_of

from .guard import guarded, nothing
from .instance_state import Phase
from .motion import parameters_from, separation_in, start_state
from .notices import Notices
from .process_end import release_at_exit
from .variable import Role, Type, VariableTable
from .variables import STATES, VARIABLES

# pythonfmu3 has no enumerations; the mode is a number.
EXCHANGE_TABLE: Final = VariableTable([v for v in VARIABLES if v.type in (Type.REAL, Type.BOOLEAN)])
# Value reference of the independent variable, after all others.
TIME_REFERENCE: Final = len(EXCHANGE_TABLE.variables)
# An importer stops within this distance of a switch, m, on either side.
_AT_SWITCH: Final = 1e-8


class ExchangeModel:
    """The slider-belt model for model exchange; a mixin, to put before pythonfmu3's classes."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        release_at_exit(kwargs.get("resources"))
        self.time = 0.0
        self._table = EXCHANGE_TABLE
        self._phase = Phase.INSTANTIATED
        self._values: dict[int, float | bool] = {
            reference: v.start for reference, v in enumerate(self._table.variables)
        }
        self._stale = True
        self._state: State = (0.0, 0.0, 0.0, 0.0)
        self._mode = Mode.CONTACT
        self._p = Parameters()
        self._switches = [0, 0]
        self._last_event = 0.0
        self._refused: dict[int | str, str] = {}
        self._notices = Notices(kwargs["instance_name"])

    def refuse(self, call: int | str, why: str) -> None:
        """Log why a call is refused; unless it only reads, end the simulation.

        `call` is the value reference that was to be set, or the name of the call; `why` is a line
        or a traceback.
        """
        if not str(call).startswith("get_"):
            self._refused[call] = why
        from pythonfmu3 import Fmi3Status

        log: Any = self.log  # type: ignore[attr-defined]
        # A constant: the wrapper may keep a reference to the category.
        log(self._notices.tell(logging.ERROR, why), Fmi3Status.error, "logStatusError")

    @guarded(nothing)
    def setup_experiment(self, start_time: float) -> None:
        """Set the start time, s."""
        self.time = self._last_event = start_time

    @guarded(nothing)
    def enter_initialization_mode(self) -> None:
        """Begin the initialization."""
        self._require("enter_initialization_mode", Phase.INSTANTIATED)
        self._phase = Phase.INITIALIZATION

    @guarded(nothing)
    def exit_initialization_mode(self) -> None:
        """Fix the parameters and begin the motion."""
        self._require("exit_initialization_mode", Phase.INITIALIZATION)
        if self._refused:
            raise InputError("not initialized: " + "; ".join(map(str, self._refused.values())))
        self._begin()
        self._phase = Phase.STEPPING

    @guarded(nothing)
    def terminate(self) -> None:
        """End the run; values can still be read."""
        self._phase = Phase.TERMINATED

    @guarded(nothing)
    def set_time(self, time: float) -> None:
        """Set the time, s."""
        self.time = time

    @guarded(lambda: 0)
    def get_number_of_continuous_states(self) -> int:
        """Four: x, ẋ, y, ẏ."""
        return len(STATES)

    @guarded(lambda: 0)
    def get_number_of_event_indicators(self) -> int:
        """One: y."""
        return 1

    @guarded(lambda size: [1.0] * size)
    def get_nominals_of_continuous_states(self, size: int) -> list[float]:
        """Typical sizes of the states."""
        table = self._table
        nominals = [table.variables[table.references[name]].nominal or 1.0 for name in STATES]
        return nominals[:size]

    @guarded(lambda: [math.nan] * len(STATES))
    def get_continuous_states(self) -> list[float]:
        """x, ẋ, y, ẏ, in m and m/s."""
        self._ready()
        return list(self._state)

    @guarded(nothing)
    def set_continuous_states(self, values: Sequence[float]) -> None:
        """Set x, ẋ, y, ẏ, in m and m/s."""
        x, vx, y, vy = values
        self._state = (x, vx, y, vy)

    @guarded(lambda: [math.nan] * len(STATES))
    def get_continuous_state_derivatives(self) -> list[float]:
        """ẋ, ẍ, ẏ, ÿ in the current mode, in m/s and m/s²."""
        self._ready()
        _, vx, _, vy = self._state
        ax, ay = accelerations(self._p, self._state, self._mode)
        return [vx, ax, vy, ay]

    @guarded(lambda: [math.nan])
    def get_event_indicators(self) -> list[float]:
        """y, m; it is zero at separation and at reattachment."""
        self._ready()
        return [self._state[2]]

    def update_discrete_states(self) -> SimpleNamespace:
        """Switch the mode if the importer has stopped at a switch."""
        self._switch()
        # The wrapper reads these names, which differ from those of pythonfmu3's own class.
        return SimpleNamespace(
            discreteStatesNeedUpdate=False,
            terminateSimulation=bool(self._refused),
            nominalContinuousStatesChanged=False,
            valuesOfContinuousStatesChanged=False,
            nextEventTimeDefined=False,
        )

    @guarded(nothing)
    def _switch(self) -> None:
        x, vx, y, vy = self._state
        # At a switch the sign of y is rounding; the direction of motion decides.
        state = (x, vx, 0.0, vy) if abs(y) <= _AT_SWITCH else self._state
        mode = mode_of(self._p, state, separation=separation_in(self._values))
        if mode is not self._mode:
            self._switches[mode] += 1
            self._mode, self._last_event = mode, self.time

    @guarded(lambda vrs: [math.nan] * len(vrs))
    def get_float64(self, vrs: Sequence[int]) -> list[float]:
        """Values of variables as numbers."""
        return [float(value) for value in self._read(vrs)]

    @guarded(lambda vrs: [False] * len(vrs))
    def get_boolean(self, vrs: Sequence[int]) -> list[bool]:
        """Values of variables as truth values."""
        return [bool(value) for value in self._read(vrs)]

    @guarded(nothing)
    def set_float64(self, vrs: Sequence[int], values: Sequence[float]) -> None:
        """Set parameters and inputs."""
        self._set(vrs, values, Type.REAL)

    @guarded(nothing)
    def set_boolean(self, vrs: Sequence[int], values: Sequence[bool]) -> None:
        """Set parameters of type Boolean."""
        self._set(vrs, values, Type.BOOLEAN)

    @guarded(lambda vrs: [0] * len(vrs))
    def get_int32(self, vrs: Sequence[int]) -> list[Any]:
        """Refuse: no variable is of this type."""
        raise _absent("int32", vrs)

    @guarded(lambda vrs: [0] * len(vrs))
    def get_int64(self, vrs: Sequence[int]) -> list[Any]:
        """Refuse: no variable is of this type."""
        raise _absent("int64", vrs)

    @guarded(lambda vrs: [SimpleNamespace(value=0)] * len(vrs))
    def get_uint64(self, vrs: Sequence[int]) -> list[Any]:
        """Refuse: no variable is of this type."""
        raise _absent("uint64", vrs)

    @guarded(lambda vrs: [""] * len(vrs))
    def get_string(self, vrs: Sequence[int]) -> list[Any]:
        """Refuse: no variable is of this type."""
        raise _absent("string", vrs)

    @guarded(nothing)
    def set_int32(self, vrs: Sequence[int], _values: Sequence[object]) -> None:
        """Refuse: no variable is of this type."""
        raise _absent("int32", vrs)

    @guarded(nothing)
    def set_int64(self, vrs: Sequence[int], _values: Sequence[object]) -> None:
        """Refuse: no variable is of this type."""
        raise _absent("int64", vrs)

    @guarded(nothing)
    def set_uint64(self, vrs: Sequence[int], _values: Sequence[object]) -> None:
        """Refuse: no variable is of this type."""
        raise _absent("uint64", vrs)

    @guarded(nothing)
    def set_string(self, vrs: Sequence[int], _values: Sequence[object]) -> None:
        """Refuse: no variable is of this type."""
        raise _absent("string", vrs)

    def _require(self, call: str, phase: Phase) -> None:
        if self._phase is not phase:
            raise InputError(f"{call} is not allowed {self._phase.value}")

    def _set(self, vrs: Sequence[int], values: Sequence[Any], kind: Type) -> None:
        for reference, value in zip(vrs, values, strict=True):
            try:
                checked = self._table.check_settable(reference, kind, value)
                variable = self._table.variables[reference]
                if variable.role is Role.PARAMETER and self._phase is Phase.STEPPING:
                    raise InputError(f"{variable.name} cannot be set {self._phase.value}")
            except InputError as error:
                self.refuse(reference, str(error))
            else:
                self._values[reference] = checked
                self._refused.pop(reference, None)
        if self._phase is Phase.STEPPING:
            self._p = parameters_from(self._values)
        else:
            self._stale = True

    def _ready(self) -> None:
        if self._stale:
            self._begin()

    def _begin(self) -> None:
        self._p = parameters_from(self._values)
        self._state = start_state(self._values)
        self._mode = mode_of(self._p, self._state, separation=separation_in(self._values))
        self._stale = False

    def _read(self, vrs: Sequence[int]) -> list[float | bool]:
        self._ready()
        x, vx, y, vy = self._state
        ax, ay = accelerations(self._p, self._state, self._mode)
        force = contact_force(self._p, y, self._mode) + 0.0
        friction = self._p.mu * force
        reattachments, separations = self._switches[Mode.CONTACT], self._switches[Mode.SEPARATED]
        outputs: dict[str, float] = {
            "x": x,
            "vx": vx,
            "y": y,
            "vy": vy,
            "ax": ax,
            "ay": ay,
            "P": force,
            "friction_slider": friction,
            "friction_belt": -friction,
            "mode": self._mode,
            "switching": y,
            "separations": separations,
            "reattachments": reattachments,
            "last_event": self._last_event,
        }
        values = {**self._values, TIME_REFERENCE: self.time}
        values |= {self._table.references[name]: value for name, value in outputs.items()}
        try:
            return [values[reference] for reference in vrs]
        except KeyError as unknown:
            raise InputError(f"value reference {unknown}: there is no such variable") from None


def _absent(kind: str, vrs: Sequence[int]) -> InputError:
    return InputError(f"value references {list(vrs)}: no variable is of type {kind.capitalize()}")
