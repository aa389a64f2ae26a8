"""Scenes that break solvers, and what two methods make of them: right, refused or wrong.

Run it as ``python examples/extremes.py``, or with the names of scenes, such as ``base lifted``;
``fivtui extremes`` tries every method, in a minute.
"""

import sys

from fivtui.assessment.trials import TRIALS, run_trials

METHODS = ("taylor", "scipy-lsoda")


def main() -> None:
    """Print verdict and error of the default method and of SciPy's LSODA on the scenes."""
    found = run_trials(sys.argv[1:] or tuple(TRIALS), METHODS)
    for name, findings in found.items():
        trial = TRIALS[name]
        print(f"{trial.meaning}, separation {'considered' if trial.separation else 'ignored'}")
        for method, finding in findings.items():
            error = "" if finding.error is None else f"to {finding.error:.0e}"
            print(f"    {method:12} {finding.verdict:8} {error} {finding.reason}")


if __name__ == "__main__":
    main()
