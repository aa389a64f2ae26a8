"""The laboratory in a browser: who may open it, what it shows, and what it downloads.

Tests marked `host` depend on this machine: they use its network, and the last one a browser.
"""

import asyncio
import http.client
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from fivtui.model.errors import InputError
from fivtui.tui.browser import _AccessControl, serve
from tests.support.laboratory import HANG_S

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")


def wait_until(condition: Callable[[], bool], description: str) -> None:
    deadline = time.monotonic() + HANG_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {description}"
        time.sleep(0.1)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def is_reachable(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fivtui.tui.browser.find_spec", lambda _name: None)
    with pytest.raises(InputError, match=r"install fivtui\[serve\]"):
        serve(report=print)


# Starts the server with laboratories to which the browser of a busy machine is no slow line.
PATIENT = f"""
import shlex, sys
from fivtui.cli import main
from fivtui.tui import browser
lab = '''
from fivtui.tui.lab import terminal_line
from fivtui.tui.start import run
terminal_line._FAST_RATE, terminal_line._SLOW_FRAME_S = 0.0, {HANG_S}
run()
'''
browser._start_command = lambda: shlex.join([sys.executable, "-c", lab])
main()
"""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[tuple[int, str]]:
    pytest.importorskip("textual_serve", reason="the extra serve is not installed")
    port = free_port()
    command = [sys.executable, "-c", PATIENT, "serve", "--port", str(port)]
    environment = os.environ | {"XDG_STATE_HOME": str(tmp_path)}
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        line = process.stderr.readline()
        try:
            address = rf"http://127\.0\.0\.1:{port}/\?token=([\w-]{{43}})"
            match = re.fullmatch(rf"fivtui is at {address}; Ctrl\+C stops it\n", line)
            assert match is not None, line
            wait_until(lambda: is_reachable(port), "the server")
            yield port, match[1]
        finally:
            process.terminate()
        assert process.wait(HANG_S) == 0


@dataclass
class Response:
    status: int
    headers: http.client.HTTPMessage
    body: str

    def getheader(self, name: str) -> str | None:
        return self.headers.get(name)


def request_page(port: int, path: str, **headers: str) -> Response:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=HANG_S)
    connection.request("GET", path, headers=headers)
    response = connection.getresponse()
    body = response.read().decode()
    connection.close()
    return Response(response.status, response.headers, body)


WEBSOCKET = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}


@pytest.mark.host
def test_only_requests_from_its_own_page_with_the_token_are_accepted(
    server: tuple[int, str],
) -> None:
    port, token = server
    assert request_page(port, "/").status == 403
    assert request_page(port, "/ws", **WEBSOCKET).status == 403
    assert request_page(port, "/?token=wrong").status == 403
    assert request_page(port, "/", Cookie=f"fivtui-{port}=wrong").status == 403
    redirection = request_page(port, f"/?token={token}")
    assert (redirection.status, redirection.getheader("Location")) == (302, "/")
    cookie = (redirection.getheader("Set-Cookie") or "").partition(";")
    assert "HttpOnly" in cookie[2]
    assert "SameSite=Strict" in cookie[2]
    for host in (f"127.0.0.1:{port}", f"localhost:{port}"):
        page = request_page(port, "/", Cookie=cookie[0], Host=host)
        assert page.status == 200
        policy = page.getheader("Content-Security-Policy") or ""
        assert f"ws://{host};" in policy
        assert f'data-session-websocket-url="ws://{host}/ws"' in page.body
    cookies = {"Cookie": cookie[0]}
    assert request_page(port, "/", Host="elsewhere.example", **cookies).status == 403
    foreign_origin = {"Origin": "http://elsewhere.example"}
    assert request_page(port, "/ws", **WEBSOCKET, **foreign_origin, **cookies).status == 403
    with pytest.raises(InputError, match=f"--port {port}: cannot be used"):
        serve(port, report=print)


@pytest.mark.host
async def test_a_page_at_localhost_shows_the_screen_and_passes_keys_on(
    server: tuple[int, str], tmp_path: Path
) -> None:
    aiohttp = pytest.importorskip("aiohttp")
    port, token = server
    origin, session_path = f"http://localhost:{port}", tmp_path / "fivtui" / "session.json"
    async with (
        aiohttp.ClientSession() as client,
        asyncio.timeout(HANG_S),
        client.get(f"{origin}/?token={token}") as page,
    ):
        assert page.status == 200
        socket_address = re.search(r'data-session-websocket-url="ws(.*)"', await page.text())
        assert socket_address is not None
        async with client.ws_connect(
            f"http{socket_address[1]}?width=80&height=24", headers={"Origin": origin}
        ) as stream:
            screen_bytes = bytearray()

            async def collect_screen_bytes() -> None:
                async for message in stream:
                    screen_bytes.extend(message.data if isinstance(message.data, bytes) else b"")

            reading_task = asyncio.create_task(collect_screen_bytes())
            for key, mu in (("", "0.7"), ("\x1b[A", "0.71")):
                if key:
                    await stream.send_json(["stdin", key])
                while (
                    not session_path.is_file()
                    or json.loads(session_path.read_bytes())["edits"]["texts"]["mu"] != mu
                ):
                    await asyncio.sleep(0.1)
            assert b"UNSTABLE" in screen_bytes
            reading_task.cancel()


