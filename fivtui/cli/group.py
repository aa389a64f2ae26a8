"""The group of all commands."""

import sys
from typing import Any

import click

from fivtui.model import InputError, unknown_name_error

from .paths import check_paths, replaceable_outputs


class CheckedCommand(click.Command):
    """A command that refuses to write two outputs, or an input and an output, to one file."""

    def invoke(self, ctx: click.Context) -> Any:
        """Check the files, then run the command; with --force its outputs may be replaced."""
        check_paths(self.params, ctx.params)
        if ctx.params.pop("force", False):
            ctx.params |= replaceable_outputs(self.params, ctx.params)
        return super().invoke(ctx)


class CommandGroup(click.Group):
    """A group of commands that suggests the nearest one when a name is unknown."""

    command_class = CheckedCommand

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that `args` begin with."""
        # No errors while a shell completes the line.
        if args and not ctx.resilient_parsing and self.get_command(ctx, args[0]) is None:
            raise unknown_name_error("command", args[0], self.list_commands(ctx))
        return super().resolve_command(ctx, args)


@click.group(
    cls=CommandGroup, invoke_without_command=True, context_settings={"max_content_width": 100}
)
@click.version_option(package_name="fivtui", message="%(prog)s %(version)s")
@click.pass_context
def commands(context: click.Context) -> None:
    """Friction-induced vibration of a slider pressed on a moving belt.

    Without a command, the terminal laboratory starts. SCENE is the name of a preset (see fivtui
    presets) or a TOML file. The default is the paper's base set: F = 80 N, μ = 0.7, 100 s,
    separation of slider and belt considered (Case 1).
    """
    if context.invoked_subcommand is None:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            raise InputError("the terminal laboratory needs a terminal; see fivtui --help")
        from fivtui.tui import run

        run()
