"""Drives an FMU with the standard library alone.

``python -I -S fmu_bare_host.py FOLDER GUID Y F STEPS`` has no site-packages: NumPy, fivtui,
pythonfmu and fmpy cannot be imported. FOLDER holds the extracted FMU; Y and F are value references
of y and of the preload. Prints y after ten steps, and the resident memory of the process in kB ten
times during STEPS further steps.
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
    library: ctypes.CDLL,
    instance: ctypes.c_void_p,
    t_start: float,
    y_reference: ctypes.c_uint,
    preload_reference: ctypes.c_uint,
    steps: int,
) -> Iterator[int]:
    value, step_size = ctypes.c_double(), ctypes.c_double(_SHORT_STEP_S)
    reading_interval = steps // 10
    for index in range(steps):
        # Changes of the preload, and outputs that are read, must not take memory either.
        if index % 100 == 0:
            value.value = 80.0 + index % 7
            status = library.fmi2SetReal(
                instance, ctypes.byref(preload_reference), 1, ctypes.byref(value)
            )
            assert status == 0
        t = ctypes.c_double(t_start + index * _SHORT_STEP_S)
        assert library.fmi2DoStep(instance, t, step_size, 1) == 0
        if index % 10 == 0:
            library.fmi2GetReal(instance, ctypes.byref(y_reference), 1, ctypes.byref(value))
        if (index + 1) % reading_interval == 0:
            yield _resident_kb()


# Lengths of the first ten steps and of the further ones, s.
_FIRST_STEP_S = 0.5
_SHORT_STEP_S = 1e-3


def main() -> None:
    """Run the FMU."""
    _, folder_name, guid, y_number, preload_number, step_count = sys.argv
    folder = Path(folder_name)
    y_reference, preload_reference = (
        ctypes.c_uint(int(number)) for number in (y_number, preload_number)
    )
    library = ctypes.CDLL(str(folder / "binaries" / "linux64" / "SliderBelt.so"))
    library.fmi2Instantiate.restype = ctypes.c_void_p
    callbacks = _Callbacks(None, _ALLOCATE(_LIBC.calloc), _FREE(_LIBC.free), None, None)
    uri = (folder / "resources").as_uri().encode()
    instance = ctypes.c_void_p(
        library.fmi2Instantiate(b"bare", 1, guid.encode(), uri, ctypes.byref(callbacks), 0, 0)
    )
    zero = ctypes.c_double(0.0)
    assert library.fmi2SetupExperiment(instance, 0, zero, zero, 0, zero) == 0
    assert library.fmi2EnterInitializationMode(instance) == 0
    assert library.fmi2ExitInitializationMode(instance) == 0
    step_size = ctypes.c_double(_FIRST_STEP_S)
    for index in range(10):
        t = ctypes.c_double(index * _FIRST_STEP_S)
        assert library.fmi2DoStep(instance, t, step_size, 1) == 0
    y = ctypes.c_double()
    assert library.fmi2GetReal(instance, ctypes.byref(y_reference), 1, ctypes.byref(y)) == 0
    print(y.value.hex())
    memory = _memory_during_steps(
        library, instance, 10 * _FIRST_STEP_S, y_reference, preload_reference, int(step_count)
    )
    print(*memory)
    library.fmi2Terminate(instance)
    library.fmi2FreeInstance(instance)
    assert not any(importlib.util.find_spec(name) for name in ("numpy", "fmpy", "fivtui"))


if __name__ == "__main__":
    main()
