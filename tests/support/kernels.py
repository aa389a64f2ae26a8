"""Simulates an installation without a compiled kernel."""

from unittest import mock

from fivtui.kernel import native
from fivtui.model import ComputationError

WHY = "the kernel is not compiled: there is no compiler here"


def _missing() -> ComputationError:
    return ComputationError(WHY, "install one")


# A context manager and decorator; `.start()` applies it permanently.
INTERPRETED = mock.patch.object(native, "_load_or_error", _missing)
