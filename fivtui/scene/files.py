"""Scenes in TOML files.

A file holds the version of the format, the fields of `Scene` and a table of parameters. Fields and
parameters that it leaves out have their defaults; a name left out is that of the file.
"""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

import tomlkit
from tomlkit.items import Item

from fivtui.io import MAX_TEXT, is_there, read_bytes, write_atomically
from fivtui.model import InputError, Parameters, parameter_spec, unknown_name
from fivtui.simulation import ALL_METHODS
from fivtui.transient import QUANTITIES, T_END_INTERVAL, TOL_INTERVAL

from .over_time import over_time_from, over_time_to_dict
from .presets import PRESETS
from .scene import OUTPUTS, Accuracy, Correlation, Scene

FORMAT_VERSION: Final = 1
_VERSION_KEY: Final = "fivtui_scene"
_LONGEST_LINE: Final = 4096
_START: Final = "static (at rest at the equilibrium of μ = 0) or [x, vx, y, vy] in m and m/s"


def _boolean(key: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"{key} = {value!r}: must be true or false")
    return value


def _text(key: str, value: object) -> str:
    if not isinstance(value, str):
        raise InputError(f"{key} = {value!r}: must be text in quotes")
    return value


def _number(key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key} = {value!r}: not a number")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{key}: the number is too large") from None


def _accuracy(key: str, value: object) -> Accuracy:
    if not isinstance(value, Mapping):
        raise InputError(f"{key} = {value!r}: must be a table such as {{peak = 1e-4}}")
    return tuple((str(name), _number(f"{key}.{name}", error)) for name, error in value.items())


def _outputs(key: str, value: object) -> tuple[str, ...]:
    if not isinstance(value, list | tuple):
        raise InputError(f"{key} = {value!r}: must be a list of {', '.join(OUTPUTS)}")
    return tuple(_text(f"{key}[{index}]", entry) for index, entry in enumerate(value))


def _correlation(key: str, value: object) -> Correlation:
    if not isinstance(value, Mapping) or not all(isinstance(v, Mapping) for v in value.values()):
        raise InputError(f"{key} = {value!r}: must be a table such as {{mu = {{F = -0.3}}}}")
    return tuple(
        (str(one), str(other), _number(f"{key}.{one}.{other}", number))
        for one, row in value.items()
        for other, number in row.items()
    )


def _start(key: str, value: object) -> str | tuple[float, ...]:
    if isinstance(value, str):
        return value
    if not isinstance(value, list | tuple):
        raise InputError(f"{key} = {value!r}: must be {_START}")
    return tuple(_number(f"{key}[{index}]", entry) for index, entry in enumerate(value))


@dataclass(frozen=True, slots=True)
class _Key:
    # How a field of `Scene` is read from a file, and the comment that explains it there.
    read: Callable[[str, object], Any]
    comment: str = ""


_KEYS: Final[Mapping[str, _Key]] = {
    "name": _Key(_text),
    "description": _Key(_text),
    "separation": _Key(_boolean, "true: separation considered (Case 1), false: ignored (Case 2)"),
    "start": _Key(_start, _START),
    "t_end": _Key(_number, f"horizon; {T_END_INTERVAL}"),
    "tol": _Key(_number, f"relative tolerance; {TOL_INTERVAL}"),
    "method": _Key(_text, ", ".join(ALL_METHODS)),
    "step": _Key(_number, "step of rk4 or communication step of fmu; above 0 and at most t_end, s"),
    "accuracy": _Key(_accuracy, f"errors allowed, in place of tol: {', '.join(QUANTITIES)}"),
    "outputs": _Key(_outputs, f"what is required: {', '.join(OUTPUTS)}"),
    "over_time": _Key(over_time_from),
    "correlation": _Key(_correlation, "of the normal scores of scattered quantities, by name"),
}


