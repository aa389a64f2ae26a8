"""Derivatives of outputs by time, from the native FMU, and what they bring to a coupled system."""

import runpy
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fivtui.model.modes import Mode
from fmu_src.build.builder import build_fmu
from fmu_src.slave.variables import REFERENCES, VARIABLES
from tests.support.fmu_instance import FmuInstance

ORDERS: Final = (1, 2, 3)
NAMES: Final = tuple(v.name for v in VARIABLES if v.variability == "continuous" and not v.settable)
BELT: Final = {"finite_belt": True, "v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}
# Weights of values at 0, h, … 4 h in derivatives at 0, and their denominators over powers of h.
WEIGHTS: Final = {
    1: ((-25.0, 48.0, -36.0, 16.0, -3.0), 12.0),
    2: ((35.0, -104.0, 114.0, -56.0, 11.0), 12.0),
    3: ((-5.0, 18.0, -24.0, 14.0, -3.0), 2.0),
}


def output_derivatives(instance: FmuInstance, names: Sequence[str], order: int) -> Any:
    references = [instance.references[name] for name in names]
    return instance.fmi.getRealOutputDerivatives(references, [order] * len(names))


@pytest.mark.parametrize(
    ("values", "t", "mode"),
    [
        ({}, 0.9, Mode.CONTACT),
        ({}, 3.1, Mode.SEPARATED),
        (BELT, 1.2, Mode.FORWARD),
        (BELT, 4.7, Mode.STICK),
    ],
)
def test_derivatives_are_those_of_the_motion_that_follows(
    folder: Path, values: dict[str, Any], t: float, mode: Mode
) -> None:
    h, inputs = 1e-3, ("F", "mu", "v_belt")
    # Slopes, of which the derivatives take account before the step to which they apply.
    slopes = {"F": 7.0, "mu": -0.02, "v_belt": 0.3 if mode is Mode.FORWARD else 0.0}
    with FmuInstance(folder).begin(**values) as instance:
        instance.step(t)
        assert instance.get("mode") == [mode]
        start_values = instance.get(*inputs)
        instance.set_slopes(**slopes)
        derivatives = [output_derivatives(instance, NAMES, order) for order in ORDERS]
        samples = [instance.get(*NAMES)]
        for _ in range(4):
            instance.set_slopes(**slopes)
            instance.step(h)
            samples.append(instance.get(*NAMES))
        assert instance.get(*inputs) == pytest.approx(
            [x + 4.0 * h * slopes[name] for x, name in zip(start_values, inputs, strict=True)]
        )
        for order, rates in zip(ORDERS, derivatives, strict=True):
            weights, denominator = WEIGHTS[order]
            expected = np.array(weights) @ np.array(samples) / (denominator * h**order)
            scale = max(np.abs(expected))
            assert rates == pytest.approx(expected, rel=0.02 * order, abs=1e-3 * scale), order


def test_derivatives_are_one_sided_at_an_event_and_after_a_jump_of_inputs(folder: Path) -> None:
    with FmuInstance(folder).begin() as instance:
        instance.step(3.1)
        (separation_time,) = instance.get("last_event")
    with FmuInstance(folder).begin() as instance:
        # Just before separation the contact force falls; off the belt it is zero.
        instance.step(separation_time - 1e-6)
        assert output_derivatives(instance, ["P"], 1)[0] < -10.0
        instance.step(1e-6)
        instance.fmi.doStep(instance.t, 1e-9)
        assert instance.get("mode") == [Mode.SEPARATED]
        assert [output_derivatives(instance, ["P"], order) for order in ORDERS] == [[0.0]] * 3
    with FmuInstance(folder).begin() as instance:
        instance.step(0.9)
        (before,) = output_derivatives(instance, ["vy"], 1)
        instance.set(F=80.0 + 10.0)
        (after,) = output_derivatives(instance, ["vy"], 1)
        assert after - before == pytest.approx(-10.0 / 5.0)
        assert instance.get("ay") == pytest.approx([after])


def test_both_versions_of_fmi_give_the_same_derivatives(folder: Path, tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "3.fmu", flavour="native", fmi="3")
    fmpy.extract(str(fmu), str(tmp_path / "3"))
    references = [REFERENCES[name] for name in NAMES]
    with FmuInstance(folder).begin() as instance:
        instance.step(0.9)
        expected = [output_derivatives(instance, NAMES, order) for order in ORDERS]
    model: Any = fmpy.instantiate_fmu(str(tmp_path / "3"), fmpy.read_model_description(str(fmu)))
    model.enterInitializationMode()
    model.exitInitializationMode()
    model.doStep(0.0, 0.9)
    count = len(NAMES)
    values = (fmpy.fmi3.fmi3Float64 * count)()
    for order, row in zip(ORDERS, expected, strict=True):
        model.fmi3GetOutputDerivatives(
            model.component,
            (fmpy.fmi3.fmi3ValueReference * count)(*references),
            count,
            (fmpy.fmi3.fmi3Int32 * count)(*[order] * count),
            values,
            count,
        )
        assert list(values) == row
    model.freeInstance()


def test_derivatives_that_do_not_exist_are_refused(folder: Path) -> None:
    with FmuInstance(folder) as instance:
        with pytest.raises(FMICallException):
            output_derivatives(instance, ["P"], 1)
        assert "get_real_output_derivatives is not allowed before" in instance.log[-1]
        instance.begin()
        for name in ("mode", "separations", "F", "k1"):
            with pytest.raises(FMICallException):
                output_derivatives(instance, [name], 1)
            assert "must be that of a continuous output" in instance.log[-1]
        for order in (0, 4):
            with pytest.raises(FMICallException):
                output_derivatives(instance, ["P"], order)
            assert f"order of an output derivative = {order}: must be from 1" in instance.log[-1]


def test_derivatives_of_the_brake_actuator_follow_from_its_equation(tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "a.fmu", component="brake-actuator", flavour="native")
    fmpy.extract(str(fmu), str(tmp_path / "a"))
    tau, gain, slope = 0.2, 0.5, 30.0
    with FmuInstance(tmp_path / "a").begin(command=100.0, P=30.0, tau=tau, gain=gain) as actuator:
        actuator.step(0.1)
        actuator.set_slopes(command=slope)
        (rate,) = actuator.get("F_rate")
        # tau dF/dt = command + gain (command − P) − F, with the contact force P.
        second = ((1.0 + gain) * slope - rate) / tau
        expected = [rate, second, -second / tau, second / tau**2]
        for order in ORDERS:
            rates = output_derivatives(actuator, ["F", "F_rate"], order)
            assert rates == pytest.approx(expected[order - 1 : order + 1])


def test_with_derivatives_a_coupled_system_converges_to_second_order() -> None:
    coupled = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "fmu_coupled.py"))[
        "coupled"
    ]
    t_end, counts = 1.0, (80, 160, 320)
    exact, _ = coupled(1280, t_end, extrapolate=True)

    def error_orders(*, extrapolate: bool) -> list[float]:
        # Exponents p of errors that are proportional to h^p.
        errors = [abs(coupled(n, t_end, extrapolate=extrapolate)[0] - exact) for n in counts]
        return np.log2(np.divide(errors[:-1], errors[1:])).tolist()  # type: ignore[no-any-return]

    assert error_orders(extrapolate=False) == pytest.approx([1.0] * 2, abs=0.2)
    assert np.mean(error_orders(extrapolate=True)) >= 1.9
