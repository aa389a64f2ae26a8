"""Fields of the form and commands of a session; its modules import no slow library."""

import shlex
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st

from fivtui.model.errors import ComputationError, InputError
from fivtui.model.parameters import BELT_PARAMETERS, PARAMETERS, Parameters
from fivtui.ranges import number_text
from fivtui.scene.over_time import parse_over_time
from fivtui.scene.presets import PRESETS
from fivtui.scene.scene import Scene
from fivtui.tui.session.equations import replace_symbols, symbol_of
from fivtui.tui.session.fields import FIELDS, digit_step
from fivtui.tui.session.scene_differences import change_texts, legend_names
from fivtui.tui.session.session import Session
from tests.support.laboratory import command_line


def test_headless_modules_import_neither_textual_nor_slow_libraries() -> None:
    code = (
        "import importlib, pkgutil, sys\n"
        "from fivtui.tui import chart, persistence, session\n"
        "for package in (chart, persistence, session):\n"
        "    for module in pkgutil.iter_modules(package.__path__, package.__name__ + '.'):\n"
        "        if not module.ispkg:\n"
        "            importlib.import_module(module.name)\n"
        "heavy = ('textual', 'matplotlib', 'scipy', 'fmpy')\n"
        "modules = sum(name.startswith('fivtui.tui.') for name in sys.modules)\n"
        "print(modules > 20, [name for name in heavy if name in sys.modules])\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert process.stdout.strip() == "True []"


def test_the_app_itself_starts_without_the_slow_libraries() -> None:
    slow_libraries = ("matplotlib", "scipy", "fmpy")
    code = f"import sys, fivtui.tui.app; print([n for n in {slow_libraries} if n in sys.modules])"
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert process.stdout.strip() == "[]"


def test_fields_repeat_the_parameter_table() -> None:
    for name, spec in PARAMETERS.items():
        field = FIELDS[name]
        texts = (field.symbol, field.unit, field.meaning, field.allowed)
        assert texts == (symbol_of(name), spec.unit, spec.meaning, spec.allowed)
        assert field.check(field.default) == spec.default


def test_every_parameter_occurs_in_an_equation() -> None:
    assert all(FIELDS[name].details for name in PARAMETERS)
    # Equations of the paper.
    assert [row.label for row in FIELDS["k_nl"].details] == ["Eq. 1"]
    assert [row.label for row in FIELDS["m"].details] == ["Eq. 2", "Eq. 2"]


@pytest.mark.parametrize("name", PRESETS)
def test_a_loaded_scene_is_edited_unchanged(name: str) -> None:
    session = Session(PRESETS[name], name)
    assert session.scene() == PRESETS[name]
    assert not session.changed_fields
    assert not session.errors


def test_a_value_that_follows_a_table_over_time_is_not_edited() -> None:
    session = Session(PRESETS["brake-stop"], "brake-stop")
    session.set_text("F", "20")
    session.set_text("c2", "3")
    refusal = "F: follows a table over time; must not be changed"
    assert session.errors == {"F": refusal}
    session.reset("F")
    # Undo restores the typed text, whose verdict would be that of another scene.
    session.undo()
    assert session.texts["F"] == "20"
    for read in (session.parameters, session.stability, session.scene):
        with pytest.raises(InputError, match=refusal):
            read()
    session.reset("F")
    state = session.edit_state
    with pytest.raises(InputError, match=refusal):
        session.set_texts({"c2": "9", "F": "62.5"})
    assert session.edit_state == state
    assert session.scene().over_time == PRESETS["brake-stop"].over_time
    assert session.scene().parameters.c2 == 3.0


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("m", "0", "m = 0: must be from 1e-12 to 1e+09 kg"),
        ("k_nl", "stiff", "k_nl = 'stiff': not a number"),
        ("F", "", "F = '': not a number"),
        ("mu", "nan", "μ = nan: not a finite number"),
        ("t_end", "-1", "t_end = -1: must be above 0"),
        ("tol", "1", "tol = 1: must be from"),
        ("start", "1,2,3", "start = [1.0, 2.0, 3.0]: must be static, or four finite numbers"),
        ("start", "1,2,3,x", "start = 'x': not a number"),
        ("method", "tailor", "did you mean taylor?"),
        ("separation", "perhaps", "unknown separation 'perhaps'"),
        ("step", "0.01", "step: the method taylor sets its step by tol"),
    ],
)
def test_an_invalid_text_gives_a_message_and_no_scene(name: str, text: str, message: str) -> None:
    session = Session()
    session.set_text(name, text)
    assert message in session.errors[name]
    assert list(session.errors) == [name]
    with pytest.raises(InputError, match=r"must be|known|sets its step"):
        session.scene()


