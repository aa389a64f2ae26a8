"""Console output of the runs of scenes."""

from rich.text import Text

from fivtui.console import number, parameter_line, print_rows, print_titled
from fivtui.transient import print_transient

from .comparison import Comparison
from .run import SceneTransient


def print_run(run: SceneTransient) -> None:
    """Print a transient, with its errors where they were verified."""
    if run.verified is None:
        print_transient(run.transient)
        return
    # If the run and a finer one diverge, the transient ends before: it is verified up to its end.
    until = f", verified up to t = {number(run.transient.t_end)} s" if run.diverges_at else ""
    title = f"Transient{until}"
    print_transient(run.transient, run.verified.estimate, run.verified.runs, title=title)


def print_comparison(result: Comparison) -> None:
    """Print the table of both cases, separation considered and ignored, native and by the FMU."""
    header = (
        "separation, path",
        "peak |y| m",
        "half peak-to-peak (2nd half) m",
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
    print_rows(f"Slider-belt, {t_end:g} s: {parameter_line(p)}", header, rows)
    text = (
        "difference: greatest of all sampled states between FMU and native, m and m/s; "
        f"the FMU was built in {result.build_s:.2f} s"
    )
    print_titled("", Text(text))
