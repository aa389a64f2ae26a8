"""The group of all commands, and how commands read their arguments and print their help."""

import sys
from collections.abc import Sequence
from typing import Any, Final, cast

import click

from fivtui.model import InputError, unknown_name_error
from fivtui.options import ACCURACY, COMPUTATION, OUTPUT, SCENE
from fivtui.version import __version__

from .arguments import parameter_hint
from .manual import ENTRIES, PROGRAM_ENTRY, SECTIONS, epilog
from .paths import check_paths, is_scene, replaceable_outputs

# Options of a command are listed in groups if it has more.
_MAX_UNGROUPED: Final = 9
# Groups that stand after those of the command itself.
_LAST_GROUPS: Final = (SCENE, ACCURACY, COMPUTATION, OUTPUT)
# Widest first column of a list in the help, as in click.
_MAX_COLUMN: Final = 30
_CONTEXT: Final[dict[str, Any]] = {
    "max_content_width": 100,
    "help_option_names": ["-h", "--help"],
}
_Rows = list[tuple[str, str]]


class _Helpful(click.Command):
    # A command whose summary is never cut.

    def get_short_help_str(self, limit: int = 0) -> str:  # noqa: ARG002
        return super().get_short_help_str(sys.maxsize)


class CheckedCommand(_Helpful):
    """A command that refuses to write two outputs, or an input and an output, to one file."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; a parameter that is given without --set is an error that says so."""
        tokens = tuple(args)
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            hint = parameter_hint(tokens)
            # Click's other subclasses of `UsageError` are for wrong or missing values.
            is_unexpected = type(error) in (click.UsageError, click.NoSuchOption)
            if is_unexpected and hint and any("--set" in param.opts for param in self.params):
                raise click.UsageError(hint, ctx) from None
            raise

    def invoke(self, ctx: click.Context) -> Any:
        """Check the files, then run the command; with --force its outputs may be replaced."""
        check_paths(self.params, ctx.params)
        if ctx.params.pop("force", False):
            # Files at paths of the type `ReplaceablePath` may be overwritten.
            outputs = replaceable_outputs(self.params, ctx.params)
            if not outputs:
                raise InputError("--force: must be given with a file to write")
            ctx.params |= outputs
        return super().invoke(ctx)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Print the options, those of long commands in groups."""
        groups: dict[str, _Rows] = {}
        for param in self.get_params(ctx):
            row = param.get_help_record(ctx)
            if row is not None and not isinstance(param, click.Argument):
                # Click's option --help has no group.
                groups.setdefault(getattr(param, "group", OUTPUT), []).append(row)
        if len(groups) == 1 or sum(map(len, groups.values())) <= _MAX_UNGROUPED:
            super().format_options(ctx, formatter)
        else:
            titles = [title for title in groups if title not in _LAST_GROUPS]
            titles += [title for title in _LAST_GROUPS if title in groups]
            _write_lists(formatter, [(title, groups[title]) for title in titles])


class CommandGroup(_Helpful, click.Group):
    """A group of commands by purpose, that suggests the nearest one when a name is unknown."""

    command_class = CheckedCommand

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        """Add a command, whose help ends with an example and its page of the manual."""
        name = str(name or cmd.name)
        # The entry of a command in a group begins with that of the group: "fmu build".
        cmd.epilog = epilog(ENTRIES[f"{self.name} {name}" if self.name in ENTRIES else name])
        cmd.context_settings.update(_CONTEXT)
        super().add_command(cmd, name)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that `args` begin with."""
        # No errors while a shell completes the line.
        if args and not ctx.resilient_parsing and self.get_command(ctx, args[0]) is None:
            kind, names = "command", self.list_commands(ctx)
            if (laboratory := self.get_command(ctx, "tui")) is not None:
                from fivtui.scene import PRESETS

                if is_scene(args[0]):
                    return "tui", laboratory, args
                kind, names = "command or scene", [*names, *PRESETS]
            raise unknown_name_error(kind, args[0], names)
        return super().resolve_command(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Print the commands by purpose, then the options."""
        prefix = f"{self.name} " if self.name in ENTRIES else ""
        lists = {
            title: [
                self._row(name.removeprefix(prefix)) for name in section if name.startswith(prefix)
            ]
            for title, section in SECTIONS.items()
        }
        _write_lists(formatter, [(title, rows) for title, rows in lists.items() if rows])
        click.Command.format_options(self, ctx, formatter)

    def _row(self, name: str) -> tuple[str, str]:
        # Name and summary of a command; the name "fmu build" is that of a subgroup's command.
        command: click.Command = self
        for part in name.split():
            command = cast("click.Group", command).commands[part]
        return name, command.get_short_help_str()


def _write_lists(
    formatter: click.HelpFormatter, lists: Sequence[tuple[str, Sequence[tuple[str, str]]]]
) -> None:
    # Lists with titles, whose second columns begin in the same place.
    width = min(max(len(first) for _, rows in lists for first, _ in rows), _MAX_COLUMN)
    for title, rows in lists:
        with formatter.section(title):
            formatter.write_dl([(first.ljust(width), second) for first, second in rows])


@click.group(
    "fivtui",
    cls=CommandGroup,
    invoke_without_command=True,
    subcommand_metavar="[SCENE | COMMAND [ARGS]...]",
    epilog=epilog(PROGRAM_ENTRY),
    context_settings=_CONTEXT,
)
@click.version_option(__version__, message="%(prog)s %(version)s")
@click.pass_context
def commands(context: click.Context) -> None:
    """Friction-induced vibration of a slider pressed on a moving belt.

    Without a command, the terminal laboratory starts, with SCENE if it is given. SCENE is the name
    of a preset (see fivtui presets) or a TOML file. The default is the base set of the paper
    Nonlinear friction-induced vibration of a slider-belt system: F = 80 N, μ = 0.7, 100 s,
    separation of slider and belt considered (Case 1).
    """
    if context.invoked_subcommand is None:
        start_laboratory()


def start_laboratory(name: str | None = None) -> None:
    """Open the terminal laboratory with the scene of a name, or with that of the last session."""
    if not has_terminal():
        raise InputError("the terminal laboratory needs a terminal; see fivtui --help")
    from fivtui.scene import find_scene
    from fivtui.tui import run

    run(None if name is None else find_scene(name), name or "")


def has_terminal() -> bool:
    """Whether input and output are a terminal."""
    return sys.stdin.isatty() and sys.stdout.isatty()
