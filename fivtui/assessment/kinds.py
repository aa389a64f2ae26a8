"""Kinds of studies: the accuracy of a run, and the stress tests of the command ``extremes``."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import StudyKind

report, stress_tests = lazy_modules(__name__, "report", "stress_tests")

ACCURACY: Final = StudyKind(contents_name="accuracy", show=report.print_accuracy)

EXTREMES: Final = StudyKind(
    contents_name="stress tests",
    show=report.print_stress_tests,
    to_dict=stress_tests.stress_tests_to_dict,
)
