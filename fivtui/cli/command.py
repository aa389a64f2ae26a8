"""Commands made from the options that a dataclass declares."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce, wraps
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

import click

from fivtui.model import ALL_PARAMETERS, InputError, parameter_spec
from fivtui.options import Option, options_of, settings_of
from fivtui.transient import SETTINGS

from .arguments import Whole, completer, option
from .deliver import Outputs
from .group import commands
from .options import (
    assigned,
    error_targets_of,
    folder_option,
    force_option,
    json_option,
    output_option,
    say_without_effect,
)
from .paths import InputFile, SceneName

if TYPE_CHECKING:
    from fivtui.scene import Scene

Options = TypeVar("Options")
Decorator = Callable[[Callable[..., Any]], Any]
# Names of the fields of `Outputs`, and of the settings that error targets determine.
_OUTPUTS: Final = ("out", "plot", "as_json")
_OF_ACCURACY: Final = ("tol", "step")

scene_argument: Final = click.argument("scene", type=SceneName(), default="base", metavar="[SCENE]")
set_option: Final = option(
    "--set",
    "assignments",
    multiple=True,
    metavar="NAME=VALUE",
    shell_complete=completer(lambda: (f"{name}=" for name in ALL_PARAMETERS)),
    help=f"Change a parameter ({', '.join(ALL_PARAMETERS)}); may be repeated.",
)


@dataclass(frozen=True)
class NoOptions:
    """A command without options of its own."""


@dataclass(frozen=True)
class Call(Generic[Options]):
    """The arguments of a command: its options, its outputs, and the scene."""

    options: Options
    outputs: Outputs
    scene_name: str
    assignments: Sequence[str]

    def scene(
        self, *, varied: Sequence[str] = (), centred: bool = False, tables: bool | None = None
    ) -> "Scene":
        """The scene with the parameters of ``--set`` and the settings of the options.

        Warns of parameters without effect. `varied` are texts that begin with the name of a
        parameter; with `centred` the computation begins at its value in the scene. `tables` says
        whether parameters may change over time, by default if the command has --over-time.
        """
        from fivtui.scene import find_scene

        changes = assigned("--set", self.assignments, "F=120")
        scene = find_scene(self.scene_name).with_values(
            {name: parameter_spec(name).read(text) for name, text in changes.items()}
        )
        if tables is None:
            tables = hasattr(self.options, "over_time")
        if not tables:
            scene.check_constant("this command")
        scene = with_settings(scene, self.options)
        say_without_effect(scene, varied, () if centred else self.assignments)
        return scene


def with_settings(scene: "Scene", options: Any) -> "Scene":
    """The scene with the settings that options give."""
    values = {
        declared.setting: getattr(options, name)
        for name, (declared, default) in options_of(options).items()
        if declared.setting and getattr(options, name) != default
    }
    targets = error_targets_of(values.pop("accuracy", ()))
    ignored = values.pop("separation", False)
    changes = {name: SETTINGS[name].read(text) for name, text in values.items()}
    fixed = values.keys() & _OF_ACCURACY
    if targets and fixed:
        _refuse_targets(options)
    if targets or fixed:
        changes["accuracy"] = tuple(targets.items())
    if ignored:
        changes["separation"] = False
    if "method" in changes and "step" not in settings_of(options):
        changes["step"] = None
    if (path := getattr(options, "over_time", None)) is not None:
        from fivtui.scene import read_over_time

        changes["over_time"] = read_over_time(path)
    return replace(scene, **changes)


def _refuse_targets(options: Any) -> None:
    declared = [entry for entry, _ in options_of(options).values() if entry.setting in _OF_ACCURACY]
    flags, verb = [entry.flag for entry in declared], "follow" if len(declared) > 1 else "follows"
    raise InputError(f"--error: must be given without {' and '.join(flags)}, which {verb} from it")


def _click_option(name: str, declared: Option, default: Any) -> Decorator:
    details: dict[str, Any] = {
        "help": declared.help,
        "multiple": declared.multiple,
        "required": declared.required,
        "show_default": declared.show_default,
    }
    if not declared.multiple:
        details["default"] = default
    if isinstance(default, bool):
        details["is_flag"] = True
    elif declared.metavar is not None:
        details["metavar"] = declared.metavar
    if declared.integers is not None:
        details["type"] = Whole(declared.integers)
    elif declared.choices:
        details["type"] = click.Choice(declared.choices)
    elif declared.file:
        details["type"] = InputFile(declared.flag)
    if declared.completions is not None:
        details["shell_complete"] = completer(declared.completions)
    return option(declared.flag, name, **details)


def command(
    declaration: type[Options],
    *,
    name: str | None = None,
    out: str = "",
    plot: str = "",
    metavar: str = "FILE",
    required: bool = False,
    in_parts: bool = False,
    folder: bool = False,
    json: bool = True,
) -> Callable[[Callable[[Call[Options]], None]], click.Command]:
    """A command for a scene, with the options that a dataclass declares.

    `out` and `plot` are the help of --out, a file or a `folder`, and of --plot; where they are
    empty the command has none.
    """
    parts: list[Decorator] = [scene_argument, set_option]
    parts += [_click_option(key, *declared) for key, declared in options_of(declaration).items()]
    if folder:
        parts.append(folder_option(out))
    elif out:
        parts.append(output_option("--out", metavar, out, required=required, in_parts=in_parts))
    if plot:
        parts.append(output_option("--plot", "FILE", plot))
    parts += [force_option] if out else []
    parts += [json_option] if json else []

    def decorate(function: Callable[[Call[Options]], None]) -> click.Command:
        @wraps(function)
        def call(scene: str, assignments: tuple[str, ...], **values: Any) -> None:
            outputs = {key: values.pop(key) for key in _OUTPUTS if key in values}
            function(Call(declaration(**values), Outputs(**outputs), scene, assignments))

        decorated: click.Command = commands.command(name)(
            reduce(lambda inner, add: add(inner), reversed(parts), call)
        )
        return decorated

    return decorate
