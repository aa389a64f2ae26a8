"""Intermediate updates by the native FMU of FMI 3.0: outputs, inputs, early returns in a step."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree as ET

import fmpy
import pytest
from fmpy.fmi1 import FMICallException

from fivtui import Parameters, simulate
from fmu_src.build.builder import build_fmu
from fmu_src.slave.actuator_variables import ACTUATOR_TABLE
from fmu_src.slave.variables import REFERENCES, VARIABLES
from tests.support.fmu_instance import FmuInstance

STATES: Final = ("x", "vx", "y", "vy")
INPUTS: Final = ("F", "mu")


class Update(NamedTuple):
    """Time and flags of an intermediate update."""

    time: float
    set_requested: bool
    get_allowed: bool
    finished: bool
    can_return: bool


# Returns the time of an early return, or None.
OnUpdate = Callable[[Any, Update], float | None]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("intermediate")
    fmpy.extract(str(build_fmu(root / "m.fmu", flavour="native", fmi="3")), str(root / "m"))
    return root / "m"


@contextmanager
def instance_with_updates(
    folder: Path,
    on_update: OnUpdate,
    *,
    needs: tuple[str | int, ...] = STATES,
    events: bool = False,
    early: bool = False,
    values: Mapping[str, float | bool] | None = None,
) -> Iterator[Any]:
    """An instance in step mode that calls `on_update` in its steps; `log` has messages.

    `needs` are the variables that the importer requires, by name or value reference.
    """
    description = fmpy.read_model_description(str(folder))
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = fmpy.fmi3.FMU3Slave(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="updated",
    )
    slave.log, slave.updates, slave.handled = [], [], 0

    def update(_: Any, *arguments: Any) -> None:
        # The callback answers through two pointers: whether to return early, and when.
        *fields, return_requested, early_return_time = arguments
        received = Update(*fields)
        slave.updates.append(received)
        # ctypes prints exceptions of callbacks instead of raising them: count the handled updates.
        return_time = on_update(slave, received)
        slave.handled += 1
        if return_time is not None:
            return_requested[0], early_return_time[0] = True, return_time

    slave.instantiate(
        eventModeUsed=events,
        earlyReturnAllowed=early,
        logMessage=fmpy.fmi3.fmi3LogMessageCallback(
            lambda *args: slave.log.append(args[-1].decode())
        ),
        intermediateUpdate=update,
        requiredIntermediateVariables=[references.get(need, need) for need in needs],
    )
    for name, value in (values or {}).items():
        setter = slave.setBoolean if isinstance(value, bool) else slave.setFloat64
        setter([references[name]], [value])
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()
    if events:
        slave.enterStepMode()
    yield slave
    slave.freeInstance()
    assert slave.handled == len(slave.updates)


def read(slave: Any, *names: str) -> list[float]:
    values: list[float] = slave.getFloat64([REFERENCES[name] for name in names])
    return values


def test_outputs_are_read_where_steps_of_the_motion_end(folder: Path) -> None:
    recorded: list[tuple[float, list[float]]] = []

    def record(slave: Any, update: Update) -> None:
        assert update.get_allowed
        assert update.finished
        assert not update.set_requested
        assert not update.can_return
        recorded.append((update.time, read(slave, *STATES)))

    points = [0.5, 1.75, 6.0]
    with instance_with_updates(folder, record) as slave:
        t = 0.0
        for end in points:
            assert slave.doStep(t, end - t) == (False, False, False, end)
            assert recorded[-1] == (end, read(slave, *STATES))
            t = end
    times = [time for time, _ in recorded]
    assert times == sorted(set(times))
    assert len(times) > 30
    native = simulate(t_end=30.0, samples=[0.0, *times], kernel="compiled").trajectory
    assert native is not None
    exact = list(zip(*(getattr(native, name)[1:].tolist() for name in STATES), strict=True))
    assert [tuple(row) for _, row in recorded] == exact


def preload_at(t: float) -> float:
    return 80.0 + 10.0 * math.sin(3.0 * t)


def set_preload(slave: Any, update: Update) -> None:
    """Set the inputs at the end of a part of the step."""
    if update.set_requested:
        assert (update.get_allowed, update.finished) == (False, False)
        slave.setFloat64([REFERENCES["F"]], [preload_at(update.time)])


def test_inputs_are_interpolated_like_input_derivatives(folder: Path, tmp_path: Path) -> None:
    fmpy.extract(str(build_fmu(tmp_path / "2.fmu", flavour="native")), str(tmp_path / "2"))
    h, count = 0.01, 300
    with (
        instance_with_updates(
            folder, set_preload, needs=("F",), values={"F": preload_at(0.0)}
        ) as slave,
        FmuInstance(tmp_path / "2").begin(F=preload_at(0.0)) as ramped,
    ):
        for n in range(count):
            t = n * h
            slave.doStep(t, h)
            ramped.set(F=preload_at(t))
            ramped.set_slopes(F=(preload_at(t + h) - preload_at(t)) / h)
            ramped.fmi.doStep(t, h)
        assert read(slave, "F")[0] == pytest.approx(preload_at(count * h), rel=1e-14)
        # Where an integrator step ends inside a communication step, F follows two lines, not one.
        assert read(slave, *STATES) == pytest.approx(ramped.get(*STATES), rel=1e-5)


def test_inputs_may_change_within_long_steps(folder: Path) -> None:
    final_heights = []
    # Short steps, long steps, and long steps with constant F: the importer does not require it.
    for h, needs in ((0.002, ("F",)), (2.0, ("F",)), (2.0, STATES)):
        with instance_with_updates(
            folder, set_preload, needs=needs, values={"F": preload_at(0.0)}
        ) as slave:
            for n in range(round(4.0 / h)):
                slave.doStep(n * h, h)
            final_heights += read(slave, "y")
    by_short_steps, by_long_steps, under_constant_force = final_heights
    assert abs(by_long_steps - by_short_steps) < 0.02 < abs(under_constant_force - by_short_steps)


@pytest.mark.parametrize("h", [0.5, 3.0])
def test_a_belt_that_slows_down_within_steps_gives_the_motion_under_a_table_of_its_speed(
    folder: Path, h: float
) -> None:
    def slow_down(slave: Any, update: Update) -> None:
        if update.set_requested:
            slave.setFloat64([REFERENCES["v_belt"]], [2.0 - 0.25 * update.time])

    friction = {"mu_s": 0.8, "v_s": 0.4}
    values = {**friction, "v_belt": 2.0, "finite_belt": True}
    with instance_with_updates(folder, slow_down, needs=("v_belt",), values=values) as slave:
        for n in range(round(6.0 / h)):
            slave.doStep(n * h, h)
        *state, sticks, switches = read(slave, *STATES, "sticks", "switches")
    # Times and speeds of the belt, s and m/s.
    run = simulate(Parameters(**friction), t_end=6.0, over_time={"v_belt": [(0, 2), (6, 0.5)]})
    assert state == pytest.approx(run.final[1:], abs=1e-9)
    assert sticks == run.events.sticks
    # `transitions` has the number of switches of each kind.
    assert switches == sum(run.events.transitions.values())
    assert run.events.sticks > 2


def test_constant_inputs_do_not_change_the_bits(folder: Path) -> None:
    p = Parameters()

    def hold_inputs(slave: Any, update: Update) -> None:
        if update.set_requested:
            slave.setFloat64([REFERENCES[name] for name in INPUTS], [p.F, p.mu])

    with instance_with_updates(folder, hold_inputs, needs=INPUTS) as slave:
        slave.doStep(0.0, 7.0)
        requests = [update.time for update in slave.updates if update.set_requested]
        reached = [update.time for update in slave.updates if update.finished]
        assert requests == reached
        final = simulate(t_end=7.0, kernel="compiled").final
        assert read(slave, *STATES) == [final.x, final.vx, final.y, final.vy]


@pytest.mark.parametrize("needs", [STATES, INPUTS])
@pytest.mark.parametrize(
    ("requested", "is_ahead"), [(0.777, True), (0.0, False), (math.nan, False), (-5.0, False)]
)
def test_an_early_return_ends_at_the_requested_time_if_it_is_ahead(
    folder: Path, needs: tuple[str, ...], requested: float, is_ahead: bool
) -> None:
    def return_early(slave: Any, _: Update) -> float | None:
        return requested if len(slave.updates) == 3 else None

    with instance_with_updates(folder, return_early, needs=needs, early=True) as slave:
        event, stops, early, t = slave.doStep(0.0, 2.0)
        assert slave.updates[0].can_return
        assert (event, stops, early) == (False, False, True)
        part_ends = [update.time for update in slave.updates if update.finished]
        # At a time that is not ahead, the step returns at once, with the parts computed so far.
        assert t == (requested if is_ahead else part_ends[-1])
        assert slave.doStep(t, 2.0 - t) == (False, False, False, 2.0)
        assert read(slave, "y") == [simulate(t_end=2.0, kernel="compiled").final.y]


def test_early_returns_are_ignored_unless_allowed(folder: Path) -> None:
    with instance_with_updates(folder, lambda _, update: update.time) as slave:
        assert slave.doStep(0.0, 2.0) == (False, False, False, 2.0)
        assert not any(update.can_return for update in slave.updates)


def test_switches_are_announced_in_steps_with_updates(folder: Path) -> None:
    native = simulate(t_end=20.0, kernel="compiled").switch_times.tolist()
    with instance_with_updates(folder, set_preload, needs=(), events=True, early=True) as slave:
        for switch in native:
            t = slave.updates[-1].time if slave.updates else 0.0
            while True:
                event, _, early, t = slave.doStep(t, 1.0)
                assert slave.updates[-1].time == t
                if event:
                    break
                assert not early
            assert (early, t) == (True, pytest.approx(switch, abs=1e-12))
            slave.enterEventMode()
            slave.updateDiscreteStates()
            slave.enterStepMode()


def test_calls_that_an_intermediate_update_does_not_allow_are_refused(folder: Path) -> None:
    messages: list[str] = []

    def misuse(slave: Any, update: Update) -> None:
        calls: list[Callable[[], Any]] = [
            lambda: slave.setFloat64([REFERENCES["m"]], [2.0]),
            lambda: slave.setFloat64([REFERENCES["mu"]], [0.5]),
            lambda: slave.doStep(update.time, 1.0),
            slave.getFMUState,
            slave.reset,
            slave.terminate,
            lambda: slave.getDirectionalDerivative([REFERENCES["ax"]], [REFERENCES["F"]], [1.0]),
        ]
        if update.finished:
            calls.append(lambda: slave.setFloat64([REFERENCES["F"]], [70.0]))
        else:
            calls.append(lambda: read(slave, "y"))
            calls.append(lambda: slave.setFloat64([REFERENCES["F"]], [math.inf]))
        for call in calls:
            with pytest.raises(FMICallException):
                call()
            messages.append(slave.log[-1])
        slave.fmi3FreeInstance(slave.component)
        messages.append(slave.log[-1])

    with instance_with_updates(folder, misuse, needs=("F",)) as slave:
        assert slave.doStep(0.0, 1.0) == (False, False, False, 1.0)
        assert read(slave, "y") == [simulate(t_end=1.0, kernel="compiled").final.y]
        *_, reached = slave.doStep(1.0, 1e-3)
        assert reached == 1.001
    assert {
        "m cannot be set during an intermediate update",
        "mu cannot be set during an intermediate update",
        "F cannot be set during an intermediate update",
        "do_step is not allowed during an intermediate update",
        "get_fmu_state is not allowed during an intermediate update",
        "reset is not allowed during an intermediate update",
        "terminate is not allowed during an intermediate update",
        "free_instance is not allowed during an intermediate update",
        "get_directional_derivative is not allowed during an intermediate update",
        "values cannot be read while an update asks for inputs",
    } <= set(messages)


def test_a_step_that_fails_in_a_later_part_leaves_the_instance_unchanged(folder: Path) -> None:
    # Without the cubic spring the equations are linear, and so much friction makes them unstable.
    unstable = {"k_nl": 0.0, "mu": 90.0}

    def raise_force(slave: Any, update: Update) -> None:
        if update.set_requested:
            slave.setFloat64([REFERENCES["F"]], [80.0 + update.time])

    with instance_with_updates(folder, raise_force, needs=("F",), values=unstable) as slave:
        slave.doStep(0.0, 0.5)
        before = read(slave, *STATES, "F")
        with pytest.raises(FMICallException):
            slave.doStep(0.5, 1e5)
        assert "grows beyond the floating-point range" in slave.log[-1]
        assert read(slave, *STATES, "F") == before
        *_, reached = slave.doStep(0.5, 0.5)
        assert reached == 1.0
        final_values = read(slave, *STATES, "F")
    with instance_with_updates(folder, raise_force, needs=("F",), values=unstable) as slave:
        slave.doStep(0.0, 0.5)
        slave.doStep(0.5, 0.5)
        assert read(slave, *STATES, "F") == final_values


def test_an_importer_that_requires_all_variables_gets_the_continuous_ones(folder: Path) -> None:
    variables = fmpy.read_model_description(str(folder)).modelVariables
    states: list[list[float]] = []

    def record(slave: Any, update: Update) -> None:
        if update.get_allowed:
            states.append(read(slave, *STATES, "mode"))

    with instance_with_updates(folder, record, needs=tuple(v.name for v in variables)) as slave:
        # Those after the table, the time and the event indicators, are ignored without a message.
        ignored = [v.name for v in VARIABLES if v.variability != "continuous"]
        assert {"mode", "m", "separations", "separation"} <= set(ignored)
        assert slave.log == [
            f"required intermediate variable {name} is not continuous: ignored" for name in ignored
        ]
        slave.doStep(0.0, 2.0)
        final = simulate(t_end=2.0, kernel="compiled").final
        assert states[-1][:4] == [final.x, final.vx, final.y, final.vy]


def test_unknown_variables_cannot_be_required(folder: Path) -> None:
    # References are 0, 1, …, without gaps.
    unused_reference = len(fmpy.read_model_description(str(folder)).modelVariables)
    with (
        pytest.raises(Exception, match="Failed to instantiate"),
        instance_with_updates(folder, set_preload, needs=("F", unused_reference)),
    ):
        pass


def test_continuous_variables_are_available_in_updates(folder: Path) -> None:
    description = ET.parse(folder / "modelDescription.xml")
    variables = description.findall("ModelVariables/*[@intermediateUpdate='true']")
    available = {str(v.get("name")) for v in variables}
    assert {"F", "mu", "x", "ay"} <= available
    assert not {"mode", "m", "separations"} & available
    assert len(available) == sum(v.variability == "continuous" for v in VARIABLES)


def test_the_brake_actuator_follows_a_command_that_ramps(tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "a.fmu", component="brake-actuator", flavour="native", fmi="3")
    fmpy.extract(str(fmu), str(tmp_path / "a"))
    references = ACTUATOR_TABLE.references
    tau = 0.05

    def ramp(slave: Any, update: Update) -> None:
        if update.set_requested:
            slave.setFloat64([references["command"]], [80.0 + 100.0 * update.time])

    start_values = {"F_start": 80.0, "gain": 0.0, "tau": tau}
    with instance_with_updates(
        tmp_path / "a", ramp, needs=("command", "F"), values=start_values
    ) as slave:
        slave.doStep(0.0, 0.25)
        assert [update.time for update in slave.updates] == [0.25, 0.25]
        exact = 80.0 + 100.0 * (0.25 - tau * (1.0 - math.exp(-0.25 / tau)))
        assert slave.getFloat64([references["F"]]) == pytest.approx([exact], rel=1e-13)
