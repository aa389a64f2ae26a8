"""Commands for a scene, made from a function and from a class that declares the options."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

import click

from fivtui.model import ALL_PARAMETERS, InputError, parameter_spec
from fivtui.options import SCENE, Option, declared_options, declared_settings
from fivtui.transient import SET_BY_ACCURACY, SETTINGS

from .arguments import WholeNumber, name_completer, option
from .deliver import Outputs
from .group import commands
from .options import (
    folder_option,
    force_option,
    json_option,
    output_option,
    parse_assignments,
    parse_error_targets,
    warn_of_unused_parameters,
)
from .paths import InputFile, SceneName

if TYPE_CHECKING:
    from fivtui.scene import Scene

Options = TypeVar("Options")
Decorator = Callable[[Callable[..., Any]], Any]
# Options of a command that are fields of `Outputs`.
_OUTPUT_FIELDS: Final = ("out", "plot", "as_json")

scene_argument: Final = click.argument("scene", type=SceneName(), default="base", metavar="[SCENE]")
set_option: Final = option(
    "--set",
    "assignments",
    multiple=True,
    metavar="NAME=VALUE",
    group=SCENE,
    shell_complete=name_completer(lambda: (f"{name}=" for name in ALL_PARAMETERS)),
    help=f"Change a parameter ({', '.join(ALL_PARAMETERS)}); may be repeated.",
)


@dataclass(frozen=True)
class NoOptions:
    """The options class of a command without options of its own."""


@dataclass(frozen=True)
class Call(Generic[Options]):
    """The arguments of a command: its options, its outputs, and the scene."""

    options: Options
    outputs: Outputs
    scene_name: str
    assignments: Sequence[str]

    def scene(
        self,
        *,
        varied: Sequence[str] = (),
        begins_at_value: bool = False,
        tables: bool | None = None,
    ) -> "Scene":
        """The scene with the parameters of ``--set`` and the settings of the options.

        Warns of parameters without effect. `varied` are texts such as ``F=10:120:23``. With
        `begins_at_value` a study along a parameter begins at its value in the scene, so that --set
        of a varied parameter has an effect. `tables` allows parameters that change over time, by
        default if the command has --over-time.
        """
        from fivtui.scene import find_scene, read_over_time

        changes = parse_assignments("--set", self.assignments, "F=120")
        self._check_not_options(changes)
        path = getattr(self.options, "over_time", None)
        scene = find_scene(self.scene_name).with_values(
            {name: parameter_spec(name).read(text) for name, text in changes.items()},
            () if path is None else read_over_time(path),
        )
        if tables is None:
            tables = hasattr(self.options, "over_time")
        if not tables:
            scene.check_constant("this command")
        scene = scene_with_settings(scene, self.options)
        warn_of_unused_parameters(scene, varied, () if begins_at_value else self.assignments)
        return scene

    def _check_not_options(self, changes: Mapping[str, str]) -> None:
        # Names such as t_end that are options of the command.
        for name, text in changes.items():
            for declared, _ in declared_options(self.options).values():
                if name == declared.setting or declared.flag == f"--{name.replace('_', '-')}":
                    has_value = declared.metavar is not None and not declared.multiple
                    example = f", here {declared.flag} {text}" if has_value else ""
                    raise InputError(
                        f"--set {name}={text}: {name} is set by {declared.flag}{example}"
                    )


def scene_with_settings(scene: "Scene", options: Any) -> "Scene":
    """The scene with the settings that options give."""
    values = {
        declared.setting: getattr(options, name)
        for name, (declared, default) in declared_options(options).items()
        if declared.setting and getattr(options, name) != default
    }
    # The scene's setting `accuracy` are its error targets.
    targets = parse_error_targets(values.pop("accuracy", ()))
    ignores_separation = values.pop("separation", False)
    changes = {name: SETTINGS[name].read(text) for name, text in values.items()}
    has_tol_or_step = not values.keys().isdisjoint(SET_BY_ACCURACY)
    if targets and has_tol_or_step:
        raise _targets_conflict_error(options)
    # A tolerance or step replaces the scene's error targets.
    if targets or has_tol_or_step:
        changes["accuracy"] = tuple(targets.items())
    if ignores_separation:
        changes["separation"] = False
    if "tol" in changes:
        from fivtui.transient import uses_step

        method = changes.get("method", scene.method)
        if uses_step(method):
            raise InputError(f"--tol: must be given without method {method}, which has a --step")
    # The scene's step may not suit the new method: use its default if the command has no --step.
    if "method" in changes and "step" not in declared_settings(options):
        changes["step"] = None
    return replace(scene, **changes)


def _targets_conflict_error(options: Any) -> InputError:
    settings = [
        entry for entry, _ in declared_options(options).values() if entry.setting in SET_BY_ACCURACY
    ]
    flags, verb = [entry.flag for entry in settings], "follow" if len(settings) > 1 else "follows"
    return InputError(f"--error: must be given without {' and '.join(flags)}, which {verb} from it")


def _click_option(name: str, declared: Option, default: Any) -> Decorator:
    # The click option for a field of an options class.
    details: dict[str, Any] = {
        "help": declared.help,
        "multiple": declared.multiple,
        "required": declared.required,
        "show_default": declared.show_default,
        "group": declared.group,
    }
    if not declared.multiple:
        details["default"] = default
    if isinstance(default, bool):
        details["is_flag"] = True
    elif declared.metavar is not None:
        details["metavar"] = declared.metavar
    if declared.integers is not None:
        details["type"] = WholeNumber(declared.integers)
    elif declared.choices:
        details["type"] = click.Choice(declared.choices)
    elif declared.file:
        details["type"] = InputFile(declared.flag)
    if declared.completions is not None:
        details["shell_complete"] = name_completer(declared.completions)
    return option(declared.flag, name, **details)


def command(
    options_class: type[Options],
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
    """A decorator that makes a function a command for a scene, with the options of a class.

    `out` and `plot` are the help texts of --out, a file or a `folder`, and of --plot. A command
    with an empty text lacks that option. `metavar`, `required` and `in_parts` (pieces are stored
    beside the file until it is complete) apply to --out; `json` adds --json.
    """
    decorators: list[Decorator] = [scene_argument, set_option]
    decorators += [
        _click_option(key, declared, default)
        for key, (declared, default) in declared_options(options_class).items()
    ]
    if folder:
        decorators.append(folder_option(out))
    elif out:
        decorators.append(
            output_option("--out", metavar, out, required=required, in_parts=in_parts)
        )
    if plot:
        decorators.append(output_option("--plot", "FILE", plot))
    decorators += [force_option] if out else []
    decorators += [json_option] if json else []

    def decorate(function: Callable[[Call[Options]], None]) -> click.Command:
        @wraps(function)
        def call(scene: str, assignments: tuple[str, ...], **values: Any) -> None:
            # `CheckedCommand` has removed the value of --force.
            outputs = {key: values.pop(key) for key in _OUTPUT_FIELDS if key in values}
            function(Call(options_class(**values), Outputs(**outputs), scene, assignments))

        decorated: Any = call
        # As if written above the function: the first decorator is applied at the end, and the help
        # lists the options in this order.
        for decorator in reversed(decorators):
            decorated = decorator(decorated)
        made_command: click.Command = commands.command(name)(decorated)
        return made_command

    return decorate
