"""Options and their types: given once, never empty, plain whole numbers, names of files."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final

import click
from click.shell_completion import CompletionItem

from fivtui.model import read_whole


class Once(click.Option):
    """An option that is refused where it is empty, or given twice though it takes one value."""

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Have the parser keep every value: by itself it drops all but the last."""
        if self.multiple or self.is_flag or self.count:
            super().add_to_parser(parser, ctx)
        else:
            parser.add_option(
                obj=self, opts=self.opts, dest=self.name, action="append", nargs=self.nargs
            )

    def handle_parse_result(
        self, ctx: click.Context, opts: Mapping[str, Any], args: list[str]
    ) -> tuple[Any, list[str]]:
        """Check what was given, and hand it on as one value."""
        given = opts.get(self.name or "")
        if isinstance(given, list):
            # While a shell completes a line, what is wrong with it is not said.
            typing = ctx.resilient_parsing
            if not typing and any(value == "" for value in given):
                raise click.UsageError(f"{self.opts[0]}: must not be empty")
            if not self.multiple:
                if not typing and len(given) > 1:
                    raise click.UsageError(f"{self.opts[0]}: given twice; must be given once")
                opts = {**opts, str(self.name): given[0]}
        return super().handle_parse_result(ctx, opts, args)


class Whole(click.IntRange):
    """A whole number in plain digits, within bounds if there are some."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number; fails if the text is none."""
        if isinstance(value, str):
            try:
                value = read_whole(value)
            except ValueError:
                self.fail(f"{value!r} is not a whole number.", param, ctx)
        return super().convert(value, param, ctx)


class FilePath(click.ParamType[Path]):
    """The name of a file or folder."""

    name = "path"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The path; fails if no file can have that name."""
        if not str(value) or "\0" in str(value):
            self.fail(f"{value!r} is not the name of a file.", param, ctx)
        return Path(value)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """Leave it to the shell, which knows the files."""
        return [CompletionItem(incomplete, type="file")]


option: Final[Callable[..., Callable[..., Any]]] = partial(click.option, cls=Once)
