"""Directional derivatives by the native FMU, in co-simulation and in initialization mode.

They are derivatives of unknowns (outputs and accelerations) by knowns (states, inputs, parameters).
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree as ET

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fivtui import Parameters
from fivtui.model.modes import Mode
from fivtui.model.slider_belt import jacobian, static_start_change
from fivtui.model.system import System
from fmu_src.build.builder import build_fmu
from fmu_src.slave.slider_belt import SliderBeltInstance
from fmu_src.slave.variable import Role, Type
from fmu_src.slave.variables import REFERENCES, TOTALS, VARIABLES
from tests.support.fmu_instance import FmuInstance

STATES: Final = ("x", "vx", "y", "vy")
INPUTS: Final = ("F", "mu")
PARAMETERS: Final = ("m", "k1", "k2", "k3", "c1", "c2", "k_nl")
KNOWNS: Final = (*STATES, *INPUTS, *PARAMETERS)
UNKNOWNS: Final = tuple(
    v.name
    for v in VARIABLES
    if v.type is Type.REAL and v.role in (Role.OUTPUT, Role.LOCAL) and not v.discrete
)
P: Final = Parameters(m=3.0, k1=90.0, k2=40.0, k3=50.0, c1=0.7, c2=0.4, F=60.0, k_nl=120.0, mu=0.9)
VALUES: Final = P.as_dict()
# Initial values for slip and stick on a belt of finite speed.
_BELT: Final[dict[str, float | bool]] = {
    "finite_belt": True,
    "v_belt": 1.5,
    "mu_s": 1.0,
    "v_s": 0.4,
    "start_static": False,
}
_SLIP: Final = {**_BELT, "x_start": 0.1, "vx_start": 0.2, "y_start": -0.5}
_STICK: Final = {**_SLIP, "vx_start": 1.5}
# Modes, initial values besides `VALUES`, and the time at which the slider is in the mode, s.
_MODE_CASES: Final[list[tuple[Mode, dict[str, float | bool], float]]] = [
    (Mode.CONTACT, {}, 0.4),
    (Mode.FORWARD, _SLIP, 0.0),
    (Mode.STICK, _STICK, 0.0),
]


@pytest.fixture(scope="module", params=["2", "3"])
def extracted(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extracted FMU's folder, by version of FMI."""
    folder = tmp_path_factory.mktemp("derivatives")
    fmu = build_fmu(folder / "m.fmu", flavour="native", fmi=request.param)
    fmpy.extract(str(fmu), str(folder / "m"))
    return folder / "m"


class Slave:
    """An instance in co-simulation, for FMI 2.0 and FMI 3.0, in initialization mode."""

    def __init__(self, folder: Path, values: Mapping[str, float | bool]) -> None:
        self.log: list[str] = []
        self.fmi: Any = fmpy.instantiate_fmu(
            str(folder),
            fmpy.read_model_description(str(folder)),
            fmi_type="CoSimulation",
            debug_logging=True,
            logger=lambda *args: self.log.append(args[-1].decode()),
        )
        self._is_3 = hasattr(self.fmi, "fmi3DoStep")
        self.set(values)
        if not self._is_3:
            self.fmi.setupExperiment(startTime=0.0)
        self.fmi.enterInitializationMode()

    def set(self, values: Mapping[str, float | bool]) -> None:
        for name, value in values.items():
            kind = "Boolean" if isinstance(value, bool) else "Float64" if self._is_3 else "Real"
            getattr(self.fmi, f"set{kind}")([REFERENCES[name]], [value])

    def get(self, *names: str) -> list[float]:
        """Values of variables of type Real, which include `mode`."""
        read = self.fmi.getFloat64 if self._is_3 else self.fmi.getReal
        values: list[float] = read([REFERENCES[name] for name in names])
        return values

    def derivatives(self, knowns: tuple[str, ...], seeds: Any) -> list[float]:
        references = [[REFERENCES[name] for name in names] for names in (UNKNOWNS, knowns)]
        values: list[float] = self.fmi.getDirectionalDerivative(*references, list(seeds))
        return values

    def matrix(self, knowns: tuple[str, ...]) -> Any:
        return np.array([self.derivatives(knowns, row) for row in np.eye(len(knowns))]).T


@contextmanager
def slave(folder: Path, **values: float | bool) -> Iterator[Slave]:
    instance = Slave(folder, values)
    yield instance
    instance.fmi.freeInstance()


