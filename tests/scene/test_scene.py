"""Scenes, their files and the presets."""

import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, strategies as st

from fivtui.distributions import Distribution
from fivtui.equilibrium.eigenvalues import stability
from fivtui.model.errors import InputError
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.scene.files import find_scene, load_scene, save_scene, scene_from_dict, scene_to_dict
from fivtui.scene.presets import DEFAULT_PRESET, PRESETS
from fivtui.scene.scene import OUTPUTS, Scene
from fivtui.simulation import simulate
from fivtui.transient import ALL_METHODS, QUANTITIES
from fivtui.transient.methods import METHODS
from fivtui.transient.request import DEFAULT_TOL, TOL_RANGE
from fivtui.transient.result import Transient
from fivtui.transient.settings.checks import MAX_T_END, Start

VERSION = "fivtui_scene = 1\n"
SCATTER = (
    ("mu", Distribution("normal", (0.42, 0.1 / 3.0))),
    ("v_belt", Distribution("gamma", (2.0, 0.0, 1.5))),
    ("y0", Distribution("uniform", (-1.0, 0.0))),
)


def run(scene: Scene) -> Transient:
    return simulate(
        scene.parameters, t_end=scene.t_end, separation=scene.separation, start=scene.start
    )


def takes_step(method: str) -> bool:
    # `METHODS` are the native methods. The two that run an FMU have a communication step.
    return method not in METHODS or METHODS[method].fixed_step


printable = st.text(st.characters(codec="utf-8").filter(str.isprintable))
finite = st.floats(allow_nan=False, allow_infinity=False)
static_starts: st.SearchStrategy[Start] = st.just("static")
parameter_sets = st.builds(
    Parameters,
    **{name: st.floats(spec.lower, spec.upper) for name, spec in PARAMETERS.items()},
)


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    t_end = draw(st.floats(0.0, MAX_T_END, exclude_min=True))
    method = draw(st.sampled_from(sorted(ALL_METHODS)))
    steps = st.none() | st.floats(0.0, t_end, exclude_min=True)
    errors = st.dictionaries(st.sampled_from(sorted(QUANTITIES)), st.floats(1e-12, 1.0))
    # Error targets by quantity; a scene with targets has neither tolerance nor step.
    accuracy = tuple(draw(errors).items())
    return Scene(
        name=draw(printable.filter(str.strip)),
        description=draw(printable),
        parameters=draw(parameter_sets),
        separation=draw(st.booleans()),
        start=draw(static_starts | st.tuples(finite, finite, finite, finite)),
        t_end=t_end,
        tol=DEFAULT_TOL if accuracy else draw(st.floats(*TOL_RANGE)),
        method=method,
        step=draw(steps) if takes_step(method) and not accuracy else None,
        accuracy=accuracy,
        outputs=tuple(draw(st.lists(st.sampled_from(sorted(OUTPUTS)), unique=True))),
        scatter=draw(st.sampled_from([(), SCATTER])),
        correlation=draw(st.sampled_from([(), (("mu", "F", -0.25), ("mu", "y0", 0.5))])),
    )


