"""The accuracy of a run and the stress tests among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import estimate, report, stress_tests
else:
    from fivtui.lazy import later

    estimate, report, stress_tests = later(__name__, "estimate", "report", "stress_tests")

ACCURACY: Final = StudyKind(
    data="accuracy",
    show=report.print_accuracy,
    to_dict=estimate.accuracy_to_dict,
)

EXTREMES: Final = StudyKind(
    data="stress tests",
    show=report.print_stress_tests,
    to_dict=stress_tests.stress_tests_to_dict,
)
