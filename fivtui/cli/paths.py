"""Types of arguments and options that are files, and checks that outputs are distinct."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from .arguments import FilePath, parameter_hint

if TYPE_CHECKING:
    from fivtui.io import LabelledPath


class InputFile(FilePath):
    """A file to be read; messages call it `label`."""

    def __init__(self, label: str) -> None:
        self.label = label


class OutputFile(FilePath):
    """A file to be written; with `in_parts`, ``FILE.parts`` holds pieces until it is complete."""

    def __init__(self, *, in_parts: bool = False) -> None:
        self.in_parts = in_parts


class OutputFolder(FilePath):
    """A folder for files that the command names and checks."""

    completion_type = "dir"


class SceneName(click.types.StringParamType):
    """The name of a preset or of a scene file."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The name; fails for the value of a parameter, e.g. F=80."""
        if (hint := parameter_hint([value])) is not None:
            raise click.UsageError(hint, ctx)
        return super().convert(value, param, ctx)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """Complete the names of presets, or else of files."""
        from fivtui.scene import PRESETS

        completions = [
            CompletionItem(name, help=scene.description)
            for name, scene in PRESETS.items()
            if name.startswith(incomplete)
        ]
        return completions or [CompletionItem(incomplete, type="file")]


def is_scene(text: str) -> bool:
    """Whether a text is the name of a preset or the path of a file."""
    from fivtui.scene import PRESETS, scene_file

    return text in PRESETS or scene_file(text) is not None


def check_paths(params: Sequence[click.Parameter], values: Mapping[str, Any]) -> None:
    """Raise `InputError` if an output of a command is the same file as another or as an input."""
    from fivtui.io import check_distinct, parts_folder

    named_values = [
        (param, values[param.name or ""])
        for param in params
        if values.get(param.name or "") is not None
    ]
    outputs = [
        (param.opts[0], path, param.type.in_parts)
        for param, path in named_values
        if isinstance(param.type, OutputFile)
    ]
    if outputs:
        check_distinct(
            outputs=[(name, path) for name, path, _ in outputs],
            inputs=[file for param, value in named_values for file in _input_files(param, value)],
            folders=[(name, parts_folder(path)) for name, path, in_parts in outputs if in_parts],
        )


def replaceable_outputs(
    params: Sequence[click.Parameter], values: Mapping[str, Any]
) -> dict[str, Path]:
    """The outputs of a command as `ReplaceablePath`, whose files may be overwritten."""
    from fivtui.io import output_path

    paths = {
        str(param.name): values[str(param.name)]
        for param in params
        if isinstance(param.type, OutputFile | OutputFolder)
    }
    return {name: output_path(path, force=True) for name, path in paths.items() if path is not None}


def check_distinct_from_scene(paths: Sequence[Path], scene: str) -> None:
    """Raise `InputError` if files to be written are the same, or one is the scene's file."""
    from fivtui.io import check_distinct

    check_distinct([("--out", path) for path in paths], _scene_files(scene))


def _input_files(param: click.Parameter, value: Any) -> "list[LabelledPath]":
    if isinstance(param.type, SceneName):
        return _scene_files(value)
    if not isinstance(param.type, InputFile):
        return []
    return [(param.type.label, path) for path in (value if param.multiple else [value])]


def _scene_files(text: str) -> "list[LabelledPath]":
    from fivtui.scene import scene_file

    path = scene_file(text)
    return [] if path is None else [("the scene", path)]
