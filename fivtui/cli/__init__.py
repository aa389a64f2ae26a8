"""The command line: each command reads options, calls a package below and prints."""

import os
import sys
from collections.abc import Callable, Sequence
from typing import Final, NoReturn

import click

from fivtui.model import Cancelled, ComputationError, InputError, one_line

from . import analysis, branches, fmu, playing, program, reliability, studies, transients
from .group import commands
from .options import drop_warnings, print_note, print_warnings
from .streams import ReaderGone, guarded_streams

__all__ = [
    "analysis",
    "branches",
    "commands",
    "fmu",
    "main",
    "playing",
    "program",
    "reliability",
    "run",
    "studies",
    "transients",
]

# Exit statuses: wrong input, a computation that cannot finish, an interrupted command.
EXIT_INPUT: Final = 2
EXIT_COMPUTATION: Final = 3
EXIT_INTERRUPTED: Final = 130
# Environment variable with which unexpected errors print a traceback.
TRACEBACK_VARIABLE: Final = "FIVTUI_TRACEBACK"
_REPORT_REQUEST: Final = f"please report it with the traceback that {TRACEBACK_VARIABLE}=1 prints"


def main(args: Sequence[str] | None = None) -> NoReturn:
    """Run a command and exit with its status; `args` defaults to the process's arguments."""
    sys.exit(run(args))


def run(args: Sequence[str] | None) -> int:
    """Run a command; returns the exit status.

    It is 0 when done, 1 where a comparison fails its tolerances, 2 for wrong input, 3 for a
    computation that cannot finish, 130 when interrupted.
    """
    with guarded_streams():
        message, code = _run_action(lambda: commands.main(args, "fivtui", standalone_mode=False))
        # Flush the output of a command that failed.
        flush_message, flush_code = _run_action(sys.stdout.flush)
        if not message:
            message, code = flush_message, flush_code or code
        if not message:
            print_warnings()
        else:
            # The error of a refused command says what to change first.
            drop_warnings()
            print_note(one_line(f"fivtui: {' '.join(message.split())}"))
    return code


def _run_action(action: Callable[[], int | None]) -> tuple[str, int]:
    # The error message of an action, empty on success, and its exit status.
    message, code = "", 0
    try:
        code = action() or 0
    except InputError as error:
        message, code = str(error), EXIT_INPUT
    except click.ClickException as error:
        message, code = error.format_message(), EXIT_INPUT
    except ComputationError as error:
        message, code = str(error), EXIT_COMPUTATION
    except MemoryError:
        message, code = "out of memory; ask for fewer points or a shorter horizon", EXIT_COMPUTATION
    except (click.Abort, Cancelled, KeyboardInterrupt) as error:
        message, code = ": ".join(filter(None, ["cancelled", str(error)])), EXIT_INTERRUPTED
    except ReaderGone:
        pass
    except Exception as error:
        if TRACEBACK_VARIABLE in os.environ:
            raise
        message, code = _unexpected_error_text(error), EXIT_COMPUTATION
    return message, code


def _unexpected_error_text(error: Exception) -> str:
    if isinstance(error, OSError):
        from fivtui.io import system_limit_error

        limit = system_limit_error(error)
        if limit is not None:
            return str(limit)
    return f"unexpected {type(error).__name__}: {error}; {_REPORT_REQUEST}"
