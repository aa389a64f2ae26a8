"""What the command line prints: tables on standard output, progress on standard error."""

import math
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, TaskID, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar
from rich.table import Table
from rich.text import Text

from .core.outcome import Transient
from .core.parameters import PARAMETERS, Parameters
from .core.stability import Stability
from .map_results import MAP_COLUMNS

if TYPE_CHECKING:
    from .accuracy import Accuracy
    from .compare import Comparison
    from .core.modes import VibrationMode
    from .core.stability_map import StabilityMap
    from .trials import Finding
    from .verified import Verified

# A bar for less than this would only flicker.
_PATIENCE_S: Final = 1.0
_FINDING_STYLES: Final = {"right": "", "refused": "dim", "wrong": "bold reverse"}


class Progress:
    """A progress bar on standard error that appears only when a computation takes over a second.

    Parameters
    ----------
    label : str
        What is being done.
    """

    def __init__(self, label: str) -> None:
        self._label = label
        self._bar: Bar | None = None
        self._task: TaskID | None = None
        self._begin = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, fraction: float) -> bool:
        """Show the fraction done, 0 to 1; always asks to go on."""
        if self._bar is None:
            if time.monotonic() - self._begin < _PATIENCE_S:
                return True
            console = Console(stderr=True)
            columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
            self._bar = Bar(
                *columns, console=console, transient=True, disable=not console.is_terminal
            )
            self._bar.start()
            self._task = self._bar.add_task(self._label, total=1.0)
        if self._task is not None:
            self._bar.update(self._task, completed=fraction, description=self._description())
        return True

    def _description(self) -> str:
        # Batches wait for the compiler where single runs do not.
        from .core.batch import kernels

        return f"{self._label}: compiling, once" if kernels.loading else self._label


def number(value: float, digits: int = 6) -> str:
    """A number for reading: a few significant digits."""
    return f"{value:.{digits}g}"


def print_table(table: Table) -> None:
    """Print a table on standard output."""
    # Without a terminal nothing is wrapped or cut: the reader is a program.
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 200, highlight=False)
    console.print(table)


