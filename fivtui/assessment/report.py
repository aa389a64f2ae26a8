"""Console output of accuracy and of stress tests."""

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.text import Text

from fivtui.console import number, print_list, print_rows

from .estimate import Accuracy, reliable_digits

if TYPE_CHECKING:
    from .stress_tests import StressResult


_STYLES: Final = {"right": "", "refused": "dim", "wrong": "bold reverse"}
# Units of estimated values that are not in m.
_OTHER_UNITS: Final = {
    "vx": "m/s",
    "vy": "m/s",
    "separations": "",
    "separated_time": "s",
    "sticks": "",
    "stick_time": "s",
}


def print_stress_tests(tests: "Mapping[str, Mapping[str, StressResult]]") -> None:
    """Print the verdict on every method in every test, then the reasons."""
    from .stress_tests import METHODS_UNDER_TEST, STRESS_TESTS

    methods = [name for name in METHODS_UNDER_TEST if any(name in row for row in tests.values())]
    rows: list[list[str | Text]] = []
    for name, results in tests.items():
        cells = [Text(_cell(results[key]), style=_STYLES[results[key].verdict]) for key in methods]
        rows.append([name, STRESS_TESTS[name].meaning, *cells])
    print_rows("Stress tests", ("scene", "what is extreme", *methods), rows, justify="left")
    reasons = [
        (f"{name}, {key}", f"{result.verdict}: {result.reason}")
        for name, results in tests.items()
        for key, result in results.items()
        if result.reason
    ]
    print_list("Why", reasons)
    counts = Counter(result.verdict for row in tests.values() for result in row.values())
    text = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
    Console(stderr=True, highlight=False).print(text)


def _cell(result: "StressResult") -> str:
    return result.verdict if result.error is None else f"{result.verdict} {result.error:.0e}"


def print_accuracy(result: Accuracy) -> None:
    """Print the error estimates of a run."""
    run, growth = result.run, result.growth
    rows = [
        (
            name,
            reliable_digits(estimate) if result.parted is None else "none",
            f"{estimate.difference:.1e}",
            _OTHER_UNITS.get(name, "m"),
        )
        for name, estimate in result.estimates.items()
    ]
    print_rows(
        f"Accuracy of {run.t_end:g} s by {run.method}, compared with {result.finer}",
        ("quantity", "reliable digits", "difference", "unit"),
        rows,
    )
    divergence = result.parted
    divergence_rows = []
    if divergence is not None:
        divergence_rows = [
            ("the runs diverge at", f"t = {divergence.t:.6g} s: {divergence.reason}")
        ]
    print_list(
        "Growth of a small error",
        [
            *divergence_rows,
            ("over the run", f"at most {growth.greatest:.3g} times, {growth.final:.3g} at the end"),
            (
                "largest Lyapunov exponent",
                f"{number(growth.exponent, 3)} 1/s  (resolution {number(growth.uncertainty, 2)})",
            ),
            ("in the long run it", growth.fate),
        ],
    )
