"""Functions of the native FMUs that may be called in each state, by FMI 2.0 and 3.0."""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any, Final

import pytest

from fmu_src.build.c_sources import MODELS, NATIVE, model_guid
from fmu_src.slave.variable import Role, Type

ERROR: Final = 3
STATES: Final = {"SliderBelt": 4, "BrakeActuator": 1}
INDICATORS: Final = {"SliderBelt": 4, "BrakeActuator": 0}
CO_SIMULATION, MODEL_EXCHANGE = "CS", "ME"
# I: instantiated, N: initialization mode, S: step mode, E: event mode, C: continuous-time mode,
# T: terminated; U: an intermediate update that asks for inputs, V: one that has outputs.
PHASES: Final = {
    ("2", CO_SIMULATION): "INST",
    ("2", MODEL_EXCHANGE): "INECT",
    ("3", CO_SIMULATION): "INESTUV",
    ("3", MODEL_EXCHANGE): "INECT",
}
# Where a call is allowed, in co-simulation and in model exchange: where the standard allows it, and
# in two more cases. FMI 2.0 values may be read when instantiated, as importers then show
# parameters; and the time may be set in event mode, as in the Reference FMUs.
ALLOWED: Final[dict[str, dict[str, tuple[str, str]]]] = {
    "2": {
        "SetDebugLogging": ("INST", "INECT"),
        "SetupExperiment": ("I", "I"),
        "EnterInitializationMode": ("I", "I"),
        "ExitInitializationMode": ("N", "N"),
        "Terminate": ("S", "EC"),
        "Reset": ("INST", "INECT"),
        "GetReal": ("INST", "INECT"),
        "GetInteger": ("INST", "INECT"),
        "GetBoolean": ("INST", "INECT"),
        "SetReal": ("INS", "INEC"),
        "SetReal of a parameter": ("IN", "IN"),
        "SetReal of a tunable": ("INS", "INE"),
        "GetFMUstate": ("INST", "INECT"),
        "SetFMUstate": ("INST", "INECT"),
        "FreeFMUstate": ("INST", "INECT"),
        "SerializedFMUstateSize": ("INST", "INECT"),
        "GetDirectionalDerivative": ("NST", "NECT"),
        "EnterEventMode": ("", "EC"),
        "NewDiscreteStates": ("", "E"),
        "EnterContinuousTimeMode": ("", "E"),
        "CompletedIntegratorStep": ("", "C"),
        "SetTime": ("", "EC"),
        "SetContinuousStates": ("", "C"),
        "GetEventIndicators": ("", "NECT"),
        "GetContinuousStates": ("", "NECT"),
        "GetDerivatives": ("", "NECT"),
        "GetNominalsOfContinuousStates": ("", "INECT"),
        "SetRealInputDerivatives": ("INS", ""),
        "GetRealOutputDerivatives": ("ST", ""),
        "DoStep": ("S", ""),
        "GetStatus": ("S", ""),
        "GetRealStatus": ("S", ""),
        "GetIntegerStatus": ("S", ""),
        "GetBooleanStatus": ("S", ""),
        "GetStringStatus": ("S", ""),
    },
    "3": {
        "SetDebugLogging": ("INESTUV", "INECT"),
        "EnterInitializationMode": ("I", "I"),
        "ExitInitializationMode": ("N", "N"),
        "EnterEventMode": ("S", "C"),
        "Terminate": ("ES", "EC"),
        "Reset": ("INEST", "INECT"),
        "GetFloat64": ("INESTV", "INECT"),
        "GetFloat64 of the time": ("INESTV", "INECT"),
        "SetFloat64": ("INESU", "INEC"),
        "SetFloat64 of a parameter": ("IN", "IN"),
        "SetFloat64 of a tunable": ("INE", "INE"),
        "GetFMUState": ("INEST", "INECT"),
        "SetFMUState": ("INEST", "INECT"),
        "GetDirectionalDerivative": ("NEST", "NECT"),
        "GetAdjointDerivative": ("NEST", "NECT"),
        "GetAdjointDerivative of nothing": ("NEST", "NECT"),
        "GetOutputDerivatives": ("ST", ""),
        "EvaluateDiscreteStates": ("E", "E"),
        "UpdateDiscreteStates": ("E", "E"),
        "EnterStepMode": ("E", ""),
        "DoStep": ("S", ""),
        "EnterContinuousTimeMode": ("", "E"),
        "CompletedIntegratorStep": ("", "C"),
        "SetTime": ("", "EC"),
        "SetContinuousStates": ("", "C"),
        "GetContinuousStates": ("", "NECT"),
        "GetContinuousStateDerivatives": ("", "NECT"),
        "GetEventIndicators": ("", "NECT"),
        "GetNominalsOfContinuousStates": ("", "INECT"),
        "GetNumberOfContinuousStates": ("", "INECT"),
        "GetNumberOfEventIndicators": ("", "INECT"),
    },
}
# The calls that lead to a state, by their names in the tables.
_TO_STEPS: Final = ("EnterInitializationMode", "ExitInitializationMode")
PATHS: Final[dict[tuple[str, str], dict[str, tuple[str, ...]]]] = {
    ("2", CO_SIMULATION): {"N": _TO_STEPS[:1], "S": _TO_STEPS, "T": (*_TO_STEPS, "Terminate")},
    ("3", CO_SIMULATION): {
        "N": _TO_STEPS[:1],
        "E": _TO_STEPS,
        "S": (*_TO_STEPS, "EnterStepMode"),
        "T": (*_TO_STEPS, "Terminate"),
        "U": (*_TO_STEPS, "EnterStepMode"),
        "V": (*_TO_STEPS, "EnterStepMode"),
    },
} | {
    (version, MODEL_EXCHANGE): {
        "N": _TO_STEPS[:1],
        "E": _TO_STEPS,
        "C": (*_TO_STEPS, "EnterContinuousTimeMode"),
        "T": (*_TO_STEPS, "Terminate"),
    }
    for version in "23"
}
_LOG_2: Final = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 2, ctypes.c_int, *[ctypes.c_char_p] * 2)
_LOG_3: Final = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, *[ctypes.c_char_p] * 2)
_UPDATE: Final = ctypes.CFUNCTYPE(
    None,
    ctypes.c_void_p,
    ctypes.c_double,
    *[ctypes.c_bool] * 4,
    ctypes.POINTER(ctypes.c_bool),
    ctypes.POINTER(ctypes.c_double),
)


