"""Commands that list presets and methods, and that serve the laboratory."""

from fivtui.model import Interval

from .arguments import WholeNumber, option
from .group import commands
from .options import json_option, print_json, print_note


@commands.command()
@json_option
def presets(as_json: bool) -> None:
    """List the scenes and sweeps that come with the program; --json gives the scenes."""
    from fivtui.scene import PRESETS, scene_to_dict

    if as_json:
        print_json({name: scene_to_dict(scene) for name, scene in PRESETS.items()})
    else:
        from fivtui.console import print_list
        from fivtui.sweeps import SWEEP_PRESETS

        rows = [(name, scene.description) for name, scene in PRESETS.items()]
        print_list("Presets", rows)
        sweeps = [(name, preset.description) for name, preset in SWEEP_PRESETS.items()]
        print_list("Sweeps, by --preset", sweeps)


@commands.command()
def methods() -> None:
    """List the integration methods."""
    from fivtui.console import print_list
    from fivtui.transient import ALL_METHODS

    print_list("Methods", list(ALL_METHODS.items()))


@commands.command()
@option(
    "--port",
    type=WholeNumber(Interval(1, 65535)),
    default=8000,
    show_default=True,
    help="Port on 127.0.0.1.",
)
def serve(port: int) -> None:
    """Open the terminal laboratory in a browser.

    It is reachable only from this machine, at the printed address; the token in the address keeps
    other users out. Needs the extra fivtui[serve].
    """
    from fivtui.tui import serve as start

    start(port, report=print_note)
