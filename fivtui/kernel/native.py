"""The kernel in C as Python calls it: compiled when fivtui is installed, loaded when first used."""

import ctypes
import os
import platform
import struct
import sys
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ALL_PARAMETERS, PARAMETERS, ComputationError

from .driven import Legs
from .field_text import law_is_tuned, sources_digest
from .in_turn import RunsInTurn
from .lanes import Work
from .orbits import OrbitSearch
from .runs import MOST_SEEDS, BeltRun, KernelRun, VariedRun

Floats = NDArray[np.float64]

_FOLDER: Final = Path(__file__).parent
_LIBRARY: Final = _FOLDER / (
    "libfivtui" + {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
)
_REASON: Final = _FOLDER / "libfivtui.txt"
# Names by the return value of `fivtui_instruction_set`.
INSTRUCTION_SETS: Final = ("baseline", "avx2", "avx512")
# Functions that gain nothing by wider registers than those of AVX2.
_OF_ONE_RUN: Final = ("run_", "belt_", "driven_", "vary_", "orbit_")
_X86: Final = ("x86_64", "amd64")
# Environment variable that overrides the best instruction set.
_CHOICE: Final = "FIVTUI_INSTRUCTION_SET"

_int, _float, _pointer = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
_BEGIN: Final[tuple[Any, list[Any]]] = (
    None,
    [_pointer, _pointer, _int, _pointer, _float, _float, _int],
)
_ADVANCE: Final[tuple[Any, list[Any]]] = (
    _int,
    [
        *(_pointer, _pointer, _int, _pointer, _int, _pointer, _pointer, _pointer, _int, _int),
        _pointer,
    ],
)
_OF_LANES: Final[dict[str, tuple[Any, list[Any]]]] = {
    "size": (_int, []),
    "advance": (_float, [*([_pointer] * 5), _int, _float, _float, _float, *([_int] * 6)]),
    "ended": (_int, [_pointer]),
}
# Prefixes of batch functions: without and with a finite belt speed.
_BATCHES: Final = ("batch", "belts")
_FUNCTIONS: Final[dict[str, tuple[Any, list[Any]]]] = {
    "run_size": (_int, []),
    "run_begin": _BEGIN,
    "run_advance": _ADVANCE,
    "belt_size": (_int, []),
    "belt_begin": _BEGIN,
    "belt_advance": _ADVANCE,
    "driven_begin": (None, [*_BEGIN[1], _int, _pointer, _int, _float]),
    **{f"{name}_{function}": kind for name in _BATCHES for function, kind in _OF_LANES.items()},
    "vary_size": (_int, []),
    "vary_begin": (
        None,
        [_pointer, _pointer, _int, _pointer, _pointer, _int, _float, _float, _int],
    ),
    "vary_advance": (_int, [_pointer, _pointer, _int, _int, _pointer, _pointer, _pointer]),
    "orbit_solve": (_int, [*([_pointer] * 5), _int, _pointer]),
    "static_starts": (None, [_pointer, _pointer, _pointer, _int]),
}
_packed_state: Final = struct.Struct("4d").pack
_packed_parameters: Final = struct.Struct(f"{len(PARAMETERS)}d").pack
_packed_with_belt: Final = struct.Struct(f"{len(ALL_PARAMETERS)}d").pack


class Kernel:
    """The kernel for one instruction set, by default the best of the processor.

    Results have the same bits with each. Raises `ComputationError` if there is no library, its
    sources differ from those beside it, or the processor lacks the instruction set.
    """

    def __init__(self, instruction_set: str | None = None) -> None:
        library = _library()
        best = library.fivtui_instruction_set()
        allowed = INSTRUCTION_SETS[: best + 1]
        chosen = instruction_set or os.environ.get(_CHOICE) or allowed[-1]
        if chosen not in allowed:
            raise ComputationError(
                f"instruction set {chosen!r}: this processor has {', '.join(allowed)}",
                f"do not set {_CHOICE}",
            )
        self.instruction_set = chosen
        self.compiler = str(library.fivtui_compiler().decode())
        functions: dict[str, Any] = {}
        self._functions = functions
        one_run = "avx2" if chosen == "avx512" else chosen
        for name, (result, arguments) in _FUNCTIONS.items():
            variant = one_run if name.startswith(_OF_ONE_RUN) else chosen
            function = getattr(library, f"fivtui_{name}_{variant}")
            function.restype, function.argtypes = result, arguments
            functions[name] = function
        self._run_memory = _float * (functions["run_size"]() // 8)
        self._belt_memory = _float * (functions["belt_size"]() // 8)
        self._varied_size = functions["vary_size"]() // 8

    def begin(
        self,
        parameters: Iterable[float],
        start: Iterable[float],
        *,
        separation: bool,
        t_end: float,
        tol: float,
        order: int,
        times: Floats | None = None,
        segments: bool = False,
        belt: tuple[float, float, float] | None = None,
        legs: Legs | None = None,
    ) -> KernelRun:
        """Begin a run with a local tolerance, of the order 8, 12, 16, 20, or with a law 24.

        `times` are ascending sample times, s; `segments` enables their output. `belt` is v_belt,
        μ_s and v_s of a belt of finite speed, with v_s = 0 for constant friction. `legs` are tables
        over time. With either the run is a `BeltRun`.
        """
        state = _packed_state(*start)
        if belt is None and legs is None:
            memory, packed = self._run_memory(), _packed_parameters(*parameters)
            self._functions["run_begin"](memory, packed, separation, state, t_end, tol, order)
            return KernelRun(self._functions["run_advance"], memory, order, times, segments)
        memory = self._belt_memory()
        packed = _packed_with_belt(*parameters, *(belt or (0.0, 0.0, 0.0)))
        problem = memory, packed, separation, state, t_end, tol, order
        if legs is None:
            self._functions["belt_begin"](*problem)
        else:
            rows = legs.rows.ctypes.data, len(legs.rows)
            on_belt = belt is not None
            self._functions["driven_begin"](*problem, on_belt, *rows, legs.greatest_load)
        run = BeltRun(self._functions["belt_advance"], memory, order, times, segments)
        run.legs = legs
        return run

    def vary(
        self,
        parameters: Floats,
        start: Floats,
        seeds: Floats,
        *,
        separation: bool,
        t_end: float,
        tol: float,
        order: int,
    ) -> VariedRun:
        """Begin a run with its derivatives; its motion has the same bits as by `begin`.

        `seeds`, shape (k, 13), say how (x, ẋ, y, ẏ) at the start and the parameters change with
        each of the k numbers to derive by, `MOST_SEEDS` at most.
        """
        if not 0 < len(seeds) <= MOST_SEEDS:
            raise ValueError(f"{len(seeds)} seeds: must be 1 to {MOST_SEEDS}")
        memory, seed_rows = np.empty(self._varied_size), np.ascontiguousarray(seeds)
        self._functions["vary_begin"](
            memory.ctypes.data,
            parameters.ctypes.data,
            separation,
            start.ctypes.data,
            seed_rows.ctypes.data,
            len(seed_rows),
            t_end,
            tol,
            order,
        )
        return VariedRun(self._functions["vary_advance"], memory, len(seed_rows))

    def orbits(self, **arguments: Any) -> OrbitSearch:
        """Begin a search of periodic orbits: see `OrbitSearch`."""
        return OrbitSearch(self._functions["orbit_solve"], self._varied_size, **arguments)

    def work(
        self, *, observed: tuple[bool, bool, bool], belts: Floats | None = None, **arguments: Any
    ) -> Work | RunsInTurn:
        """Begin a chunk of a batch, in lanes or in turn, with the same bits: see `Work`."""
        if belts is not None and (self._is_slow_in_lanes or not law_is_tuned()):
            # Single runs always record all extremes.
            return RunsInTurn(self.begin, belts=belts, **arguments)
        return Work(self._functions, observed=observed, belts=belts, **arguments)

    @property
    def _is_slow_in_lanes(self) -> bool:
        # Without hardware fused multiply-add the finite-belt lanes call a function for it.
        return self.instruction_set == "baseline" and platform.machine().lower() in _X86

    def static_starts(self, parameters: Floats, separation: NDArray[np.bool_]) -> Floats:
        """The states at rest at the equilibria of μ = 0, shape (n, 4), infinite where none is."""
        starts = np.empty((len(parameters), 4))
        flags = separation.astype(np.uint8)
        self._functions["static_starts"](
            parameters.ctypes.data, flags.ctypes.data, starts.ctypes.data, len(parameters)
        )
        return starts


def _library() -> Any:
    advice = "install fivtui anew; until then the interpreted kernel runs"
    if not _LIBRARY.is_file():
        why = _REASON.read_text(encoding="utf-8").strip() if _REASON.is_file() else "not installed"
        raise ComputationError(f"the kernel is not compiled: {why}", advice)
    try:
        library = ctypes.CDLL(str(_LIBRARY))
    except OSError as error:
        raise ComputationError(f"the compiled kernel cannot be loaded: {error}", advice) from error
    library.fivtui_instruction_set.restype = ctypes.c_int64
    library.fivtui_sources.restype = library.fivtui_compiler.restype = ctypes.c_char_p
    if library.fivtui_sources().decode() != sources_digest(_FOLDER):
        raise ComputationError("the compiled kernel is of another text than its sources", advice)
    return library


@lru_cache(maxsize=1)
def _loaded() -> Kernel | ComputationError:
    try:
        return Kernel()
    except ComputationError as error:
        return error


def load_kernel() -> Kernel:
    """The kernel for this processor, loaded on first use."""
    kernel = _loaded()
    if isinstance(kernel, ComputationError):
        raise ComputationError(kernel.why, kernel.advice)
    return kernel


def why_interpreted() -> str | None:
    """Why there is no compiled kernel; None where there is one."""
    kernel = _loaded()
    return kernel.why if isinstance(kernel, ComputationError) else None


def stepping_kernel() -> Literal["compiled", "interpreted"]:
    """The kernel that takes steps here: the compiled one, or the interpreted one without it."""
    return "compiled" if why_interpreted() is None else "interpreted"
