"""Sweeps on a cluster: pieces computed by the workers of Dask's scheduler, stored here."""

from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

from .core.errors import ComputationError, InputError
from .core.sweep import Rows, Study, compute_rows
from .sweep_store import Piece, versions
from .sweeps import Engine

if TYPE_CHECKING:
    from distributed import Client

# Pieces handed out ahead of those that are being computed, for each thread of the workers.
_AHEAD: Final = 2
_CONNECT_S: Final = 10
# Times that a piece is handed out again when what fails is the worker, not the piece.
_RETRIES: Final = 3


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
        If Dask is not installed, or no scheduler answers there.
    """
    if find_spec("distributed") is None:
        raise InputError("--scheduler needs Dask: install fivtui[cluster]")
    from distributed import Client

    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (TimeoutError, OSError, ValueError) as error:
        raise InputError(f"--scheduler {address}: no scheduler answers there: {error}") from None
    with client:
        if not client.nthreads():
            raise InputError(f"--scheduler {address}: the scheduler has no workers")
        yield _engine(client, address)


def _compute(study: Study, piece: Piece) -> tuple[dict[str, str], Rows]:
    # On the worker.
    return versions(), compute_rows(study, piece.first, piece.last)


def _engine(client: "Client", address: str) -> Engine:
    from distributed import as_completed

    def engine(study: Study, pieces: Iterable[Piece]) -> Generator[tuple[Piece, Rows]]:
        own, waiting = versions(), iter(pieces)
        handed_out: dict[Any, Piece] = {}
        completed = as_completed(loop=client.loop)

        def hand_out() -> None:
            threads = max(sum(client.nthreads().values()), 1)
            for piece in islice(waiting, max(_AHEAD * threads - len(handed_out), 0)):
                future = client.submit(_compute, study, piece, pure=False, retries=_RETRIES)
                handed_out[future.key] = piece
                completed.add(future)

        hand_out()
        try:
            for future in completed:
                there, rows = _result(future, address)
                _check_versions(there, own)
                yield handed_out.pop(future.key), rows
                hand_out()
        finally:
            completed.clear()

    return engine


def _result(future: Any, address: str) -> tuple[dict[str, str], Rows]:
    from distributed import CancelledError
    from distributed.scheduler import KilledWorker

    again = "the same command continues"
    try:
        result: tuple[dict[str, str], Rows] = future.result()
    except CancelledError:
        raise ComputationError(
            f"the scheduler at {address} is lost", f"start it again; {again}"
        ) from None
    except KilledWorker as error:
        raise ComputationError(
            f"a piece was lost with several workers: {error}",
            f"see why they end (memory, time limit); {again}",
        ) from None
    except ModuleNotFoundError as error:
        raise ComputationError(
            f"a worker cannot run fivtui: {error}", f"install it there; {again}"
        ) from None
    return result


def _check_versions(there: dict[str, str], own: dict[str, str]) -> None:
    for name, number in own.items():
        if there.get(name) != number:
            raise ComputationError(
                f"a worker has {name} {there.get(name)}, not {number} as here",
                "install the same versions; the same command continues",
            )
