"""Claims of sections 2 to 4.1: damping, contact, equilibrium points."""

import math
from typing import Final

import numpy as np

from fivtui.equilibrium import stability
from fivtui.model import (
    Mode,
    Parameters,
    System,
    contact_force,
    equilibrium,
    jacobian,
    static_start,
    tangent_stiffness,
)
from fivtui.paper import PaperResults, modes
from fivtui.scene import PRESETS
from fivtui.simulation import simulate
from fivtui.transient import Trajectory, trajectory_of

from .claim import Chapter, Finding, Quantity

EQUILIBRIUM: Final = Chapter()
_BASE: Final = Parameters()
_ROUNDING: Final = 1e-12
# Greatest displacement, m, or force, N, at a located switch.
_NEGLIGIBLE: Final = 1e-9


@EQUILIBRIUM.claim(
    "2", "Equal damping is proportional to mass: without friction both modes decay alike", "c1 = c2"
)
def _proportional_damping(_: PaperResults) -> Finding:
    lower, upper = modes(stability(_BASE.with_values({"mu": 0.0})))
    expected = -_BASE.c1 / (2.0 * _BASE.m)
    return Finding(
        all(math.isclose(mode.real, expected, rel_tol=1e-9) for mode in (lower, upper)),
        (
            Quantity("Re λ_1", lower.real, "1/s"),
            Quantity("Re λ_2", upper.real, "1/s"),
            Quantity("−c1/2m", expected, "1/s"),
        ),
    )


@EQUILIBRIUM.claim(
    "2 and 3, Eqs. 3 and 4",
    "The slider is pressed against the belt exactly while y < 0",
    "P > 0 in contact, y > 0 when separated",
)
def _contact_means_negative_y(_: PaperResults) -> Finding:
    heights = np.linspace(-5.0, 5.0, 2001)
    sets = [_BASE.with_values({"k_nl": k_nl}) for k_nl in (0.0, 20.0, 100.0, 500.0)]
    wrong = sum(
        (contact_force(p, y, Mode.CONTACT) > 0.0) != (y < 0.0) for p in sets for y in heights
    )
    points = Quantity("points", len(sets) * heights.size)
    return Finding(wrong == 0, (points, Quantity("contradictions", int(wrong))))


def _at_reattachments(results: PaperResults) -> Trajectory:
    # The base scene at the end of every separation; the last may last to the end of the run.
    scene = PRESETS["base"]
    run = results.run(scene)
    ends = [end for _, end in run.separated_intervals if end < run.t_end]
    return trajectory_of(simulate(scene.parameters, t_end=scene.t_end, tol=scene.tol, samples=ends))


@EQUILIBRIUM.claim(
    "3", "At reattachment the slider touches the belt without contact force", "P = 0"
)
def _reattachment_without_force(results: PaperResults) -> Finding:
    touching = _at_reattachments(results)
    greatest = float(np.abs(touching.P).max())
    return Finding(
        greatest <= _NEGLIGIBLE,
        (
            Quantity("reattachments of the base scene", touching.t.size),
            Quantity("greatest |P| at them", greatest, "N"),
        ),
    )


@EQUILIBRIUM.claim(
    "3", "At reattachment the mass is back at the original static position", "y = y_static"
)
def _reattachment_at_the_static_position(results: PaperResults) -> Finding:
    rest = static_start(System(_BASE))[2]
    y = _at_reattachments(results).y
    return Finding(
        float(np.abs(y - rest).max()) <= _NEGLIGIBLE,
        (
            Quantity("greatest |y| at reattachment", float(np.abs(y).max()), "m"),
            Quantity("y_static(F = 80 N)", rest, "m"),
        ),
        "the original static position is defined in section 2 as that under the preload; the "
        "condition used, y = 0, is the position of the undeformed contact spring",
    )


