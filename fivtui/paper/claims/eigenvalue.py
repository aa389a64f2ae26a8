"""Claims of section 4.2: eigenvalues along the friction coefficient."""

from typing import Final

import numpy as np

from fivtui.equilibrium import growth_rate, stability
from fivtui.model import Parameters, System
from fivtui.paper import FigureData, PaperResults, critical_mu, modes

from .claim import Chapter, Finding, Quantity
from .trends import falls, rises

EIGENVALUES: Final = Chapter()
_BASE: Final = Parameters()
# Frequencies closer than this have merged, rad/s.
_MERGED: Final = 1e-6


def _critical(data: FigureData) -> dict[float, float]:
    # μ_c of the lines of Figs. 3 to 5.
    return {value: float(line["mu_c"][0]) for value, line in data.lines()}


def _named(critical: dict[float, float]) -> tuple[Quantity, ...]:
    names = (f"k_nl = {k_nl:g} N/m³" if k_nl else "linear" for k_nl in critical)
    return tuple(
        Quantity(f"μ_c({name})", mu) for name, mu in zip(names, critical.values(), strict=True)
    )


@EIGENVALUES.claim(
    "4.2, Figs. 3 and 4",
    "The equilibrium is stable below the critical friction coefficient and unstable above it",
    "max Re λ < 0 for μ < μ_c, > 0 for μ > μ_c",
)
def _one_critical_friction(results: PaperResults) -> Finding:
    exceptions, points = 0, 0
    for key in ("3", "4"):
        for _, line in results.table(key).lines():
            growth = np.maximum(line["sigma_1"], line["sigma_2"])
            exceptions += int(np.sum((growth > 0.0) != (line["mu"] > line["mu_c"])))
            points += growth.size
    quantities = (Quantity("points on 8 lines", points), Quantity("exceptions", exceptions))
    return Finding(exceptions == 0, quantities)


@EIGENVALUES.claim(
    "4.2, Figs. 3 and 4",
    "With proportional damping two distinct frequencies merge at the critical friction coefficient",
    "Im λ_1 = Im λ_2 at μ_c",
)
def _frequencies_merge(_: PaperResults) -> Finding:
    before, at = [], []
    for F in (20.0, 100.0):
        for k_nl in (0.0, 50.0, 100.0, 500.0):
            p = _BASE.with_values({"F": F, "k_nl": k_nl})
            critical = critical_mu(p)
            before.append(_gap(p, 0.99 * critical))
            at.append(_gap(p, critical))
    return Finding(
        min(before) > 0.0 and max(at) <= _MERGED,
        (
            Quantity("least gap at 0.99 μ_c", min(before), "rad/s"),
            Quantity("greatest gap at μ_c", max(at), "rad/s"),
        ),
        "they merge less than 1 % below μ_c: from there damping keeps the growth rate negative for "
        "a little more friction",
    )


def _gap(p: Parameters, mu: float) -> float:
    lower, upper = modes(stability(p.with_values({"mu": mu})))
    return abs(upper.imag - lower.imag)


@EIGENVALUES.claim(
    "4.2, Fig. 3", "At F = 20 N the critical friction falls with k_nl", "μ_c falls with k_nl"
)
def _critical_friction_falls_at_small_preload(results: PaperResults) -> Finding:
    critical = _critical(results.table("3"))
    values = np.array([critical[k_nl] for k_nl in (50.0, 100.0, 500.0)])
    return Finding(falls(values), _named(critical))


@EIGENVALUES.claim(
    "4.2, Fig. 3",
    "At F = 20 N the critical friction of the nonlinear systems is below the linear one",
    "μ_c < μ_c(linear)",
)
def _below_linear_at_small_preload(results: PaperResults) -> Finding:
    critical = _critical(results.table("3"))
    return Finding(
        all(mu < critical[0.0] for k_nl, mu in critical.items() if k_nl > 0.0), _named(critical)
    )


