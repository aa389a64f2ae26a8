"""Console output of verdicts and maps of safe friction."""

from fivtui.console import print_list

from .verdict import SafeFriction
from .words import basis_rows, coexistence_here, safety_words


def print_safe_friction(found: SafeFriction) -> None:
    """Print a verdict, and what each of its statements rests on."""
    here = coexistence_here(found)
    rows = [("verdict", safety_words(found)), *basis_rows(found)]
    if here:
        rows.insert(1, (f"at μ = {found.parameters.mu:.4g}", here))
    print_list("Disturbances of any size", rows)
