"""An input of files and options, as on the command line."""

import asyncio
import os
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from textual.suggester import Suggester

from fivtui.io import home_path
from fivtui.model import InputError
from fivtui.options import Options, read_arguments, value_options
from fivtui.ranges import with_decimal_point, with_decimal_points
from fivtui.tui.chart import TextInput

_DATA_SUFFIX: Final = ".csv"
ACCEPT_KEY: Final = "→ accepts the grey text"


class OptionInput(TextInput):
    """An input of files and options that proposes the rest of the last word."""

    def __init__(self, value: str, options: type, **details: Any) -> None:
        super().__init__(
            value,
            suggester=_WordSuggester(value_options(options)),
            replace_commas=_with_points,
            compact=True,
            select_on_focus=False,
            **details,
        )


def read_option_text(options: type[Options], text: str) -> tuple[Options, list[Path]]:
    """The options in a text, and its files, which are the words without an option."""
    try:
        # Backslashes separate the folders of a path on Windows.
        arguments = shlex.split(text.replace("\\", r"\\"))
    except ValueError as error:
        raise InputError(f"{text}: {error}") from None
    values, files = read_arguments(options, arguments)
    return values, list(map(home_path, files))


def option_help(options: type, text: str, default: str) -> str:
    """The meaning of the option that is last in a text, or else the default."""
    flags = [word.partition("=")[0] for word in text.split() if word.startswith("--")]
    _, declared = value_options(options).get(flags[-1] if flags else "", ("", None))
    return default if declared is None else f"{declared.flag} {declared.metavar}: {declared.help}"


def _with_points(text: str) -> str:
    return with_decimal_points(" ".join(map(with_decimal_point, text.split(" "))))


class _WordSuggester(Suggester):
    # Proposes a flag, or the path of a folder or file of data.

    def __init__(self, flags: Iterable[str]) -> None:
        super().__init__(use_cache=False, case_sensitive=True)
        self._flags = sorted(flags)

    async def get_suggestion(self, value: str) -> str | None:
        start, blank, word = value.rpartition(" ")
        previous = start.rpartition(" ")[2]
        if word.startswith("--"):
            candidates = self._flags
        elif word and not previous.startswith("--"):
            candidates = await asyncio.to_thread(_data_paths, word)
        else:
            return None
        longer = (text for text in candidates if text.startswith(word) and text != word)
        match = next(longer, None)
        return None if match is None else f"{start}{blank}{match}"


def _data_paths(word: str) -> list[str]:
    # The folders and files of data beside a path, written as its beginning is.
    folder, slash, _ = word.rpartition("/")
    try:
        with os.scandir(home_path(f"{folder}{slash}" or ".")) as entries:
            return sorted(
                f"{folder}{slash}{entry.name}{'/' if entry.is_dir() else ''}"
                for entry in entries
                if entry.is_dir() or entry.name.endswith(_DATA_SUFFIX)
            )
    except OSError:
        return []
