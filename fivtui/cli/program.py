"""Commands that list presets and methods, and that open the laboratory and the manual.

The laboratory is the interactive program in the terminal.
"""

import click

from fivtui.model import Interval

from .arguments import WholeNumber, option
from .group import commands, start_laboratory
from .options import json_option, print_json, print_note, print_text
from .paths import SceneName


@commands.command()
@json_option
def presets(as_json: bool) -> None:
    """List the scenes and sweeps that come with the program.

    --json gives the scenes with all their values.
    """
    from fivtui.scene import PRESETS, scene_to_dict

    if as_json:
        print_json({name: scene_to_dict(scene) for name, scene in PRESETS.items()})
    else:
        from fivtui.console import print_list
        from fivtui.sweeps import SWEEP_PRESETS

        rows = [(name, scene.description) for name, scene in PRESETS.items()]
        print_list("Presets", rows)
        sweeps = [(name, preset.description) for name, preset in SWEEP_PRESETS.items()]
        print_list("Sweeps, for fivtui sweep --preset", sweeps)


@commands.command()
def methods() -> None:
    """List the integration methods."""
    from fivtui.console import print_list
    from fivtui.transient import ALL_METHODS

    print_list("Methods", list(ALL_METHODS.items()))


@commands.command()
@click.argument("scene", type=SceneName(), required=False, metavar="[SCENE]")
def tui(scene: str | None) -> None:
    """Open the terminal laboratory, with SCENE if it is given.

    SCENE takes the place of the edited scene of the last session, which undo restores; runs and
    results of the session stay. fivtui SCENE does the same.
    """
    start_laboratory(scene)


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


@commands.command()
@click.argument("page", required=False, metavar="[PAGE]")
def docs(page: str | None) -> None:
    """Open the manual in a browser.

    PAGE is the name of a page, e.g. trust, or of a command. The address is printed.
    """
    from .manual import find_page, open_page

    file = find_page(page)
    print_text(file.as_uri())
    if not open_page(file):
        print_note("there is no browser on this machine; open the address in one")
