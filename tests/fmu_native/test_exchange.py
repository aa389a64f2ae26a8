"""Model exchange by the native FMU: states, switches and derivatives, with any integrator."""

import ctypes
import math
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fivtui import Parameters, simulate
from fivtui.model import Mode
from fmu_src.build.builder import build_fmu
from tests.support.fmu_exchange import (
    FLOATS,
    INDICATORS,
    integrate_instance,
    model_exchange_instance,
    read,
    write_states,
)
from tests.support.fmu_instance import FmuInstance

STATES = ("x", "y", "vx", "vy")
DERIVATIVES = ("vx", "vy", "ax", "ay")
DISCARD, ERROR = 2, 3
VALUES = {"m": 3.0, "k1": 90.0, "k2": 40.0, "k3": 50.0, "c1": 0.7, "c2": 0.4, "k_nl": 120.0}
# Sizes in a serialised state: header, numbers, and checksum, bytes.
HEADER_SIZE, NUMBER_SIZE, CHECKSUM_SIZE = 48, 8, 4


@pytest.mark.parametrize(("tol", "error"), [(1e-6, 0.2), (1e-8, 5e-3), (1e-10, 1e-4)])
def test_cvode_finds_the_native_switches(fmu: Path, tol: float, error: float) -> None:
    native = simulate(t_end=50.0)
    run = fmpy.simulate_fmu(
        str(fmu),
        stop_time=50.0,
        output_interval=0.05,
        relative_tolerance=tol,
        fmi_type="ModelExchange",
    )
    assert run["separations"][-1] == native.events.separations
    assert run["reattachments"][-1] == native.events.reattachments
    assert run["last_event"][-1] == pytest.approx(native.switch_times[-1], abs=error)
    state = (run["x"][-1], run["y"][-1])
    assert state == pytest.approx((native.final.x, native.final.y), abs=error)
    assert np.all(run["P"] >= -1e-6)


@pytest.mark.parametrize("friction", [{}, {"mu_s": 0.9}, {"mu_s": 0.9, "v_s": 0.4}])
def test_cvode_agrees_on_a_belt_that_runs_backward(fmu: Path, friction: dict[str, float]) -> None:
    run = fmpy.simulate_fmu(
        str(fmu),
        stop_time=10.0,
        output_interval=0.05,
        relative_tolerance=1e-9,
        fmi_type="ModelExchange",
        start_values={"finite_belt": True, "v_belt": -1.5, **friction},
        output=[*STATES, "sticks"],
    )
    native = simulate(Parameters(**friction), t_end=10.0, over_time={"v_belt": [(0.0, -1.5)]})
    assert run["sticks"][-1] == native.events.sticks > 0
    final = [run[name][-1] for name in STATES]
    assert final == pytest.approx([getattr(native.final, name) for name in STATES], abs=1e-4)


def test_parameters_are_tuned_in_event_mode_alone(folder: Path) -> None:
    with FmuInstance(folder, "ModelExchange").begin() as instance:
        (y, P) = instance.get("y", "P")
        instance.set(k2=500.0)
        assert instance.get("P", "P_max") == pytest.approx([P - (500.0 - 50.0) * y] * 2)
        assert instance.get("ay") == pytest.approx([-(500.0 - 50.0) * y / 5.0])
        instance.update_mode()
        instance.fmi.enterContinuousTimeMode()
        with pytest.raises(FMICallException):
            instance.set(k2=50.0)
        assert "k2 cannot be set in continuous-time mode" in instance.log[-1]


def test_an_integrator_restarted_only_where_the_fmu_requests_it_finds_the_native_switches(
    folder: Path,
) -> None:
    native = simulate(t_end=20.0)
    with model_exchange_instance(folder) as instance:
        state = integrate_instance(instance, 20.0)
        *counts, last_event = instance.get("separations", "reattachments", "last_event")
    final = native.final
    assert state == pytest.approx([final.x, final.y, final.vx, final.vy], abs=1e-7)
    assert counts == [native.events.separations, native.events.reattachments]
    assert last_event == pytest.approx(native.events.last, abs=1e-8)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e7])