@given(scene=scenes())
def test_a_saved_scene_loads_as_the_same_scene(
    scene: Scene, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("scene") / "scene.toml"
    save_scene(scene, path)
    # Unlike equality, the representation distinguishes -0.0 from 0.0.
    assert repr(load_scene(path)) == repr(scene)


@given(scene=scenes())
def test_a_scene_as_plain_data_reads_back_the_same(scene: Scene) -> None:
    assert scene_from_dict(json.loads(json.dumps(scene_to_dict(scene)))) == scene


def test_a_saved_file_explains_every_parameter(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    save_scene(PRESETS["base"], path)
    lines = path.read_text(encoding="utf-8").splitlines()
    for name, spec in PARAMETERS.items():
        (line,) = (line for line in lines if line.startswith(f"{name} = "))
        assert line == f"{name} = {spec.default!r} # {spec.meaning}; {spec.allowed}"
    for method in ALL_METHODS:
        assert any(line.startswith("method") and method in line for line in lines)


def test_a_scene_file_is_replaced_only_with_force(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    save_scene(PRESETS["base"], path)
    with pytest.raises(InputError, match="exists already"):
        save_scene(PRESETS["linear"], path)
    assert load_scene(path) == PRESETS["base"]
    save_scene(PRESETS["linear"], path, force=True)
    assert load_scene(path) == PRESETS["linear"]


def test_a_scene_with_scatter_is_computed_at_its_values() -> None:
    scene = dataclasses.replace(PRESETS["base"], scatter=SCATTER)
    assert run(scene).final == run(PRESETS["base"]).final
    assert scene.with_values({"mu": 0.3}).scatter == SCATTER


@pytest.mark.parametrize(
    ("scatter", "message"),
    [
        ((SCATTER[0], SCATTER[0]), "every name must be given once"),
        ((("mu", Distribution("normal", (0.4, 0.1), low=0.3)),), "mu: must not be truncated"),
        ((("mu", "normal:0.4:0.1"),), "must be a distribution, such as normal:80:8"),
    ],
)
def test_scatter_that_a_file_cannot_hold_is_refused(scatter: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        dataclasses.replace(PRESETS["base"], scatter=scatter)


def test_keys_missing_in_a_file_have_defaults(tmp_path: Path) -> None:
    path = tmp_path / "brake.toml"
    path.write_text(VERSION + "[parameters]\nF = 120\n", encoding="utf-8")
    expected = Scene(name="brake", description="", parameters=Parameters(F=120.0))
    assert load_scene(path) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not a scene: the key fivtui_scene = 1 is missing"),
        ("fivtui_scene = 2", "fivtui_scene = 2: this fivtui reads version 1"),
        ("fivtui_scene = true", "fivtui_scene = True: this fivtui reads version 1"),
        (VERSION + "seperation = true", "unknown key 'seperation'; did you mean separation?"),
        (VERSION + "[parameter]\nF = 1", "unknown key 'parameter'; did you mean parameters?"),
        (VERSION + "[parameters]\nf = 1.0", "[parameters] unknown parameter 'f'; did you mean F?"),
        (VERSION + "[parameters]\nF = '80'", "[parameters] F = '80': not a number"),
        (VERSION + "[parameters]\nF = true", "[parameters] F = True: not a number"),
        (VERSION + "[parameters]\nF = nan", "[parameters] F = nan: not a finite number"),
        (
            VERSION + "[parameters]\nm = 0.0",
            "[parameters] m = 0: must be from 1e-12 to 1e+09 kg",
        ),
        (VERSION + f"[parameters]\nm = 0x{'f' * 4000}", "[parameters] m: the number is too large"),
        (VERSION + "parameters = 3", "parameters: must be a table"),
        (VERSION + "name = 3", "name = 3: must be text in quotes"),
        (VERSION + "name = ' '", "name is empty"),
        (VERSION + 'description = "a\\nb"', "description = 'a\\nb': must be one line"),
        (VERSION + "separation = 'yes'", "separation = 'yes': must be true or false"),
        (VERSION + "separation = 1", "separation = 1: must be true or false"),
        (VERSION + "start = 'stat'", "start = 'stat': must be static, or four finite numbers"),
        (VERSION + "start = 3", "start = 3: must be static"),
        (VERSION + "start = [0, 0, 0]", "start = (0.0, 0.0, 0.0): must be static"),
        (VERSION + "start = [0, 0, inf, 0]", "start = inf: not a finite number"),
        (VERSION + "start = [0, 0, '1', 0]", "start[2] = '1': not a number"),
        (VERSION + "scatter = 3", "scatter = 3: must be a table such as {mu = "),
        (VERSION + "[scatter]\nmu = 3", "scatter.mu = 3: must be text in quotes"),
        (VERSION + "[scatter]\nmu = 'normal:1'", "normal:1: must be normal:MEAN:SD"),
        (VERSION + "[scatter]\nf = 'normal:1:2'", "unknown name 'f'; did you mean F?"),
        (VERSION + "[scatter]\nmu = 'uniform:-2:-1'", "mu: uniform:-2:-1: must have values from 0"),
        (VERSION + "t_end = -1", "t_end = -1: must be above 0 and at most 1e+07 s"),
        (VERSION + "tol = 1.0", "tol = 1: must be from 1e-13 to 0.01"),
        (VERSION + "method = 'rk5'", "unknown method 'rk5'; did you mean rk4?"),
        (VERSION + "method = 'rk4'\nstep = 200", "step = 200: must be above 0 and at most 100 s"),
        (VERSION + "step = 0.1", "step: the method taylor sets its step by tol"),
        ("a = ", "not a TOML file: Invalid value (at end of document)"),
        ("a = " + 4000 * "[", "not a TOML file: values are nested too deeply"),
        ("a = " + 100_000 * "[", "line 1: must be of at most 4096 characters"),
        (VERSION + "a" + 20_000 * ".a" + " = 1", "line 2: must be of at most 4096 characters"),
        # Python from 3.12 on can also print values that are nested so deeply.
        (
            VERSION + "accuracy" + 1500 * ".a" + " = 1",
            ("not a scene: values are nested too deeply", "accuracy.a = {'a': {'a': {"),
        ),
        (VERSION + f"name = '{300 * 'x'}'", "name: must be of at most 255 characters, not 300"),
    ],
)
def test_a_wrong_file_is_a_one_line_error_with_file_key_and_range(
    tmp_path: Path, text: str, message: str | tuple[str, ...]
) -> None:
    path = tmp_path / "brake.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_scene(path)
    assert str(caught.value).removeprefix(f"{path}: ").startswith(message)
    assert "\n" not in str(caught.value)


def test_a_binary_file_is_a_one_line_error(tmp_path: Path) -> None:
    path = tmp_path / "brake.toml"
    with pytest.raises(InputError, match=r"brake\.toml: there is no such file$"):
        load_scene(path)
    with pytest.raises(InputError, match="is a folder"):
        load_scene(tmp_path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="not UTF-8 text"):
        load_scene(path)


def test_a_scene_without_a_name_is_refused() -> None:
    with pytest.raises(InputError, match="name is missing"):
        scene_from_dict({"fivtui_scene": 1})


def test_parameters_can_be_overridden() -> None:
    base = PRESETS["base"]
    changed = base.with_values({"F": "120", "mu": 0.5})
    assert changed == dataclasses.replace(base, parameters=Parameters(F=120.0, mu=0.5))
    with pytest.raises(InputError, match="did you mean k_nl"):
        base.with_values({"knl": 1.0})


def test_a_scene_is_found_by_preset_or_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = dataclasses.replace(PRESETS["base"], name="mine", t_end=7.0)
    for name in ("mine.toml", "mine", "base"):
        save_scene(scene, Path(name))
    assert find_scene("mine.toml") == find_scene("mine") == find_scene("./base") == scene
    assert find_scene("base") == PRESETS["base"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("baes", "unknown preset 'baes'; did you mean base?"),
        ("linaer.toml", "linaer.toml: there is no such file"),
        ("nowhere/base", "nowhere/base: there is no such file"),
        ("", "unknown preset ''"),
    ],
)
def test_a_missing_scene_is_a_one_line_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as caught:
        find_scene(name)
    assert str(caught.value).startswith(message)


def test_presets_have_short_names_and_cite_the_paper() -> None:
    assert PRESETS[DEFAULT_PRESET].parameters == Parameters()
    for name, scene in PRESETS.items():
        assert scene.name == name
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", name)
        assert re.match(r"(Fig|Figs|Section|Beyond the paper)\b", scene.description)


def test_the_linear_preset_has_the_linear_critical_friction_coefficient() -> None:
    result = stability(PRESETS["linear"].parameters)
    (critical,) = result.critical_mu
    assert critical.mu == pytest.approx(1.0181, abs=5e-5)
    assert result.linear_critical_mu == pytest.approx(critical.mu, rel=1e-12)


def test_the_coexistence_presets_show_two_attractors_of_one_parameter_set() -> None:
    large, small = PRESETS["coexistence"], PRESETS["coexistence-decay"]
    assert large.parameters == small.parameters
    assert stability(large.parameters).stable
    assert run(large).steady.y_half_range > 7.0
    decay = run(small)
    assert decay.steady.y_half_range < 1e-3
    assert decay.events.separations == 0


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_can_be_computed(name: str) -> None:
    scene = PRESETS[name]
    result = run(dataclasses.replace(scene, t_end=5.0))
    assert result.separation == scene.separation
    assert result.peak.y_abs > 0.0


def test_presets_have_the_parameters_that_their_descriptions_state() -> None:
    changed = {
        name: {
            symbol: value
            for symbol, value in scene.parameters.as_dict().items()
            if value != getattr(Parameters(), symbol)
        }
        for name, scene in PRESETS.items()
    }
    assert changed == {
        "base": {},
        "separation-ignored": {},
        "linear": {"k_nl": 0.0},
        "nonproportional-damping": {"c1": 0.8, "F": 100.0},
        "soft-horizontal": {"k1": 50.0, "k2": 100.0},
        "stiff-contact": {"mu": 1.2, "F": 100.0, "k_nl": 300.0},
        "coexistence": {"F": 120.0},
        "coexistence-decay": {"F": 120.0},
        "brake-stop": {"F": 10.0, "mu": 0.6, "c2": 2.0, "v_belt": 10.0, "mu_s": 0.9, "v_s": 0.3},
    }
    ignored = {name for name, scene in PRESETS.items() if not scene.separation}
    assert ignored == {"separation-ignored", "linear"}