@cache
def model_token(model: str) -> bytes:
    """GUID or instantiation token of a model; cached, as it depends on all sources."""
    return model_guid(model).encode()


class _Callbacks(ctypes.Structure):
    _fields_ = (("logger", _LOG_2), ("further_callbacks", ctypes.c_void_p * 4))


class Instance:
    """An instance of a model in a given state, driven by the library's functions."""

    def __init__(self, model: str, version: str, kind: str) -> None:
        # The suffix is .so, .dll or .dylib.
        self.library = ctypes.CDLL(str(next(NATIVE.glob(f"{model}.[sd]*"))))
        self.version, self.kind, self.log = version, kind, list[str]()
        self.on_update: Callable[[bool], None] = lambda _: None
        table = MODELS[model]
        references = {
            role: next(
                r
                for r, v in enumerate(table.variables)
                if v.role is role and is_real(v) and not v.tunable
            )
            for role in (Role.INPUT, Role.PARAMETER)
        }
        tunable = next(r for r, v in enumerate(table.variables) if v.tunable)
        self.tunable = ctypes.c_uint(tunable)
        self.input = ctypes.c_uint(references[Role.INPUT])
        self.parameter = ctypes.c_uint(references[Role.PARAMETER])
        # A derivative in each model: horizontal acceleration, and rate of the preload.
        rate = next(r for r, v in enumerate(table.variables) if v.name in ("ax", "F_rate"))
        # The time has the first reference after the variables of the table.
        self.rate, self.time = ctypes.c_uint(rate), ctypes.c_uint(len(table.variables))
        self.states, self.indicators = STATES[model], INDICATORS[model]
        # Memory for results of any type; the largest are 4 numbers, and FMI 2.0's event info.
        self.buffer = (ctypes.c_double * 8)()
        self.saved_state = ctypes.c_void_p()
        self.flags, self.size = (ctypes.c_bool * 32)(), ctypes.c_size_t()
        token = model_token(model)
        self.component = ctypes.c_void_p(
            self._instantiate_2(token) if version == "2" else self._instantiate_3(token)
        )
        assert self.component.value
        if version == "2":
            assert self.call("SetupExperiment") == 0

    def _instantiate_2(self, token: bytes) -> int | None:
        logger = _LOG_2(lambda *call: self.log.append(call[-1].decode()))
        self.callbacks: Any = _Callbacks(logger)
        make = self.library.fmi2Instantiate
        make.restype = ctypes.c_void_p
        kind = int(self.kind == CO_SIMULATION)
        return make(b"i", kind, token, None, ctypes.byref(self.callbacks), 0, 0)  # type: ignore[no-any-return]

    def _instantiate_3(self, token: bytes) -> int | None:
        logger = _LOG_3(lambda *call: self.log.append(call[-1].decode()))
        update = _UPDATE(lambda _, __, wants_inputs, *___: self.on_update(wants_inputs))
        self.callbacks = logger, update
        common_arguments = (b"i", token, None, False, False)
        if self.kind == MODEL_EXCHANGE:
            make = self.library.fmi3InstantiateModelExchange
            make.restype = ctypes.c_void_p
            return make(*common_arguments, None, logger)  # type: ignore[no-any-return]
        make = self.library.fmi3InstantiateCoSimulation
        make.restype = ctypes.c_void_p
        required = ctypes.byref(self.input), ctypes.c_size_t(1)
        return make(*common_arguments, True, True, *required, None, logger, update)  # type: ignore[no-any-return]

    def arguments(self, name: str) -> tuple[Any, ...]:
        """Valid arguments of a function in the states in which it is allowed."""
        zero, step, unit, unused = map(ctypes.c_double, (0.0, 0.01, 1.0, 0.0))
        count = ctypes.c_size_t(1)
        buffer, flags = self.buffer, self.flags
        start = (
            (0, unused, zero, 0, unused)
            if self.version == "2"
            else (False, unused, zero, False, unused)
        )
        counted = (count,) if self.version == "3" else ()
        input_arguments = ctypes.byref(self.input), count
        derivative_arguments = (
            ctypes.byref(self.rate),
            count,
            *input_arguments,
            ctypes.byref(unit),
            *counted,
        )
        states, indicators = ctypes.c_size_t(self.states), ctypes.c_size_t(self.indicators)
        # The FMU gives the value of a variable as any type: the Real input serves all `Get…`.
        calls: dict[str, tuple[Any, ...]] = {
            "SetDebugLogging": (0, ctypes.c_size_t(0), None),
            "SetupExperiment": start,
            "EnterInitializationMode": start if self.version == "3" else (),
            "GetReal": (*input_arguments, buffer),
            "GetInteger": (*input_arguments, buffer),
            "GetBoolean": (*input_arguments, buffer),
            "SetReal": (*input_arguments, ctypes.byref(unit)),
            "SetReal of a parameter": (ctypes.byref(self.parameter), count, ctypes.byref(unit)),
            "SetReal of a tunable": (ctypes.byref(self.tunable), count, ctypes.byref(unit)),
            "SetFloat64 of a tunable": (
                *(ctypes.byref(self.tunable), count, ctypes.byref(unit), count),
            ),
            "GetFloat64": (*input_arguments, buffer, count),
            "GetFloat64 of the time": (ctypes.byref(self.time), count, buffer, count),
            "SetFloat64": (*input_arguments, ctypes.byref(unit), count),
            "SetFloat64 of a parameter": (
                *(ctypes.byref(self.parameter), count, ctypes.byref(unit), count),
            ),
            "GetFMUstate": (ctypes.byref(self.saved_state),),
            "SetFMUstate": (self.saved_state,),
            "FreeFMUstate": (ctypes.byref(ctypes.c_void_p()),),
            "SerializedFMUstateSize": (self.saved_state, ctypes.byref(self.size)),
            "GetFMUState": (ctypes.byref(self.saved_state),),
            "SetFMUState": (self.saved_state,),
            "GetDirectionalDerivative": (*derivative_arguments, buffer, *counted),
            "GetAdjointDerivative": (*derivative_arguments, buffer, *counted),
            "GetAdjointDerivative of nothing": (None, ctypes.c_size_t(0)) * 4,
            "NewDiscreteStates": (buffer,),
            "UpdateDiscreteStates": (*(ctypes.byref(flags, n) for n in range(5)), buffer),
            "CompletedIntegratorStep": (1, flags, ctypes.byref(flags, 8)),
            "SetTime": (zero,),
            "SetContinuousStates": ((ctypes.c_double * 4)(), states),
            "GetContinuousStates": (buffer, states),
            "GetDerivatives": (buffer, states),
            "GetContinuousStateDerivatives": (buffer, states),
            "GetNominalsOfContinuousStates": (buffer, states),
            "GetEventIndicators": (buffer, indicators),
            "GetNumberOfContinuousStates": (ctypes.byref(self.size),),
            "GetNumberOfEventIndicators": (ctypes.byref(self.size),),
            "SetRealInputDerivatives": (
                *(*input_arguments, ctypes.byref(ctypes.c_int(1)), ctypes.byref(unused)),
            ),
            # Of an acceleration, or the rate of the preload.
            "GetRealOutputDerivatives": (
                *(ctypes.byref(self.rate), count, ctypes.byref(ctypes.c_int(1)), buffer),
            ),
            "GetOutputDerivatives": (
                *(ctypes.byref(self.rate), count, ctypes.byref(ctypes.c_int(1)), buffer, count),
            ),
            "DoStep": (zero, step, True),
            "GetStatus": (0, buffer),
            "GetRealStatus": (2, buffer),
            "GetIntegerStatus": (1, buffer),
            "GetBooleanStatus": (3, buffer),
            "GetStringStatus": (1, buffer),
        }
        if name == "DoStep" and self.version == "3":
            return (*calls[name], *(ctypes.byref(flags, n) for n in range(3)), buffer)
        return calls.get(name, ())

    def call(self, name: str) -> int:
        """Status of a function of the table."""
        function = getattr(self.library, f"fmi{self.version}{name.partition(' ')[0]}")
        return int(function(self.component, *self.arguments(name)))

    def call_in(self, phase: str, name: str) -> int:
        """Status of a function in a state, after an FMU state was saved."""
        save = "GetFMUstate" if self.version == "2" else "GetFMUState"
        for step in PATHS[self.version, self.kind].get(phase, ()):
            assert self.call(step) == 0, step
        assert self.call(save) == 0
        if phase not in ("U", "V"):
            return self.call(name)
        statuses: list[int] = []

        def answer(wants_inputs: bool) -> None:
            if wants_inputs == (phase == "U") and not statuses:
                statuses.append(self.call(name))

        self.on_update = answer
        assert self.call("DoStep") == 0
        return statuses[0]

    def free(self) -> None:
        free = f"FreeFMU{'state' if self.version == '2' else 'State'}"
        getattr(self.library, f"fmi{self.version}{free}")(
            self.component, ctypes.byref(self.saved_state)
        )
        getattr(self.library, f"fmi{self.version}FreeInstance")(self.component)


def is_real(variable: Any) -> bool:
    return variable.type is Type.REAL


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("version", "kind"), PHASES)
def test_functions_fail_exactly_in_the_states_that_the_standard_forbids(
    model: str, version: str, kind: str
) -> None:
    accepted = {}
    for name in ALLOWED[version]:
        statuses = {}
        for phase in PHASES[version, kind]:
            instance = Instance(model, version, kind)
            statuses[phase] = instance.call_in(phase, name)
            # Failures are logged. Asking for an unknown status is discarded, but allowed.
            assert bool(statuses[phase]) == bool(instance.log), (name, phase)
            instance.free()
        accepted[name] = "".join(phase for phase in statuses if statuses[phase] != ERROR)
    column = (CO_SIMULATION, MODEL_EXCHANGE).index(kind)
    assert accepted == {name: phases[column] for name, phases in ALLOWED[version].items()}
