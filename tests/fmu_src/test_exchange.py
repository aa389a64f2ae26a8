"""FMI 3.0 model exchange: fmpy's CVode integrates, and finds the switches as zeros of y."""

import re
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fivtui import Parameters, simulate
from fivtui.fmu.check import check_fmu
from fivtui.model.errors import InputError
from fmu_src.build.builder import build_fmu
from fmu_src.slave.exchange import EXCHANGE_TABLE
from tests.support.fmu_driver import Call, Driver

RECORD = [("time", float), ("F", float), ("mu", float)]
needs_wrapper = pytest.mark.skipif(
    find_spec("pythonfmu3") is None, reason="pythonfmu3 is not installed (extra fmi3)"
)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_fmu(tmp_path_factory.mktemp("fmu") / "slider_belt_3.fmu", fmi="3")


@needs_wrapper
def test_it_follows_the_schema_and_is_sound(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []
    assert check_fmu(fmu) == []
    folder = Path(fmpy.__file__).parent / "schema" / "fmi3"
    schema = etree.XMLSchema(etree.parse(folder / "fmi3ModelDescription.xsd"))
    with zipfile.ZipFile(fmu) as archive:
        schema.assertValid(etree.fromstring(archive.read("modelDescription.xml")))


@needs_wrapper
def test_it_is_described_as_what_it_is(fmu: Path) -> None:
    description = fmpy.read_model_description(fmu)
    assert description.fmiVersion == "3.0"
    assert description.coSimulation is None
    assert description.numberOfContinuousStates == 4
    assert [u.variable.name for u in description.eventIndicators] == ["switching"]
    # The slave puts its states and derivatives in this order.
    derivatives = {u.variable.derivative.name: u.variable for u in description.derivatives}
    assert list(derivatives) == ["x", "vx", "y", "vy"]
    assert len(description.modelVariables) == len(EXCHANGE_TABLE.variables) + 1


@needs_wrapper
@pytest.mark.parametrize(("tol", "error"), [(1e-6, 0.2), (1e-8, 5e-3), (1e-10, 1e-4)])
def test_the_importer_finds_the_native_switches(fmu: Path, tol: float, error: float) -> None:
    native = simulate(t_end=50.0)
    run = fmpy.simulate_fmu(str(fmu), stop_time=50.0, output_interval=0.05, relative_tolerance=tol)
    assert run["separations"][-1] == native.events.separations
    assert run["reattachments"][-1] == native.events.reattachments
    assert run["last_event"][-1] == pytest.approx(native.switch_times[-1], abs=error)
    assert (run["x"][-1], run["y"][-1]) == pytest.approx(
        (native.final.x, native.final.y), abs=error
    )
    assert np.all(run["P"] >= -1e-6)


@needs_wrapper
def test_parameters_and_the_switch_of_the_model_reach_it(fmu: Path) -> None:
    native = simulate(Parameters(F=60.0, k_nl=50.0, mu=0.9), t_end=10.0, separation=False)
    start = {"F": 60.0, "k_nl": 50.0, "mu": 0.9, "separation": False}
    run = fmpy.simulate_fmu(str(fmu), stop_time=10.0, relative_tolerance=1e-9, start_values=start)
    assert run["y"][-1] == pytest.approx(native.final.y, abs=1e-4)
    assert run["separations"][-1] == 0.0


@needs_wrapper
def test_inputs_may_jump(fmu: Path) -> None:
    rows = [(0.0, 80.0, 0.7), (5.0, 80.0, 0.7), (5.0, 120.0, 0.7), (10.0, 120.0, 0.7)]
    table = np.array(rows, dtype=RECORD)
    run = fmpy.simulate_fmu(str(fmu), stop_time=10.0, relative_tolerance=1e-9, input=table)
    first = simulate(t_end=5.0).final
    state = (first.x, first.vx, first.y, first.vy)
    second = simulate(Parameters(F=120.0), t_end=5.0, start=state).final
    assert run["y"][-1] == pytest.approx(second.y, abs=1e-4)


@needs_wrapper
@pytest.mark.parametrize("start", [{"m": 0.0}, {"mu": -1.0}, {"F": -1.0, "k3": 0.0}])
def test_what_is_refused_ends_the_simulation_and_nothing_crashes(
    fmu: Path, start: dict[str, float]
) -> None:
    code = f"""
import fmpy
for _ in range(8):
    try:
        fmpy.simulate_fmu({str(fmu)!r}, stop_time=1.0, start_values={start!r}, validate=False)
    except Exception as error:
        print(error)
"""
    done = subprocess.run(
        [sys.executable, "-I", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("requested termination") == 8


@needs_wrapper
def test_wrong_calls_crash_nothing_and_are_logged(fmu: Path) -> None:
    code = f"""
import fmpy
folder = fmpy.extract({str(fmu)!r})
description = fmpy.read_model_description(folder)
log = []
instance = fmpy.instantiate_fmu(folder, description, debug_logging=True,
                                logger=lambda *args: log.append(args[-1].decode()))
for _ in range(8):
    for kind in ("Int32", "Int64", "UInt64", "String", "Float64", "Boolean"):
        getattr(instance, f"get{{kind}}")([10_000])
    for kind in ("Int32", "Int64", "UInt64", "Float64"):
        getattr(instance, f"set{{kind}}")([10_000], [1])
    instance.exitInitializationMode()
print(len(log), all(log), len(set(log)))
instance.reset()
names = {{v.name: v.valueReference for v in description.modelVariables}}
instance.enterInitializationMode()
instance.exitInitializationMode()
print(instance.updateDiscreteStates()[1])
instance.setFloat64([names["m"]], [6.0])
print(instance.updateDiscreteStates()[1], instance.getFloat64([names["m"]]))
"""
    done = subprocess.run(
        [sys.executable, "-I", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    refused, legal, fixed = done.stdout.splitlines()
    assert refused.startswith("88 True")
    assert (legal, fixed) == ("False", "True [5.0]")


@needs_wrapper
def test_inputs_may_vary_continuously(fmu: Path, tmp_path: Path) -> None:
    table = np.array([(0.0, 80.0, 0.7), (5.0, 100.0, 0.7)], dtype=RECORD)
    # fmpy sets inputs once for every step of CVode, not for every right-hand side: 1e-3 at best.
    run = fmpy.simulate_fmu(str(fmu), stop_time=5.0, relative_tolerance=1e-8, input=table)
    # Held at its mean over short steps, the ramp has an error of second order in the other FMU.
    h, count = 0.0025, 2000
    calls: list[Call] = [("a", "begin")]
    for number in range(count):
        calls.append(("a", "set", {"F": 80.0 + 4.0 * (number + 0.5) * h}))
        calls.append(("a", "step", number * h, h))
    with Driver(build_fmu(tmp_path / "slider_belt.fmu")) as driver:
        (x, y) = driver.drive(*calls, ("a", "get", ["x", "y"]))[-1].value
    assert (run["x"][-1], run["y"][-1]) == pytest.approx((x, y), abs=1e-3)


@needs_wrapper
def test_many_instances_live_side_by_side(fmu: Path) -> None:
    folder = fmpy.extract(str(fmu))
    description = fmpy.read_model_description(folder)
    names = {v.name: v.valueReference for v in description.modelVariables}
    instances = [fmpy.instantiate_fmu(folder, description) for _ in range(100)]
    for number, instance in enumerate(instances):
        instance.setFloat64([names["F"]], [80.0 + number])
        instance.enterInitializationMode()
        instance.exitInitializationMode()
    for number, instance in enumerate(instances):
        assert instance.getFloat64([names["F"]]) == [80.0 + number]
        instance.terminate()
        instance.freeInstance()
    shutil.rmtree(folder)


@needs_wrapper
def test_the_same_project_builds_the_same_bytes(fmu: Path, tmp_path: Path) -> None:
    assert build_fmu(tmp_path / "again.fmu", fmi="3").read_bytes() == fmu.read_bytes()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"fmi": "1"}, "FMI 1: must be 2 or 3"),
        ({"fmi": "3", "component": "brake-actuator"}, "must be slider-belt"),
    ],
)
def test_what_there_is_not_is_refused(options: dict[str, str], said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        build_fmu(tmp_path / "m.fmu", **options)  # type: ignore[arg-type]


def test_without_its_wrapper_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fmu_src.build.builder.find_spec", lambda _name: None)
    with pytest.raises(InputError, match="pythonfmu3"):
        build_fmu(tmp_path / "m.fmu", fmi="3")
