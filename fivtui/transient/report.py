"""What the command line prints of transients."""

from fivtui.console import number, parameter_line, print_list

from .errors import Deviation
from .result import Transient


def print_transient(result: Transient, errors: Deviation | None = None, runs: int = 0) -> None:
    """Print extremes, events and final state, with their errors as verified by `runs` runs."""
    peak, events, final = result.peak, result.events, result.final

    def error(quantity: str, unit: str = "relative") -> str:
        return "" if errors is None else f"  ± {errors.of(quantity):.1g} {unit}"

    share = events.separated_time / result.t_end
    rows = [
        ("parameters", parameter_line(result.parameters)),
        ("separation", "considered" if result.separation else "ignored"),
        (
            "method",
            _work(result) + ("" if errors is None else f", verified by {runs} runs"),
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
