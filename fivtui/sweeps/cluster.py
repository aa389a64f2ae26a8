"""Sweeps on a Dask cluster: workers compute pieces, this machine stores them.

A piece is a range of members. An engine computes pieces of a study and yields their rows.
"""

import asyncio
import logging
import math
import pickle
import time
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

from fivtui.model import ComputationError, InputError

from .arithmetic import arithmetic_difference, arithmetic_digests
from .pieces import SweepPiece
from .provenance import versions
from .rows import Rows
from .run import Engine
from .study import Study

if TYPE_CHECKING:
    from distributed import Client

# Submitted pieces per thread of the workers.
_PIECES_PER_THREAD: Final = 2
# Timeout for the answer of the scheduler and for its first worker, s.
_CONNECT_S: Final = 10.0
# Interval at which the threads of the workers are counted, s.
_COUNT_INTERVAL_S: Final = 5.0
_LOGGERS: Final = ("distributed", "distributed.client")
# Advice at the end of errors: a sweep that was stopped can be continued.
_CONTINUE: Final = "the same command continues"
# What a worker returns for a piece: its versions, its arithmetic, and the rows.
_WorkerResult = tuple[dict[str, str], object, Any]


@contextmanager
def cluster_engine(address: str) -> Iterator[Engine]:
    """An engine that computes on the workers of a Dask scheduler.

    If a worker is lost, another worker computes its piece. The workers need the same versions of
    fivtui and its numerical packages.
    """
    if find_spec("distributed") is None:
        raise InputError("--scheduler needs Dask: install fivtui[cluster]")
    from distributed import Client

    try:
        # A client that fails to connect hangs at exit, so try the address first.
        asyncio.run(_check_connection(address))
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except Exception as error:  # noqa: BLE001
        raise InputError(f"--scheduler {address}: no scheduler answers there: {error}") from None
    with _silence_loggers(), client:
        try:
            client.wait_for_workers(1, timeout=_CONNECT_S)
        except TimeoutError:
            raise InputError(f"--scheduler {address}: the scheduler has no workers") from None
        yield _make_engine(client, address)


async def _check_connection(address: str) -> None:
    # Fails for a wrong address, and for a protocol whose package is missing or not configured.
    from distributed.comm.core import connect
    from distributed.security import Security

    arguments = Security().get_connection_args("client")
    comm = await connect(address, timeout=_CONNECT_S, **arguments)
    await comm.close()


@contextmanager
def _silence_loggers() -> Iterator[None]:
    # The caller turns failures into one error; the client's log would repeat them.
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _make_engine(client: "Client", address: str) -> Engine:
    from distributed import as_completed

    def compute(pickled_request: bytes) -> Any:
        # Dask sends a nested function by value. It imports fivtui inside, so that a worker without
        # fivtui fails here; failing while unpickling would end the worker.
        import pickle

        from .provenance import versions

        # The request comes from `submit` below.
        own_versions, request = versions(), pickle.loads(pickled_request)  # noqa: S301
        if request["versions"] != own_versions:
            return own_versions, None, None

        from .arithmetic import arithmetic_digests
        from .rows import compute_rows

        study, piece = pickle.loads(request["piece"])  # noqa: S301
        return (
            own_versions,
            arithmetic_digests(study),
            compute_rows(study, piece.first, piece.stop),
        )

    def engine(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        local_versions, local_arithmetic = versions(), arithmetic_digests(study)
        pending = iter(pieces)
        submitted: dict[Any, SweepPiece] = {}
        completed = as_completed(loop=client.loop)
        threads, counted_at = 0, -math.inf
        while True:
            if time.monotonic() - counted_at >= _COUNT_INTERVAL_S:
                threads, counted_at = _count_threads(client, address), time.monotonic()
            for piece in islice(pending, max(_PIECES_PER_THREAD * threads - len(submitted), 0)):
                # Only the same version can unpickle a piece, so workers compare versions first.
                request = {"versions": local_versions, "piece": pickle.dumps((study, piece))}
                future = client.submit(compute, pickle.dumps(request), pure=False)
                submitted[future.key] = piece
                completed.add(future)
            if not submitted:
                return
            future = next(completed)
            worker_versions, worker_arithmetic, rows = _worker_result(future, address)
            _check_versions(worker_versions, local_versions)
            _check_arithmetic(worker_arithmetic, local_arithmetic)
            yield submitted.pop(future.key), rows

    return engine


def _count_threads(client: "Client", address: str) -> int:
    # Threads of all workers; at least 1, because lost workers may come back.
    try:
        return max(int(sum(client.nthreads().values())), 1)
    except OSError:
        raise _lost_scheduler_error(address) from None


def _lost_scheduler_error(address: str) -> ComputationError:
    return ComputationError(f"the scheduler at {address} is lost", f"start it again; {_CONTINUE}")


def _worker_result(future: Any, address: str) -> _WorkerResult:
    # The result of a future; failures of workers and scheduler become a `ComputationError`.
    from distributed import CancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    try:
        result: _WorkerResult = future.result()
    except (CancelledError, CommClosedError):
        raise _lost_scheduler_error(address) from None
    except KilledWorker as error:
        raise ComputationError(
            f"several workers ended while computing a piece: {error}",
            f"see why they end (memory, time limit); {_CONTINUE}",
        ) from None
    except ImportError as error:
        raise ComputationError(
            f"a worker cannot run fivtui: {error}", f"install it there; {_CONTINUE}"
        ) from None
    return result


def _check_versions(worker_versions: dict[str, str], local_versions: dict[str, str]) -> None:
    for name, number in local_versions.items():
        if worker_versions.get(name) != number:
            raise ComputationError(
                f"a worker has {name} {worker_versions.get(name)}, not {number} as here",
                f"install the same versions; {_CONTINUE}",
            )


def _check_arithmetic(worker_arithmetic: object, local_arithmetic: Mapping[str, Any]) -> None:
    difference = arithmetic_difference(worker_arithmetic, local_arithmetic)
    if difference:
        raise ComputationError(
            f"rows of a worker would differ in their last bits from those of this machine "
            f"({difference})",
            f"install fivtui on the workers as here; {_CONTINUE}",
        )
