"""The accuracy of a run and the stress tests among the studies."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from .estimate import Accuracy
    from .stress_tests import StressResult


def _show_accuracy(result: "Accuracy") -> None:
    from .report import print_accuracy

    print_accuracy(result)


def _accuracy_to_dict(result: "Accuracy") -> Any:
    from .estimate import accuracy_to_dict

    return accuracy_to_dict(result)


ACCURACY: Final = StudyKind(data="accuracy", show=_show_accuracy, to_dict=_accuracy_to_dict)


def _show_extremes(found: "Mapping[str, Mapping[str, StressResult]]") -> None:
    from .report import print_stress_tests

    print_stress_tests(found)


def _extremes_to_dict(found: "Mapping[str, Mapping[str, StressResult]]") -> Any:
    from .stress_tests import stress_tests_to_dict

    return stress_tests_to_dict(found)


EXTREMES: Final = StudyKind(data="stress tests", show=_show_extremes, to_dict=_extremes_to_dict)