def interpreted_unknowns(values: Mapping[str, float | bool]) -> Any:
    """The unknowns at the start, by the model of the Python FMU."""
    instance = SliderBeltInstance(instance_name="twin")
    for name, value in values.items():
        if isinstance(value, bool):
            instance.set_boolean([REFERENCES[name]], [value])
        else:
            instance.set_real([REFERENCES[name]], [value])
    instance.setup_experiment(0.0, None, None)
    instance.enter_initialization_mode()
    instance.exit_initialization_mode()
    assert not instance.log_queue
    return np.array(instance.get_real([REFERENCES[name] for name in UNKNOWNS]))


def central_difference(base_values: Mapping[str, float | bool], name: str) -> Any:
    """Derivative of the unknowns by a start value or parameter, from central differences."""
    h = 1e-5 * max(abs(base_values[name]), 1.0)
    high, low = (
        interpreted_unknowns({**base_values, name: base_values[name] + sign * h})
        for sign in (1.0, -1.0)
    )
    return (high - low) / (2.0 * h)


@pytest.mark.parametrize("t", [0.4, 2.5])
def test_derivatives_at_a_communication_point_agree_with_the_interpreted_model(
    extracted: Path, t: float
) -> None:
    with slave(extracted, **VALUES) as instance:
        instance.fmi.exitInitializationMode()
        instance.fmi.doStep(0.0, t)
        states = dict(zip(STATES, instance.get(*STATES), strict=True))
        partials = instance.matrix(KNOWNS)
        mixed = np.arange(1.0, len(KNOWNS) + 1.0)
        assert instance.derivatives(KNOWNS, mixed) == pytest.approx((partials @ mixed).tolist())
        for column, name in enumerate(INPUTS, start=len(STATES)):
            # Outputs follow a change of an input at once.
            h = 1e-3
            instance.set({name: VALUES[name] + h})
            high = np.array(instance.get(*UNKNOWNS))
            instance.set({name: VALUES[name] - h})
            low = np.array(instance.get(*UNKNOWNS))
            instance.set({name: VALUES[name]})
            assert partials[:, column] == pytest.approx((high - low) / (2.0 * h), abs=1e-9), name
    starts = {f"{name}_start": value for name, value in states.items()}
    base_values = {**VALUES, **starts, "start_static": False}
    # Another motion that starts here has other totals.
    instant_rows = [row for row, name in enumerate(UNKNOWNS) if name not in TOTALS]
    for column, name in enumerate(KNOWNS):
        exact = central_difference(base_values, f"{name}_start" if name in STATES else name)
        expected = pytest.approx(exact[instant_rows], rel=1e-6, abs=1e-6)
        assert partials[instant_rows, column] == expected, name
    # Contact compresses the contact spring: y < 0.
    mode = Mode.CONTACT if states["y"] < 0.0 else Mode.SEPARATED
    assert (mode is Mode.CONTACT) == (t == 0.4)
    rows = [UNKNOWNS.index(name) for name in ("vx", "ax", "vy", "ay")]
    by_states = jacobian(P, states["y"], mode)
    assert partials[rows, : len(STATES)] == pytest.approx(np.array(by_states))


@pytest.mark.parametrize("force", [60.0, -20.0])
def test_derivatives_in_initialization_mode_are_those_of_the_initial_values(
    extracted: Path, force: float
) -> None:
    knowns = (*INPUTS, *PARAMETERS)
    values = {**VALUES, "F": force}
    with slave(extracted, **values) as instance:
        jacobian = instance.matrix(knowns)
    state_rows = [UNKNOWNS.index(state) for state in STATES]
    for column, name in enumerate(knowns):
        exact = central_difference(values, name)
        assert jacobian[:, column] == pytest.approx(exact, rel=1e-6, abs=1e-6), name
        # The slider starts at rest at an equilibrium, which parameters and inputs shift.
        shift = static_start_change(System(Parameters(**values)), name)
        assert jacobian[state_rows, column] == pytest.approx(shift, rel=1e-12), name


def test_start_values_are_knowns_in_initialization_mode(extracted: Path) -> None:
    starts = {"x_start": 0.2, "vx_start": -1.0, "y_start": -0.7, "vy_start": 0.3}
    values = {**VALUES, **starts, "start_static": False}
    knowns = (*starts, *INPUTS, *PARAMETERS)
    with slave(extracted, **values) as instance:
        jacobian = instance.matrix(knowns)
        with pytest.raises(FMICallException):
            instance.derivatives(("x",), [1.0])
        assert "must be that of an input or Real parameter" in instance.log[-1]
    for column, name in enumerate(knowns):
        exact = central_difference(values, name)
        assert jacobian[:, column] == pytest.approx(exact, rel=1e-6, abs=1e-6), name


