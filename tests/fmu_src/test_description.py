"""Every attribute of the model descriptions, compared with independent tables and units.

The tables below come from the equations and base parameters of the paper "Nonlinear
friction-induced vibration of a slider-belt system", not from the code. Units are checked by the
dimensions of the equations, display units by their factors, nominals by the motion with the base
parameters.
"""

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from fivtui import simulate

# Name, causality, variability, unit, min, max, nominal, start, and a part of the description. Units
# have · in place of a space, and - is no value.
PARAMETERS: Final = """
m        parameter fixed      kg    1e-12 1e9  5    5    mass of the slider
k1       parameter tunable    N/m   1e-12 1e12 100  100  horizontal stiffness
k2       parameter tunable    N/m   1e-12 1e12 50   50   linear contact stiffness
k3       parameter tunable    N/m   0     1e12 60   60   coupling spring
c1       parameter tunable    N·s/m 0     1e9  0.32 0.32 horizontal damping
c2       parameter tunable    N·s/m 0     1e9  0.32 0.32 vertical damping
F        input     continuous N     -1e9  1e9  80   80   preload, positive towards the belt
k_nl     parameter tunable    N/m^3 0     1e24 100  100  cubic contact stiffness
mu       input     continuous 1     0     100  0.7  0.7  friction coefficient
x_start  parameter fixed      m     -     -    1    0    horizontal displacement at the start
vx_start parameter fixed      m/s   -     -    10   0    horizontal velocity at the start
y_start  parameter fixed      m     -     -    1    0    vertical displacement at the start
vy_start parameter fixed      m/s   -     -    10   0    vertical velocity at the start
v_belt   input     continuous m/s   -1e9  1e9  1    1    speed of the belt, used if finite_belt is true
mu_s     parameter tunable    1     0     100  0.9  0    at least mu, or 0 to use mu
v_s      parameter tunable    m/s   0     1e9  0.4  0    falls from mu_s to mu, used if finite_belt is true; with 0 it falls at once
"""  # noqa: E501
OUTPUTS: Final = """
x               output continuous m     - - 1   - horizontal displacement
vx              output continuous m/s   - - 10  - horizontal velocity
y               output continuous m     - - 1   - vertical displacement
vy              output continuous m/s   - - 10  - vertical velocity
P               output continuous N     - - 100 - contact force
friction_slider output continuous N     - - 100 - of the belt on the slider, mu P
friction_belt   output continuous N     - - 100 - of the slider on the belt, -mu P
mode            output discrete   1     0 4 1   - 1 in contact, 0 separated; 2 forward slip, 3 backward slip, 4 stick
switching       output continuous m     - - 1   - negative in contact, positive when separated
separations     output discrete   1     0 - 1   - number of separations
reattachments   output discrete   1     0 - 1   - number of reattachments
last_event      output discrete   s     - - 1   - time of the last change of the mode
switches        output discrete   1     0 - 1   - number of changes of the mode
sticks          output discrete   1     0 - 1   - began to stick
x_peak          output continuous m     - - 1   - greatest |x| so far
y_peak          output continuous m     - - 1   - greatest |y| so far
vx_max          output continuous m/s   - - 10  - greatest horizontal velocity so far
P_min           output continuous N     - - 100 - least contact force so far
P_max           output continuous N     - - 100 - greatest contact force so far
separated_time  output continuous s     - - 1   - off the belt so far
ax              local  continuous m/s^2 - - 50  - horizontal acceleration
ay              local  continuous m/s^2 - - 50  - vertical acceleration
"""  # noqa: E501
ACTUATOR: Final = """
command input     continuous N   -1e9  1e9 100  80   commanded contact force
P       input     continuous N   -     -   100  80   contact force, fed back
tau     parameter tunable    s   1e-12 1e6 0.05 0.05 time constant of the lag
gain    parameter tunable    1   0     1e3 0.1  0.1  gain of the feedback
F_start parameter fixed      N   -1e9  1e9 100  80   preload at the start
F       output    continuous N   -     -   100  -    preload, positive towards the belt
F_rate  local     continuous N/s -     -   1e3  -    rate of the preload
"""
DISPLAY_UNITS: Final = {"m": "mm", "N": "kN", "N/m": "N/mm", "N/s": "kN/s"}
FLAGS: Final = ("separation", "start_static", "finite_belt")
DERIVATIVE_OF: Final = {"vx": "x", "ax": "vx", "vy": "y", "ay": "vy", "F_rate": "F"}
STATES: Final = ("x", "vx", "y", "vy")
FMUS: Final = ("slider-belt", "brake-actuator")
REALS: Final = {
    "slider-belt": PARAMETERS + OUTPUTS,
    "brake-actuator": ACTUATOR,
}


