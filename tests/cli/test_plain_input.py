"""Plain numbers, names and messages are accepted; any other input is a one-line error."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui import (
    Parameters,
    Scene,
    build_fmu,
    figures,
    find_scene,
    run_fmu,
    simulate,
    simulate_batch,
    stability,
    sweep,
    uncertainty,
)
from fivtui.cli import run
from fivtui.io.reading import open_regular, read_bytes
from fivtui.model.errors import ComputationError, InputError, one_line
from fivtui.model.numbers import read_integer, read_number
from fivtui.scene import scene_transient


@pytest.mark.parametrize(
    "kind", [np.float32, np.float64, np.longdouble, np.int8, np.int64, np.uint16]
)
def test_scalars_of_numpy_are_numbers(kind: type) -> None:
    assert Parameters(F=kind(60)).F == 60.0
    assert type(Parameters(F=kind(60)).F) is float
    assert simulate(t_end=kind(1), start=list(np.zeros(4))).t_end == 1.0


@pytest.mark.parametrize("value", [np.True_, True, None, [80.0], 80j, np.array([80.0])])
def test_values_that_are_not_real_numbers_are_refused(value: object) -> None:
    with pytest.raises(InputError, match=r"F = .*: not a number"):
        Parameters(F=value)  # type: ignore[arg-type]
    assert Parameters(F=Fraction(1, 4)).F == 0.25  # type: ignore[arg-type]


def test_a_wrong_parameter_set_is_a_one_line_error() -> None:
    pattern = r"parameters = .*: must be a set of parameters, such as Parameters\(F=80\.0\)$"
    with pytest.raises(InputError, match=pattern):
        simulate(80.0)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=pattern):
        simulate({"F": 80.0}, method="fmu")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=pattern):
        sweep(80.0, vary={"F": [1.0]})  # type: ignore[arg-type]
    with pytest.raises(InputError, match=pattern):
        simulate_batch({"F": [1.0]}, base=80.0)  # type: ignore[arg-type]


def test_presets_and_scenes_as_parameters_are_refused_with_advice() -> None:
    pattern = (
        r"such as Parameters\(F=80\.0\); a preset .* is find_scene\('coexistence'\), with param"
    )
    computations: tuple[Callable[[Any], object], ...]
    computations = (simulate, stability, lambda name: sweep(name, vary={"F": [1.0]}))
    for compute in computations:
        with pytest.raises(InputError, match=pattern):
            compute("coexistence")
    scene = find_scene("coexistence")
    with pytest.raises(InputError, match="; a scene has parameters, separation, start and t_end"):
        simulate(scene)  # type: ignore[arg-type]
    transient = simulate(
        scene.parameters, separation=scene.separation, start=scene.start, t_end=scene.t_end
    )
    assert transient.final == scene_transient(scene).transient.final


NAMES: dict[str, Callable[[Any, Path], object]] = {
    "outputs = 'y_abs'": lambda names, _: sweep(vary={"F": [1.0]}, outputs=names),
    "outputs = 'critical_mu'": lambda names, _: uncertainty(
        vary={"F": "uniform:70:90"}, outputs=names
    ),
    "outputs = 'stability'": lambda names, _: Scene("a", "", Parameters(), outputs=names),
    "outputs = 'y'": lambda names, folder: run_fmu(
        build_fmu(folder / "belt.fmu", flavour="native"), outputs=names
    ),
    "sensitivities = 'mu'": lambda names, _: simulate(sensitivities=names),
    "formats = 'png'": lambda names, _: figures("nowhere", [2], formats=names),
}


@pytest.mark.parametrize("subject", NAMES)
def test_a_text_instead_of_a_list_of_names_is_refused(subject: str, tmp_path: Path) -> None:
    name = subject.split("'")[1]
    pattern = f"^{subject}: must be a list of names, such as \\['{name}'\\]$"
    with pytest.raises(InputError, match=pattern):
        NAMES[subject](name, tmp_path)


@pytest.mark.parametrize("text", ["1_0", "٣", "１", "1e１", "0x10", "", "1 0", "1,0", "--1"])
def test_only_plain_digits_are_a_number(text: str) -> None:
    for read in (read_number, read_integer):
        with pytest.raises(ValueError, match=r"plain|convert|literal"):
            read(text)
    with pytest.raises(InputError, match="not a number"):
        Parameters().with_values({"F": text})


def test_plain_numbers_are_read_in_every_usual_form() -> None:
    assert [read_number(text) for text in (" 1 ", "+1.", ".5e1", "-1E-2")] == [1.0, 1.0, 5.0, -0.01]
    assert read_integer(" +12 ") == 12


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "--t-end", "1", "--t-end", "2"],
        ["simulate", "--t-end=1", "--t-end", "1"],
        ["simulate", "--set", "F=1", "--set", "F=2"],
        ["simulate", "--error", "peak=1e-2", "--error", "peak=1e-3"],
        ["sweep", "--vary", "F=1:2:2", "--vary", "F=3:4:2"],
        ["sweep", "--vary", "F=1:2:2", "--design", "list", "--design", "list"],
        ["fmu", "build", "--out", "a.fmu", "--out", "b.fmu"],
    ],
    ids=" ".join,
)
def test_repeated_single_value_options_are_refused(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    assert "twice" in capsys.readouterr().err


@pytest.mark.parametrize("flag", ["--scheduler", "--out", "--t-end", "--design"])
def test_an_empty_value_is_refused(flag: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["sweep", "--vary", "F=1:2:2", flag, ""]) == 2
    assert capsys.readouterr().err == f"fivtui: {flag}: must not be empty\n"


def test_a_flag_may_be_repeated(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["presets", "--json", "--json"]) == 0


def test_messages_are_one_printable_line_of_bounded_length() -> None:
    text = "\n\x1b[31m\udcff" + 100_000 * "1" + 50_000 * " 2"
    for error in (InputError(f"F = {text}: wrong"), ComputationError(f"at {text}", text)):
        assert str(error).isprintable()
        assert len(str(error)) < 4200
    assert str(InputError(f"{text}: must be short")).endswith(": must be short")
    assert one_line("μ = 0.7: as it is") == "μ = 0.7: as it is"
    assert one_line(one_line(text)) == one_line(text)


def test_a_file_is_read_up_to_its_limit(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(bytes(2048))
    assert read_bytes(path, limit=2048) == bytes(2048)
    with pytest.raises(InputError, match=r"file: must be of at most 2047 bytes$"):
        read_bytes(path, limit=2047)
    # The operating system reports that files of processes are empty.
    with pytest.raises(InputError, match="at most 16 bytes"):
        read_bytes(Path("/proc/self/status"), limit=16)


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000, "missing", "folder", "\udcff" * 300])
def test_a_missing_file_is_a_one_line_error(name: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError) as caught, open_regular(tmp_path / name):
        pass
    assert str(caught.value).isprintable()
