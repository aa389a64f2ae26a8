"""Scenes in TOML files.

A file holds the version of the format, the fields of `Scene` and a table of parameters. Missing
fields and parameters have their defaults; a missing name is that of the file.
"""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, BinaryIO, Final

import tomlkit
from tomlkit.items import Item

from fivtui.distributions import parse_distribution
from fivtui.io import MAX_TEXT, output_path, path_exists, read_bytes, write_atomically
from fivtui.model import (
    InputError,
    Parameters,
    check_known,
    initial_values,
    parameter_spec,
    unknown_name_error,
)
from fivtui.transient import SET_BY_ACCURACY, SETTINGS, check_file_number, check_file_text

from .over_time import over_time_to_dict, parse_over_time
from .presets import PRESETS
from .scene import OUTPUTS, Correlation, Distributions, Scene

FORMAT_VERSION: Final = 1
_VERSION_KEY: Final = "fivtui_scene"
_PARAMETERS_KEY: Final = "parameters"
# Limit of a line, characters: tomllib needs n² steps for a key with n dots.
_LONGEST_LINE: Final = 4096


def _read_outputs(key: str, value: object) -> tuple[str, ...]:
    if not isinstance(value, list | tuple):
        raise InputError(f"{key} = {value!r}: must be a list of {', '.join(OUTPUTS)}")
    return tuple(check_file_text(f"{key}[{index}]", entry) for index, entry in enumerate(value))


def _read_correlation(key: str, value: object) -> Correlation:
    if not isinstance(value, Mapping) or not all(isinstance(v, Mapping) for v in value.values()):
        raise InputError(f"{key} = {value!r}: must be a table such as {{mu = {{F = -0.3}}}}")
    return tuple(
        (str(first), str(second), check_file_number(f"{key}.{first}.{second}", number))
        for first, row in value.items()
        for second, number in row.items()
    )


def _read_scatter(key: str, value: object) -> Distributions:
    if not isinstance(value, Mapping):
        raise InputError(f'{key} = {value!r}: must be a table such as {{mu = "normal:0.4:0.04"}}')
    return tuple(
        (str(name), parse_distribution(check_file_text(f"{key}.{name}", text)))
        for name, text in value.items()
    )


def _correlation_rows(correlation: Correlation) -> dict[str, dict[str, float]]:
    rows: dict[str, dict[str, float]] = {}
    for first, second, value in correlation:
        rows.setdefault(first, {})[second] = value
    return rows


# Keys of a file, which are fields of `Scene`; scatter and correlation, tables, come last.
_FIELDS: Final = [field.name for field in fields(Scene) if field.name != _PARAMETERS_KEY]
_KEYS: Final = sorted(_FIELDS, key=lambda name: name in ("scatter", "correlation"))
# Functions that read a field and check its type, by key.
_READERS: Final[Mapping[str, Callable[[str, object], Any]]] = {
    "name": check_file_text,
    "description": check_file_text,
    **{name: setting.check_file_value for name, setting in SETTINGS.items()},
    "outputs": _read_outputs,
    "over_time": parse_over_time,
    "scatter": _read_scatter,
    "correlation": _read_correlation,
}
# Functions that convert a field to a plain value, by key.
_WRITERS: Final[Mapping[str, Callable[[Any], Any]]] = {
    "start": lambda start: start if isinstance(start, str) else list(start),
    "accuracy": dict,
    "outputs": list,
    "over_time": over_time_to_dict,
    "scatter": lambda scatter: {name: str(distribution) for name, distribution in scatter},
    "correlation": _correlation_rows,
}
# Keys that are written only if they are set.
_OPTIONAL: Final = ("step", "accuracy", "over_time", "scatter", "correlation")
# Comments by key.
_COMMENTS: Final[Mapping[str, str]] = {
    **{
        name: setting.comment or f"{setting.meaning}; {setting.allowed}"
        for name, setting in SETTINGS.items()
    },
    "outputs": f"outputs to be computed: {', '.join(OUTPUTS)}",
    "scatter": "distributions of quantities that fivtui uncertainty scatters, by name",
    "correlation": "of quantities that fivtui uncertainty scatters, by name (a Gaussian copula)",
}


def scene_to_dict(scene: Scene) -> dict[str, Any]:
    """A scene in the layout of its file: plain values by key; unset fields have no key."""
    data: dict[str, Any] = {_VERSION_KEY: FORMAT_VERSION}
    for key in _KEYS:
        value = getattr(scene, key)
        is_unset = key in _OPTIONAL and not value
        if not is_unset and not (scene.accuracy and key in SET_BY_ACCURACY):
            data[key] = _WRITERS.get(key, lambda plain: plain)(value)
    return {**data, _PARAMETERS_KEY: scene.parameters.as_dict()}


