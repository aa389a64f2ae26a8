"""Starts the terminal UI. Imports Textual when it starts."""

import gc
import os
import sys
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from fivtui.scene import Scene

# Time after which a computing thread lets the screen's thread run, s: the screen responds quickly.
_SWITCH_INTERVAL_S: Final = 1e-3
# Exit status of a program that Ctrl+C ended.
_INTERRUPTED_STATUS: Final = 130


def run(scene: "Scene | None" = None, source: str = "") -> None:
    """Run the terminal UI until the user quits.

    `scene`, from the preset or file `source`, replaces the scene of the last session; undo restores
    that.
    """
    # Garbage collection would delay the first frame.
    gc.disable()
    from .app import SIGNAL_STATUS_BASE, FivtuiApp
    from .persistence import user_files
    from .session import FILE_WRITES, ComputingThreads

    sys.setswitchinterval(_SWITCH_INTERVAL_S)
    threads, (state, config) = ComputingThreads(), user_files()
    app = FivtuiApp(
        scene,
        source,
        state=state,
        config=config,
        on_first_frame=_enable_garbage_collection,
        threads=threads,
    )
    app.run()
    status = app.return_code or 0
    if status > SIGNAL_STATUS_BASE:
        # After a signal, do not wait for threads; the terminal may be closed.
        os._exit(status)
    try:
        FILE_WRITES.wait(lambda names: sys.stderr.write(f"writing {names}; Ctrl+C stops it\n"))
    except KeyboardInterrupt:
        os._exit(_INTERRUPTED_STATUS)
    if app.autosave.save_error:
        sys.stderr.write(f"{app.autosave.save_error}\n")
    if threads.busy:
        # A normal exit of Python would stop threads inside compiled code, which may crash.
        os._exit(status)


def _enable_garbage_collection() -> None:
    # Exempting the objects created so far saves a tenth of a second per collection.
    gc.freeze()
    gc.enable()
