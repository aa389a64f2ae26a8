"""The command `fivtui serve`."""

from fivtui.model import Interval

from .arguments import Whole, option
from .group import commands
from .options import say


@commands.command()
@option(
    "--port",
    type=Whole(Interval(1, 65535)),
    default=8000,
    show_default=True,
    help="Port on 127.0.0.1.",
)
def serve(port: int) -> None:
    """Open the terminal laboratory in a browser.

    It answers on this machine alone; needs the extra fivtui[serve].
    """
    from fivtui.tui import serve as start

    start(port, say=say)