def test_the_tolerance_of_a_switch_scales_with_the_motion(folder: Path, scale: float) -> None:
    # y, ẏ and the mode after the event: ẏ decides if y is 0 within rounding, otherwise y.
    cases = [
        (1e-12, -1.0, Mode.CONTACT),
        (-1e-12, 1.0, Mode.SEPARATED),
        (1e-4, -1.0, Mode.SEPARATED),
        (-1e-4, 1.0, Mode.CONTACT),
    ]
    for y, vy, mode in cases:
        with model_exchange_instance(folder, F=80.0 * scale, k_nl=0.0) as instance:
            states = np.array([0.1, y, 0.0, vy]) * scale
            write_states(instance.fmi, states)
            instance.fmi.enterEventMode()
            before = instance.get("mode")
            changed = instance.update_mode()
            assert instance.get("mode") == [mode]
            assert changed == (before != [mode])


def test_at_a_switch_y_is_zero_and_the_indicator_is_on_the_side_of_the_mode(folder: Path) -> None:
    with model_exchange_instance(folder) as instance:
        states = np.array([3.0, -1e-14, 1.0, 2.0])
        write_states(instance.fmi, states)
        # y, and the indicators of slip and stick, which are 1 on a belt that is always faster.
        assert read(instance.fmi.getEventIndicators, INDICATORS) == [-1e-14, 1.0, 1.0, 1.0]
        instance.fmi.enterEventMode()
        assert instance.update_mode()
        assert read(instance.fmi.getContinuousStates, len(STATES)) == [3.0, 0.0, 1.0, 2.0]
        # In place of y = 0, the indicator is the least positive normal number.
        indicator, *_ = read(instance.fmi.getEventIndicators, INDICATORS)
        assert 0.0 < indicator < 1e-300
        assert not instance.update_mode()


@pytest.mark.parametrize("y", [-0.9, 0.4])
def test_directional_derivatives_agree_with_differences(folder: Path, y: float) -> None:
    knowns = [*STATES, "F", "mu"]
    # `switching` is the switching function y.
    unknowns = [*DERIVATIVES, "P", "friction_slider", "friction_belt", "switching", "mode"]
    base_states = np.array([0.5, y, -1.0, 0.3])

    def values(change: np.ndarray) -> np.ndarray:
        # A change of the states, of F and of mu.
        *_, force_change, mu_change = change
        write_states(instance.fmi, base_states + change[: len(STATES)])
        instance.set(F=60.0 + force_change, mu=0.9 + mu_change)
        return np.array(instance.get(*unknowns))

    with model_exchange_instance(folder, **VALUES) as instance:
        write_states(instance.fmi, base_states)
        instance.fmi.enterEventMode()
        instance.update_mode()
        instance.fmi.enterContinuousTimeMode()
        references = [[instance.references[n] for n in names] for names in (unknowns, knowns)]
        rng = np.random.default_rng(1)
        for direction in (*np.eye(len(knowns)), rng.normal(size=len(knowns))):
            difference = (values(1e-5 * direction) - values(-1e-5 * direction)) / 2e-5
            values(np.zeros(len(knowns)))
            exact = instance.fmi.getDirectionalDerivative(*references, direction.tolist())
            assert exact == pytest.approx(difference, rel=1e-6, abs=1e-6)


