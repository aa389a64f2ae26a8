"""Options that dataclasses declare: commands read back the arguments made from their values.

A setting belongs to the transient of a scene, such as its horizon; an option may replace it.
"""

from pathlib import Path
from typing import Any

import pytest

from fivtui.cli import commands, run
from fivtui.identification import IdentifyOptions
from fivtui.maps import MapOptions
from fivtui.measured import ValidateOptions
from fivtui.model import InputError
from fivtui.options import (
    Option,
    declared_options,
    declared_settings,
    option_arguments,
    read_arguments,
)
from fivtui.orbits import BranchOptions
from fivtui.reliability import UncertaintyOptions
from fivtui.scene import PRESETS, Scene, save_scene
from fivtui.sweeps import SweepOptions
from fivtui.tradeoffs import TradeoffOptions
from fivtui.transient import SETTINGS, SimulateOptions

DECLARED = {
    "map": MapOptions,
    "validate": ValidateOptions,
    "identify": IdentifyOptions,
    "branch": BranchOptions,
    "uncertainty": UncertaintyOptions,
    "sweep": SweepOptions,
    "tradeoff": TradeoffOptions,
    "simulate": SimulateOptions,
}


def another_value(declared: Option, default: Any) -> Any:
    """A value that differs from the default."""
    if declared.integers is not None:
        return 7
    if declared.choices:
        return declared.choices[-1]
    if declared.multiple:
        return (Path("a.csv"), Path("b.csv")) if declared.file else ("a=1", "b=-2")
    if declared.metavar is None:
        return not default
    return Path("a.csv") if declared.file else "-1,5"


@pytest.mark.parametrize("name", DECLARED)
def test_options_survive_a_round_trip_through_the_command_line(name: str) -> None:
    values = {
        key: another_value(declared, default)
        for key, (declared, default) in declared_options(DECLARED[name]).items()
    }
    required = {
        key: values[key]
        for key, (declared, _) in declared_options(DECLARED[name]).items()
        if declared.required
    }
    for settings in (values, required):
        options = DECLARED[name](**settings)
        read = commands.commands[name].make_context(name, option_arguments(options)).params
        assert {key: read[key] for key in values} == vars(options)


def test_options_of_settings_have_the_flags_of_the_table() -> None:
    for options_class in DECLARED.values():
        assert set(declared_settings(options_class)) <= set(SETTINGS)
        for declared, _ in declared_options(options_class).values():
            if declared.setting:
                of_table = SETTINGS[declared.setting].option
                assert (declared.flag, declared.metavar) == (of_table.flag, of_table.metavar)


def test_arguments_are_read_with_and_without_an_equals_sign_among_others() -> None:
    options, others = read_arguments(
        IdentifyOptions, ["rig.csv", "--fit", "mu", "--fit=c1=0.1:2", "b.csv", "--noise=-1"]
    )
    assert others == ["rig.csv", "b.csv"]
    assert option_arguments(options) == ["--noise", "-1", "--fit", "mu", "--fit", "c1=0.1:2"]
    for arguments, message in (
        (["--fits", "mu"], "unknown option '--fits'"),
        (["--fit"], "--fit: must be followed by a value"),
        (["--fit="], "--fit: must be followed by a value"),
        # Settings and flags are set elsewhere.
        (["--start", "static"], "unknown option '--start'"),
        (["--ignore-separation"], "unknown option '--ignore-separation'"),
    ):
        with pytest.raises(InputError, match=message):
            read_arguments(IdentifyOptions, arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("simulate --method=rk4 --step=0.01 --tol=1e-2", "--tol: must be given without method rk4"),
        ("simulate --points=10", "--points: must be given with --out or --plot"),
        ("simulate --force", "--force: must be given with a file to write"),
    ],
)
def test_an_option_without_effect_is_refused(
    arguments: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments.split()) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ("sweep --vary k3=0,0 --set F=-5 --output y_abs", "all 2 members failed, the first: no eq"),
        ("sweep --vary k3=0,0 --set F=-5 --output y_abs --out", "all 2 members failed, the first"),
        (
            "uncertainty --set v_belt=0 --vary mu~uniform:0.2:0.5 --samples 32 --no-indices "
            "--output critical_mu --out",
            "members failed, the first: no equilibrium of sliding",
        ),
        (
            "map --set v_belt=0 --over F=60:80:2 --over mu=0.1:0.5:2 --out",
            "no value at any of the 4 points, which have no verdict",
        ),
    ],
)
def test_a_study_without_a_computed_value_fails_after_its_files_are_written(
    arguments: str, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.csv"
    has_file = arguments.endswith("--out")
    assert run([*arguments.split(), *([str(out)] if has_file else [])]) == 3
    assert reason in capsys.readouterr().err.splitlines()[-1]
    assert out.is_file() == has_file


def test_a_scene_without_outputs_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "s.toml"
    path.write_text("fivtui_scene = 1\noutputs = []\n")
    assert run(["run", str(path)]) == 2
    assert "scene s: outputs must name what is to be computed" in capsys.readouterr().err
    assert run(["sweep", "--vary", "F=60:80", "--design", "sobol"]) == 2
    assert "count: must be given, from 1 to" in capsys.readouterr().err


def test_the_laboratory_starts_with_a_preset_or_a_scene_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    save_scene(PRESETS["linear"], path)
    starts: list[tuple[Scene | None, str]] = []
    monkeypatch.setattr("fivtui.cli.group.has_terminal", lambda: True)
    monkeypatch.setattr("fivtui.tui.run", lambda scene, source: starts.append((scene, source)))
    for arguments in ([], ["linear"], ["tui"], ["tui", "linear"], [str(path)]):
        assert run(arguments) == 0
    linear = PRESETS["linear"]
    assert starts == [
        *((None, ""), (linear, "linear"), (None, ""), (linear, "linear"), (linear, str(path)))
    ]
    for unknown, message in (("absent.toml", "there is no such file"), ("bse", "unknown command")):
        assert run([unknown]) == 2
        assert message in capsys.readouterr().err
