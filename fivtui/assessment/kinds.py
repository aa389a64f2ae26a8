"""Kinds of studies: the accuracy of a run, and the stress tests."""

from typing import Final

from fivtui.lazy import later
from fivtui.results import StudyKind

report, stress_tests = later(__name__, "report", "stress_tests")

ACCURACY: Final = StudyKind(data="accuracy", show=report.print_accuracy)

EXTREMES: Final = StudyKind(
    data="stress tests",
    show=report.print_stress_tests,
    to_dict=stress_tests.stress_tests_to_dict,
)