def scene_from_dict(data: Mapping[str, object], *, name: str | None = None) -> Scene:
    """A scene from the layout of its file, see `scene_to_dict`.

    `name` is used where the layout has none. Raises `InputError` if a key is unknown or missing, or
    a value has the wrong type or is out of range.
    """
    _check_version(data)
    keys = (_VERSION_KEY, *_KEYS, _PARAMETERS_KEY)
    for key in data:
        check_known("key", key, keys)
    values = {key: read(key, data[key]) for key, read in _READERS.items() if key in data}
    for key in SET_BY_ACCURACY:
        if values.get("accuracy") and key in values:
            raise InputError(f"{key}: must not be given with accuracy, from which it follows")
    if name is not None:
        values.setdefault("name", name)
    if "name" not in values:
        raise InputError("the key name is missing")
    values.setdefault("description", "")
    # Values just after t = 0, without the slopes.
    initial = initial_values(dict(values.get("over_time", ())))
    return Scene(parameters=_parameters(data.get(_PARAMETERS_KEY, {}), initial), **values)


def _check_version(data: Mapping[str, object]) -> None:
    if _VERSION_KEY not in data:
        raise InputError(f"not a scene: the key {_VERSION_KEY} = {FORMAT_VERSION} is missing")
    version = data[_VERSION_KEY]
    if isinstance(version, bool) or version != FORMAT_VERSION:
        raise InputError(
            f"{_VERSION_KEY} = {version!r}: this fivtui reads version {FORMAT_VERSION} only"
        )


def _parameters(table: object, initial: Mapping[str, float]) -> Parameters:
    # `initial` has the values at t = 0 of parameters with tables; the file may omit these.
    if not isinstance(table, Mapping):
        raise InputError("parameters: must be a table of parameters")
    try:
        values = {}
        for name, value in table.items():
            spec = parameter_spec(name)
            values[name] = spec.check(check_file_number(name, value))
        parameters = Parameters(**{**initial, **values})
        # Compare parameter sets, in which tiny values are set to zero.
        initial_parameters = parameters.with_values(initial)
        for name in initial:
            if getattr(parameters, name) != getattr(initial_parameters, name):
                raise InputError(
                    f"{name} = {values[name]:g}: follows a table over time, which begins with "
                    f"{initial[name]:g}; must be left out"
                )
        return parameters
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
        data = _parse_toml(text)
        if "over_time" in data:
            # Put the rows in place of a CSV file, whose path is relative to that of the scene.
            tables = parse_over_time("over_time", data["over_time"], path.parent)
            data["over_time"] = over_time_to_dict(tables)
        return scene_from_dict(data, name=path.stem)
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a TOML file: not UTF-8 text") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except RecursionError:
        raise InputError(f"{path}: not a scene: values are nested too deeply") from None


def _check_lines(text: str) -> None:
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > _LONGEST_LINE:
            raise InputError(f"line {number}: must be of at most {_LONGEST_LINE} characters")


def _parse_toml(text: str) -> dict[str, Any]:
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

    write_atomically(output_path(path, force=force), write)


def _document(scene: Scene) -> tomlkit.TOMLDocument:
    data = scene_to_dict(scene)
    document = tomlkit.document()
    document.add(tomlkit.comment("A scene of fivtui, the nonlinear slider-belt model."))
    document.add(_VERSION_KEY, _commented_item(data[_VERSION_KEY], "version of this format"))
    for key in _KEYS:
        if key in data and key != "over_time":
            document.add(key, _commented_item(data[key], _COMMENTS.get(key, "")))
    table = tomlkit.table()
    for name, value in data[_PARAMETERS_KEY].items():
        spec = parameter_spec(name)
        table.add(name, _commented_item(value, f"{spec.meaning}; {spec.allowed}"))
    document.add(_PARAMETERS_KEY, table)
    if scene.over_time:
        document.add("over_time", _over_time_table(data["over_time"]))
    return document


def _over_time_table(tables: Mapping[str, Any]) -> Item:
    table = tomlkit.table()
    table.comment("linear between rows of time, s, and value, in place of the parameters above")
    for name, rows in tables.items():
        array = tomlkit.item(rows)
        array.multiline(multiline=True)
        table.add(name, array)
    return table


def _commented_item(value: object, comment: str) -> Item:
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
        The scene; a preset has priority over a file of the same name.

    Raises
    ------
    InputError
        If neither exists; the message suggests the nearest preset.

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
    raise unknown_name_error("preset", name_or_path, PRESETS)


def scene_file(name_or_path: str) -> Path | None:
    """The file that `find_scene` reads for this text; None for a preset or an unknown name."""
    if name_or_path in PRESETS:
        return None
    path = Path(name_or_path)
    # Names of presets have no dot and no separator.
    is_file = path.suffix or len(path.parts) > 1 or (name_or_path and path_exists(path))
    return path if is_file else None
