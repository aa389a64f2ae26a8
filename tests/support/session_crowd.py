"""Kills laboratories at random times while more laboratories run, and checks the stored runs.

``python -m tests.support.session_crowd FOLDER KILLS TERMINALS`` runs laboratories in TERMINALS
terminals and one in a browser tab, by a client that speaks its protocol. It presses keys in all of
them, kills one, or the server, at a random time, and starts it again. It prints the number of runs
stored at the end.
It fails if a run is lost after a session's file listed it. A slot is the place of a session: its
number, its file and its folder of results.
"""

import asyncio
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, Final

import aiohttp

from fivtui.tui.persistence.autosave import Autosave
from fivtui.tui.persistence.slots import saved_slots
from fivtui.tui.persistence.state_file import session_state
from fivtui.tui.session.runs import MAX_RUNS, Run
from tests.support.pseudo_terminal import start_laboratory

SEED: Final = 5
# Escape sequence of F5, the run key.
RUN_KEY: Final = "\x1b[15~"
HANG_S: Final = 120.0
_PAUSE_S: Final = 0.3
# The longest time from a start to the next kill, s.
_MAX_LIFETIME_S: Final = 2.0


class Terminal:
    """A laboratory in a terminal."""

    def __init__(self, folder: Path) -> None:
        self._environment = environment(folder)
        self._process: subprocess.Popen[bytes] | None = None
        self._screen = 0

    async def start(self) -> None:
        self._process, self._screen = start_laboratory(self._environment, 24, 80)
        asyncio.get_running_loop().add_reader(self._screen, self._read)

    def _read(self) -> None:
        try:
            os.read(self._screen, 65536)
        except OSError:
            # The program in the terminal has ended.
            asyncio.get_running_loop().remove_reader(self._screen)

    async def press(self, keys: str) -> None:
        with suppress(OSError):
            os.write(self._screen, keys.encode())

    async def kill(self) -> None:
        await self.end()

    async def end(self) -> None:
        """Kill the program and close its terminal."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            asyncio.get_running_loop().remove_reader(self._screen)
            os.close(self._screen)
            self._process = None


class Tab:
    """A laboratory in a browser: a server, and a client of its page."""

    def __init__(self, folder: Path, rng: random.Random) -> None:
        self._environment, self._rng = environment(folder), rng
        self._server: subprocess.Popen[str] | None = None
        self._client: aiohttp.ClientSession | None = None
        self._socket: aiohttp.ClientWebSocketResponse | None = None
        self._reading: asyncio.Task[None] | None = None

    async def start(self) -> None:
        if self._server is None:
            await self._serve()
        assert self._client is not None
        self._socket = await self._client.ws_connect(f"{self._address}/ws?width=80&height=24")
        self._reading = asyncio.create_task(self._read(self._socket))

    async def _serve(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        command = [sys.executable, "-m", "fivtui", "serve", "--port", str(port)]
        self._server = subprocess.Popen(
            command, env=self._environment, stderr=subprocess.PIPE, text=True
        )
        assert self._server.stderr is not None
        line = await asyncio.to_thread(self._server.stderr.readline)
        match = re.search(r"(http://[\d.:]+)/\?token=([\w-]+)", line)
        assert match is not None, line
        self._address = match[1]
        self._client = aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True))
        while True:
            with suppress(aiohttp.ClientConnectorError):
                async with self._client.get(f"{match[1]}/?token={match[2]}") as page:
                    assert page.status == 200
                return
            await asyncio.sleep(_PAUSE_S)

    async def _read(self, stream: aiohttp.ClientWebSocketResponse) -> None:
        async for _ in stream:
            pass

    async def press(self, keys: str) -> None:
        if self._socket is not None and not self._socket.closed:
            with suppress(ConnectionError):
                await self._socket.send_json(["stdin", keys])

    async def kill(self) -> None:
        """Kill the laboratory alone, or with its server, at random."""
        if self._rng.random() < 0.5:
            await self.end()
        elif self._server is not None and self._socket is not None:
            _kill(descendants(self._server.pid))
            await self._socket.close()

    async def end(self) -> None:
        """Kill laboratory and server."""
        if self._server is not None:
            pids = [self._server.pid, *descendants(self._server.pid)]
            _kill(pids)
            self._server.wait()
            self._server = None
        if self._socket is not None and self._client is not None:
            await self._socket.close()
            await self._client.close()


def _kill(pids: list[int]) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def environment(folder: Path) -> dict[str, str]:
    """Environment variables of a laboratory that keeps its state in a folder."""
    root = str(Path(__file__).parents[2])
    return {
        **os.environ,
        "XDG_STATE_HOME": str(folder),
        "XDG_CONFIG_HOME": str(folder / "config"),
        "PYTHONPATH": root,
    }


def descendants(pid: int) -> list[int]:
    """All descendants of a process."""
    try:
        fields = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    children = [int(field) for field in fields]
    return [process for child in children for process in (child, *descendants(child))]


class Observer:
    """Records the runs listed in the files of all sessions."""

    def __init__(self, folder: Path) -> None:
        self._first = folder / "fivtui" / "session.json"
        self.stored_runs: dict[int, set[int]] = {}

    def check_stored_runs(self) -> None:
        """Record the stored runs; fail if an earlier one is lost."""
        for slot in saved_slots(self._first):
            state: dict[str, Any] = json.loads(slot.path.read_bytes())
            stored = {int(key.removeprefix("run ")) for key in state["results"] if "run " in key}
            for number in stored:
                name = state["results"][f"run {number}"]["file"]
                missing = not (slot.results_folder / name).is_file()
                # A state that was replaced meanwhile may have lost its files.
                assert not missing or json.loads(slot.path.read_bytes()) != state, (slot, name)
            previous = self.stored_runs.get(slot.number, set())
            count = state["run_count"]
            expected = {number for number in previous if number > count - MAX_RUNS}
            assert expected <= stored, (slot.number, expected - stored)
            self.stored_runs[slot.number] = stored

    def read_all(self) -> int:
        """Read every result of every session as the program does; return their number."""
        read = 0
        with ExitStack() as opened:
            # Each opens the last used session that is not locked, and locks it.
            for _ in saved_slots(self._first):
                autosave = Autosave(self._first)
                session = autosave.load()
                assert session is not None
                assert not autosave.notices, autosave.notices
                opened.callback(autosave.close, session_state(session))
                runs = session.unread_results
                numbers = {key.number for key in runs if isinstance(key, Run)}
                assert numbers == self.stored_runs[autosave.number]
                results, errors = autosave.store.read(runs)
                assert not errors, errors
                read += len(results)
        return read


async def crowd(folder: Path, kills: int, terminals: int) -> int:
    """Kill laboratories `kills` times; return the number of runs that can be read at the end."""
    rng = random.Random(SEED)
    users: list[Terminal | Tab] = [*(Terminal(folder) for _ in range(terminals)), Tab(folder, rng)]
    observer = Observer(folder)
    try:
        for user in users:
            await user.start()
        # Kill only after each session was stored.
        async with asyncio.timeout(HANG_S):
            while len(observer.stored_runs) < len(users):
                await press_all(users, observer)
        for _ in range(kills):
            async with asyncio.timeout(HANG_S):
                end = asyncio.get_running_loop().time() + rng.uniform(0.0, _MAX_LIFETIME_S)
                while asyncio.get_running_loop().time() < end:
                    await press_all(users, observer)
                user = rng.choice(users)
                await user.kill()
                observer.check_stored_runs()
                await user.start()
    finally:
        for user in users:
            await user.end()
    observer.check_stored_runs()
    # A laboratory that dies slowly may still lock its session when the next one starts.
    assert len(observer.stored_runs) <= len(users) + 1, observer.stored_runs
    return observer.read_all()


async def press_all(users: list[Terminal | Tab], observer: Observer) -> None:
    """Start a run in every laboratory, and check the stored runs."""
    for user in users:
        await user.press(RUN_KEY)
    await asyncio.sleep(_PAUSE_S)
    observer.check_stored_runs()


if __name__ == "__main__":
    print(asyncio.run(crowd(Path(sys.argv[1]), *map(int, sys.argv[2:]))))