@pytest.mark.host
async def test_an_export_is_downloaded_by_the_browser_and_not_stored_on_the_server(
    server: tuple[int, str], tmp_path: Path
) -> None:
    aiohttp = pytest.importorskip("aiohttp")
    port, token = server
    origin = f"http://localhost:{port}"
    async with (
        aiohttp.ClientSession() as client,
        asyncio.timeout(HANG_S),
        client.get(f"{origin}/?token={token}"),
        client.ws_connect(f"{origin}/ws?width=100&height=30", headers={"Origin": origin}) as stream,
    ):
        screen_bytes = bytearray()
        # Screen texts with the key that follows each: the tab, F7, and Enter.
        keys = [("UNSTABLE", "\x1b2"), ("Re λ", "\x1b[18~"), ("Download", "\r")]
        async for message in stream:
            if isinstance(message.data, bytes):
                screen_bytes.extend(message.data)
                if keys and keys[0][0].encode() in screen_bytes:
                    await stream.send_json(["stdin", keys.pop(0)[1]])
                    screen_bytes.clear()
                continue
            kind, key = json.loads(message.data)
            if kind == "deliver_file_start":
                break
        async with client.get(f"{origin}/download/{key}") as download:
            assert download.status == 200
            disposition = download.headers["Content-Disposition"]
            downloaded_text = await download.text()
    assert disposition == "attachment; filename=base-stability.csv"
    assert downloaded_text.startswith("# fivtui: ")
    assert not list(tmp_path.glob("base*"))


def test_on_port_80_the_origin_has_no_port() -> None:
    test_utils = pytest.importorskip("aiohttp.test_utils")
    make_mocked_request = test_utils.make_mocked_request
    access = _AccessControl(80)
    headers = {"Cookie": f"{access.cookie}={access.token}"}
    for host in ("localhost", "127.0.0.1:80"):
        request = make_mocked_request(
            "GET", "/", {**headers, "Host": host, "Origin": f"http://{host}"}
        )
        assert access.refusal_reason(request) == ""
    # A page of another server on this machine has another port.
    headers = {**headers, "Host": "localhost:80", "Origin": "http://localhost:8000"}
    assert access.refusal_reason(make_mocked_request("GET", "/", headers))


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Any]:
    webdriver = pytest.importorskip("selenium.webdriver", reason="Selenium is not installed")
    if CHROMIUM is None or DRIVER is None:
        pytest.skip("no Chromium with its driver")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in ("headless=new", "no-sandbox", "disable-gpu", "window-size=1000,700"):
        options.add_argument(f"--{flag}")
    options.add_argument(f"--user-data-dir={tmp_path / 'chromium'}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(DRIVER)
    driver = webdriver.Chrome(options=options, service=service)
    yield driver
    driver.quit()


@pytest.mark.host
@pytest.mark.slow
def test_a_browser_shows_the_laboratory_and_passes_keys_on(
    server: tuple[int, str], browser: Any, tmp_path: Path
) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    session_path = tmp_path / "fivtui" / "session.json"

    def saved_texts() -> dict[str, str]:
        session_texts: dict[str, str] = (
            json.loads(session_path.read_bytes())["edits"]["texts"]
            if session_path.is_file()
            else {}
        )
        return session_texts

    def find(selector: str) -> list[Any]:
        elements: list[Any] = browser.find_elements(By.CSS_SELECTOR, selector)
        return elements

    port, token = server
    browser.get(f"http://localhost:{port}/?token={token}")
    wait_until(lambda: saved_texts().get("mu") == "0.7", "the session of an app in the browser")
    assert browser.title.startswith("fivtui")
    # The page has the focus; the tab Modes always has charts.
    keyboard = browser.switch_to.active_element
    keyboard.send_keys(Keys.ALT, "2")
    wait_until(lambda: bool(find("canvas.picture")), "a chart as a picture")
    keyboard.send_keys(Keys.ARROW_UP)
    wait_until(lambda: saved_texts().get("mu") == "0.71", "a key to reach the app")
    clipboard = ["clipboardReadWrite", "clipboardSanitizedWrite"]
    browser.execute_cdp_cmd("Browser.grantPermissions", {"permissions": clipboard})
    browser.execute_script("navigator.clipboard.writeText('5')")
    keyboard.send_keys(Keys.END, Keys.CONTROL, "v")
    wait_until(lambda: saved_texts().get("mu") == "0.715", "the pasted text to reach the app")
    # Text on a background has more than a few colours.
    from matplotlib.image import imread

    screenshot = tmp_path / "page.png"
    browser.save_screenshot(str(screenshot))
    pixels = imread(screenshot).reshape(-1, 4)
    assert len({tuple(pixel) for pixel in pixels[::7].tolist()}) > 20
    severe_messages = [
        entry["message"] for entry in browser.get_log("browser") if entry["level"] == "SEVERE"
    ]
    assert not severe_messages
    # Pictures leave with their tab.
    keyboard.send_keys(Keys.F1)
    wait_until(lambda: not find("canvas.picture"), "the pictures to leave")
    # The smallest width and height of tablets have 80 columns and 24 rows.
    size = {"width": 820, "height": 768, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.refresh()
    wait_until(lambda: bool(find("canvas.picture")), "a picture after a new start")
    columns, rows = browser.execute_script("return [terminalSize.width, terminalSize.height]")
    assert columns >= 80
    assert rows >= 24
