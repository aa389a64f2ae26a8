"""Stress tests of two methods, on scenes that break solvers: right, refused or wrong.

Run it as ``python examples/extremes.py``, or with the names of scenes, such as ``base lifted``;
``fivtui extremes`` tries every method, in a minute.
"""

import sys

from fivtui.assessment.stress_tests import STRESS_TESTS, run_stress_tests

METHODS = ("taylor", "scipy-lsoda")


def main() -> None:
    """Print verdict and error of the default method and of SciPy's LSODA on the scenes."""
    results_by_scene = run_stress_tests(sys.argv[1:] or tuple(STRESS_TESTS), METHODS)
    for name, results in results_by_scene.items():
        test = STRESS_TESTS[name]
        print(f"{test.meaning}, separation {'considered' if test.separation else 'ignored'}")
        for method, result in results.items():
            error = "" if result.error is None else f"to {result.error:.0e}"
            print(f"    {method:12} {result.verdict:8} {error} {result.reason}")


if __name__ == "__main__":
    main()
