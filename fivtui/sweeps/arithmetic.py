"""Digests that identify the floating-point arithmetic behind the last bits of rows.

A member of a sweep is one set of parameters and start; it has a row. Rows by the compiled kernel
have the same bits on every machine, rows by the interpreted kernel have other bits. The digest of
the rows of a fixed set of trial members identifies the arithmetic.
"""

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Final

import numpy as np

from fivtui.kernel import stepping_kernel
from fivtui.model import Parameters

from .design import Design, Range
from .rows import compute_rows
from .scatter import Scatter
from .study import (
    CRITICAL_MU_COLUMN,
    SAFE_MU_COLUMN,
    STABILITY_COLUMNS,
    STICK_COLUMNS,
    TRANSIENT_COLUMNS,
    Study,
)

_DIGEST_DIGITS: Final = 32
_TRANSIENT_OUTPUTS: Final = tuple(column.name for column in TRANSIENT_COLUMNS)
_RUN_OUTPUTS: Final = tuple(column.name for column in (*TRANSIENT_COLUMNS, *STICK_COLUMNS))
_STABILITY_OUTPUTS: Final = tuple(column.name for column in STABILITY_COLUMNS)
# Different code computes the extremes of all quantities and those of y alone.
_TRIAL_OUTPUTS: Final[Mapping[str, tuple[tuple[str, ...], ...]]] = {
    "transients": (_TRANSIENT_OUTPUTS, ("y_abs",)),
    "stability": (_STABILITY_OUTPUTS,),
    "critical": ((CRITICAL_MU_COLUMN.name,),),
}
# Trial members for safe μ, the least μ on a branch of limit cycles: its last bits depend on the
# linear algebra library.
_BRANCH_DESIGN: Final = Design({"F": (50.0, 80.0)})
# Number of points of a scattered design that enter the digest.
_SCATTERED_POINTS: Final = 256
# With separation considered and ignored.
_BOTH_CASES: Final = (True, False)
_PRELOADS: Final = Range(10.0, 120.0)
_FRICTION_COEFFICIENTS: Final = Range(0.1, 1.5, log=True)
_CUBIC_STIFFNESSES: Final = Range(1.0, 500.0, log=True)
_VARIED: Final = {"F": _PRELOADS, "mu": _FRICTION_COEFFICIENTS}
# Trial members with cubic and with linear contact.
_TRIAL_DESIGNS: Final = (
    Design({**_VARIED, "k_nl": _CUBIC_STIFFNESSES}, "sobol", count=32),
    Design(_VARIED, "sobol", count=16),
)
_LINEAR_PARAMETERS: Final = Parameters(k_nl=0.0)
# Horizon of the trial members, s.
_T_END: Final = 20.0
# Kernel of files without the key "kernel": versions before that key had only this one.
_KERNEL_BEFORE_KEY: Final = "compiled by numba"


def arithmetic_digests(study: Study) -> dict[str, Any]:
    """Digests of the arithmetic of this machine that a study depends on.

    ``kernel`` names the kernel. ``transients``, ``stability``, ``critical`` and ``safe`` are
    digests of trial rows, ``samples`` is one of the first points of a scattered design. Equal
    digests mean equal rows.
    """
    digests: dict[str, Any] = {}
    has_runs = not set(study.outputs).isdisjoint(_RUN_OUTPUTS)
    if study.accuracy or study.has_vibration or has_runs:
        digests["transients"] = _row_digest("transients")
        digests["kernel"] = stepping_kernel()
    if not set(study.outputs).isdisjoint(_STABILITY_OUTPUTS):
        digests["stability"] = _row_digest("stability")
    if CRITICAL_MU_COLUMN.name in study.outputs:
        digests["critical"] = _row_digest("critical")
    if SAFE_MU_COLUMN.name in study.outputs:
        digests["safe"] = _branch_digest()
    if isinstance(study.design, Scatter):
        # Quantiles of distributions depend on the mathematical library.
        samples = study.design.columns(np.arange(min(_SCATTERED_POINTS, study.design.size)))
        digest = hashlib.sha256(b"".join(values.tobytes() for values in samples.values()))
        digests["samples"] = digest.hexdigest()[:_DIGEST_DIGITS]
    return digests


def arithmetic_difference(stored: object, local: Mapping[str, Any]) -> str:
    """Why rows of `stored` and `local` arithmetic differ in their last bits; empty if equal."""
    if not isinstance(stored, Mapping):
        return "an older fivtui began the sweep and did not record the arithmetic"
    if all(stored.get(key) == value for key, value in local.items()):
        return ""
    if stored.get("kernel") != local.get("kernel"):
        kernel = stored.get("kernel", _KERNEL_BEFORE_KEY)
        return f"the kernel is {kernel} there, {local.get('kernel')} here"
    return "rows of the same trial members differ in their last bits"


@lru_cache
def _branch_digest() -> str:
    study = Study(_BRANCH_DESIGN, Parameters(), outputs=(SAFE_MU_COLUMN.name,))
    rows = compute_rows(study, 0, study.members)
    return hashlib.sha256(rows.numbers[SAFE_MU_COLUMN.name].tobytes()).hexdigest()[:_DIGEST_DIGITS]


@lru_cache
def _row_digest(kind: str) -> str:
    digest = hashlib.sha256()
    for outputs in _TRIAL_OUTPUTS[kind]:
        for design in _TRIAL_DESIGNS:
            parameters = Parameters() if "k_nl" in design.axes else _LINEAR_PARAMETERS
            study = Study(design, parameters, _BOTH_CASES, t_end=_T_END, outputs=outputs)
            rows = compute_rows(study, 0, study.members)
            for values in rows.numbers.values():
                digest.update(values.tobytes())
            # Why members failed.
            digest.update("\n".join(rows.reasons).encode())
    return digest.hexdigest()[:_DIGEST_DIGITS]