def test_a_step_is_checked_against_method_and_end_time() -> None:
    session = Session()
    session.set_text("method", "rk4")
    session.set_text("step", "0.01")
    assert session.scene().step == 0.01
    session.set_text("t_end", "0.001")
    assert "step = 0.01: must be above 0 and at most 0.001 s" in session.errors["step"]


def test_invalid_run_settings_do_not_change_the_verdict() -> None:
    session = Session()
    session.set_text("t_end", "never")
    # Every μ at which stability changes: a single one here.
    (critical,) = session.stability().critical_mu
    assert critical.mu == pytest.approx(0.4394, abs=5e-5)


def test_the_verdict_raises_the_error_of_its_input() -> None:
    session = Session()
    session.set_text("F", "x")
    with pytest.raises(InputError, match="F = 'x'"):
        session.stability()
    session.set_text("F", "-5")
    session.set_text("k3", "0")
    with pytest.raises(ComputationError, match="no equilibrium"):
        session.stability()


def test_reset_restores_the_loaded_scene_not_the_base_scene() -> None:
    session = Session(PRESETS["stiff-contact"], "stiff-contact")
    session.set_text("F", "1")
    session.set_text("mu", "2")
    session.reset("F")
    assert (session.texts["F"], session.changed_fields) == ("100", ["mu"])
    session.reset_all()
    assert not session.changed_fields


@pytest.mark.parametrize(
    ("value", "direction", "fine", "expected"),
    [
        (100.0, 1, False, 110.0),
        # From a power of ten towards zero, the step has the size of steps below the power.
        (100.0, -1, False, 99.0),
        (99.0, 1, False, 100.0),
        (0.7, 1, False, 0.71),
        (0.7, -1, True, 0.699),
        (-80.0, 1, False, -79.0),
        (-100.0, 1, False, -99.0),
        (-100.0, -1, False, -110.0),
        (0.0, 1, False, 1.0),
        (0.0, -1, True, -0.1),
    ],
)
def test_a_step_is_one_unit_of_the_second_digit(
    value: float, direction: int, fine: bool, expected: float
) -> None:
    # The default gives the size of a step from zero.
    step = digit_step(default=80.0)
    assert step(value, direction, fine) == expected


@given(st.integers(10, 99), st.integers(-9, 9), st.sampled_from([1, -1]), st.booleans())
def test_a_step_and_the_reverse_step_restore_the_value(
    digits: int, exponent: int, sign: int, fine: bool
) -> None:
    value = sign * float(f"{digits}e{exponent}")
    step = digit_step(1.0)
    assert step(step(value, 1, fine), -1, fine) == value
    assert step(step(value, -1, fine), 1, fine) == value


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_text_of_a_number_is_read_as_that_number(value: float) -> None:
    assert float(number_text(value)) == value


def test_tolerances_are_stepped_by_decades() -> None:
    tolerance_step = FIELDS["tol"].step_rule
    assert tolerance_step is not None
    assert tolerance_step(1e-12, 1, False) == 1e-11
    session = Session()
    assert session.step_field("tol", -1)
    assert session.texts["tol"] == "1e-13"
    assert not session.step_field("tol", -1)
    assert session.texts["tol"] == "1e-13"


def test_a_step_out_of_range_or_from_no_number_does_nothing() -> None:
    session = Session()
    session.set_text("mu", "100")
    assert not session.step_field("mu", 1)
    session.set_text("mu", "slippery")
    assert not session.step_field("mu", 1)
    assert not session.step_field("method", 1)
    assert not session.step_field("step", 1)
    assert session.texts["mu"] == "slippery"


def test_the_command_line_has_only_the_differences() -> None:
    session = Session()
    assert command_line(session) == "fivtui simulate"
    for name, text in {
        "F": "90",
        "separation": "ignored",
        "start": "0.1, 0, -0.5, 0",
        "t_end": "200",
        "method": "rk4",
        "step": "0.001",
    }.items():
        session.set_text(name, text)
    assert shlex.split(command_line(session)) == [
        "fivtui",
        "simulate",
        "--set",
        "F=90",
        "--ignore-separation",
        "--start=0.1,0,-0.5,0",
        "--t-end=200",
        "--method=rk4",
        "--step=0.001",
    ]


