"""How kernels are compiled and cached.

Kernels are ordinary modules and the straight-line parts of them are generated from the
recurrences when they are compiled: no generated source is ever written. numba keeps the machine
code on disk beside this package, or in the user's cache folder if that is read-only, and looks at
nothing but the file of the function itself to see whether it is still fresh. A kernel is made of
several files, therefore the name under which it is stored holds a digest of all of them.
"""

import hashlib
import inspect
from collections.abc import Callable
from functools import lru_cache
from types import ModuleType
from typing import Any, Final, TypeVar, cast

import numba
import numba.extending

F = TypeVar("F", bound=Callable[..., Any])

# Contraction lets a product and a sum become one fused operation, rounded once.
_OPTIONS: Final[dict[str, Any]] = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},
}
# Untyped: what it returns is called without the first argument.
intrinsic: Final[Any] = numba.extending.intrinsic
_DIGEST_LENGTH: Final = 16


def inner(function: F) -> F:
    """Compile a function that only kernels call; it becomes part of every kernel that does.

    Parameters
    ----------
    function : callable
        Python that numba can type.

    Returns
    -------
    callable
        The same, compiled on first use.
    """
    return cast("F", numba.njit(**_OPTIONS)(function))


def plain(function: F) -> F:
    """`inner`, but every operation is rounded: the same bits as in Python."""
    return cast("F", numba.njit(**{**_OPTIONS, "fastmath": False})(function))


def part(function: F) -> F:
    """`inner`, and copied to wherever it is called: short, and where time is spent."""
    return cast("F", numba.njit(forceinline=True, **_OPTIONS)(function))


def kernel(signature: Any, *modules: ModuleType) -> Callable[[F], F]:
    """Compile an entry point for its signature, or load it from the cache on disk.

    Parameters
    ----------
    signature : numba signature
        Types of the arguments and of the result.
    *modules : module
        The modules it is made of, beside its own.

    Returns
    -------
    callable
        The decorator. Entering the function releases the interpreter's lock.
    """

    def decorate(function: F) -> F:
        own = inspect.getmodule(function)
        sources = [_source(module) for module in (own, *modules) if module is not None]
        digest = hashlib.sha256("\0".join(sources).encode()).hexdigest()[:_DIGEST_LENGTH]
        function.__qualname__ = f"{function.__qualname__}_{digest}"
        return cast("F", numba.njit(signature, cache=True, **_OPTIONS)(function))

    return decorate


@lru_cache
def _source(module: ModuleType) -> str:
    return inspect.getsource(module)
