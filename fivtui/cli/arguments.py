"""Option and argument types of the commands."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import click
from click.shell_completion import CompletionItem

from fivtui.model import ALL_PARAMETERS, Interval, read_integer
from fivtui.options import STUDY


def times_text(count: int) -> str:
    """The number of times an option was given, as text."""
    return {0: "never", 1: "once", 2: "twice"}.get(count, f"{count} times")


class CheckedOption(click.Option):
    """An option that must not be empty, nor given twice unless it is `multiple`.

    `group` is its heading in the help of a command with many options; by default the heading of
    options that define the study.
    """

    def __init__(self, *args: Any, group: str = STUDY, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.group = group

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Collect all values of the option; click would store only the last."""
        if self.multiple or self.is_flag or self.count:
            super().add_to_parser(parser, ctx)
        else:
            parser.add_option(
                obj=self, opts=self.opts, dest=self.name, action="append", nargs=self.nargs
            )

    def handle_parse_result(
        self, ctx: click.Context, opts: Mapping[str, Any], args: list[str]
    ) -> tuple[Any, list[str]]:
        """Check the values given, and pass a single one on."""
        values = opts.get(self.name or "")
        if isinstance(values, list):
            # No errors while a shell completes the line.
            completing = ctx.resilient_parsing
            if not completing and any(value == "" for value in values):
                raise click.UsageError(f"{self.opts[0]}: must not be empty")
            if not self.multiple:
                if not completing and len(values) > 1:
                    raise click.UsageError(f"{self.opts[0]}: given twice; must be given once")
                opts = {**opts, str(self.name): values[0]}
        return super().handle_parse_result(ctx, opts, args)


class WholeNumber(click.ParamType[int]):
    """A whole number in plain digits, inside an interval if one is given."""

    name = "N"

    def __init__(self, interval: Interval | None = None) -> None:
        self.interval = interval

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """The number; fails if the text is not a number in the interval."""
        try:
            number = read_integer(value) if isinstance(value, str) else int(value)
        except ValueError:
            self.fail(f"{value!r} is not a whole number", param, ctx)
        if self.interval is not None and not self.interval.lower <= number <= self.interval.upper:
            self.fail(f"{number}: must be {self.interval}", param, ctx)
        return number


class FilePath(click.ParamType[Path]):
    """The path of a file or folder."""

    name = "path"
    completion_type = "file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The path; fails for an impossible file name."""
        if not str(value) or "\0" in str(value):
            self.fail(f"{value!r} is not the name of a file.", param, ctx)
        return Path(value)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """Let the shell complete the names of files, or of folders."""
        return [CompletionItem(incomplete, type=self.completion_type)]


def name_completer(names: Callable[[], Iterable[str]]) -> Callable[..., list[str]]:
    """A function for shell completion that proposes those of `names` that begin as typed."""

    def complete(_context: click.Context, _param: click.Parameter, typed: str) -> list[str]:
        return [name for name in names() if name.startswith(typed)]

    return complete


def parameter_hint(args: Sequence[str]) -> str | None:
    """Advice if an argument such as F=80 or --mu 0.5 is a parameter without the option --set."""
    for index, text in enumerate(args):
        name, equals, value = text.lstrip("-").partition("=")
        is_option = text.startswith("-")
        # After an option, e.g. --set, F=80 is the value of that option.
        follows_option = index > 0 and args[index - 1].startswith("-")
        is_assignment = equals == "=" and not follows_option
        if name in ALL_PARAMETERS and (is_option or is_assignment):
            value = value or next(iter(args[index + 1 :]), "")
            if not value or value.startswith("--"):
                value = "VALUE"
            return f"{text}: parameters are set by --set, here --set {name}={value}"
    return None


option: Final[Callable[..., Callable[..., Any]]] = partial(click.option, cls=CheckedOption)
