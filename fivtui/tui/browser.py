"""The terminal UI in a browser on this machine, by textual-serve."""

import os
import shlex
import socket
import subprocess
import sys
from collections.abc import Awaitable, Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from fivtui.model import InputError

if TYPE_CHECKING:
    from aiohttp.web import Application, Request, StreamResponse

    Handler = Callable[[Request], Awaitable[StreamResponse]]

HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 8000
# The page loads nothing from and sends nothing to other sites.
_POLICY: Final = (
    "default-src 'self' 'unsafe-inline' data: blob:; connect-src 'self' ws://{0}; "
    "frame-ancestors 'none'"
)


def serve(port: int = DEFAULT_PORT, *, say: Callable[[str], None]) -> None:
    """Serve the terminal UI to browsers on this machine, until interrupted.

    A browser can read and write files as the serving user: it listens on the loopback address only
    and refuses requests from other sites' pages.

    Parameters
    ----------
    port : int
        Port to listen on, 1 to 65535.
    say : callable
        Prints words for the user.

    Raises
    ------
    InputError
        If the extra ``serve`` is not installed, or the port cannot be used.
    """
    if find_spec("textual_serve") is None:
        raise InputError("serve: needs textual-serve: install fivtui[serve]")
    _check_free(port)
    from aiohttp import web
    from textual_serve.server import Server

    address = f"{HOST}:{port}"
    allowed = {address, f"localhost:{port}"}

    async def guard(request: "Request", handler: "Handler") -> "StreamResponse":
        origin = request.headers.get("Origin")
        known = origin is None or origin in {f"http://{name}" for name in allowed}
        if request.host not in allowed or not known:
            raise web.HTTPForbidden(text="fivtui answers requests from its own page only")
        return await handler(request)

    async def restrict(_request: "Request", response: "StreamResponse") -> None:
        response.headers["Content-Security-Policy"] = _POLICY.format(address)

    class LocalServer(Server):
        """A textual-serve server with guarded requests."""

        async def _make_app(self) -> "Application":
            application: Application = await super()._make_app()
            application.middlewares.append(web.middleware(guard))
            application.on_response_prepare.append(restrict)
            return application

        async def on_startup(self, app: "Application") -> None:  # noqa: ARG002
            say(f"fivtui is at http://{address}; Ctrl+C stops it")

        def initialize_logging(self) -> None:
            """Log nothing to the terminal."""

    LocalServer(_command(), host=HOST, port=port, title="fivtui").serve()


def _check_free(port: int) -> None:
    try:
        with socket.socket() as probe:
            if os.name == "posix":
                # As the server does: a recently closed port can be used again.
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((HOST, port))
    except OSError as error:
        raise InputError(f"--port {port}: cannot be used: {error.strerror or error}") from None


def _command() -> str:
    words = [sys.executable, "-m", "fivtui.tui"]
    return subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words)
