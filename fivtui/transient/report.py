"""What the command line prints of transients."""

from typing import TYPE_CHECKING

from rich.text import Text

from fivtui.console.printing import number, parameter_line, print_list, print_rows, print_titled

from .result import Transient

if TYPE_CHECKING:
    from fivtui.assessment.estimate import Accuracy
    from fivtui.scene.compare import Comparison
    from fivtui.scene.verified import Verified


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
        ("parameters", parameter_line(result.parameters)),
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
            "half peak-to-peak of y",
            f"{number(result.steady.y_half_range)} m  over the second half of the run"
            f"{error('half_range')}",
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


def print_accuracy(found: "Accuracy") -> None:
    """Print how far to trust a run.

    Parameters
    ----------
    found : Accuracy
        What `accuracy` returned.
    """
    from fivtui.assessment.estimate import believed_digits

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
        "half peak-to-peak, 2nd half m",
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
