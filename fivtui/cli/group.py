"""The root of all commands."""

import sys
from typing import Any

import click

from fivtui.model import InputError, unknown_name

from .paths import check_paths


class Command(click.Command):
    """A command that starts only if its files are different ones."""

    def invoke(self, ctx: click.Context) -> Any:
        """Check the files that are named, and call the command."""
        check_paths(self.params, ctx.params)
        return super().invoke(ctx)


class Commands(click.Group):
    """A group that names the nearest command when one is unknown."""

    command_class = Command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that `args` begin with."""
        # While a shell completes a line, what is wrong with it is not said.
        if args and not ctx.resilient_parsing and self.get_command(ctx, args[0]) is None:
            raise unknown_name("command", args[0], self.list_commands(ctx))
        return super().resolve_command(ctx, args)


@click.group(cls=Commands, invoke_without_command=True, context_settings={"max_content_width": 100})
@click.version_option(package_name="fivtui", message="%(prog)s %(version)s")
@click.pass_context
def commands(context: click.Context) -> None:
    """Friction-induced vibration of a slider on a belt: stability, transients, FMU.

    Without a command the terminal laboratory starts. SCENE is the name of a preset or a TOML file;
    without it the base scene of the paper is taken.
    """
    if context.invoked_subcommand is None:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            raise InputError("the terminal laboratory needs a terminal; see fivtui --help")
        from fivtui.tui import run

        run()
