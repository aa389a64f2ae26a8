"""The command that shows the terminal laboratory in a browser."""

from .arguments import Whole, option
from .group import commands
from .options import say


@commands.command()
@option(
    "--port",
    type=Whole(1, 65535),
    default=8000,
    show_default=True,
    help="Port on 127.0.0.1.",
)
def serve(port: int) -> None:
    """Show the terminal laboratory in a browser on this machine."""
    from fivtui.tui import serve as start

    start(port, say=say)