def scene_to_dict(scene: Scene) -> dict[str, Any]:
    """A scene in the layout of its file: plain values by key; what is not set has no key."""
    fields = {key: getattr(scene, key) for key in _KEYS}
    if scene.step is None:
        del fields["step"]
    fields["outputs"] = list(scene.outputs)
    fields["accuracy"] = dict(scene.accuracy)
    if scene.over_time:
        fields["over_time"] = over_time_to_dict(scene.over_time)
    else:
        del fields["over_time"]
    rows: dict[str, dict[str, float]] = {}
    for one, other, value in fields.pop("correlation"):
        rows.setdefault(one, {})[other] = value
    if rows:
        fields["correlation"] = rows
    for unused in ("tol", "step") if scene.accuracy else ("accuracy",):
        fields.pop(unused, None)
    if not isinstance(scene.start, str):
        fields["start"] = list(scene.start)
    return {_VERSION_KEY: FORMAT_VERSION, **fields, "parameters": scene.parameters.as_dict()}


def scene_from_dict(data: Mapping[str, object], *, name: str | None = None) -> Scene:
    """A scene from the layout of its file, see `scene_to_dict`.

    `name` is used where the layout has none. Raises `InputError` if a key is unknown or missing, or
    a value has the wrong type or is out of range.
    """
    _check_version(data)
    known = (_VERSION_KEY, *_KEYS, "parameters")
    for key in data:
        if key not in known:
            raise unknown_name("key", key, known)
    fields = {key: entry.read(key, data[key]) for key, entry in _KEYS.items() if key in data}
    for unused in ("tol", "step"):
        if fields.get("accuracy") and unused in fields:
            raise InputError(f"{unused}: must not be given with accuracy, from which it follows")
    if name is not None:
        fields.setdefault("name", name)
    if "name" not in fields:
        raise InputError("the key name is missing")
    fields.setdefault("description", "")
    starts = {timed: table.after(0.0)[0] for timed, table in fields.get("over_time", ())}
    return Scene(parameters=_parameters(data.get("parameters", {}), starts), **fields)


def _check_version(data: Mapping[str, object]) -> None:
    if _VERSION_KEY not in data:
        raise InputError(f"not a scene: the key {_VERSION_KEY} = {FORMAT_VERSION} is missing")
    version = data[_VERSION_KEY]
    if isinstance(version, bool) or version != FORMAT_VERSION:
        raise InputError(
            f"{_VERSION_KEY} = {version!r}: this fivtui reads version {FORMAT_VERSION} only"
        )


def _parameters(table: object, starts: Mapping[str, float]) -> Parameters:
    # `starts` are values at t = 0 of those over time, which need not be given.
    if not isinstance(table, Mapping):
        raise InputError("parameters: must be a table of parameters")
    try:
        values = {}
        for name, value in table.items():
            spec = parameter_spec(name)
            values[name] = spec.check(_number(name, value))
        made = Parameters(**{**starts, **values})
        begins = made.with_values(starts)
        for name in starts:
            if getattr(made, name) != getattr(begins, name):
                raise InputError(
                    f"{name} = {values[name]:g}: follows a table over time, which begins with "
                    f"{starts[name]:g}; must be left out"
                )
        return made
    except InputError as error:
        raise InputError(f"[parameters] {error}") from None


def load_scene(path: str | Path) -> Scene:
    r"""Read a scene from a TOML file.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Scene
        The checked scene; its name is that of the file if the file has none.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or is not a scene; the message names file and key.

    Examples
    --------
    >>> from pathlib import Path
    >>> from fivtui import load_scene
    >>> text = "fivtui_scene = 1\nt_end = 20.0\n[parameters]\nF = 60.0\n"
    >>> _ = Path("soft.toml").write_text(text)
    >>> scene = load_scene("soft.toml")
    >>> scene.name, scene.t_end, scene.parameters.F
    ('soft', 20.0, 60.0)
    """
    path = Path(path)
    content = read_bytes(path, limit=MAX_TEXT)
    try:
        text = content.decode()
        _check_lines(text)
        data = _parsed(text)
        if "over_time" in data:
            tables = over_time_from("over_time", data["over_time"], path.parent)
            data["over_time"] = over_time_to_dict(tables)
        return scene_from_dict(data, name=path.stem)
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a TOML file: not UTF-8 text") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except RecursionError:
        raise InputError(f"{path}: not a scene: values are nested too deeply") from None


