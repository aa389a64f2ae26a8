"""Sweeps on a Dask scheduler with two workers, all processes of their own, on the loopback."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from fivtui import Parameters
from fivtui.distributions import Distribution
from fivtui.model.errors import ComputationError, InputError
from fivtui.sweeps.arithmetic import arithmetic_digests
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.pieces import sweep_piece
from fivtui.sweeps.provenance import versions
from fivtui.sweeps.run import local_engine, sweep_in_memory, sweep_to_file
from fivtui.sweeps.scatter import Scatter
from fivtui.sweeps.study import Study
from tests.support.dask_cluster import Cluster, loopback_cluster

pytest.importorskip("distributed")

from fivtui.sweeps import cluster as cluster_module
from fivtui.sweeps.cluster import cluster_engine

pytestmark = [pytest.mark.slow, pytest.mark.host]

ROOT = Path(__file__).parents[2]
# With separation ignored the motion is linear, and some members grow without bound: they fail.
STUDY = Study(
    Design({"F": Range(10.0, 120.0), "k2": Range(40.0, 200.0)}, "sobol", 100),
    Parameters(k_nl=0.0, mu=2.0),
    cases=(True, False),
    t_end=600.0,
)
# Members per piece.
SIZE = 10


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with loopback_cluster(tmp_path_factory.mktemp("dask")) as address:
        yield address


def test_scattered_members_are_those_of_this_machine(cluster: Cluster, tmp_path: Path) -> None:
    scatter = Scatter(
        {"mu": Distribution("uniform", (0.2, 0.8)), "F": Distribution("normal", (80.0, 8.0))},
        count=2,
        repeats=2,
    )
    study = Study(scatter, Parameters(), t_end=2.0, outputs=("stable", "safe_mu", "P_max"))
    local_file, cluster_file = tmp_path / "here.csv", tmp_path / "there.csv"
    sweep_to_file(study, local_file, local_engine(1), size=SIZE)
    with cluster_engine(cluster.address) as engine:
        sweep_to_file(study, cluster_file, engine, size=SIZE)
    assert cluster_file.read_bytes() == local_file.read_bytes()


def test_the_file_is_that_of_this_machine_though_a_worker_dies(
    cluster: Cluster, tmp_path: Path
) -> None:
    local_file, cluster_file = tmp_path / "here.csv", tmp_path / "there.csv"
    summary = sweep_to_file(STUDY, local_file, local_engine(1), size=SIZE)
    assert summary.failed
    fractions: list[float] = []

    def progress(fraction: float) -> bool:
        fractions.append(fraction)
        if len(fractions) == 5:
            cluster.kill_worker(0)
        return True

    with cluster_engine(cluster.address) as engine:
        assert sweep_to_file(STUDY, cluster_file, engine, size=SIZE, progress=progress) == summary
    # Before the first piece, and after every piece.
    assert len(fractions) == 1 + STUDY.members // SIZE
    assert cluster_file.read_bytes() == local_file.read_bytes()


def test_the_command_computes_on_the_cluster(cluster: Cluster, tmp_path: Path) -> None:
    args = ["--vary=F=20:80:4", "--t-end=5", "--out=out.csv", "--piece=1"]
    process = subprocess.run(
        [sys.executable, "-m", "fivtui", "sweep", *args, f"--scheduler={cluster.address}"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    assert process.stderr == f"wrote out.csv in {tmp_path}: 4 members\n"
    assert (tmp_path / "out.csv").is_file()


def test_workers_of_other_versions_are_refused(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_versions = versions()
    monkeypatch.setattr(cluster_module, "versions", lambda: own_versions | {"numpy": "1.0"})
    with (
        cluster_engine(cluster.address) as engine,
        pytest.raises(ComputationError, match=r"a worker has numpy \S+, not 1.0 as here"),
    ):
        sweep_in_memory(STUDY, engine)


def test_workers_whose_rows_have_other_bits_are_refused(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    digest, out = arithmetic_digests(STUDY), tmp_path / "out.csv"
    monkeypatch.setattr(
        cluster_module, "arithmetic_digests", lambda _: digest | {"kernel": "interpreted"}
    )
    with (
        cluster_engine(cluster.address) as engine,
        pytest.raises(
            ComputationError, match=r"a worker would differ in their last bits.*compiled there"
        ),
    ):
        sweep_to_file(STUDY, out, engine, size=SIZE)
    # No piece is stored: names of pieces begin with their number.
    assert not list(tmp_path.glob("out.csv.parts/0*"))


def test_a_worker_without_the_program_says_so_and_lives_on(tmp_path: Path) -> None:
    # This file hides the installed package.
    text = "raise ModuleNotFoundError(\"No module named 'fivtui'\")\n"
    (tmp_path / "fivtui.py").write_text(text, encoding="utf-8")
    with (
        loopback_cluster(tmp_path, workers=1, path=str(tmp_path)) as cluster_without_program,
        cluster_engine(cluster_without_program.address) as engine,
    ):
        for _ in range(2):
            with pytest.raises(ComputationError, match="a worker cannot run fivtui: No module"):
                sweep_in_memory(STUDY, engine)
        assert all(worker.poll() is None for worker in cluster_without_program.workers)


def test_a_missing_scheduler_or_missing_workers_are_reported(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(cluster_module, "_CONNECT_S", 0.2)
    for address in ("tcp://127.0.0.1:1", "nonsense://x"):
        with (
            pytest.raises(InputError, match="no scheduler answers there"),
            cluster_engine(address),
        ):
            pass
    monkeypatch.setattr(cluster_module, "_CONNECT_S", 1.0)
    with (
        loopback_cluster(tmp_path, workers=0) as idle,
        pytest.raises(InputError, match="has no workers"),
        cluster_engine(idle.address),
    ):
        pass


def test_a_lost_scheduler_loses_nothing(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out.csv"
    with loopback_cluster(tmp_path, workers=1) as cluster_to_lose:
        fractions: list[float] = []

        def progress(fraction: float) -> bool:
            fractions.append(fraction)
            if len(fractions) == 3:
                cluster_to_lose.scheduler.kill()
            return True

        with (
            pytest.raises(ComputationError, match=r"scheduler at tcp.* is lost; start it again"),
            cluster_engine(cluster_to_lose.address) as engine,
        ):
            sweep_to_file(STUDY, out, engine, size=SIZE, progress=progress)
    assert "Traceback" not in capfd.readouterr().err
    stored_members = sweep_to_file(STUDY, out, local_engine(1), size=SIZE).stored_before
    assert stored_members >= 2 * SIZE


class FakeClient:
    """A client of a cluster that computes nothing and counts the submitted pieces."""

    loop = None

    def __init__(self) -> None:
        self.threads, self.submitted = 1, 0

    def nthreads(self) -> dict[str, int]:
        return {"worker": self.threads}

    def submit(self, *_: object, **_options: object) -> SimpleNamespace:
        self.submitted += 1
        answer = (versions(), arithmetic_digests(STUDY), None)
        return SimpleNamespace(key=self.submitted, result=lambda: answer)


class CompletedInOrder(list[SimpleNamespace]):
    """Futures that are completed in the order in which they were submitted."""

    def __init__(self, **_: object) -> None:
        super().__init__()
        self.add = self.append

    def __next__(self) -> SimpleNamespace:
        return self.pop(0)


def test_pieces_are_submitted_for_the_threads_counted_in_the_last_seconds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    client, clock = FakeClient(), [0.0]
    monkeypatch.setattr("distributed.as_completed", CompletedInOrder)
    monkeypatch.setattr(cluster_module, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    pieces = (sweep_piece(number, STUDY.members, 1) for number in range(STUDY.members))
    rows = cluster_module._make_engine(client, "address")(STUDY, pieces)  # type: ignore[arg-type]
    submitted_ahead = []
    for seconds, threads in ((0.0, 1), (1.0, 4), (10.0, 4), (10.5, 1), (20.0, 1)):
        clock[0], client.threads = seconds, threads
        piece, _ = next(rows)
        submitted_ahead.append(client.submitted - piece.number)
    # Threads are counted after 5 s at the earliest: at 0, 10 and 20 s, but not at 1 and 10.5 s. At
    # 20 s there are fewer: one piece is completed, and no new one is submitted.
    for_1 = cluster_module._PIECES_PER_THREAD
    for_4 = 4 * for_1
    assert submitted_ahead == [for_1, for_1, for_4, for_4, for_4 - 1]
