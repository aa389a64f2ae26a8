"""Starts the terminal UI. Imports Textual when it starts."""

import gc
import os
import sys
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from fivtui.scene import Scene

# Time after which a computing thread lets the screen's thread run, s.
_SWITCH_INTERVAL_S: Final = 1e-3
# Exit status of a program that Ctrl+C ended.
_INTERRUPTED_STATUS: Final = 130


def shorten_switch_interval() -> None:
    """Shorten the thread switch interval so that the screen responds quickly."""
    sys.setswitchinterval(_SWITCH_INTERVAL_S)


def run(scene: "Scene | None" = None, source: str = "") -> None:
    """Run the terminal UI until the user quits.

    `scene`, from the preset or file `source`, replaces the scene of the last session; undo restores
    that.
    """
    # Garbage collection would delay the first frame.
    gc.disable()
    from .app import SIGNAL_STATUS_BASE, FivtuiApp
    from .persistence import config_path, state_path
    from .session import FILE_WRITES, ComputingThreads

    shorten_switch_interval()
    threads = ComputingThreads()
    app = FivtuiApp(
        scene,
        source,
        state=state_path(),
        config=config_path(),
        on_first_frame=_enable_garbage_collection,
        threads=threads,
    )
    app.run()
    status = app.return_code or 0
    if status > SIGNAL_STATUS_BASE:
        # After a signal, do not wait for threads; the terminal may be closed.
        os._exit(status)
    try:
        FILE_WRITES.wait(_report_pending_writes)
    except KeyboardInterrupt:
        os._exit(_INTERRUPTED_STATUS)
    if app.autosave.save_error:
        sys.stderr.write(f"{app.autosave.save_error}\n")
    if threads.busy:
        # A normal exit of Python would stop threads inside compiled code, which may crash.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _report_pending_writes(names: str) -> None:
    sys.stderr.write(f"writing {names}; Ctrl+C stops it\n")
    sys.stderr.flush()


def _enable_garbage_collection() -> None:
    # Exempting the objects created so far saves a tenth of a second per collection.
    gc.freeze()
    gc.enable()
