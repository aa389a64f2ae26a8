"""Belt parameters without effect: a warning if they are set, an error if they vary."""

import pytest

from fivtui import Parameters, branch, continuation, simulate, stability, stability_map, sweep
from fivtui.cli import run
from fivtui.model import InputError, System, describe_unused, equilibrium
from fivtui.scene import Scene
from fivtui.tui.session import Session

NO_BELT_SPEED = "mu_s has no effect without v_belt"
CONSTANT_FRICTION = "v_s has no effect without mu_s greater than mu"


@pytest.mark.parametrize(
    ("values", "varied", "message"),
    [
        ({}, (), ""),
        ({"v_belt": 1.0}, (), ""),
        ({"mu_s": 0.9}, (), NO_BELT_SPEED),
        ({"mu_s": 0.9, "v_s": 0.4}, (), "mu_s and v_s have no effect without v_belt"),
        ({"mu_s": 0.9, "v_s": 0.4}, ("v_belt",), ""),
        ({"v_belt": 1.0, "v_s": 0.4}, (), CONSTANT_FRICTION),
        ({"v_belt": 1.0, "mu_s": 0.7, "v_s": 0.4}, (), CONSTANT_FRICTION),
        ({"v_belt": 1.0, "v_s": 0.4}, ("mu_s",), ""),
        ({"v_belt": 1.0, "mu_s": 0.7, "v_s": 0.4}, ("mu",), ""),
        ({"v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}, (), ""),
        ({}, ("mu_s",), NO_BELT_SPEED),
    ],
)
def test_a_parameter_that_needs_another_one_gives_a_warning(
    values: dict[str, float], varied: tuple[str, ...], message: str
) -> None:
    assert describe_unused(Parameters(**values), varied) == message


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("simulate --set mu_s=0.9 --t-end 1", NO_BELT_SPEED),
        ("simulate --set v_belt=1 --set v_s=0.4 --t-end 1", CONSTANT_FRICTION),
        ("stability --set mu_s=0.9 --no-search", NO_BELT_SPEED),
        ("sweep --set mu_s=0.9 --vary F=20,30 --t-end 1", NO_BELT_SPEED),
        ("map --set mu_s=0.9 --over F=20:30:2 --over c1=1:2:2", NO_BELT_SPEED),
    ],
)
def test_commands_warn_of_parameters_without_effect_in_one_line(
    line: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 0
    assert capsys.readouterr().err.splitlines() == [f"warning: {message}"]


@pytest.mark.parametrize(
    "line",
    [
        "simulate --set v_belt=1 --set mu_s=0.9 --set v_s=0.4 --t-end 1",
        "sweep --set mu_s=0.9 --vary v_belt=1,2 --t-end 1",
        "map --set v_belt=1 --set v_s=0.4 --over F=20:30:2 --over mu_s=0.8:0.9:2",
        "simulate brake-stop --t-end 1",
    ],
)
def test_parameters_with_an_effect_give_no_warning(
    line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 0
    assert "no effect" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "names"),
    [
        (
            "uncertainty --vary mu~uniform:0.2:0.8 --set mu=0.5 --samples 64 --output critical_mu",
            "mu",
        ),
        ("sweep --vary F=20,30 --set F=5 --set c1=1 --t-end 1", "F"),
        ("map --over F=20:30:2 --over mu=0.1:0.2:2 --set F=4 --set mu=0.3", "F mu"),
        ("attractors --vary mu=0.1:0.2:2 --set mu=0.4", "mu"),
        # A branch begins at the scene's value.
        ("branch --vary mu=0.3:0.5 --set mu=0.4", ""),
        ("branch --curve hopf --over mu=0.3:0.5 --over F=70:90 --set mu=0.4", ""),
    ],
)
def test_commands_warn_of_a_value_for_a_parameter_that_varies(
    line: str, names: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 0
    warnings = [f"warning: --set {name} has no effect: {name} varies" for name in names.split()]
    assert capsys.readouterr().err.splitlines() == warnings


@pytest.mark.parametrize(
    "line",
    [
        "sweep --vary mu_s=0.8,0.9 --t-end 1",
        "map --over F=20:30:2 --over mu_s=0.8:0.9:2",
        "uncertainty --vary mu_s~uniform:0.8:0.9 --samples 64",
    ],
)
def test_varied_parameters_without_effect_are_refused(
    line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line.split()) == 2
    assert capsys.readouterr().err == f"fivtui: {NO_BELT_SPEED}, which must be given\n"


def test_functions_note_or_refuse_parameters_without_effect() -> None:
    over = {"F": [20.0, 80.0], "mu_s": [0.8, 0.9]}
    with pytest.raises(InputError, match=NO_BELT_SPEED):
        stability_map(None, over)
    with pytest.raises(InputError, match=NO_BELT_SPEED):
        sweep(vary=over, t_end=1.0)
    constant = Parameters(v_belt=1.0, v_s=0.4)
    with pytest.raises(InputError, match=CONSTANT_FRICTION):
        continuation(constant, "v_s", [0.4, 0.5])
    with pytest.raises(InputError, match=CONSTANT_FRICTION):
        branch(constant, "v_s", low=0.4, high=0.5, origin="cycle")
    assert NO_BELT_SPEED in repr(simulate(Parameters(mu_s=0.9), t_end=1.0))
    assert CONSTANT_FRICTION in repr(stability(constant))
    assert "no effect" not in repr(simulate(Parameters(v_belt=1.0, mu_s=0.9), t_end=1.0))


def test_parameters_without_effect_do_not_move_the_equilibrium() -> None:
    p = Parameters(mu_s=0.9, v_s=0.4)
    assert equilibrium(System(p)) == equilibrium(System(Parameters()))


def test_the_result_of_a_run_on_a_belt_says_how_often_it_sticks() -> None:
    result = simulate(Parameters(v_belt=1.0), t_end=10.0)
    assert f"{result.events.sticks}, {result.events.stick_time:.4g} s" in repr(result)
    assert "sticks" not in repr(simulate(t_end=1.0))


def test_the_form_notes_parameters_without_effect_at_their_fields() -> None:
    session = Session(Scene(name="mine", description="", parameters=Parameters(mu_s=0.9)))
    assert session.notes == {"mu_s": "no effect without v_belt"}
    session.set_text("v_belt", "1")
    assert session.notes == {}
    session.set_text("v_s", "0.4")
    session.set_text("mu_s", "")
    assert session.notes == {"v_s": "no effect without mu_s greater than mu"}
    session.set_text("v_s", "-1")
    assert session.notes == {}


@pytest.mark.parametrize(
    "line",
    ["sweep --vary v_belt=none,1", "sweep --vary v_belt=-2e9,1", "map --over v_belt=-2e9:1:3"],
)
def test_none_is_not_offered_where_a_number_is_needed(
    line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*line.split(), *(["--over", "F=1:2:2"] if "map" in line else [])]) == 2
    assert capsys.readouterr().err.endswith("must be from -1e+09 to 1e+09 m/s\n")
    assert run(["simulate", "--set", "v_belt=-2e9"]) == 2
    assert "must be none, or from -1e+09 to" in capsys.readouterr().err


def test_an_error_hides_warnings_about_the_input(capsys: pytest.CaptureFixture[str]) -> None:
    line = "map --set mu=0.4 --over mu=0:1:3 --over F=10:20:2 --out map.txt"
    assert run(line.split()) == 2
    assert capsys.readouterr().err.startswith("fivtui: map.txt: the suffix")
