"""The terminal UI in a browser on this machine, by textual-serve."""

import os
import secrets
import shlex
import socket
import subprocess
import sys
from collections.abc import Awaitable, Callable, Mapping
from copy import copy
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from fivtui.model import InputError

if TYPE_CHECKING:
    from aiohttp.web import Application, Request, StreamResponse

    Handler = Callable[[Request], Awaitable[StreamResponse]]

HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 8000
_NAME: Final = "localhost"
_USUAL_PORT: Final = 80
# The page loads nothing from and sends nothing to other sites.
_POLICY: Final = (
    "default-src 'self' 'unsafe-inline' data: blob:; connect-src 'self' ws://{0}; "
    "frame-ancestors 'none'"
)


def serve(port: int = DEFAULT_PORT, *, say: Callable[[str], None]) -> None:
    """Serve the terminal UI to browsers on this machine, until interrupted.

    A browser can read and write files as the serving user. The server therefore listens on the
    loopback address only, refuses requests from other sites' pages, and asks for a token. The
    printed address has the token, which other users of this machine do not know.
    """
    if find_spec("textual_serve") is None:
        raise InputError("serve: needs textual-serve: install fivtui[serve]")
    _check_free(port)
    from aiohttp import web
    from textual_serve.server import Server

    door = _Door(port)

    async def guard(request: "Request", handler: "Handler") -> "StreamResponse":
        if why := door.refusal(request):
            raise web.HTTPForbidden(text=why)
        if door.has_token(request.query):
            # Redirect to an address without the token, which would stay in the browser's history.
            answer = web.Response(status=302, headers={"Location": "/"})
            answer.set_cookie(door.cookie, door.token, httponly=True, samesite="Strict")
            return answer
        return await handler(request)

    async def restrict(request: "Request", response: "StreamResponse") -> None:
        response.headers["Content-Security-Policy"] = _POLICY.format(request.host)
        response.headers["Referrer-Policy"] = "no-referrer"

    class LocalServer(Server):
        """A textual-serve server with guarded requests."""

        async def _make_app(self) -> "Application":
            application: Application = await super()._make_app()
            application.middlewares.append(web.middleware(guard))
            application.on_response_prepare.append(restrict)
            return application

        async def handle_index(self, request: "Request") -> "StreamResponse":
            # Addresses in the page use the host name of the request.
            named = copy(self)
            named.public_url = f"http://{request.host}"
            answer: StreamResponse = await super(LocalServer, named).handle_index(request)
            return answer

        async def on_startup(self, app: "Application") -> None:  # noqa: ARG002
            say(f"fivtui is at http://{HOST}:{port}/?token={door.token}; Ctrl+C stops it")

        def initialize_logging(self) -> None:
            """Log nothing to the terminal."""

    LocalServer(_command(), host=HOST, port=port, title="fivtui").serve()


class _Door:
    # Accepts requests of its own page that have the token.

    def __init__(self, port: int) -> None:
        self.hosts = {f"{name}:{port}" for name in (HOST, _NAME)}
        if port == _USUAL_PORT:
            # Browsers omit the usual port.
            self.hosts |= {HOST, _NAME}
        self.token = secrets.token_urlsafe()
        self.cookie = f"fivtui-{port}"

    def refusal(self, request: "Request") -> str:
        """Why a request is refused; empty if it is answered."""
        origin = request.headers.get("Origin")
        is_own_page = origin is None or origin in {f"http://{name}" for name in self.hosts}
        if request.host not in self.hosts or not is_own_page:
            return "fivtui answers requests from its own page only"
        # The style sheets and scripts of the page are no secret.
        free = request.path.startswith("/static/")
        if free or self.has_token(request.query) or self.has_token(request.cookies, self.cookie):
            return ""
        return "open the address that fivtui serve has printed"

    def has_token(self, values: Mapping[str, str], name: str = "token") -> bool:
        """Whether a query or cookies contain the token."""
        return secrets.compare_digest(values.get(name, "").encode(), self.token.encode())


def _check_free(port: int) -> None:
    try:
        with socket.socket() as probe:
            if os.name == "posix":
                # As the server does, so that a recently closed port can be used again.
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((HOST, port))
    except OSError as error:
        raise InputError(f"--port {port}: cannot be used: {error.strerror or error}") from None


def _command() -> str:
    arguments = [sys.executable, "-m", "fivtui.tui"]
    return subprocess.list2cmdline(arguments) if sys.platform == "win32" else shlex.join(arguments)
