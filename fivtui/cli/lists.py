"""Commands that list presets and methods."""

from .group import commands
from .options import json_option, print_json


@commands.command()
@json_option
def presets(as_json: bool) -> None:
    """List the scenes that come with the program."""
    from fivtui.scene import PRESETS, scene_to_dict

    if as_json:
        print_json({name: scene_to_dict(scene) for name, scene in PRESETS.items()})
    else:
        from fivtui.console import print_list

        rows = [(name, scene.description) for name, scene in PRESETS.items()]
        print_list("Presets", rows)


@commands.command()
def methods() -> None:
    """List the integration methods."""
    from fivtui.console import print_list
    from fivtui.simulation import ALL_METHODS

    print_list("Methods", list(ALL_METHODS.items()))
