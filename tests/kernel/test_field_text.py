"""The generated C agrees with the model's equations and with their derivatives."""

import math
import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from fivtui import Parameters
from fivtui.kernel.field_text import equation_headers, has_tuned_law
from fivtui.model import field as equations
from fivtui.model.modes import Mode
from fivtui.model.parameters import ALL_PARAMETERS
from fivtui.taylor.expression import Expression

HEADER = equation_headers()["field.h"]
VALUES = Parameters(c1=0.4, F=70.0, mu=0.5, v_belt=1.0, mu_s=0.9, v_s=0.4).as_dict()
# Derivatives of the parameters by one number, on which all of them depend here.
DERIVATIVES = {name: 0.1 * (n + 1) for n, name in enumerate(VALUES)}
# The function of the model for each in C: `suspension_stiffness` is that of k1 and k3 against y,
# `holding_force` the friction of a slider that sticks. At rest in contact, α y³ + β y + load = 0;
# `rest_cubic` is α, `rest_linear` is β.
PYTHON_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "load_of": equations.load,
    "coupling_stiffness": equations.coupling_stiffness,
    "horizontal_stiffness": equations.horizontal_stiffness,
    "total_stiffness": equations.total_stiffness,
    "suspension_stiffness": equations.suspension_stiffness,
    "spring_force": equations.spring_force,
    "tangent_stiffness": equations.tangent_stiffness,
    "tangent_slope": equations.tangent_slope,
    "horizontal_acceleration": equations.horizontal_acceleration,
    "vertical_acceleration": equations.vertical_acceleration,
    "holding_force": lambda p, x, y, rate: equations.holding_force(
        p, x, y, equations.Rates(v_belt=rate)
    ),
    "holding_force_rate": equations.holding_force_rate,
    "rest_position": equations.rest_position,
    "rest_cubic": lambda p, mu: equations.rest_coefficients(p, mu)[0],
    "rest_linear": lambda p, mu: equations.rest_coefficients(p, mu)[1],
    "friction_coefficient": equations.friction_coefficient,
}
C_FUNCTIONS = re.findall(
    r"INLINE double (\w+)\(const double \*p(.*?)\)\n\{\n    return (.*?);\n\}", HEADER
)
C_COEFFICIENTS = re.findall(
    r"INLINE Coefficients (\w+)_coefficients\(const double \*p\)\n\{\n    return \(Coefficients\)"
    r"\{\n(.*?)\};",
    HEADER,
    re.DOTALL,
)
# Only derivatives contain the derivatives q of the parameters.
C_COEFFICIENT_CHANGES = re.findall(
    r"return \(Coefficients\)\{\n([^}]*q\[.*?)\};", HEADER, re.DOTALL
)


def parameters_moved_by(step: float) -> Any:
    """Parameters plus i · step · `DERIVATIVES`, for complex-step derivatives; real for step 0."""
    values = {
        name: complex(VALUES[name], step * DERIVATIVES[name]) if step else VALUES[name]
        for name in VALUES
    }
    return SimpleNamespace(**values, mu_static=values["mu_s"])


def evaluate_c(text: str, names: dict[str, float]) -> Any:
    """Value of a C expression for `VALUES`, `DERIVATIVES` and named numbers."""
    columns = {f"P_{name.upper()}": name for name in ALL_PARAMETERS}
    namespace = {**columns, **names, "p": VALUES, "q": DERIVATIVES, "exponential": math.exp}
    # In Python, a ? b : c is b if a else c.
    text = re.sub(r"^(.*) \? (.*) : (.*)$", r"(\2) if (\1) else (\3)", text)
    return eval(text, {}, namespace)


@pytest.mark.parametrize(
    ("name", "arguments", "text"), C_FUNCTIONS, ids=[f[0] for f in C_FUNCTIONS]
)
def test_functions_in_c_equal_those_of_the_model(name: str, arguments: str, text: str) -> None:
    is_change = name.endswith("_change")
    numbers = re.findall(r"double (\w+)", arguments)
    values = {number: 0.3 + 0.2 * n for n, number in enumerate(numbers)}
    compute, step = PYTHON_FUNCTIONS[name.removesuffix("_change")], equations.DERIVATIVE_STEP
    if not is_change:
        expected = compute(parameters_moved_by(0.0), *values.values())
    else:
        # Each number is followed by its derivative.
        pairs = zip(numbers[::2], numbers[1::2], strict=True)
        complex_arguments = [
            complex(values[number], step * values[change]) for number, change in pairs
        ]
        expected = equations.derivative(compute(parameters_moved_by(step), *complex_arguments) + 0j)
    assert evaluate_c(text, values) == pytest.approx(expected, rel=1e-14)


def test_every_function_of_the_header_is_compared() -> None:
    assert {name.removesuffix("_change") for name, _, _ in C_FUNCTIONS} == set(PYTHON_FUNCTIONS)
    assert HEADER.count("INLINE double") == len(C_FUNCTIONS)
    # The friction law is that for which the kernel has recurrences written by hand.
    assert has_tuned_law()


def test_the_coefficients_of_every_mode_and_their_changes_equal_those_of_the_model() -> None:
    assert [name for name, _ in C_COEFFICIENTS] == [mode.name.lower() for mode in Mode]
    assert len(C_COEFFICIENT_CHANGES) == len(C_COEFFICIENTS)
    step = equations.DERIVATIVE_STEP
    for mode, (_, values), slopes in zip(Mode, C_COEFFICIENTS, C_COEFFICIENT_CHANGES, strict=True):
        expected = equations.field(parameters_moved_by(0.0), mode)
        expected_changes = equations.field(parameters_moved_by(step), mode)
        for text, value in zip(values.split(",\n"), expected, strict=True):
            assert evaluate_c(text.strip(), {}) == pytest.approx(value, rel=1e-14)
        for text, value in zip(slopes.split(",\n"), expected_changes, strict=True):
            slope = equations.derivative(value + 0j)
            assert evaluate_c(text.strip(), {}) == pytest.approx(slope, rel=1e-13, abs=1e-13)


def test_expressions_omit_neutral_terms() -> None:
    a, b = Expression("a"), Expression("b")
    assert (a + 0.0).text == (a * 1.0).text == (a / 1.0).text == (0.0 + a).text == "a"
    assert (a * 0.0).text == (0.0 * a).text == (0.0 / a).text == "0.0"
    assert (-Expression("-a")).text == "a"
    assert (-1.0 * a).text == "-a"
    assert (a - (b - a)).text == "a - (b - a)"
    assert (a / (b * a)).text == "a / (b * a)"
    assert ((a + b) * a).text == "(a + b) * a"
    assert (-a * b).text == "-a * b"
