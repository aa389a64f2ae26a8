"""Claims of section 4.2: critical friction along preload and nonlinear stiffness."""

from typing import Final

import numpy as np

from fivtui.equilibrium import growth_rate
from fivtui.model import Parameters, System
from fivtui.paper import FigureData, PaperResults, critical_mu

from .claim import Chapter, Finding, Quantity
from .trends import crossing, falls, falls_then_rises, rises

CRITICAL: Final = Chapter()
_BASE: Final = Parameters()
_CONDITION: Final = {"k_nl": "k_nl = {:g} N/m³", "F": "F = {:g} N"}
_ROUNDING: Final = 1e-9


def _linear(data: FigureData) -> float:
    # The line of k_nl = 0, or of F = 0, is that of the linear system.
    return float(data.line(0.0)["mu_c"][0])


def _nonlinear(data: FigureData) -> list[tuple[float, FigureData]]:
    return [(value, line) for value, line in data.lines() if value > 0.0]


def _exceeds_linear(data: FigureData, value: float, unit: str) -> Finding:
    # Whether a line ends above the linear one, and where that begins.
    linear, line = _linear(data), data.line(value)
    place = crossing(line[line.along], line["mu_c"] - linear)
    ends = tuple(
        Quantity(f"μ_c({_CONDITION[data.by].format(other)}) at the end", each["mu_c"][-1])
        for other, each in _nonlinear(data)
    )
    found = () if place is None else (Quantity(f"exceeds from {line.along}", place, unit),)
    return Finding(place is not None, (Quantity("μ_c(linear)", linear), *ends, *found))


@CRITICAL.claim(
    "4.2, Fig. 6",
    "The preload does not influence the stability of the linear system",
    "μ_c(linear) independent of F",
)
def _preload_leaves_the_linear_system(results: PaperResults) -> Finding:
    line = results.table("6").line(0.0)
    return Finding(
        float(np.ptp(line["mu_c"])) <= _ROUNDING,
        (
            Quantity("μ_c(linear)", line["mu_c"][0]),
            Quantity("change over 0 to 100 N", float(np.ptp(line["mu_c"]))),
        ),
    )


@CRITICAL.claim(
    "4.2, Fig. 6",
    "With increasing preload the nonlinear system is at first less stable than the linear one",
    "μ_c < μ_c(linear) at first",
)
def _preload_destabilises_at_first(results: PaperResults) -> Finding:
    return _first_below_linear(results.table("6"))


@CRITICAL.claim(
    "4.2, Fig. 6",
    "From a preload that depends on k_nl the critical friction rises with the preload",
    "μ_c has a minimum along F",
)
def _preload_stabilises_later(results: PaperResults) -> Finding:
    lines = _nonlinear(results.table("6"))
    least = np.array([line["F"][np.argmin(line["mu_c"])] for _, line in lines])
    return Finding(
        all(falls_then_rises(line["mu_c"]) for _, line in lines) and falls(least),
        tuple(
            Quantity(f"F of least μ_c (k_nl = {k_nl:g} N/m³)", F, "N")
            for (k_nl, _), F in zip(lines, least.tolist(), strict=True)
        ),
    )


@CRITICAL.claim(
    "4.2, Fig. 6",
    "At k_nl = 500 N/m³ the critical friction finally exceeds the linear one in the range shown",
    "μ_c(500 N/m³) > μ_c(linear) at large F",
)
def _preload_stabilises_beyond_linear(results: PaperResults) -> Finding:
    return _exceeds_linear(results.table("6"), 500.0, "N")


@CRITICAL.claim(
    "4.2",
    "Non-proportional damping gives the same trend of the critical friction with the preload",
    "μ_c falls, then rises, at 500 N/m³ beyond the linear one",
)
def _same_trend_with_other_damping(_: PaperResults) -> Finding:
    base = _BASE.with_values({"c1": 0.8})
    loads = np.linspace(0.0, 100.0, 101)
    linear = critical_mu(base.with_values({"k_nl": 0.0}))
    same, quantities = True, [Quantity("μ_c(linear)", linear)]
    for k_nl in (50.0, 200.0, 500.0):
        sets = (base.with_values({"k_nl": k_nl, "F": F}) for F in loads.tolist())
        line = np.array([critical_mu(p) for p in sets])
        same &= falls_then_rises(line) and bool((line[-1] > linear) == (k_nl == 500.0))
        least = float(loads[np.argmin(line)])
        quantities.append(Quantity(f"F of least μ_c (k_nl = {k_nl:g} N/m³)", least, "N"))
        quantities.append(Quantity("μ_c at 100 N", line[-1]))
    return Finding(same, tuple(quantities))


@CRITICAL.claim(
    "4.2, Fig. 7",
    "Without preload the nonlinear stiffness does not influence the stability",
    "μ_c independent of k_nl at F = 0",
)
def _stiffness_needs_preload(results: PaperResults) -> Finding:
    line = results.table("7").line(0.0)
    change = float(np.ptp(line["mu_c"]))
    return Finding(change <= _ROUNDING, (Quantity("change of μ_c at F = 0", change),))


