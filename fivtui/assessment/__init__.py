"""Accuracy of runs: error estimates, Lyapunov exponents, stress tests of the methods."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .estimate import accuracy
    from .stress_tests import run_stress_tests
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
