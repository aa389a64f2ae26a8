"""How far to trust a run: error estimates, Lyapunov exponents, stress tests."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .estimate import accuracy as accuracy, accuracy_to_dict as accuracy_to_dict
    from .report import print_accuracy as print_accuracy, print_stress_tests as print_stress_tests
    from .stress_tests import (
        run_stress_tests as run_stress_tests,
        stress_tests_to_dict as stress_tests_to_dict,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