def print_list(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """Print names and what they stand for.

    Parameters
    ----------
    title : str
        Title of the list.
    rows : sequence of tuple of str
        Name and text of each.
    """
    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in rows:
        table.add_row(name, value)
    print_table(table)


def _parameter_line(p: Parameters) -> str:
    return "  ".join(f"{name}={number(value)}" for name, value in p.as_dict().items())


def print_transient(result: Transient, verified: "Verified | None" = None) -> None:
    """Print extremes, events and final state of a transient.

    Parameters
    ----------
    result : Transient
        Any transient.
    verified : Verified, optional
        What is known of its errors, shown beside the numbers.
    """
    peak, events, final = result.peak, result.events, result.final

    def error(quantity: str, unit: str = "relative") -> str:
        return "" if verified is None else f"  ± {verified.estimate.of(quantity):.1g} {unit}"

    share = events.separated_time / result.t_end
    rows = [
        ("parameters", _parameter_line(result.parameters)),
        ("separation", "considered" if result.separation else "ignored"),
        (
            "method",
            _work(result) + ("" if verified is None else f", verified by {verified.runs} runs"),
        ),
        (
            "peak |y|",
            f"{number(peak.y_abs)} m  (y from {number(peak.y_min)} to {number(peak.y_max)} m)"
            f"{error('peak')}",
        ),
        ("peak |x|", f"{number(peak.x_abs)} m"),
        (
            "steady half range of y",
            f"{number(result.steady.y_half_range)} m  (second half){error('half_range')}",
        ),
        (
            "contact force",
            f"{number(result.contact_force.min)} to {number(result.contact_force.max)} N",
        ),
        (
            "separations",
            f"{events.separations}  (reattachments {events.reattachments})"
            f"{error('events', 's in their times')}",
        ),
        ("time off the belt", f"{number(events.separated_time)} s  ({share:.1%})"),
        ("valid for belt speeds above", f"{number(max(peak.vx_max, 0.0))} m/s"),
        (
            f"final state, t = {number(final.t)} s",
            f"x={final.x:.13g}  vx={final.vx:.13g}  y={final.y:.13g}  vy={final.vy:.13g}"
            f"{error('final')}",
        ),
    ]
    if result.stats.cpu_s is not None:
        rows.append(("CPU time", f"{result.stats.cpu_s:.3g} s"))
    print_list("Transient", rows)


def _work(result: Transient) -> str:
    if result.stats.kernel == "exact":
        return "matrix exponential: the scene is linear"
    return f"{result.method}, {result.stats.steps} steps"


def print_stability(verdict: Stability, p: Parameters) -> None:
    """Print equilibrium, eigenvalues and critical friction coefficients.

    Parameters
    ----------
    verdict : Stability
        Of any parameter set.
    p : Parameters
        That parameter set.
    """
    point = verdict.equilibrium
    rows = [
        ("parameters", _parameter_line(p)),
        (
            "equilibrium",
            f"x={number(point.x)} m  y={number(point.y)} m  P={number(point.P)} N",
        ),
        ("verdict", "stable" if verdict.stable else "unstable"),
        ("growth rate", f"{number(verdict.growth_rate)} 1/s"),
    ]
    rows += [
        ("eigenvalue", f"{number(value.real)} {value.imag:+.6g}i 1/s")
        for value in verdict.eigenvalues.tolist()
    ]
    rows += [
        (
            "mode",
            f"{number(mode.frequency)} Hz  ({number(mode.angular_frequency)} rad/s)  "
            f"damping ratio {number(mode.damping_ratio)}  {_shape(mode)}",
        )
        for mode in verdict.modes
    ]
    rows += [
        ("critical friction coefficient", f"{number(c.mu)}  ({c.becomes} above)")
        for c in verdict.critical_mu
    ] or [("critical friction coefficient", "none")]
    linear = verdict.linear_critical_mu
    rows.append(("  of the linear system", "none" if linear is None else number(linear)))
    left = verdict.margin.mu
    rows.append(("margin in friction coefficient", "none" if left is None else f"{left:+.6g}"))
    near = verdict.coalescence
    meet = "nowhere" if near.mu is None else f"at friction coefficient {number(near.mu)}"
    rows += [
        ("distance of the frequencies", f"{number(near.frequency_distance)} rad/s"),
        ("undamped frequencies coalesce", meet),
    ]
    print_list("Stability", rows)


def _shape(mode: "VibrationMode") -> str:
    # Vertical over horizontal amplitude, and how far y is ahead of x.
    x, y = mode.shape
    if x == 0.0:
        return "vertical motion alone"
    ratio = y / x
    degrees = round(math.degrees(math.atan2(ratio.imag, ratio.real)), 6) + 0.0
    return f"y/x {number(abs(ratio))}, {number(degrees, 4)}°"


def print_map(result: "StabilityMap") -> None:
    """Print what a stability map holds: its size, the range of its values, the stable share.

    Parameters
    ----------
    result : StabilityMap
        Any map.
    """
    values = result.values[~np.isnan(result.values)]
    known = result.excess[~np.isnan(result.excess)]
    rows = [
        (name, f"{number(axis[0])} to {number(axis[-1])} {PARAMETERS[name].unit}, {axis.size}")
        for name, axis in zip(result.names, result.axes, strict=True)
    ]
    column = MAP_COLUMNS[result.value]
    span = f"{number(values.min())} to {number(values.max())} {column.unit}" if values.size else ""
    rows += [
        ("points", str(result.values.size)),
        (column.meaning, span.rstrip() or "none"),
        ("points without value", str(result.values.size - values.size)),
        ("unstable", f"{np.count_nonzero(known > 0.0) / result.values.size:.1%} of the points"),
    ]
    print_list("Stability map", rows)


def print_rows(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table.

    Parameters
    ----------
    title : str
        Its title.
    header : sequence of str
        Column names.
    rows : sequence of sequence of str
        As many texts each; the first column is left-aligned, the others right-aligned.
    """
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for index, name in enumerate(header):
        table.add_column(name, justify="left" if index == 0 else "right", no_wrap=index > 0)
    for row in rows:
        table.add_row(*row)
    print_table(table)


def print_accuracy(found: "Accuracy") -> None:
    """Print how far to trust a run.

    Parameters
    ----------
    found : Accuracy
        What `accuracy` returned.
    """
    from .accuracy import believed_digits

    run, growth = found.run, found.growth
    units = {"x": "m", "vx": "m/s", "y": "m", "vy": "m/s", "separations": "", "separated_time": "s"}
    rows = [
        (name, believed_digits(entry), f"{entry.difference:.1e}", units.get(name, "m"))
        for name, entry in found.estimates.items()
    ]
    print_rows(
        f"Accuracy of {run.t_end:g} s by {run.method}, held against {found.finer}",
        ("number", "digits to believe", "difference", "unit"),
        rows,
    )
    print_list(
        "Growth of a small error",
        [
            ("over the run", f"at most {growth.greatest:.3g} times, {growth.final:.3g} at the end"),
            (
                "largest Lyapunov exponent",
                f"{number(growth.exponent, 3)} 1/s  (zero within {number(growth.uncertainty, 2)})",
            ),
            ("in the long run it", growth.fate),
        ],
    )


def print_trials(found: "Mapping[str, Mapping[str, Finding]]") -> None:
    """Print the verdicts on every method at the extremes, and the reasons below.

    Parameters
    ----------
    found : mapping
        What `run_trials` returned.
    """
    from .trials import CONTESTANTS, TRIALS

    contestants = [name for name in CONTESTANTS if any(name in row for row in found.values())]
    table = Table(title="Extremes", title_justify="left", box=None, pad_edge=False)
    for name in ("scene", "what is extreme", *contestants):
        table.add_column(name)
    for name, findings in found.items():
        cells = [
            Text(_finding(findings[key]), style=_FINDING_STYLES[findings[key].verdict])
            for key in contestants
        ]
        table.add_row(name, TRIALS[name].meaning, *cells)
    print_table(table)
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


def print_comparison(result: "Comparison") -> None:
    """Print the table of the main job: both cases, native and through the FMU.

    Parameters
    ----------
    result : Comparison
        What `compare` returned.
    """
    header = (
        "separation, path",
        "peak |y| m",
        "half range m",
        "separations",
        "off the belt",
        "difference",
        "time s",
    )
    rows = []
    for case, pair in (("considered", result.considered), ("ignored", result.ignored)):
        for path, run, seconds in (
            ("native", pair.native, pair.native_s),
            ("FMU", pair.fmu, pair.fmu_s),
        ):
            rows.append(
                (
                    f"{case}, {path}",
                    number(run.peak.y_abs),
                    number(run.steady.y_half_range),
                    str(run.events.separations),
                    f"{run.events.separated_time / run.t_end:.1%}",
                    f"{pair.difference:.1e}" if run is pair.fmu else "",
                    f"{seconds:.2f}",
                )
            )
    p, t_end = result.considered.native.parameters, result.considered.native.t_end
    print_rows(f"Slider-belt, {t_end:g} s: {_parameter_line(p)}", header, rows)
    text = (
        "difference: greatest of all sampled states between FMU and native, m and m/s; "
        f"the FMU was built in {result.build_s:.2f} s"
    )
    Console(file=sys.stdout, width=None if sys.stdout.isatty() else 200).print(text)
