"""Loads and calls the kernel in C, which is compiled when fivtui is installed.

The library has each function once for each instruction set, as ``fivtui_NAME_INSTRUCTIONSET``.
"""

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

from .field_text import has_tuned_law, sources_digest
from .lanes import LaneBatch
from .orbits import OrbitSearch
from .runs import MAX_SEEDS, BeltRun, CourseTable, KernelRun, VariedRun
from .sequential import SequentialBatch

Floats = NDArray[np.float64]

_FOLDER: Final = Path(__file__).parent
_LIBRARY: Final = _FOLDER / (
    "libfivtui" + {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
)
# File that the build leaves in place of the library, with the reason why there is none.
_REASON: Final = _FOLDER / "libfivtui.txt"
# `fivtui_instruction_set` returns an index of this tuple.
INSTRUCTION_SETS: Final = ("baseline", "avx2", "avx512")
# Prefixes of functions for one run. They gain nothing from registers wider than those of AVX2.
_SINGLE_RUN_PREFIXES: Final = ("run_", "belt_", "driven_", "vary_", "orbit_")
_X86_MACHINES: Final = ("x86_64", "amd64")
# Environment variable that overrides the best instruction set.
_VARIABLE: Final = "FIVTUI_INSTRUCTION_SET"

# Result and arguments of the functions; the C files describe them.
_int, _float, _pointer = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
_BEGIN_SIGNATURE: Final[tuple[Any, list[Any]]] = (
    None,
    [_pointer, _pointer, _int, _pointer, _float, _float, _int],
)
_ADVANCE_SIGNATURE: Final[tuple[Any, list[Any]]] = (
    _int,
    [
        *(_pointer, _pointer, _int, _pointer, _int, _pointer, _pointer, _pointer, _int, _int),
        _pointer,
    ],
)
_BATCH_CALLS: Final[dict[str, tuple[Any, list[Any]]]] = {
    "size": (_int, []),
    "advance": (_float, [*([_pointer] * 5), _int, _float, _float, _float, *([_int] * 6)]),
    "ended": (_int, [_pointer]),
}
# Prefixes of batch functions: without and with a finite belt speed.
_BATCHES: Final = ("batch", "belts")
_SIGNATURES: Final[dict[str, tuple[Any, list[Any]]]] = {
    "run_size": (_int, []),
    "run_begin": _BEGIN_SIGNATURE,
    "run_advance": _ADVANCE_SIGNATURE,
    "belt_size": (_int, []),
    "belt_begin": _BEGIN_SIGNATURE,
    "belt_advance": _ADVANCE_SIGNATURE,
    "driven_begin": (None, [*_BEGIN_SIGNATURE[1], _int, _pointer, _int, _float]),
    **{f"{name}_{call}": kind for name in _BATCHES for call, kind in _BATCH_CALLS.items()},
    "vary_size": (_int, []),
    "vary_begin": (
        None,
        [_pointer, _pointer, _int, _pointer, _pointer, _int, _float, _float, _int],
    ),
    "vary_sample": (None, [_pointer, _pointer, _int, _pointer]),
    "vary_advance": (_int, [_pointer, _pointer, _int, _int, _pointer, _pointer, _pointer]),
    "orbit_solve": (_int, [*([_pointer] * 5), _int, _pointer]),
    "static_starts": (None, [_pointer, _pointer, _pointer, _int]),
}
_FLOAT_SIZE: Final = ctypes.sizeof(_float)
_pack_state: Final = struct.Struct("4d").pack
_pack_parameters: Final = struct.Struct(f"{len(PARAMETERS)}d").pack
_pack_with_belt: Final = struct.Struct(f"{len(ALL_PARAMETERS)}d").pack


class Kernel:
    """The kernel for one instruction set, by default the best of the processor.

    All instruction sets give the same bits. Raises `ComputationError` if there is no library, if it
    does not match the sources, or if the processor lacks the instruction set.
    """

    def __init__(self, instruction_set: str | None = None) -> None:
        library = _load_library()
        best = library.fivtui_instruction_set()
        allowed = INSTRUCTION_SETS[: best + 1]
        chosen = instruction_set or os.environ.get(_VARIABLE) or allowed[-1]
        if chosen not in allowed:
            raise ComputationError(
                f"instruction set {chosen!r}: this processor has {', '.join(allowed)}",
                f"do not set {_VARIABLE}",
            )
        self.instruction_set = chosen
        self.compiler = str(library.fivtui_compiler().decode())
        functions: dict[str, Any] = {}
        self._functions = functions
        single_run_set = "avx2" if chosen == "avx512" else chosen
        for name, (result, arguments) in _SIGNATURES.items():
            function_set = single_run_set if name.startswith(_SINGLE_RUN_PREFIXES) else chosen
            function = getattr(library, f"fivtui_{name}_{function_set}")
            function.restype, function.argtypes = result, arguments
            functions[name] = function
        # The sizes are in bytes.
        self._run_memory = _float * (functions["run_size"]() // _FLOAT_SIZE)
        self._belt_memory = _float * (functions["belt_size"]() // _FLOAT_SIZE)
        self._varied_size = functions["vary_size"]() // _FLOAT_SIZE

    def begin_run(
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
        table: CourseTable | None = None,
    ) -> KernelRun:
        """Begin a run with a local tolerance and an order of its Taylor series.

        The order is 8, 12, 16 or 20, or 24 where friction depends on the sliding speed. `times` are
        ascending sample times, s; `segments` says whether to return segments. `belt` is v_belt, μ_s
        and v_s of a belt of finite speed, v_s = 0 for constant friction. `table` has the parameters
        over time. With `belt` or `table` the run is a `BeltRun`.
        """
        state = _pack_state(*start)
        if belt is None and table is None:
            memory, packed = self._run_memory(), _pack_parameters(*parameters)
            self._functions["run_begin"](memory, packed, separation, state, t_end, tol, order)
            return KernelRun(self._functions["run_advance"], memory, order, times, segments)
        memory = self._belt_memory()
        packed = _pack_with_belt(*parameters, *(belt or (0.0, 0.0, 0.0)))
        begin_arguments = memory, packed, separation, state, t_end, tol, order
        if table is None:
            self._functions["belt_begin"](*begin_arguments)
        else:
            # The greatest load gives the scale of displacements, to which `tol` is relative.
            rows = table.rows.ctypes.data, len(table.rows)
            has_belt = belt is not None
            self._functions["driven_begin"](*begin_arguments, has_belt, *rows, table.greatest_load)
        run = BeltRun(self._functions["belt_advance"], memory, order, times, segments)
        run.table = table
        return run

    def begin_varied_run(
        self,
        parameters: Floats,
        start: Floats,
        seeds: Floats,
        *,
        separation: bool,
        t_end: float,
        tol: float,
        order: int,
        times: Floats,
    ) -> VariedRun:
        """Begin a run with its derivatives; the motion has the same bits as that of `begin_run`.

        `seeds`, shape (k, 13), are the derivatives of (x, ẋ, y, ẏ) at the start and of the
        parameters by k numbers, at most `MAX_SEEDS`. `times` are ascending sample times, s.
        """
        if not 0 < len(seeds) <= MAX_SEEDS:
            raise ValueError(f"{len(seeds)} seeds: must be 1 to {MAX_SEEDS}")
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
        run = VariedRun(self._functions["vary_advance"], memory, len(seed_rows), times)
        if times.size:
            sampling = times.ctypes.data, times.size, run.samples.ctypes.data
            self._functions["vary_sample"](memory.ctypes.data, *sampling)
        return run

    def orbit_search(self, **arguments: Any) -> OrbitSearch:
        """A search for periodic orbits: see `OrbitSearch`."""
        return OrbitSearch(self._functions["orbit_solve"], self._varied_size, **arguments)

    def begin_batch(
        self, *, observed: tuple[bool, bool, bool], belts: Floats | None = None, **arguments: Any
    ) -> LaneBatch | SequentialBatch:
        """Begin a chunk of a batch, side by side or one by one: see `LaneBatch`.

        The flags `observed` select extremes of y, all extremes, and those of y in the second half.
        """
        # Lanes, in which runs are side by side, have recurrences for the tuned friction law alone.
        if belts is not None and (self._are_belts_slow_in_lanes or not has_tuned_law()):
            # Single runs record all extremes, whatever `observed`.
            return SequentialBatch(self.begin_run, belts=belts, **arguments)
        return LaneBatch(self._functions, observed=observed, belts=belts, **arguments)

    @property
    def _are_belts_slow_in_lanes(self) -> bool:
        # Lanes are runs side by side in vectors. On belts of finite speed they use fused
        # multiply-add, which is a slow function where the processor has no instruction for it.
        return self.instruction_set == "baseline" and platform.machine().lower() in _X86_MACHINES

    def static_starts(self, parameters: Floats, separation: NDArray[np.bool_]) -> Floats:
        """States at rest at the equilibria for μ = 0, shape (n, 4); infinite if there is none."""
        starts = np.empty((len(parameters), 4))
        flags = separation.astype(np.uint8)
        self._functions["static_starts"](
            parameters.ctypes.data, flags.ctypes.data, starts.ctypes.data, len(parameters)
        )
        return starts


def _load_library() -> Any:
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
        raise ComputationError("the compiled kernel does not match its sources", advice)
    return library


@lru_cache(maxsize=1)
def _load_or_error() -> Kernel | ComputationError:
    try:
        return Kernel()
    except ComputationError as error:
        return error


def load_kernel() -> Kernel:
    """The kernel for this processor, loaded on first use."""
    kernel = _load_or_error()
    if isinstance(kernel, ComputationError):
        raise ComputationError(kernel.why, kernel.advice)
    return kernel


def why_interpreted() -> str | None:
    """The reason why runs are interpreted; None if the kernel is compiled."""
    kernel = _load_or_error()
    return kernel.why if isinstance(kernel, ComputationError) else None


def stepping_kernel() -> Literal["compiled", "interpreted"]:
    """Which kernel computes runs here: the compiled one if it is available."""
    return "compiled" if why_interpreted() is None else "interpreted"