def test_the_command_line_names_the_preset_or_file_of_the_scene() -> None:
    session = Session(PRESETS["stiff-contact"], "stiff-contact")
    session.set_text("mu", "1.1")
    assert command_line(session) == "fivtui simulate stiff-contact --set mu=1.1"
    scene = Scene(name="mine", description="", parameters=Parameters(F=90.0))
    assert command_line(Session(scene, "my scene.toml")) == "fivtui simulate 'my scene.toml'"
    assert command_line(Session(scene)) == "fivtui simulate --set F=90"


def test_with_separation_considered_again_the_command_names_no_preset() -> None:
    session = Session(PRESETS["linear"], "linear")
    session.set_text("separation", "considered")
    assert command_line(session) == "fivtui simulate --set k_nl=0"


def test_an_invalid_field_has_no_command_line() -> None:
    session = Session()
    session.set_text("F", "x")
    with pytest.raises(InputError, match="F = 'x'"):
        command_line(session)


def test_the_fields_beside_the_parameters_have_descriptions_and_units() -> None:
    field_texts = {
        name: (field.symbol, field.unit, field.meaning, field.when_empty)
        for name, field in FIELDS.items()
        if name not in PARAMETERS
    }
    belt_texts = {
        name: (symbol_of(name), spec.unit, spec.meaning, "none")
        for name, spec in BELT_PARAMETERS.items()
    }
    assert field_texts == belt_texts | {
        "separation": ("", "", "whether contact can be lost", ""),
        "start": ("", "m, m/s", "state at t = 0", ""),
        "t_end": ("t_end", "s", "end time", ""),
        "method": ("", "", "integration method", ""),
        "tol": ("tol", "", "relative tolerance", ""),
        "accuracy": ("", "", "error targets, in place of tol and step", "tol or step"),
        "step": ("step", "s", "step of rk4 or fmu", "default"),
    }
    assert {row.label: row.value for row in FIELDS["accuracy"].details} == {
        "final": "state at the end, relative to its greatest component",
        "peak": "peak of |y|, relative",
        "half_range": (
            "half peak-to-peak of y over the second half of the run, relative to peak |y|"
        ),
        "events": "times of separation and reattachment, s",
    }
    for name in ("t_end", "tol"):
        assert FIELDS[name].check(FIELDS[name].default) == float(FIELDS[name].default)
    with pytest.raises(InputError, match="t_end"):
        FIELDS["t_end"].check("0")


def test_symbols_are_names_except_greek_and_symbols_of_the_paper_are_read() -> None:
    assert [symbol_of(name) for name in ("mu", "mu_s", "k1", "k_nl", "x0")] == [
        "μ",
        "μ_s",
        "k1",
        "k_nl",
        "x0",
    ]
    typed = "μ=0:1:3 k_1=1:2:3 c_2~uniform:1:2 mu=0:1:2 k_nl=1,2 μ_s=1"
    assert replace_symbols(typed) == "mu=0:1:3 k1=1:2:3 c2~uniform:1:2 mu=0:1:2 k_nl=1,2 mu_s=1"


def test_changes_name_both_values_and_tables_over_time() -> None:
    base, tables = PRESETS["base"], parse_over_time("over_time", {"F": [[0, 80], [1, 100]]})
    scene = replace(base, over_time=tables)
    other_scene = replace(base, over_time=parse_over_time("over_time", {"F": [[0, 80], [1, 90]]}))
    assert change_texts(scene, scene) == []
    assert change_texts(base, scene) == ["F=80 (now over time)"]
    assert change_texts(scene, base) == ["F=over time (now 80)"]
    assert change_texts(scene, other_scene) == ["F=over time (now another table)"]


def test_legends_list_differences_and_run_numbers_only_for_equal_scenes() -> None:
    base, ignored = PRESETS["base"], PRESETS["separation-ignored"]
    assert legend_names({4: base}) == ["run 4"]
    assert legend_names({1: base, 2: ignored}) == ["separation considered", "separation ignored"]
    varied = base.with_values({"mu": 0.5, "k1": 90.0})
    assert legend_names({1: base, 3: varied}) == ["k1 100 N/m, μ 0.7", "k1 90 N/m, μ 0.5"]
    assert legend_names({1: base, 2: ignored, 5: base}) == [
        "separation considered, run 1",
        "separation ignored",
        "separation considered, run 5",
    ]