def dependencies(folder: Path, tag: str) -> dict[str, set[str]]:
    root = ET.parse(folder / "modelDescription.xml").getroot()
    names = [v.name for v in VARIABLES]
    if root.get("fmiVersion") == "2.0":
        group, key, first = root.find(f"ModelStructure/{tag}s"), "index", 1
        unknowns = [] if group is None else list(group)
    else:
        tag = tag if tag != "Derivative" else "ContinuousStateDerivative"
        unknowns, key, first = list(root.iterfind(f"ModelStructure/{tag}")), "valueReference", 0
    return {
        names[int(unknown.attrib[key]) - first]: {
            names[int(number) - first] for number in unknown.attrib["dependencies"].split()
        }
        for unknown in unknowns
    }


def test_the_description_lists_the_available_derivatives(extracted: Path) -> None:
    # The velocities are in both lists, with equal dependencies.
    declared = {**dependencies(extracted, "Output"), **dependencies(extracted, "Derivative")}
    is_3 = 'fmiVersion="3.0"' in (extracted / "modelDescription.xml").read_text()
    # Descriptions list dependencies on states and inputs, in FMI 3.0 on parameters too.
    parameters = (*PARAMETERS, "mu_s", "v_s") if is_3 else ()
    knowns = (*STATES, *INPUTS, "v_belt", *parameters)
    nonzero: dict[str, set[str]] = {unknown: set() for unknown in UNKNOWNS}
    for mode, initial_values, t in _MODE_CASES:
        with slave(extracted, **{**VALUES, **initial_values}) as instance:
            instance.fmi.exitInitializationMode()
            if t > 0.0:
                instance.fmi.doStep(0.0, t)
            assert instance.get("mode") == [mode]
            for row, unknown in zip(instance.matrix(knowns), UNKNOWNS, strict=True):
                pairs = zip(knowns, row, strict=True)
                nonzero[unknown] |= {name for name, value in pairs if value}
    for unknown in UNKNOWNS:
        assert nonzero[unknown] == declared[unknown], unknown


def test_unavailable_derivatives_are_refused(extracted: Path) -> None:
    with slave(extracted, **VALUES) as instance:
        instance.fmi.exitInitializationMode()
        for knowns, seeds, message in (
            # A Boolean parameter, and an output: the contact force.
            (("separation",), [1.0], "must be that of an input, state or Real parameter"),
            (("P",), [1.0], "must be that of an input, state or Real parameter"),
            (("y",), [np.inf], "seed of y = inf: must be a finite number"),
            (("mu",), [np.nan], "seed of mu = nan: must be a finite number"),
            (("x", "x"), [1e308, 1e308], "the derivative of x is not a finite number"),
        ):
            with pytest.raises(FMICallException):
                instance.derivatives(knowns, seeds)
            assert message in instance.log[-1]


def test_derivatives_of_the_brake_actuator_follow_from_its_equation(tmp_path: Path) -> None:
    fmu = build_fmu(tmp_path / "a.fmu", component="brake-actuator", flavour="native")
    fmpy.extract(str(fmu), str(tmp_path / "a"))
    values = {"command": 100.0, "P": 30.0, "tau": 0.2, "gain": 0.5, "F_start": 10.0}
    with FmuInstance(tmp_path / "a") as actuator:
        rate = [actuator.references["F_rate"]]

        def derivative_by(name: str) -> float:
            derivative: list[float] = actuator.fmi.getDirectionalDerivative(
                rate, [actuator.references[name]], [1.0]
            )
            return derivative[0]

        actuator.set(**values)
        actuator.fmi.setupExperiment()
        actuator.fmi.enterInitializationMode()
        assert derivative_by("F_start") == pytest.approx(-5.0)
        actuator.fmi.exitInitializationMode()
        actuator.step(0.1)
        force, slope = actuator.get("F", "F_rate")
        # tau dF/dt = command + gain (command − P) − F, with the contact force P.
        target_force = 100.0 + 0.5 * (100.0 - 30.0)
        assert slope == pytest.approx((target_force - force) / 0.2)
        assert [derivative_by("command"), derivative_by("P"), derivative_by("F")] == pytest.approx(
            [7.5, -2.5, -5.0]
        )
        assert [derivative_by("gain"), derivative_by("tau")] == pytest.approx([350.0, -slope / 0.2])
