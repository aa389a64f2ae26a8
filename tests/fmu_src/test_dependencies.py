"""Dependencies in the model descriptions are the variables whose change has an effect.

`table_rows` gives the variables, with name and causality, from the tables in `test_description`.
"""

from collections.abc import Iterator, Mapping
from typing import Any, Final
from xml.etree import ElementTree as ET

import pytest

from fmu_src.slave.actuator import BrakeActuator
from fmu_src.slave.instance import Instance
from fmu_src.slave.slider_belt import SliderBeltInstance

from .test_description import DERIVATIVE_OF, FLAGS, STATES, table_rows, variable_attributes

INCREMENTS: Final = {
    "m": 1.0, "k1": 7.0, "k2": 7.0, "k3": 7.0, "c1": 0.1, "c2": 0.1, "F": 9.0, "k_nl": 9.0,
    "mu": 0.1, "v_belt": 0.1, "mu_s": 0.1, "v_s": 0.1, "x_start": 0.1,
    "vx_start": 0.1, "y_start": 0.01, "vy_start": 0.1,
    "command": 5.0, "P": 5.0, "tau": 0.01, "gain": 0.1, "F_start": 5.0,
}  # fmt: skip
MOVING: Final = {"start_static": False, "x_start": 0.2, "vx_start": -0.3, "vy_start": 0.4}
FINITE_BELT: Final = {**MOVING, "finite_belt": True, "mu_s": 0.9, "v_s": 0.4}
STICKING: Final = {**FINITE_BELT, "vx_start": 1.0, "vy_start": 0.0, "y_start": -0.5, "x_start": 0.1}
# In contact and separated, at rest and moving, with and without separation; on a belt of finite
# speed, slower and faster than the slider, sticking, and about to stick.
POINTS: Final[Mapping[str, list[dict[str, Any]]]] = {
    "slider-belt": [
        {**start, "separation": separation}
        for separation in (True, False)
        for start in (
            {"F": 80.0},
            {"F": -80.0},
            {**MOVING, "y_start": -0.5},
            {**MOVING, "y_start": 0.5},
            {**FINITE_BELT, "y_start": -0.5},
            {**FINITE_BELT, "y_start": -0.5, "vx_start": 3.0},
            STICKING,
            # Slips: the holding force is above mu_s P, but not above (mu_s + 0.1) P.
            {**STICKING, "x_start": 0.17},
        )
    ],
    "brake-actuator": [{"command": 60.0, "P": 40.0}],
}
# Outputs that depend on some variables only exactly at a switch, which no point hits. At y = 0, for
# example, the initial velocity decides the mode, and with it forces and sticks.
AT_SWITCH_ONLY: Final = {
    *("P", "P_min", "P_max", "friction_slider", "friction_belt"),
    *("mode", "mode_enumeration", "sticks"),
}
# Of these, outputs on which m, c1 and c2 act only near the limit of sticking.
AT_STICK_LIMIT_ONLY: Final = {"mode", "mode_enumeration", "sticks"}


def new_instance(component: str) -> Instance:
    return (SliderBeltInstance if component == "slider-belt" else BrakeActuator)(
        instance_name="test"
    )


def values_after(
    component: str, values: Mapping[str, Any], later: Mapping[str, Any]
) -> dict[str, Any]:
    """All values of an instance initialized with `values` and then changed by `later`."""
    instance = new_instance(component)
    references = instance.TABLE.references

    def set_values(changes: Mapping[str, Any]) -> None:
        for name, value in changes.items():
            setter = instance.set_boolean if isinstance(value, bool) else instance.set_real
            setter([references[name]], [value])

    set_values(values)
    instance.setup_experiment(0.0, None, None)
    instance.enter_initialization_mode()
    instance.exit_initialization_mode()
    set_values(later)
    # Some points set variables of the belt that have no effect there, which the FMU logs.
    refused = [message.msg for message in instance.log_queue if "no effect" not in message.msg]
    assert not refused
    return dict(zip(references, instance.get_real(list(references.values())), strict=True))