def _check_lines(text: str) -> None:
    # A key of n dots takes tomllib n² steps.
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > _LONGEST_LINE:
            raise InputError(f"line {number}: must be of at most {_LONGEST_LINE} characters")


def _parsed(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise InputError(f"not a TOML file: {error}") from None
    except RecursionError:
        raise InputError("not a TOML file: values are nested too deeply") from None


def save_scene(scene: Scene, path: str | Path, *, force: bool = False) -> None:
    """Write a scene to a TOML file, with units, meanings and ranges as comments.

    Parameters
    ----------
    scene : Scene
        The scene.
    path : str or Path
        The file.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> from fivtui import Parameters, Scene, load_scene, save_scene
    >>> scene = Scene(name="mine", description="half the preload", parameters=Parameters(F=40.0))
    >>> save_scene(scene, "mine.toml")
    >>> load_scene("mine.toml") == scene
    True
    """
    content = tomlkit.dumps(_document(scene)).encode()

    def write(file: BinaryIO) -> None:
        file.write(content)

    write_atomically(Path(path), write, force=force)


def _document(scene: Scene) -> tomlkit.TOMLDocument:
    data = scene_to_dict(scene)
    document = tomlkit.document()
    document.add(tomlkit.comment("A scene of fivtui, the nonlinear slider-belt model."))
    document.add(_VERSION_KEY, _item(data[_VERSION_KEY], "version of this format"))
    for key, entry in _KEYS.items():
        if key in data and key != "over_time":
            document.add(key, _item(data[key], entry.comment))
    table = tomlkit.table()
    for name, value in data["parameters"].items():
        spec = parameter_spec(name)
        table.add(name, _item(value, f"{spec.meaning}; {spec.allowed}"))
    document.add("parameters", table)
    if scene.over_time:
        document.add("over_time", _over_time(data["over_time"]))
    return document


def _over_time(tables: Mapping[str, Any]) -> Item:
    table = tomlkit.table()
    table.comment("linear between rows of time, s, and value, in place of the parameters above")
    for name, rows in tables.items():
        array = tomlkit.item(rows)
        array.multiline(multiline=True)
        table.add(name, array)
    return table


def _item(value: object, comment: str) -> Item:
    if isinstance(value, Mapping):
        table = tomlkit.inline_table()
        table.update(value)
        return table.comment(comment)
    item = tomlkit.item(value)
    return item.comment(comment) if comment else item


def find_scene(name_or_path: str) -> Scene:
    """A preset by name, or the scene in a file.

    Parameters
    ----------
    name_or_path : str
        Name of a preset, or else path of a TOML file.

    Returns
    -------
    Scene
        The scene; a preset wins over a file of its name.

    Raises
    ------
    InputError
        If there is neither; the nearest preset is suggested.

    Examples
    --------
    >>> from fivtui import find_scene
    >>> find_scene("linear").parameters.k_nl
    0.0
    """
    path = scene_file(name_or_path)
    if path is not None:
        return load_scene(path)
    if name_or_path in PRESETS:
        return PRESETS[name_or_path]
    raise unknown_name("preset", name_or_path, PRESETS)


def scene_file(name_or_path: str) -> Path | None:
    """The file that `find_scene` reads for this text; None if it reads none."""
    if name_or_path in PRESETS:
        return None
    path = Path(name_or_path)
    # Names of presets have no dot and no separator.
    there = path.suffix or len(path.parts) > 1 or (name_or_path and is_there(path))
    return path if there else None