class Row(NamedTuple):
    """A row of the tables above."""

    name: str
    causality: str
    variability: str
    unit: str
    min: str
    max: str
    nominal: str
    start: str
    description: str


def table_rows(component: str) -> list[Row]:
    lines = [line for line in REALS[component].splitlines() if line]
    rows = [Row(*re.split(r"\s+", line, maxsplit=8)) for line in lines]
    return [row._replace(unit=row.unit.replace("·", " ")) for row in rows]


@pytest.fixture(params=FMUS)
def fmu_description(request: pytest.FixtureRequest, descriptions: Any) -> tuple[str, ET.Element]:
    """Each FMU with its model description."""
    return request.param, descriptions[request.param]


def variable_attributes(root: ET.Element) -> list[dict[str, str]]:
    """Attributes of the variables, those of the inner element included, and its tag, the type."""
    variables = []
    for element in root.iterfind("ModelVariables/ScalarVariable"):
        (typed,) = element
        variables.append({**element.attrib, **typed.attrib, "type": typed.tag})
    return variables


def parse_number(text: str | None) -> float | None:
    return None if text in (None, "-") else float(str(text))


def test_every_real_variable_agrees_with_the_table(fmu_description: tuple[str, ET.Element]) -> None:
    component, root = fmu_description
    table = {row.name: row for row in table_rows(component)}
    reals = {v["name"]: v for v in variable_attributes(root) if v["type"] == "Real"}
    assert reals.keys() - {"time"} == table.keys()
    for name, row in table.items():
        v = reals[name]
        assert (v["causality"], v["variability"]) == (row.causality, row.variability), name
        initial = {"parameter": "exact", "input": None}.get(row.causality, "calculated")
        assert v.get("initial") == initial, name
        assert v["unit"] == row.unit, name
        assert v["displayUnit"] == DISPLAY_UNITS.get(row.unit, row.unit), name
        for attribute in ("min", "max", "nominal", "start"):
            actual, expected = parse_number(v.get(attribute)), parse_number(getattr(row, attribute))
            assert actual == expected, (name, attribute)
        assert row.description in v["description"], name
        assert "quantity" not in v, name
        assert "declaredType" not in v, name


# Exponents of kg, m and s.
DIMENSIONS: Final = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "1": (0,) * 3,
}
PREFIX_FACTORS: Final = {
    "g": Fraction(1, 1000),
    "mm": Fraction(1, 1000),
    "ms": Fraction(1, 1000),
    "kN": Fraction(1000),
}


def evaluate_factors(
    unit: str, value_of: Callable[[str], Any], power: Callable[[Any, int], Any]
) -> Any:
    numerator, *divisors = unit.split("/")
    factors = [(f, 1) for f in numerator.split()] + [(f, -1) for f in divisors]
    values = []
    for factor, sign in factors:
        name, _, exponent = factor.partition("^")
        values.append(power(value_of(name), sign * int(exponent or 1)))
    return values


