"""Sweeps on a cluster: pieces computed by the workers of Dask's scheduler, stored here."""

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

from .arithmetic import arithmetic_difference, arithmetic_of
from .pieces import Piece
from .provenance import versions
from .rows import Rows
from .run import Engine
from .study import Study

if TYPE_CHECKING:
    from distributed import Client

# Pieces handed out ahead of those that are being computed, for each thread of the workers.
_AHEAD: Final = 2
# Time for the scheduler to answer, and for its first worker to come, s.
_CONNECT_S: Final = 10.0
# Time between two looks at how many workers there are.
_LOOK_S: Final = 5.0
_LOGGERS: Final = ("distributed", "distributed.client")
_AGAIN: Final = "the same command continues"


@contextmanager
def cluster_engine(address: str) -> Iterator[Engine]:
    """An engine of the workers of a Dask scheduler.

    Parameters
    ----------
    address : str
        That of the scheduler, such as ``tcp://10.0.0.1:8786``. Its workers need the same versions
        of fivtui and of what it computes with.

    Yields
    ------
    callable
        The engine. A piece whose worker is lost is computed by another one.

    Raises
    ------
    InputError
        If Dask is not installed, no scheduler answers there, or it has no workers.
    """
    if find_spec("distributed") is None:
        raise InputError("--scheduler needs Dask: install fivtui[cluster]")
    from distributed import Client

    try:
        # A client that cannot be made hangs when the process ends: ask before one is made.
        asyncio.run(_reach(address))
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except Exception as error:  # noqa: BLE001
        raise InputError(f"--scheduler {address}: no scheduler answers there: {error}") from None
    with _quiet(), client:
        try:
            client.wait_for_workers(1, timeout=_CONNECT_S)
        except TimeoutError:
            raise InputError(f"--scheduler {address}: the scheduler has no workers") from None
        yield _engine(client, address)


async def _reach(address: str) -> None:
    # Besides what is no address, schemes of packages that are missing or not set up fail here.
    from distributed.comm.core import connect
    from distributed.security import Security

    arguments = Security().get_connection_args("client")
    comm = await connect(address, timeout=_CONNECT_S, **arguments)
    await comm.close()


@contextmanager
def _quiet() -> Iterator[None]:
    # What goes wrong is said once, by an error, and not in the client's log as well.
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _engine(client: "Client", address: str) -> Engine:
    from distributed import as_completed

    def compute(packed: bytes) -> Any:
        # Being no module's it is sent by value, and it names nothing of fivtui but inside. So a
        # worker without fivtui fails here, and not in reading the message, which would end it.
        import pickle

        from .provenance import versions

        there, asked = versions(), pickle.loads(packed)  # noqa: S301, it comes from `submit` below
        if asked["versions"] != there:
            return there, None, None

        from .arithmetic import arithmetic_of
        from .rows import compute_rows

        study, piece = pickle.loads(asked["piece"])  # noqa: S301
        return there, arithmetic_of(study), compute_rows(study, piece.first, piece.last)

    def engine(study: Study, pieces: Iterable[Piece]) -> Generator[tuple[Piece, Rows]]:
        own, arithmetic, waiting = versions(), arithmetic_of(study), iter(pieces)
        handed_out: dict[Any, Piece] = {}
        completed = as_completed(loop=client.loop)
        threads, looked = 0, -math.inf
        while True:
            if time.monotonic() - looked >= _LOOK_S:
                threads, looked = _threads(client, address), time.monotonic()
            for piece in islice(waiting, max(_AHEAD * threads - len(handed_out), 0)):
                # What a piece is can be read by the same version alone.
                asked = {"versions": own, "piece": pickle.dumps((study, piece))}
                future = client.submit(compute, pickle.dumps(asked), pure=False)
                handed_out[future.key] = piece
                completed.add(future)
            if not handed_out:
                return
            future = next(completed)
            there, computed_with, rows = _result(future, address)
            _check_versions(there, own)
            _check_arithmetic(computed_with, arithmetic)
            yield handed_out.pop(future.key), rows

    return engine


def _threads(client: "Client", address: str) -> int:
    # At least one: workers that are all lost may come back.
    try:
        return max(int(sum(client.nthreads().values())), 1)
    except OSError:
        raise _lost(address) from None


def _lost(address: str) -> ComputationError:
    return ComputationError(f"the scheduler at {address} is lost", f"start it again; {_AGAIN}")


def _result(future: Any, address: str) -> tuple[dict[str, str], object, Any]:
    from distributed import CancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    try:
        result: tuple[dict[str, str], object, Any] = future.result()
    except (CancelledError, CommClosedError):
        raise _lost(address) from None
    except KilledWorker as error:
        raise ComputationError(
            f"a piece was lost with several workers: {error}",
            f"see why they end (memory, time limit); {_AGAIN}",
        ) from None
    except ImportError as error:
        raise ComputationError(
            f"a worker cannot run fivtui: {error}", f"install it there; {_AGAIN}"
        ) from None
    return result


def _check_versions(there: dict[str, str], own: dict[str, str]) -> None:
    for name, number in own.items():
        if there.get(name) != number:
            raise ComputationError(
                f"a worker has {name} {there.get(name)}, not {number} as here",
                f"install the same versions; {_AGAIN}",
            )


def _check_arithmetic(there: object, own: Mapping[str, Any]) -> None:
    difference = arithmetic_difference(there, own)
    if difference:
        raise ComputationError(
            f"rows of a worker would differ in the last bits from those of this machine "
            f"({difference})",
            f"take workers whose processors are of one kind with this machine's; {_AGAIN}",
        )