@EQUILIBRIUM.claim(
    "4.1, Eq. 6",
    "Of the three equilibrium points one is real, the others are complex conjugates",
    "1 real root",
)
def _one_real_equilibrium(_: PaperResults) -> Finding:
    counts = set()
    gap = 0.0
    for k_nl in (1.0, 50.0, 100.0, 500.0):
        for F in (5.0, 20.0, 50.0, 100.0):
            p = _BASE.with_values({"k_nl": k_nl, "F": F})
            roots = np.roots(_equilibrium_cubic(p))
            real = np.isclose(roots.imag, 0.0, atol=1e-9)
            counts.add(int(real.sum()))
            gap = max(gap, abs(float(roots[real][0].real) - equilibrium(System(p)).y))
    return Finding(
        counts == {1} and gap < 1e-9,
        (
            Quantity("real roots in 16 parameter sets", max(counts)),
            Quantity("largest difference from y_e", gap, "m"),
        ),
    )


def _equilibrium_cubic(p: Parameters) -> tuple[float, float, float, float]:
    # Eq. 6 with x_e eliminated by its first row.
    a, h = p.k1 + 0.5 * p.k3, 0.5 * p.k3
    return (
        p.k_nl + h * p.mu * p.k_nl / a,
        0.0,
        p.k2 + h - h * (h - p.mu * p.k2) / a,
        p.F,
    )


@EQUILIBRIUM.claim(
    "4.1, Fig. 2a", "The equilibrium sinks with increasing preload", "y_e falls with F"
)
def _equilibrium_sinks_with_preload(results: PaperResults) -> Finding:
    lines = list(results.table("2a").lines())
    return Finding(
        all(bool(np.all(np.diff(line["y_e"]) < 0.0)) for _, line in lines),
        tuple(
            Quantity(f"y_e(F = 100 N, k_nl = {k_nl:g} N/m³)", line["y_e"][-1], "m")
            for k_nl, line in lines
        ),
    )


@EQUILIBRIUM.claim(
    "4.1, Fig. 2b",
    "A larger nonlinear stiffness resists the vertical displacement more",
    "|y_e| falls with k_nl",
)
def _stiffness_resists_displacement(results: PaperResults) -> Finding:
    lines = [(F, line) for F, line in results.table("2b").lines() if F > 0.0]
    quantities = []
    for F, line in lines:
        for place in (0, -1):
            name = f"y_e(F = {F:g} N, k_nl = {line['k_nl'][place]:g} N/m³)"
            quantities.append(Quantity(name, line["y_e"][place], "m"))
    return Finding(
        all(bool(np.all(np.diff(np.abs(line["y_e"])) < 0.0)) for _, line in lines),
        tuple(quantities),
    )


@EQUILIBRIUM.claim(
    "4.1, Fig. 2b",
    "Without preload the nonlinear stiffness does not affect the equilibrium",
    "y_e independent of k_nl at F = 0",
)
def _no_preload_no_displacement(results: PaperResults) -> Finding:
    line = results.table("2b").line(0.0)
    change = float(np.ptp(line["y_e"]))
    return Finding(change <= _ROUNDING, (Quantity("change of y_e at F = 0", change, "m"),))


@EQUILIBRIUM.claim(
    "4.2, Eq. 8",
    "The nonlinear stiffness enters the linearised system only because y_e is not zero",
    "no nonlinear term in J for y_e = 0",
)
def _preload_brings_stiffness_into_the_jacobian(_: PaperResults) -> Finding:
    quantities = []
    for F in (0.0, _BASE.F):
        matrices = []
        for k_nl in (0.0, _BASE.k_nl):
            p = _BASE.with_values({"F": F, "k_nl": k_nl})
            matrices.append(np.array(jacobian(p, equilibrium(System(p)).y, Mode.CONTACT)))
        change = float(np.abs(matrices[1] - matrices[0]).max())
        quantities.append(Quantity(f"largest change of J at F = {F:g} N", change, "1/s²"))
    stiffness = tangent_stiffness(_BASE, equilibrium(System(_BASE)).y)
    quantities.append(Quantity(f"k_2 + 3 k_nl y_e² at F = {_BASE.F:g} N", stiffness, "N/m"))
    without, with_preload = quantities[0].value, quantities[1].value
    return Finding(without <= _ROUNDING < with_preload, tuple(quantities))
