"""Totals of the FMU: peaks, greatest velocity, range of the contact force, time off the belt."""

from pathlib import Path
from typing import Any, Final

import fmpy
import numpy as np
import pytest

from fivtui import Parameters, simulate
from fmu_src.build.builder import build_fmu
from fmu_src.slave.variables import TOTALS
from tests.support.fmu_instance import FmuInstance

T_END: Final = 20.0
CASES: Final[list[dict[str, Any]]] = [
    {},
    {"separation": False},
    {"v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4},
]


def expected_totals(values: dict[str, Any], **tables: Any) -> list[float]:
    separation = values.get("separation", True)
    p = Parameters(**{name: value for name, value in values.items() if name != "separation"})
    run = simulate(p, t_end=T_END, separation=separation, over_time=tables or None)
    peak, force = run.peak, run.contact_force
    return [
        *(peak.x_abs, peak.y_abs, peak.vx_max),
        *(force.min, force.max, run.events.separated_time),
    ]


def start_values(values: dict[str, Any]) -> dict[str, Any]:
    return {**values, "finite_belt": "v_belt" in values}


def run_outputs(fmu: Path, values: dict[str, Any], **options: Any) -> Any:
    return fmpy.simulate_fmu(
        str(fmu), stop_time=T_END, start_values=start_values(values), output=TOTALS, **options
    )


@pytest.mark.parametrize("values", CASES)
@pytest.mark.parametrize(("flavour", "fmi"), [("native", "2"), ("native", "3"), ("python", "2")])
def test_totals_equal_those_of_a_run_for_any_communication_step(
    flavour: str, fmi: str, values: dict[str, Any], tmp_path: Path
) -> None:
    fmu = build_fmu(tmp_path / "belt.fmu", flavour=flavour, fmi=fmi)
    expected = expected_totals(values)
    for step in (0.05, 1.25):
        outputs = run_outputs(fmu, values, output_interval=step, fmi_type="CoSimulation")
        for name in TOTALS:
            # Ranges only widen, up to rounding; the contact force alone has a lower end.
            widening = np.diff(outputs[name]) * (-1.0 if name == "P_min" else 1.0)
            assert (widening >= -1e-14 * np.abs(outputs[name][1:])).all(), name
        final = [outputs[name][-1] for name in TOTALS]
        if flavour == "native":
            assert final == expected
        else:
            assert final == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_totals_survive_changes_of_inputs_and_saved_states(folder: Path) -> None:
    # A ramp of the preload over the run, by slopes that are set at every step.
    expected = expected_totals({}, F=[(0.0, 60.0), (T_END, 100.0)])
    slope, h, count = (100.0 - 60.0) / T_END, 0.5, 40
    with FmuInstance(folder) as source, FmuInstance(folder) as target:
        source.begin(F=60.0), target.begin()
        for step in range(count):
            instance = source if step < count // 2 else target
            if step == count // 2:
                # Continue from serialised bytes in another instance.
                data = source.fmi.serializeFMUstate(source.fmi.getFMUstate())
                target.fmi.setFMUstate(target.fmi.deSerializeFMUstate(data))
                target.t = source.t
                assert target.get(*TOTALS) == source.get(*TOTALS)
            instance.set(F=60.0 + slope * h * step)
            instance.set_slopes(F=slope)
            instance.step(h)
        assert target.get(*TOTALS) == pytest.approx(expected, rel=1e-9)


def test_in_model_exchange_totals_are_those_at_completed_steps(fmu: Path) -> None:
    outputs = run_outputs(fmu, {}, fmi_type="ModelExchange", output_interval=0.01)
    expected = dict(zip(TOTALS, expected_totals({}), strict=True))
    for name in TOTALS:
        assert outputs[name][-1] == pytest.approx(expected[name], rel=1e-3, abs=1e-6), name
    for name in ("x_peak", "y_peak", "vx_max", "P_max"):
        assert outputs[name][-1] <= expected[name] * (1.0 + 1e-4), name
