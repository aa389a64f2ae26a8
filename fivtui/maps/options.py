"""Options of ``fivtui map``."""

from fivtui.model import PARAMETERS
from fivtui.options import option, options_class
from fivtui.transient import setting


@options_class
class MapOptions:
    """Options of ``fivtui map``."""

    # The option --ignore-separation, as of all commands that have this setting of scenes.
    ignore_separation: bool = setting("separation")
    over: tuple[str, ...] = option(
        "--over",
        "A parameter and its values; give it twice.",
        metavar="NAME=START:STOP:COUNT[:log]",
        multiple=True,
        required=True,
        completions=lambda: (f"{name}=" for name in PARAMETERS),
    )
    value: str = option(
        "--value",
        "Value computed at every point.",
        "growth-rate",
        metavar="growth-rate|critical-mu|unstable-modes|safe-mu|coexistence",
        show_default=True,
    )
