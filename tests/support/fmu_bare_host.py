"""Drives an FMU with the standard library alone: ``python -I -S fmu_bare_host.py FOLDER GUID``.

Without site-packages: NumPy, fivtui, pythonfmu and fmpy cannot be imported. Prints y after ten
steps, and the resident memory of the process in kB during further steps.
"""

import ctypes
import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

_ALLOCATE = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)
_FREE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_LIBC = ctypes.CDLL(None)
_LIBC.calloc.restype, _LIBC.calloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t] * 2
_LIBC.free.argtypes = [ctypes.c_void_p]


class _Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", ctypes.c_void_p),
        ("allocate", _ALLOCATE),
        ("free", _FREE),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    )


def _resident_kb() -> int:
    status = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def _memory_during_steps(
    library: ctypes.CDLL, instance: ctypes.c_void_p, t: float, steps: int
) -> Iterator[int]:
    reference, value = ctypes.c_uint(int(sys.argv[3])), ctypes.c_double()
    force = ctypes.c_uint(int(sys.argv[4]))
    start_time = t
    for step_index in range(steps):
        if step_index % 100 == 0:
            value.value = 80.0 + step_index % 7
            assert library.fmi2SetReal(instance, ctypes.byref(force), 1, ctypes.byref(value)) == 0
        assert (
            library.fmi2DoStep(
                instance, ctypes.c_double(start_time + step_index * 1e-3), _STEP_S, 1
            )
            == 0
        )
        if step_index % 10 == 0:
            library.fmi2GetReal(instance, ctypes.byref(reference), 1, ctypes.byref(value))
        if step_index % (steps // 10) == steps // 10 - 1:
            yield _resident_kb()


_STEP_S = ctypes.c_double(1e-3)


def main() -> None:
    """Run the FMU."""
    folder = Path(sys.argv[1])
    library = ctypes.CDLL(str(folder / "binaries" / "linux64" / "SliderBelt.so"))
    library.fmi2Instantiate.restype = ctypes.c_void_p
    callbacks = _Callbacks(None, _ALLOCATE(_LIBC.calloc), _FREE(_LIBC.free), None, None)
    uri = (folder / "resources").as_uri().encode()
    instance = ctypes.c_void_p(
        library.fmi2Instantiate(
            b"bare", 1, sys.argv[2].encode(), uri, ctypes.byref(callbacks), 0, 0
        )
    )
    zero = ctypes.c_double(0.0)
    assert library.fmi2SetupExperiment(instance, 0, zero, zero, 0, zero) == 0
    assert library.fmi2EnterInitializationMode(instance) == 0
    assert library.fmi2ExitInitializationMode(instance) == 0
    step_size = ctypes.c_double(0.5)
    for step_index in range(10):
        assert library.fmi2DoStep(instance, ctypes.c_double(step_index * 0.5), step_size, 1) == 0
    reference, y = ctypes.c_uint(int(sys.argv[3])), ctypes.c_double()
    assert library.fmi2GetReal(instance, ctypes.byref(reference), 1, ctypes.byref(y)) == 0
    print(y.value.hex())
    print(*_memory_during_steps(library, instance, 5.0, int(sys.argv[5])))
    library.fmi2Terminate(instance)
    library.fmi2FreeInstance(instance)
    assert not any(importlib.util.find_spec(name) for name in ("numpy", "fmpy", "fivtui"))


if __name__ == "__main__":
    main()
