"""A Dask scheduler with workers on the loopback interface, in separate processes."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Longest wait for the scheduler and for the workers, s.
STARTUP_LIMIT_S = 600.0


@dataclass
class Cluster:
    """Address of a scheduler, and its processes."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def kill_worker(self, number: int) -> None:
        """Kill a worker, counted from 0, and wait for its end."""
        self.workers[number].kill()
        self.workers[number].wait()


@contextmanager
def loopback_cluster(folder: Path, workers: int = 2, path: str = str(ROOT)) -> Iterator[Cluster]:
    """Start a scheduler with workers of one thread each, which import modules from `path`."""
    address_file = folder / "scheduler.json"
    scheduler = _start_dask(
        path, folder, "scheduler", "--host=127.0.0.1", "--port=0", "--no-dashboard",
        "--no-show", f"--scheduler-file={address_file}",
    )  # fmt: skip
    cluster = Cluster("", scheduler)
    try:
        deadline = time.monotonic() + STARTUP_LIMIT_S
        while not cluster.address:
            assert scheduler.poll() is None, "the scheduler has ended"
            assert time.monotonic() < deadline, "the scheduler has not written its address"
            time.sleep(0.05)
            with suppress(OSError, ValueError):
                cluster.address = json.loads(address_file.read_text(encoding="utf-8"))["address"]
        cluster.workers += [
            _start_dask(
                path, folder, "worker", cluster.address, "--nworkers=1", "--nthreads=1",
                "--no-nanny",
                "--host=127.0.0.1", "--no-dashboard", f"--name=w{number}",
                f"--local-directory={folder}", "--death-timeout=60",
            )
            for number in range(workers)
        ]  # fmt: skip
        if workers:
            from distributed import Client

            with Client(cluster.address, set_as_default=False) as client:
                client.wait_for_workers(workers, timeout=STARTUP_LIMIT_S)
        yield cluster
    finally:
        for process in (*cluster.workers, scheduler):
            process.send_signal(signal.SIGKILL)
            process.wait()


def _start_dask(path: str, folder: Path, *args: str) -> subprocess.Popen[bytes]:
    with (folder / f"{args[0]}.log").open("ab") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *args],
            env=os.environ | {"PYTHONPATH": path},
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )
