"""What the command line prints of accuracy and of stress tests."""

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.text import Text

from fivtui.console import number, print_list, print_rows

from .estimate import Accuracy, believed_digits

if TYPE_CHECKING:
    from .trials import Finding


_FINDING_STYLES: Final = {"right": "", "refused": "dim", "wrong": "bold reverse"}


def print_trials(found: "Mapping[str, Mapping[str, Finding]]") -> None:
    """Print the verdicts on every method at the extremes, and the reasons below.

    Parameters
    ----------
    found : mapping
        What `run_trials` returned.
    """
    from .trials import CONTESTANTS, TRIALS

    contestants = [name for name in CONTESTANTS if any(name in row for row in found.values())]
    rows: list[list[str | Text]] = []
    for name, findings in found.items():
        cells = [
            Text(_finding(findings[key]), style=_FINDING_STYLES[findings[key].verdict])
            for key in contestants
        ]
        rows.append([name, TRIALS[name].meaning, *cells])
    print_rows("Extremes", ("scene", "what is extreme", *contestants), rows, justify="left")
    reasons = [
        (f"{name}, {key}", f"{finding.verdict}: {finding.reason}")
        for name, findings in found.items()
        for key, finding in findings.items()
        if finding.reason
    ]
    print_list("Why", reasons)
    counts = Counter(finding.verdict for row in found.values() for finding in row.values())
    text = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
    Console(stderr=True, highlight=False).print(text)


def _finding(finding: "Finding") -> str:
    return finding.verdict if finding.error is None else f"{finding.verdict} {finding.error:.0e}"


def print_accuracy(found: Accuracy) -> None:
    """Print how far to trust a run.

    Parameters
    ----------
    found : Accuracy
        What `accuracy` returned.
    """
    run, growth = found.run, found.growth
    units = {"x": "m", "vx": "m/s", "y": "m", "vy": "m/s", "separations": "", "separated_time": "s"}
    rows = [
        (
            name,
            believed_digits(entry) if found.parted is None else "none",
            f"{entry.difference:.1e}",
            units.get(name, "m"),
        )
        for name, entry in found.estimates.items()
    ]
    print_rows(
        f"Accuracy of {run.t_end:g} s by {run.method}, held against {found.finer}",
        ("number", "digits to believe", "difference", "unit"),
        rows,
    )
    parted = []
    if found.parted is not None:
        parted = [("the runs part at", f"t = {found.parted.t:.6g} s: {found.parted.reason}")]
    print_list(
        "Growth of a small error",
        [
            *parted,
            ("over the run", f"at most {growth.greatest:.3g} times, {growth.final:.3g} at the end"),
            (
                "largest Lyapunov exponent",
                f"{number(growth.exponent, 3)} 1/s  (zero within {number(growth.uncertainty, 2)})",
            ),
            ("in the long run it", growth.fate),
        ],
    )