def dimension(unit: str) -> tuple[int, ...]:
    parts = evaluate_factors(unit, DIMENSIONS.__getitem__, lambda d, n: tuple(n * e for e in d))
    return tuple(sum(exponents) for exponents in zip(*parts, strict=True))


def si_factor(unit: str) -> Fraction:
    product = Fraction(1)
    for part in evaluate_factors(
        unit, lambda name: PREFIX_FACTORS.get(name, Fraction(1)), lambda v, n: v**n
    ):
        product *= part
    return product


def test_units_and_display_units_have_the_dimensions_of_their_names(
    fmu_description: tuple[str, ET.Element],
) -> None:
    _, root = fmu_description
    units = {str(unit.get("name")): unit for unit in root.iterfind("UnitDefinitions/Unit")}
    assert {v["unit"] for v in variable_attributes(root) if "unit" in v} == units.keys()
    for name, unit in units.items():
        base = unit.find("BaseUnit")
        assert base is not None
        exponents = {k: int(v) for k, v in base.attrib.items()}
        expected = dict(zip(("kg", "m", "s"), dimension(name), strict=True))
        assert exponents == {k: e for k, e in expected.items() if e}, name
        factors = {str(d.get("name")): str(d.get("factor")) for d in unit.iter("DisplayUnit")}
        assert all("offset" not in d.attrib for d in unit.iter("DisplayUnit"))
        assert len(factors) == (1 if name == "1" else 2)
        for display, factor in factors.items():
            # A value in the display unit is the factor times the value in the unit.
            assert Fraction(factor) == si_factor(name) / si_factor(display), (name, display)


def test_the_terms_of_the_equations_have_one_dimension_each(
    descriptions: dict[str, ET.Element],
) -> None:
    units = {row.name: row.unit for row in table_rows("slider-belt")}

    def product(term: str) -> tuple[int, ...]:
        dimensions = [dimension(units[name]) for name in term.split()]
        return tuple(np.sum(dimensions, axis=0).tolist())

    force = product("F")
    terms = (
        "m ax, c1 vx, k1 x, k3 y, mu P, m ay, c2 vy, k3 x, k2 y, k_nl y y y, friction_slider, "
        "friction_belt, P, k1 x_start, k2 y_start, c1 vx_start, c2 vy_start, k2 switching"
    )
    for term in terms.split(", "):
        assert product(term) == force, term
    assert dimension(units["last_event"]) == dimension("s")
    for derivative, state in (("vx", "x"), ("vy", "y"), ("ax", "vx"), ("ay", "vy")):
        assert dimension(f"s {units[derivative]}") == product(state)
    # tau dF/dt = command + gain (command - P) - F
    units = {row.name: row.unit for row in table_rows("brake-actuator")}
    for term in ("tau F_rate", "command", "gain P", "F", "F_start"):
        assert product(term) == force, term


def test_nominals_are_the_sizes_that_motion_with_the_base_parameters_reaches() -> None:
    trajectory = simulate(t_end=50.0, samples=np.linspace(0.0, 50.0, 2001)).trajectory
    assert trajectory is not None
    x, vx, y, vy, P = (getattr(trajectory, name) for name in ("x", "vx", "y", "vy", "P"))
    reached = {"x": x, "vx": vx, "y": y, "vy": vy, "P": P, "switching": y}
    # The spring k3 is at 45°: 130 N/m is k1 + k3/2, and 30 N/m is k3/2.
    reached |= {
        "friction_slider": 0.7 * P,
        "friction_belt": -0.7 * P,
        "ax": (0.7 * P - 0.32 * vx - 130.0 * x + 30.0 * y) / 5.0,
        "ay": (P - 80.0 - 0.32 * vy - 30.0 * y + 30.0 * x) / 5.0,
    }
    for row in table_rows("slider-belt"):
        if row.name in reached:
            rms = float(np.sqrt(np.mean(reached[row.name] ** 2)))
            assert 1 / 4 < rms / float(row.nominal) < 4, (row.name, rms)
