"""Console output of verdicts and maps of safe friction."""

import numpy as np

from fivtui.console import number, print_list
from fivtui.model import PARAMETERS

from .map import REGIONS, SafetyMap, basis_words
from .verdict import SafeFriction
from .words import basis_rows, coexistence_here, safety_words


def print_safe_friction(found: SafeFriction) -> None:
    """Print a verdict, and what each of its statements rests on."""
    here = coexistence_here(found)
    rows = [("verdict", safety_words(found)), *basis_rows(found)]
    if here:
        rows.insert(1, (f"at μ = {found.parameters.mu:.4g}", here))
    print_list("Disturbances of any size", rows)


def print_safety_map(result: SafetyMap) -> None:
    """Print a map's size, its range of values and the share of each region."""
    rows = [
        (name, f"{number(axis[0])} to {number(axis[-1])} {PARAMETERS[name].unit}, {axis.size}")
        for name, axis in zip(result.names, result.axes, strict=True)
    ]
    rows.append(("safe μ", _span(result.safe_mu)))
    if result.escape is None:
        lower = np.count_nonzero(result.safe_mu < result.critical_mu)
        rows.append(("below the critical μ", f"{lower / result.safe_mu.size:.1%} of the points"))
    else:
        regions = result.regions
        rows += [
            (region, f"{np.count_nonzero(regions == place) / regions.size:.1%} of the points")
            for place, region in enumerate(REGIONS)
        ]
        rows.append(("offset from rest that escapes", f"{_span(result.escape)} m"))
    rows.append(("safe μ rests on", basis_words(result)))
    print_list("Map of safe friction", rows)


def _span(values: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> str:
    known = values[~np.isnan(values)]
    return f"{number(known.min())} to {number(known.max())}" if known.size else "none"