@CRITICAL.claim(
    "4.2, Fig. 7",
    "With preload the nonlinear system at first becomes less stable as k_nl grows",
    "μ_c falls with k_nl at first",
)
def _stiffness_destabilises_at_first(results: PaperResults) -> Finding:
    return _first_below_linear(results.table("7"))


def _first_below_linear(data: FigureData) -> Finding:
    linear = _linear(data)
    holds, quantities = True, [Quantity("μ_c(linear)", linear)]
    for value, line in _nonlinear(data):
        place = int(np.argmin(line["mu_c"]))
        first = line["mu_c"][: place + 1]
        holds &= place > 0 and falls(first) and float(first[1]) < linear
        condition = _CONDITION[data.by].format(value)
        quantities.append(Quantity(f"least μ_c ({condition})", first[-1]))
    return Finding(holds, tuple(quantities))


@CRITICAL.claim(
    "4.2, Fig. 7",
    "At F = 100 N a strong nonlinearity makes the system more stable than the linear one",
    "μ_c(100 N) > μ_c(linear) at large k_nl",
)
def _stiffness_stabilises_at_large_preload(results: PaperResults) -> Finding:
    return _exceeds_linear(results.table("7"), 100.0, "N/m³")


@CRITICAL.claim(
    "4.2, Fig. 7",
    "At F = 5 N the nonlinear system is less stable than the linear one",
    "μ_c(5 N) < μ_c(linear)",
)
def _small_preload_stays_below_linear(results: PaperResults) -> Finding:
    data = results.table("7")
    linear, line = _linear(data), data.line(5.0)
    return Finding(
        bool(np.all(line["mu_c"][1:] < linear)),
        (Quantity("μ_c(linear)", linear), Quantity("μ_c(5 N, 500 N/m³)", line["mu_c"][-1])),
    )


@CRITICAL.claim("4.2", "At μ = 1.2 the linear system is unstable", "μ_c(linear) < 1.2")
def _linear_unstable_at_1_2(_: PaperResults) -> Finding:
    linear = _BASE.with_values({"k_nl": 0.0, "mu": 1.2})
    critical, growth = critical_mu(linear), growth_rate(System(linear))
    return Finding(
        critical < 1.2 and growth > 0.0,
        (Quantity("μ_c(linear)", critical), Quantity("growth rate", growth, "1/s")),
    )


@CRITICAL.claim(
    "4.2",
    "At μ = 1.2 the system is stabilised by F = 100 N and k_nl = 300 N/m³",
    "stable at μ = 1.2",
)
def _stabilised_at_1_2(_: PaperResults) -> Finding:
    from scipy.optimize import brentq

    p = _BASE.with_values({"F": 100.0, "k_nl": 300.0, "mu": 1.2})
    growth = growth_rate(System(p))

    def excess(k_nl: float) -> float:
        return critical_mu(p.with_values({"k_nl": k_nl})) - 1.2

    needed = float(brentq(excess, 100.0, 500.0, xtol=1e-9))
    return Finding(
        growth < 0.0,
        (
            Quantity("μ_c(100 N, 300 N/m³)", critical_mu(p)),
            Quantity("growth rate", growth, "1/s"),
            Quantity("k_nl needed", needed, "N/m³"),
        ),
        "the point misses the boundary by 2 % in k_nl: read off a plot such as Fig. 7, it seems to "
        "lie on it",
    )


@CRITICAL.claim(
    "4.2, Figs. 8 and 9",
    "With k1 = 50 N/m and k2 = 100 N/m the nonlinear system is always more stable than the linear",
    "μ_c > μ_c(linear)",
)
def _soft_horizontal_more_stable(results: PaperResults) -> Finding:
    linear = _linear(results.table("8"))
    lines = [line for key in ("8", "9") for _, line in _nonlinear(results.table(key))]
    # The first point of every line is the linear system.
    least = min(float(line["mu_c"][1:].min()) for line in lines)
    greatest = max(float(line["mu_c"].max()) for line in lines)
    return Finding(
        least > linear,
        (
            Quantity("μ_c(linear)", linear),
            Quantity("least μ_c − μ_c(linear)", least - linear),
            Quantity("greatest μ_c", greatest),
        ),
    )


@CRITICAL.claim(
    "4.2, Figs. 8 and 9",
    "With k1 = 50 N/m and k2 = 100 N/m both F and k_nl stabilise monotonically",
    "μ_c rises with F and with k_nl",
)
def _soft_horizontal_monotonic(results: PaperResults) -> Finding:
    lines = [(key, *pair) for key in ("8", "9") for pair in _nonlinear(results.table(key))]
    return Finding(
        all(rises(line["mu_c"]) for *_, line in lines),
        tuple(
            Quantity(
                f"Fig. {key}, {_CONDITION[line.by].format(value)}: greatest μ_c", line["mu_c"][-1]
            )
            for key, value, line in lines
        ),
    )
