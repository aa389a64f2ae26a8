"""Starts the terminal UI: soon there, and quick at every key. Imports Textual when it starts."""

import gc
import sys
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from fivtui.scene.scene import Scene

_SWITCH_INTERVAL: Final = 1e-3


def answer_quickly() -> None:
    """Let the screen have the interpreter soon where a thread computes in Python beside it."""
    sys.setswitchinterval(_SWITCH_INTERVAL)


def run(scene: "Scene | None" = None, source: str = "") -> None:
    """Run the terminal UI until the user quits.

    The session of the last time is restored, but for the scene if one is given.

    Parameters
    ----------
    scene : Scene, optional
        The scene to begin with.
    source : str
        How the command line names it, a preset or a file; empty if it does not.
    """
    # What is made on the way to the first frame stays: there is nothing to collect.
    gc.disable()
    from .app import FivtuiApp
    from .persistence.state_file import state_path

    answer_quickly()
    app = FivtuiApp(scene, source, state=state_path(), when_shown=_collect_later)
    app.run()
    if app.not_kept:
        sys.stderr.write(f"the session is not kept: {app.not_kept}\n")


def _collect_later() -> None:
    # Nor is it looked at again later, which would take a tenth of a second each time.
    gc.freeze()
    gc.enable()