def test_forbidden_calls_are_refused_and_change_nothing(folder: Path) -> None:
    with model_exchange_instance(folder) as instance:
        fmi, references = instance.fmi, instance.references
        before = read(fmi.getContinuousStates, len(STATES))
        states_with_nan = np.array([0.0, np.nan, 0.0, 0.0])
        wrong = {
            "y = nan: must be a finite number": lambda: write_states(fmi, states_with_nan),
            "3 numbers: must be 4": lambda: read(fmi.getContinuousStates, 3),
            "time = inf: must be a finite number": lambda: fmi.setTime(np.inf),
            "new_discrete_states is not allowed in continuous-time mode": fmi.newDiscreteStates,
            "m cannot be set in continuous-time mode": lambda: instance.set(m=2.0),
            "must be that of an input, state or Real": lambda: fmi.getDirectionalDerivative(
                [references["ax"]], [references["P"]], [1.0]
            ),
            "must be that of an output or derivative": lambda: fmi.getDirectionalDerivative(
                [references["m"]], [references["x"]], [1.0]
            ),
        }
        for message, call in wrong.items():
            with pytest.raises(FMICallException):
                call()
            assert message in instance.log[-1]
        step = ctypes.c_double(1.0)
        assert fmi.dll.fmi2DoStep(ctypes.c_void_p(fmi.component), step, step, 1) == ERROR
        assert "do_step is for co-simulation" in instance.log[-1]
        assert read(fmi.getContinuousStates, len(STATES)) == before


def test_values_beyond_the_floating_point_range_are_discarded(folder: Path) -> None:
    parameters = {"finite_belt": True, "v_belt": 0.0}
    with model_exchange_instance(folder, **parameters) as instance:
        fmi = instance.fmi
        assert instance.get("mode") == [Mode.STICK]
        initial_states = read(fmi.getContinuousStates, len(STATES))
        values = instance.get(*STATES, "P"), read(fmi.getEventIndicators, INDICATORS)
        large_states = np.array([0.0, -1e200, 0.0, 0.0])
        write_states(fmi, large_states)
        calls: dict[str, Callable[[], object]] = {
            "P": lambda: instance.get("y", "P"),
            "ay": lambda: read(fmi.getDerivatives, 4),
            "an event indicator": lambda: read(fmi.getEventIndicators, INDICATORS),
        }
        for name, call in calls.items():
            with pytest.raises(FMICallException) as refused:
                call()
            assert refused.value.status == DISCARD
            assert instance.log[-1] == f"{name} grows beyond the floating-point range"
        assert instance.get("y") == [-1e200]
        fmi.setContinuousStates(np.array(initial_states).ctypes.data_as(FLOATS), 4)
        assert values == (instance.get(*STATES, "P"), read(fmi.getEventIndicators, INDICATORS))


def test_a_saved_state_restores_mode_and_counts(folder: Path) -> None:
    with model_exchange_instance(folder) as instance, model_exchange_instance(folder) as restored:
        integrate_instance(instance, 5.0)
        saved = instance.fmi.getFMUstate()
        data = instance.fmi.serializeFMUstate(saved)
        saved_values = instance.get(*STATES, "mode", "separations", "last_event")
        integrate_instance(instance, 9.0)
        instance.fmi.setFMUstate(saved)
        assert instance.get(*STATES, "mode", "separations", "last_event") == saved_values
        instance.fmi.freeFMUstate(saved)
        copy = restored.fmi.deSerializeFMUstate(data)
        restored.fmi.setFMUstate(copy)
        assert restored.get(*STATES, "mode", "separations", "last_event") == saved_values
        restored.fmi.freeFMUstate(copy)


def replace_number(state: bytes, index: int, value: float) -> bytes:
    """A serialised state with one number replaced and the checksum updated."""
    start = HEADER_SIZE + NUMBER_SIZE * index
    before, after = state[:start], state[start + NUMBER_SIZE : -CHECKSUM_SIZE]
    changed = before + struct.pack("<d", value) + after
    return changed + struct.pack("<I", zlib.crc32(changed))


