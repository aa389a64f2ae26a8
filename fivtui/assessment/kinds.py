"""Kinds of studies: the accuracy of a run, and the stress tests."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import StudyKind

report, stress_tests = lazy_modules(__name__, "report", "stress_tests")

ACCURACY: Final = StudyKind(data="accuracy", show=report.print_accuracy)

EXTREMES: Final = StudyKind(
    data="stress tests",
    show=report.print_stress_tests,
    to_dict=stress_tests.stress_tests_to_dict,
)
