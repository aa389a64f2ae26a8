"""The terminal UI in a browser on this machine, by textual-serve."""

import re
import secrets
import shlex
import socket
import subprocess
import sys
from collections.abc import Awaitable, Callable, Mapping
from copy import copy
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

from fivtui.model import InputError

if TYPE_CHECKING:
    from aiohttp.web import Application, Request, Response, StreamResponse

    Handler = Callable[[Request], Awaitable[StreamResponse]]

HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 8000
# Title, fonts and pictures of the page; inserted before the scripts of textual-serve.
_PAGE_HEAD: Final = Path(__file__).with_name("page.html")
# The page of textual-serve requests its font from elsewhere.
_FOREIGN_FONT: Final = re.compile(r'<link\s+rel="stylesheet"\s+href="https://fonts[^>]*>')
# The page must not exchange data with other sites; {0} is the host of this server.
_CONTENT_POLICY: Final = (
    "default-src 'self' 'unsafe-inline' data: blob:; connect-src 'self' ws://{0}; "
    "frame-ancestors 'none'"
)


def serve(port: int = DEFAULT_PORT, *, report: Callable[[str], None]) -> None:
    """Serve the terminal UI to browsers on this machine, until interrupted.

    A browser can read and write files as the user who serves. The server therefore listens on the
    loopback address only, refuses requests from pages of other sites, and requires a token. The
    printed address contains the token, so other users of this machine do not know it.
    """
    if find_spec("textual_serve") is None:
        raise InputError("serve: needs textual-serve: install fivtui[serve]")
    _check_port(port)
    from aiohttp import web
    from textual_serve.server import Server

    access = _AccessControl(port)

    async def check_access(request: "Request", handler: "Handler") -> "StreamResponse":
        if reason := access.refusal_reason(request):
            raise web.HTTPForbidden(text=reason)
        if access.has_token(request.query):
            # The redirection keeps the token out of the browser's history.
            response = web.Response(status=302, headers={"Location": "/"})
            response.set_cookie(access.cookie, access.token, httponly=True, samesite="Strict")
            return response
        return await handler(request)

    async def add_security_headers(request: "Request", response: "StreamResponse") -> None:
        response.headers["Content-Security-Policy"] = _CONTENT_POLICY.format(request.host)
        response.headers["Referrer-Policy"] = "no-referrer"

    class LocalServer(Server):
        """A textual-serve server that refuses requests without a token."""

        async def _make_app(self) -> "Application":
            application: Application = await super()._make_app()
            application.middlewares.append(web.middleware(check_access))
            application.on_response_prepare.append(add_security_headers)
            return application

        async def handle_index(self, request: "Request") -> "StreamResponse":
            # A browser may address this machine by name or number; the page uses the same.
            server = copy(self)
            server.public_url = f"http://{request.host}"
            page = cast("Response", await Server.handle_index(server, request))
            head = _PAGE_HEAD.read_text(encoding="utf-8")
            page.text = _FOREIGN_FONT.sub("", page.text or "").replace("<head>", f"<head>{head}", 1)
            return page

        async def on_startup(self, app: "Application") -> None:  # noqa: ARG002
            report(f"fivtui is at http://{HOST}:{port}/?token={access.token}; Ctrl+C stops it")

        def initialize_logging(self) -> None:
            """Log nothing to the terminal."""

    LocalServer(_start_command(), host=HOST, port=port, title="fivtui").serve()


class _AccessControl:
    # Accepts requests that come from this server's page and carry the token.

    def __init__(self, port: int) -> None:
        self._port_suffix = f":{port}"
        self.token = secrets.token_urlsafe()
        self.cookie = f"fivtui-{port}"

    def refusal_reason(self, request: "Request") -> str:
        """Why a request is refused; empty if it is accepted."""
        # Browsers omit the usual port 80. A page of this server has its host, with the port.
        is_own_host = request.host.removesuffix(self._port_suffix) in (HOST, "localhost")
        is_own_page = request.headers.get("Origin") in (None, f"http://{request.host}")
        if not is_own_host or not is_own_page:
            return "fivtui answers requests from its own page only"
        has_token = self.has_token(request.query) or self.has_token(request.cookies, self.cookie)
        # Style sheets and scripts contain no secrets.
        if has_token or request.path.startswith("/static/"):
            return ""
        return "open the address that fivtui serve has printed"

    def has_token(self, values: Mapping[str, str], name: str = "token") -> bool:
        """Whether the query or the cookies of a request contain the token."""
        return secrets.compare_digest(values.get(name, "").encode(), self.token.encode())


def _check_port(port: int) -> None:
    try:
        socket.create_server((HOST, port)).close()
    except OSError as error:
        raise InputError(f"--port {port}: cannot be used: {error.strerror or error}") from None


def _start_command() -> str:
    arguments = [sys.executable, "-c", "from fivtui.tui import run; run()"]
    return subprocess.list2cmdline(arguments) if sys.platform == "win32" else shlex.join(arguments)