def test_serialised_states_with_invalid_numbers_are_refused(folder: Path) -> None:
    # Indices of numbers that are 0 or 1. Each says whether the experiment is set up, the motion has
    # started, inputs have slopes, inputs are those of the last step, or a switch waits for event
    # mode.
    flags = {
        "is set up": 2,
        "has motion": 3,
        "has slopes": 4,
        "has inputs of step": 5,
        "switch pending": 6,
    }
    invalid_numbers: dict[str, tuple[int, tuple[float, ...]]] = {
        name: (index, (-1.0, 0.5, 2.0, math.nan)) for name, index in flags.items()
    }
    invalid_numbers |= {
        "type": (0, (2.0, 0.5)),
        "phase": (1, (-1.0, 0.5, 100.0)),
        "stop time": (8, (-1.0,)),
    }
    invalid_numbers |= {"tolerance": (9, (0.9e-13, 1.1e-2, 0.0)), "time": (10, (math.inf,))}
    with model_exchange_instance(folder) as instance:
        invalid_parameters = {
            "m": (0.0, -1.0, 1.1e9),
            "k3": (-1e-9, 1.1e12),
            "F": (-1.1e9, 1.1e9, math.nan),
            "mu": (-1e-9, 101.0),
            "separation": (0.5, 2.0),
        }
        invalid_numbers |= {
            n: (11 + instance.references[n], v) for n, v in invalid_parameters.items()
        }
        saved = instance.fmi.getFMUstate()
        state = bytes(instance.fmi.serializeFMUstate(saved))
        for name, (index, values) in invalid_numbers.items():
            (value,) = struct.unpack_from("<d", state, HEADER_SIZE + NUMBER_SIZE * index)
            assert replace_number(state, index, value) == state, name
            for wrong in values:
                with pytest.raises(FMICallException):
                    instance.fmi.deSerializeFMUstate(replace_number(state, index, wrong))
                assert "the serialised FMU state is damaged" in instance.log[-1], (name, wrong)
        instance.fmi.freeFMUstate(saved)


def test_both_interfaces_of_the_brake_actuator_give_the_exact_solution(tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "a.fmu", component="brake-actuator", flavour="native")
    runs = [
        fmpy.simulate_fmu(
            str(fmu),
            stop_time=0.5,
            output_interval=0.05,
            relative_tolerance=1e-9,
            fmi_type=kind,
            start_values={"command": 100.0, "F_start": 10.0, "P": 30.0},
        )
        for kind in ("CoSimulation", "ModelExchange")
    ]
    ends = [run["F"][-1] for run in runs]
    # The default gain is 0.1, and the default time constant 0.05 s.
    target_force = 100.0 + 0.1 * (100.0 - 30.0)
    exact = target_force + (10.0 - target_force) * np.exp(-0.5 / 0.05)
    assert ends == pytest.approx([exact] * 2, rel=1e-6)


def test_the_brake_actuator_gives_only_finite_values(tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "a.fmu", component="brake-actuator", flavour="native")
    fmpy.extract(str(fmu), str(tmp_path / "a"))
    with FmuInstance(tmp_path / "a").begin(tau=1e-12, gain=0.0, P=30.0) as actuator:
        actuator.set(command=1e3)
        # F begins at the default F_start, and follows the command in steps.
        assert actuator.get("F") == [80.0]
        # The gain is 0, so that F is finite; P is not.
        actuator.set_slopes(P=1e308)
        with pytest.raises(FMICallException) as refused:
            actuator.step(10.0)
        assert refused.value.status == DISCARD
        assert actuator.log[-1] == "P = inf at the end of the step: must be a finite number of N"
        actuator.set_slopes(P=1.0)
        actuator.step(10.0)
        # P = 30 + 1.0 · 10, without the refused step; F is the command.
        assert actuator.get("P", "F", "F_rate") == [40.0, 1e3, 0.0]


def test_parameters_and_the_separation_flag_reach_the_model(fmu: Path) -> None:
    native = simulate(Parameters(F=60.0, k_nl=50.0, mu=0.9), t_end=10.0, separation=False)
    run = fmpy.simulate_fmu(
        str(fmu),
        stop_time=10.0,
        relative_tolerance=1e-9,
        fmi_type="ModelExchange",
        start_values={"F": 60.0, "k_nl": 50.0, "mu": 0.9, "separation": False},
    )
    assert run["y"][-1] == pytest.approx(native.final.y, abs=1e-4)
    assert run["separations"][-1] == 0.0
