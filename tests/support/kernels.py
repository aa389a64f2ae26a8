"""Simulates an installation without a compiled kernel, or with another compiler."""

from unittest import mock

import hatch_build
from fivtui.kernel import native
from fivtui.model import ComputationError

GCC = hatch_build._Compiler(
    name="gcc",
    command=["gcc"],
    suffix=hatch_build.LIBRARY_SUFFIX,
    is_x86=hatch_build._is_x86(),
)
NO_COMPILER = "the kernel is not compiled: there is no compiler here"


# In place of `_load_or_error`, which returns the kernel or the error.
def _missing_kernel_error() -> ComputationError:
    return ComputationError(NO_COMPILER, "install one")


# Removes the compiled kernel, as context manager or decorator; `.start()` removes it permanently.
INTERPRETED = mock.patch.object(native, "_load_or_error", _missing_kernel_error)
