"""The report of a transient: rows of name, value and note.

The command line prints them, the laboratory (the terminal program) displays them.
"""

from operator import attrgetter
from typing import Final

from fivtui.console import number, parameter_line, print_list, print_rows
from fivtui.model import parameter_spec
from fivtui.results import Row

from .derivatives.digits import MAX_DIGITS, FinalDigits, final_digits
from .derivatives.sensitivity import Sensitivities
from .errors import Deviation
from .native import later_amplitude
from .result import Transient

# Quantities of a transient and of its sensitivities: label, unit and attribute.
QUANTITY_ROWS: Final = (
    ("peak |y|", "m", "peak.y_abs"),
    ("greatest y", "m", "peak.y_max"),
    ("least y", "m", "peak.y_min"),
    ("peak |x|", "m", "peak.x_abs"),
    ("max ẋ", "m/s", "peak.vx_max"),
    ("half peak-to-peak of y", "m", "steady.y_half_range"),
    ("least contact force", "N", "contact_force.min"),
    ("greatest contact force", "N", "contact_force.max"),
    ("final x", "m", "final.x"),
    ("final ẋ", "m/s", "final.vx"),
    ("final y", "m", "final.y"),
    ("final ẏ", "m/s", "final.vy"),
)


def transient_rows(
    result: Transient, method_note: str = "", errors: Deviation | None = None
) -> list[Row]:
    """The rows of a report on a transient, with its errors as notes if they are known.

    `method_note` is the note in the row of the method, such as the number of runs that verify it.
    """
    peak, events, force, final = result.peak, result.events, result.contact_force, result.final

    def error_note(quantity: str, default: str = "", unit: str = "relative") -> str:
        return default if errors is None else f"± {errors.of(quantity):.1g} {unit}"

    range_note = "above 0: off the belt" if result.separation else "above 0: contact in tension"
    later = later_amplitude(result)
    unsettled = (
        ""
        if later is None
        else f"; not settled: {number(later.y_half_range)} m {number(later.after)} s later"
    )
    half_range_error = "" if errors is None else f", {error_note('half_range')}"
    separated_share = events.separated_time / result.t_end
    rows = [
        *(
            Row(f"{name} over time", table.describe(name))
            for name, table in result.over_time.items()
        ),
        Row("separation", "considered" if result.separation else "ignored"),
        # An extreme of the solution between its steps too, as accurate as the run.
        Row("peak |y|", f"{number(peak.y_abs)} m", error_note("peak", default="not sampled")),
        Row("range of y", f"{number(peak.y_min)} to {number(peak.y_max)} m", range_note),
        Row("peak |x|", f"{number(peak.x_abs)} m"),
        Row(
            "half peak-to-peak of y",
            f"{number(result.steady.y_half_range)} m",
            f"over the second half of the run{half_range_error}{unsettled}",
        ),
        Row("contact force", f"{number(force.min)} to {number(force.max)} N"),
        Row("separations", str(events.separations), error_note("events", unit="s in their times")),
        Row("reattachments", str(events.reattachments)),
        Row(
            "time off the belt",
            f"{number(events.separated_time)} s",
            f"{separated_share:.1%} of the run",
        ),
    ]
    p = result.parameters
    if p.v_belt is not None:
        stick_share = f"{events.stick_time / result.t_end:.1%} of the run"
        transitions = ", ".join(f"{count} {name}" for name, count in events.transitions.items())
        rows += [
            Row(
                "sticks",
                str(events.sticks),
                f"to a belt of {number(p.v_belt)} m/s" if "v_belt" not in result.over_time else "",
            ),
            Row("time of stick", f"{number(events.stick_time)} s", stick_share),
            Row("transitions", transitions or "none"),
        ]
    rows += _stop_rows(result)
    if events.first is not None and events.last is not None:
        rows += [
            Row("first switch", f"{number(events.first)} s"),
            Row("last switch", f"{number(events.last)} s"),
        ]
    at_end = f"t = {number(final.t)} s"
    digits = final_digits(result)
    digits_note = at_end if digits is None else f"{at_end}, reliable digits only"
    state_note = error_note("final", default=digits_note, unit=f"relative, {at_end}")
    rows += [
        Row(
            "max ẋ",
            f"{number(peak.vx_max)} m/s",
            "valid for faster belts" if p.v_belt is None else "",
        ),
        *_final_rows(result, digits, state_note),
        Row("method", _method_text(result), method_note),
        Row("steps", str(result.stats.steps)),
    ]
    if result.stats.cpu_s is not None:
        rows.append(Row("CPU time", f"{result.stats.cpu_s:.3g} s"))
    return rows


def _stop_rows(result: Transient) -> list[Row]:
    # Rows of squeal, groan and final stick; none if the speed of the belt is constant.
    stop_times = result.stop
    if stop_times is None:
        return []

    def start_text(t: float | None) -> str:
        return "none" if t is None else f"from {number(t)} s"

    groan = start_text(stop_times.groan_begin)
    if stop_times.groan_end is not None:
        groan += f" to {number(stop_times.groan_end)} s"
    return [
        Row("squeal", start_text(stop_times.squeal), "the slider leaves the belt"),
        Row("stick-slip groan", groan, "stick and slip alternate"),
        Row("final stick", start_text(stop_times.final_stick), "until the end"),
    ]


def _final_rows(result: Transient, digits: FinalDigits | None, note: str) -> list[Row]:
    # Rows of the final state, rounded to the reliable digits if these are known.
    digit_counts, final = digits or (MAX_DIGITS,) * 4, result.final
    names, units = ("x", "ẋ", "y", "ẏ"), ("m", "m/s", "m", "m/s")
    notes = (note, "", "", "")
    return [
        Row(
            f"final {name}",
            f"{value:.{max(count, 1)}g} {unit}",
            row_note if count else "no reliable digit",
        )
        for name, value, count, unit, row_note in zip(
            names, final[1:], digit_counts, units, notes, strict=True
        )
    ]


def print_transient(
    result: Transient,
    errors: Deviation | None = None,
    runs: int = 0,
    *,
    title: str = "Transient",
) -> None:
    """Print the report of a transient, with its `errors` if `runs` runs have verified it."""
    verified = "" if errors is None else f"verified by {runs} runs"
    rows = transient_rows(result, verified, errors)
    parameters = parameter_line(result.parameters, without=tuple(result.over_time))
    print_list(title, [Row("parameters", parameters), *rows])
    if result.sensitivities is not None:
        _print_sensitivities(result.sensitivities, result.tol)


def _print_sensitivities(sensitivities: Sensitivities, tol: float) -> None:
    # One row per result, one column per parameter.
    units = [parameter_spec(name).unit for name in sensitivities]
    header = [
        f"{name}, {unit}" if unit else name for name, unit in zip(sensitivities, units, strict=True)
    ]
    rows = [
        [f"{label}, {unit}", *map(number, map(attrgetter(attribute), sensitivities.values()))]
        for label, unit, attribute in QUANTITY_ROWS
    ]
    growth_text = f"small deviations grow {number(sensitivities.growth, 3)} times until the end"
    digits = sensitivities.digits(tol)
    digits_text = f"about {digits} digits are reliable" if digits else "no digit is reliable"
    heading = f"Sensitivities; {growth_text}; {digits_text}"
    print_rows(heading, ["result, by parameter", *header], rows)


def _method_text(result: Transient) -> str:
    exact = result.stats.kernel == "exact"
    return "matrix exponential: the scene is linear" if exact else result.method