@EIGENVALUES.claim(
    "4.2, Fig. 4", "At F = 100 N the critical friction rises with k_nl", "μ_c rises with k_nl"
)
def _critical_friction_rises_at_large_preload(results: PaperResults) -> Finding:
    critical = _critical(results.table("4"))
    values = np.array([critical[k_nl] for k_nl in (50.0, 100.0, 500.0)])
    return Finding(rises(values), _named(critical))


@EIGENVALUES.claim(
    "4.2, Fig. 4",
    "At F = 100 N the strongest nonlinearity is more stable than the linear system",
    "μ_c(500 N/m³) > μ_c(linear)",
)
def _strong_nonlinearity_above_linear(results: PaperResults) -> Finding:
    critical = _critical(results.table("4"))
    return Finding(critical[500.0] > critical[0.0], _named(critical))


@EIGENVALUES.claim(
    "4.2, Fig. 4",
    "At F = 100 N the weaker nonlinearities are less stable than the linear system",
    "μ_c(50 and 100 N/m³) < μ_c(linear)",
)
def _weak_nonlinearities_below_linear(results: PaperResults) -> Finding:
    critical = _critical(results.table("4"))
    return Finding(max(critical[50.0], critical[100.0]) < critical[0.0], _named(critical))


@EIGENVALUES.claim(
    "4.2, Fig. 5",
    "With non-proportional damping the frequencies approach each other but do not coalesce",
    "Im λ_1 ≠ Im λ_2 for c1 = 0.8, c2 = 0.32",
)
def _no_coalescence(results: PaperResults) -> Finding:
    gaps = [line["omega_2"] - line["omega_1"] for _, line in results.table("5").lines()]
    names = ("linear", "50 N/m³", "100 N/m³", "500 N/m³")
    return Finding(
        all(float(gap.min()) > 1e-3 and gap.min() < gap[0] for gap in gaps),
        tuple(
            Quantity(f"least gap ({name})", float(gap.min()), "rad/s")
            for name, gap in zip(names, gaps, strict=True)
        ),
    )


@EIGENVALUES.claim(
    "4.2, Fig. 5",
    "With non-proportional damping too one real part passes zero at the critical friction",
    "max Re λ = 0 at μ_c, > 0 beyond",
)
def _one_real_part_passes_zero(results: PaperResults) -> Finding:
    right = True
    for _, line in results.table("5").lines():
        growth = np.maximum(line["sigma_1"], line["sigma_2"])
        decay = np.minimum(line["sigma_1"], line["sigma_2"])
        right &= bool(np.all((growth > 0.0) == (line["mu"] > line["mu_c"])))
        right &= bool(np.all(decay < 0.0))
    return Finding(right, _named(_critical(results.table("5"))))


@EIGENVALUES.claim(
    "Abstract, 6",
    "A stable linear system becomes unstable with the preload, and stable again at a high level",
    "unstable, then stable with F",
)
def _preload_destabilises_then_stabilises(_: PaperResults) -> Finding:
    return _growth_along("F", (0.0, 60.0, 120.0), "N")


@EIGENVALUES.claim(
    "Abstract, 6",
    "A stable linear system becomes unstable with k_nl, and stable again at a high level",
    "unstable, then stable with k_nl",
)
def _stiffness_destabilises_then_stabilises(_: PaperResults) -> Finding:
    return _growth_along("k_nl", (0.0, 100.0, 500.0), "N/m³")


def _growth_along(name: str, values: tuple[float, float, float], unit: str) -> Finding:
    growth = [growth_rate(System(_BASE.with_values({name: value}))) for value in values]
    before, between, after = growth
    return Finding(
        before < 0.0 < between and after < 0.0,
        tuple(
            Quantity(f"growth rate at {name} = {value:g} {unit}", rate, "1/s")
            for value, rate in zip(values, growth, strict=True)
        ),
        f"μ = {_BASE.mu:g}, the other parameters of the base set",
    )
