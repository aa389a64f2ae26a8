"""The command line: one function a command, everything computed elsewhere."""

import os
import sys
from collections.abc import Sequence
from typing import Final, NoReturn

import click

from ..core.errors import Cancelled, ComputationError, InputError
from . import analysis, browser, fmu, lists, paper, studies, transients
from .group import commands
from .options import say

__all__ = [
    "analysis",
    "browser",
    "commands",
    "fmu",
    "lists",
    "main",
    "paper",
    "run",
    "studies",
    "transients",
]

EXIT_INPUT: Final = 2
EXIT_COMPUTATION: Final = 3
EXIT_INTERRUPTED: Final = 130
TRACEBACK_VARIABLE: Final = "FIVTUI_TRACEBACK"
_DEBUG: Final = f"please report it, with what {TRACEBACK_VARIABLE}=1 shows"


def main(args: Sequence[str] | None = None) -> NoReturn:
    """Run a command and exit: 0 done, 2 wrong input, 3 not finished.

    Parameters
    ----------
    args : sequence of str, optional
        The arguments; those of the process if not given.
    """
    sys.exit(run(args))


def run(args: Sequence[str] | None) -> int:
    """Run a command.

    Parameters
    ----------
    args : sequence of str or None
        The arguments; those of the process if None.

    Returns
    -------
    int
        The exit status: 0 done, 2 wrong input, 3 not finished, 130 interrupted.
    """
    message, code = "", 0
    try:
        commands.main(args=args, prog_name="fivtui", standalone_mode=False)
        sys.stdout.flush()
    except InputError as error:
        message, code = str(error), EXIT_INPUT
    except click.ClickException as error:
        message, code = " ".join(error.format_message().split()), EXIT_INPUT
    except ComputationError as error:
        message, code = str(error), EXIT_COMPUTATION
    except MemoryError:
        message, code = "out of memory; ask for fewer points or a shorter horizon", EXIT_COMPUTATION
    except (click.Abort, Cancelled, KeyboardInterrupt) as error:
        message, code = ": ".join(filter(None, ["cancelled", str(error)])), EXIT_INTERRUPTED
    except BrokenPipeError:
        # The reader has gone: nothing more to say, and nothing to flush at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        if TRACEBACK_VARIABLE in os.environ:
            raise
        message, code = f"unexpected {type(error).__name__}: {error}; {_DEBUG}", EXIT_COMPUTATION
    if message:
        say(f"fivtui: {message}")
    return code
