"""The native FMU of FMI 3.0: the motion is the same with and without announced events."""

import ctypes
import itertools
import math
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from lxml import etree

from fivtui import Parameters, simulate
from fivtui.fmu.check import check_fmu
from fivtui.model import Mode
from fmu_src.build.builder import build_fmu
from fmu_src.build.components import COMPONENTS
from fmu_src.slave.variables import REFERENCES, VARIABLES
from tests.support.fmu_exchange import INDICATORS

STATES = ("x", "vx", "y", "vy")
COUNTS = ("mode", "separations", "reattachments", "last_event")
DISCARD = 2
# Value references after those of the table: the time, and the first event indicator.
TIME, FIRST_INDICATOR = len(VARIABLES), len(VARIABLES) + 1


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmu")
    return build_fmu(folder / "slider_belt_3.fmu", flavour="native", fmi="3")


@pytest.fixture(scope="module")
def folder(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    extracted = tmp_path_factory.mktemp("extracted")
    fmpy.extract(str(fmu), str(extracted))
    return extracted


@contextmanager
def instance(
    folder: Path, *, events: bool, kind: str = "CoSimulation", **values: Any
) -> Iterator[Any]:
    """An initialized instance, in step mode or event mode."""
    log: list[str] = []
    model = fmpy.instantiate_fmu(
        str(folder),
        fmpy.read_model_description(str(folder)),
        fmi_type=kind,
        debug_logging=True,
        logger=lambda *args: log.append(args[-1].decode()),
        event_mode_used=events,
        early_return_allowed=events,
    )
    for name, value in values.items():
        setter = model.setBoolean if isinstance(value, bool) else model.setFloat64
        setter([REFERENCES[name]], [value])
    model.enterInitializationMode(tolerance=None, startTime=0.0, stopTime=None)
    model.exitInitializationMode()
    model.log = log
    yield model
    model.freeInstance()


def read(model: Any, *names: str) -> list[float]:
    values: list[float] = model.getFloat64([REFERENCES[name] for name in names])
    return values


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_fmu_follows_the_schema_and_has_no_problems(component: str, tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "m.fmu", component=component, flavour="native", fmi="3")
    assert validate_fmu(str(fmu)) == []
    assert check_fmu(fmu) == []
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3ModelDescription.xsd"
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("modelDescription.xml")
    etree.XMLSchema(etree.parse(schema)).assertValid(etree.fromstring(text))


def test_event_indicators_are_separate_local_variables(folder: Path) -> None:
    description = fmpy.read_model_description(str(folder))
    indicators = [unknown.variable for unknown in description.eventIndicators]
    references = [indicator.valueReference for indicator in indicators]
    indicator_names = [indicator.name for indicator in indicators]
    assert indicator_names[0] == "event_indicator"
    assert references == [FIRST_INDICATOR + n for n in range(INDICATORS)]
    assert {(v.causality, v.variability) for v in indicators} == {("local", "continuous")}
    names = [v.name for v in description.modelVariables]
    assert names == [*(v.name for v in VARIABLES), "time", *indicator_names]
    for speed in (None, 0.0, 1.0):
        values: dict[str, Any] = {"finite_belt": True, "v_belt": speed} if speed is not None else {}
        with instance(folder, events=False, kind="ModelExchange", **values) as model:
            read_values = model.getFloat64(references)
            buffer = (ctypes.c_double * INDICATORS)()
            model.getEventIndicators(buffer, INDICATORS)
            assert read_values == list(buffer)
            (y,) = read(model, "y")
            # Besides y, only the indicators that can end the mode are not 1. At rest at the start,
            # the slider slips on a belt that moves, and sticks to one at rest.
            v_r = forward_margin = backward_margin = 1.0
            if speed == 1.0:
                (vx,) = read(model, "vx")
                v_r = 1.0 - vx
            elif speed == 0.0:
                friction, P = read(model, "friction_slider", "P")
                friction_limit = Parameters().mu * P
                forward_margin = friction_limit - friction
                backward_margin = friction_limit + friction
            expected = [y, v_r, forward_margin, backward_margin]
            assert read_values == pytest.approx(expected, rel=1e-14)


def record_events(folder: Path, t_end: float, **values: Any) -> list[tuple[float, ...]]:
    """Time, mode before and after, and number of sticks, at every event of a run."""
    events = []
    with instance(folder, events=True, **values) as model:
        model.enterStepMode()
        t = 0.0
        while t < t_end:
            event, _, _, t = model.doStep(t, t_end - t)
            if event:
                (before,) = read(model, "mode")
                model.enterEventMode()
                events.append((t, before, *read(model, "mode", "sticks")))
                model.updateDiscreteStates()
                model.enterStepMode()
    return events


def test_stick_and_slip_are_announced_as_events(folder: Path) -> None:
    p = Parameters(v_belt=2.0, mu_s=0.8, v_s=0.4)
    x, vx, y, vy = start = (2.0, 8.0, 1.0, 0.0)
    starts = {"x_start": x, "vx_start": vx, "y_start": y, "vy_start": vy}
    flags = {"finite_belt": True, "start_static": False}
    values: dict[str, Any] = {**p.as_dict(), **starts, **flags}
    native = simulate(p, t_end=6.0, start=start)
    events = record_events(folder, 6.0, **values)
    changes = [(t, before, after) for t, before, after, _ in events]
    assert changes == [tuple(change) for change in native.mode_changes]
    *_, (_, _, _, sticks) = events
    assert sticks == native.events.sticks
    # CONTACT is a mode of a belt that is always faster; all others occur.
    assert {after for _, _, after in changes} == {*Mode} - {Mode.CONTACT}


@pytest.mark.parametrize("h", [0.01, 1.0])
def test_every_switch_is_announced_at_its_time(fmu: Path, h: float) -> None:
    native = simulate(kernel="compiled")
    run = fmpy.simulate_fmu(
        str(fmu),
        stop_time=100.0,
        output_interval=h,
        fmi_type="CoSimulation",
        use_event_mode=True,
        early_return_allowed=True,
        output=["x", "y", *COUNTS],
    )
    switched = run["time"][1:][np.diff(run["mode"]) != 0.0]
    # Of the default parameters over 100 s.
    separations, reattachments = 74, 73
    assert native.events.separations == separations
    assert native.events.reattachments == reattachments
    assert switched.size == separations + reattachments
    assert np.array_equal(switched, native.switch_times)
    assert (run["x"][-1], run["y"][-1]) == (native.final.x, native.final.y)
    assert (run["separations"][-1], run["reattachments"][-1]) == (separations, reattachments)


@pytest.mark.parametrize("events", [False, True])
def test_importers_with_and_without_event_mode_get_the_native_motion(
    folder: Path, events: bool
) -> None:
    times = [0.37 * number for number in range(1, 100)]
    native = simulate(t_end=times[-1], samples=times, kernel="compiled").trajectory
    assert native is not None
    t, rows, early_returns = 0.0, [], 0
    with instance(folder, events=events) as model:
        if events:
            model.enterStepMode()
        for end in times:
            while t < end:
                event, stops, early, t = model.doStep(t, end - t)
                assert not stops
                assert event == early or t == end
                early_returns += early
                if event:
                    model.enterEventMode()
                    model.updateDiscreteStates()
                    model.enterStepMode()
            assert model.getFloat64([TIME]) == [t]
            rows.append(read(model, *STATES, "P", "mode"))
    assert (early_returns > 10) == events
    for row, t_row, *exact in zip(
        rows, times, *(getattr(native, name) for name in (*STATES, "P", "mode")), strict=True
    ):
        # The end of a step from a switch, t + (end − t), may differ from `end` by rounding; the
        # values are those at that time.
        assert row == pytest.approx(exact, rel=1e-13, abs=1e-13), t_row
    if not events:
        assert [row[0] for row in rows] == pytest.approx(native.x.tolist(), rel=1e-13)


def test_mode_and_counts_change_in_the_event_mode(folder: Path) -> None:
    native = simulate(t_end=5.0, kernel="compiled")
    first = float(native.switch_times[0])
    with instance(folder, events=True) as model:
        model.enterStepMode()
        assert model.doStep(0.0, 5.0) == (True, False, True, first)
        state = model.getFMUState()
        data = model.serializeFMUState(state)
        assert read(model, *COUNTS) == [1.0, 0.0, 0.0, 0.0]
        assert read(model, "y") == [pytest.approx(0.0, abs=1e-13)]
        model.enterEventMode()
        assert read(model, *COUNTS) == [0.0, 1.0, 0.0, first]
        model.updateDiscreteStates()
        model.enterStepMode()
        model.setFMUState(state)
        model.freeFMUState(state)
        assert read(model, *COUNTS) == [1.0, 0.0, 0.0, 0.0]
        with instance(folder, events=True) as restored:
            copy = restored.deserializeFMUState(data)
            restored.setFMUState(copy)
            restored.freeFMUState(copy)
            assert read(restored, *COUNTS) == [1.0, 0.0, 0.0, 0.0]
            restored.enterEventMode()
            assert read(restored, *COUNTS) == [0.0, 1.0, 0.0, first]
        # A step that skips the event mode gives the right motion as well.
        model.doStep(first, 0.01)
        assert read(model, *COUNTS) == [0.0, 1.0, 0.0, first]


def test_a_step_that_ends_at_a_switch_does_not_return_early(folder: Path) -> None:
    first = float(simulate(t_end=5.0, kernel="compiled").switch_times[0])
    with instance(folder, events=True) as model:
        model.enterStepMode()
        assert model.doStep(0.0, first) == (True, False, False, first)


def test_a_step_in_event_mode_is_refused_even_if_the_motion_is_computed(folder: Path) -> None:
    with instance(folder, events=True) as model:
        model.enterStepMode()
        # This computes the motion well beyond 2 ms; a step up to there skips most checks.
        model.doStep(0.0, 1e-3)
        model.enterEventMode()
        with pytest.raises(FMICallException):
            model.doStep(1e-3, 1e-3)
        assert model.log[-1] == "do_step is not allowed in event mode"
        model.enterStepMode()
        *_, reached = model.doStep(1e-3, 1e-3)
        assert reached == 2e-3


@pytest.mark.parametrize(("tol", "error"), [(1e-6, 0.2), (1e-10, 1e-4)])
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
    assert run["y"][-1] == pytest.approx(native.final.y, abs=error)


def test_adjoint_and_directional_derivatives_share_one_jacobian(folder: Path) -> None:
    unknowns = [REFERENCES[name] for name in ("vx", "vy", "ax", "ay", "P", "friction_slider")]
    knowns = [REFERENCES[name] for name in (*STATES, "F", "mu")]
    with instance(folder, events=False, kind="ModelExchange") as model:
        matrix = np.array(
            [model.getDirectionalDerivative(unknowns, knowns, row.tolist()) for row in np.eye(6)]
        ).T
        adjoint = np.array(
            [model.getAdjointDerivative(unknowns, knowns, row.tolist()) for row in np.eye(6)]
        )
    assert np.array_equal(matrix, adjoint)
    # vx, vy and P each depend on 1 known, friction on y and μ, ax on x, vx, y, μ, and ay on x, y,
    # vy, F.
    assert np.count_nonzero(matrix) == 3 + 2 + 4 + 4


@pytest.mark.parametrize("function", ["getDirectionalDerivative", "getAdjointDerivative"])
def test_a_derivative_that_is_not_finite_is_discarded(folder: Path, function: str) -> None:
    unknowns, knowns = ("ax", "ay"), ("x", "y")
    seeded = knowns if function == "getDirectionalDerivative" else unknowns
    references = [[REFERENCES[name] for name in names] for names in (unknowns, knowns)]
    with instance(folder, events=False) as model:
        for index, seed in itertools.product(range(2), (math.nan, math.inf, -math.inf, 1e308)):
            seeds = [0.0, 0.0]
            seeds[index] = seed
            with pytest.raises(FMICallException) as refused:
                getattr(model, function)(*references, seeds)
            assert refused.value.status == DISCARD
            message = (
                "is not a finite number"
                if seed == 1e308
                else f"seed of {seeded[index]} = {seed}: must"
            )
            assert message in model.log[-1]


def test_variables_are_read_by_their_types(folder: Path) -> None:
    with instance(folder, events=False) as model:
        assert model.getInt32([REFERENCES["mode_integer"]]) == [1]
        assert model.getInt64([REFERENCES["mode_enumeration"]]) == [1]
        assert model.getBoolean([REFERENCES["separation"]]) == [True]


def test_unsupported_calls_are_refused(folder: Path) -> None:
    with instance(folder, events=False) as model:
        wrong = {
            "no variable is of type Float32": lambda: model.getFloat32([0]),
            "no variable of type UInt16 can be set": lambda: model.setUInt16([0], [1]),
            "there are no clocks": lambda: model.getClock([0]),
            "enter_event_mode: the instance was created without event mode": model.enterEventMode,
            "enter_step_mode is not allowed while stepping": model.enterStepMode,
            "m cannot be set while stepping": lambda: model.setFloat64([0], [2.0]),
            "there are no structural parameters": model.enterConfigurationMode,
            "mu = -1: must be from 0 to 100": lambda: model.setFloat64([REFERENCES["mu"]], [-1.0]),
        }
        for message, call in wrong.items():
            with pytest.raises(FMICallException):
                call()
            assert message in model.log[-1]
        assert model.doStep(0.0, 1.0) == (False, False, False, 1.0)