def changed_names(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    return (name for name in before if abs(before[name] - after[name]) > 1e-9)


def dependencies(root: ET.Element, tag: str) -> dict[str, set[str]]:
    # FMI 2.0 counts variables from 1.
    names = {str(n): v["name"] for n, v in enumerate(variable_attributes(root), start=1)}
    knowns_by_unknown = {}
    for unknown in root.iterfind(f"ModelStructure/{tag}/Unknown"):
        knowns = unknown.attrib["dependencies"].split()
        assert unknown.attrib["dependenciesKind"].split() == ["dependent"] * len(knowns)
        knowns_by_unknown[names[unknown.attrib["index"]]] = {names[index] for index in knowns}
    return knowns_by_unknown


def output_names(root: ET.Element) -> list[str]:
    return [v["name"] for v in variable_attributes(root) if v["causality"] == "output"]


@pytest.mark.parametrize("component", ["slider-belt", "brake-actuator"])
def test_initial_values_depend_on_the_variables_that_change_them(
    component: str, descriptions: dict[str, ET.Element]
) -> None:
    declared = dependencies(descriptions[component], "InitialUnknowns")
    assert declared.keys() == {*output_names(descriptions[component]), *DERIVATIVE_OF} & {
        v["name"] for v in variable_attributes(descriptions[component])
    }
    influences: dict[str, set[str]] = {name: set() for name in declared}
    for point in POINTS[component]:
        start = values_after(component, point, {})
        settable = [r.name for r in table_rows(component) if r.causality in ("parameter", "input")]
        changes: dict[str, Any] = {name: start[name] + INCREMENTS[name] for name in settable}
        if component == "slider-belt":
            changes |= {name: not start[name] for name in FLAGS}
        for name, value in changes.items():
            for output in changed_names(start, values_after(component, {**point, name: value}, {})):
                if output in influences:
                    influences[output].add(name)
    for output, knowns in declared.items():
        if output in AT_SWITCH_ONLY:
            assert influences[output] <= knowns <= {*INCREMENTS, *FLAGS}, output
            # At some point these act on every output that depends on them.
            acting = {"finite_belt", "v_belt", "mu_s"}
            if output not in AT_STICK_LIMIT_ONLY:
                acting |= {"m", "c1", "c2"}
            assert acting & knowns <= influences[output], output
        else:
            assert influences[output] == knowns, output
    if component == "slider-belt":
        # The slider sticks if |f| <= mu_s P for the holding force f, which includes c1 v_belt. If
        # both are equal, ÿ decides, with m and c2. Friction in slip depends on v_s.
        stick_condition = {"finite_belt", "v_belt", "mu", "mu_s", "c1"}
        assert declared["friction_belt"] - declared["P"] == {*stick_condition, "v_s"}
        assert declared["friction_belt"] == declared["friction_slider"]
        assert declared["mode"] - declared["P"] == {*stick_condition, "m", "c2"}
        assert declared["mode"] == declared["mode_enumeration"] == declared["sticks"]


@pytest.mark.parametrize("component", ["slider-belt", "brake-actuator"])
def test_outputs_depend_at_a_communication_point_on_the_inputs_that_change_them(
    component: str, descriptions: dict[str, ET.Element]
) -> None:
    declared = dependencies(descriptions[component], "Outputs")
    assert list(declared) == output_names(descriptions[component])
    inputs = [row.name for row in table_rows(component) if row.causality == "input"]
    influences: dict[str, set[str]] = {name: set() for name in declared}
    # With mu_s = 0 static friction is mu, which then decides whether the slider sticks.
    static_by_mu = [{**STICKING, "mu_s": 0.0}] if component == "slider-belt" else []
    for point in (*POINTS[component], *static_by_mu):
        start = values_after(component, point, {})
        for name in inputs:
            after = values_after(component, point, {name: start[name] + INCREMENTS[name]})
            for output in changed_names(start, after):
                if output in influences:
                    influences[output].add(name)
    assert influences == declared


def test_derivatives_depend_on_the_states_and_inputs_that_change_them(
    descriptions: dict[str, ET.Element],
) -> None:
    declared = dependencies(descriptions["slider-belt"], "Derivatives")
    assert declared.keys() == {"vx", "vy", "ax", "ay"}
    influences: dict[str, set[str]] = {name: set() for name in declared}
    # Moving in contact, separated, and slower than a belt of finite speed.
    for point in POINTS["slider-belt"][2:5]:
        start = values_after("slider-belt", point, {})
        for quantity in (*STATES, "F", "mu", "v_belt"):
            name = f"{quantity}_start" if quantity in STATES else quantity
            after = values_after("slider-belt", {**point, name: start[name] + INCREMENTS[name]}, {})
            for derivative in changed_names(start, after):
                if derivative in influences:
                    influences[derivative].add(quantity)
    assert influences == declared
    assert dependencies(descriptions["brake-actuator"], "Derivatives") == {
        "F_rate": {"F", "command", "P"}
    }
