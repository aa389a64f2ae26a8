"""Fingerprint of the arithmetic that decides the last bits of a row.

Rows by the compiled kernel have the same bits on every machine; the interpreted kernel gives other
bits. The digest of the rows of a fixed set of members identifies the arithmetic.
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
from .study import CRITICAL, SAFE, STABILITY, STICK, TRANSIENT, Study

_DIGITS: Final = 32
_TRANSIENT: Final = tuple(column.name for column in TRANSIENT)
_OF_RUNS: Final = tuple(column.name for column in (*TRANSIENT, *STICK))
_STABILITY: Final = tuple(column.name for column in STABILITY)
# Extremes of all quantities and of y alone are computed by different code.
_TRIED_OUTPUTS: Final[Mapping[str, tuple[tuple[str, ...], ...]]] = {
    "transients": (_TRANSIENT, ("y_abs",)),
    "stability": (_STABILITY,),
    "critical": ((CRITICAL.name,),),
}
# Trial members of branches, whose last bits depend on the linear algebra library.
_BRANCHES: Final = Design({"F": (50.0, 80.0)})
# Number of scattered trial members.
_SAMPLES: Final = 256
_BOTH_CASES: Final = (True, False)
_LOAD: Final = Range(10.0, 120.0)
_FRICTION: Final = Range(0.1, 1.5, log=True)
# The cubic field and the linear one.
_DESIGNS: Final = (
    Design({"F": _LOAD, "mu": _FRICTION, "k_nl": Range(1.0, 500.0, log=True)}, "sobol", 32),
    Design({"F": _LOAD, "mu": _FRICTION}, "sobol", 16),
)
_LINEAR: Final = Parameters(k_nl=0.0)
_T_END: Final = 20.0


def arithmetic_of(study: Study) -> dict[str, Any]:
    """The arithmetic of this machine as far as a study uses it.

    ``kernel`` names the kernel. ``transients``, ``stability`` and ``critical`` are digests of trial
    rows, ``safe`` of branches, ``samples`` of the first scattered values. Equal digests mean equal
    rows.
    """
    digests: dict[str, Any] = {}
    if study.accuracy or not set(study.outputs).isdisjoint(_OF_RUNS):
        digests["transients"] = _digest("transients")
        digests["kernel"] = stepping_kernel()
    if not set(study.outputs).isdisjoint(_STABILITY):
        digests["stability"] = _digest("stability")
    if CRITICAL.name in study.outputs:
        digests["critical"] = _digest("critical")
    if SAFE.name in study.outputs:
        digests["safe"] = _digest_of_branches()
    if isinstance(study.design, Scatter):
        # Quantiles come from a mathematical library.
        first = study.design.columns(np.arange(min(_SAMPLES, study.design.size)))
        content = hashlib.sha256(b"".join(values.tobytes() for values in first.values()))
        digests["samples"] = content.hexdigest()[:_DIGITS]
    return digests


def arithmetic_difference(stored: object, local: Mapping[str, Any]) -> str:
    """Why rows by `stored` arithmetic differ in last bits from `local` rows; empty if not."""
    if not isinstance(stored, Mapping):
        return "an older fivtui began it, which did not record the arithmetic"
    if all(stored.get(key) == value for key, value in local.items()):
        return ""
    if stored.get("kernel") != local.get("kernel"):
        kernel = stored.get("kernel", "of a kernel compiled by numba")
        return f"transients are {kernel} there, {local.get('kernel')} here"
    return "the same members have other last bits there than here"


@lru_cache
def _digest_of_branches() -> str:
    rows = compute_rows(Study(_BRANCHES, Parameters(), outputs=(SAFE.name,)), 0, _BRANCHES.size)
    return hashlib.sha256(rows.numbers[SAFE.name].tobytes()).hexdigest()[:_DIGITS]


@lru_cache
def _digest(kind: str) -> str:
    content = hashlib.sha256()
    for outputs in _TRIED_OUTPUTS[kind]:
        for design in _DESIGNS:
            parameters = Parameters() if "k_nl" in design.axes else _LINEAR
            study = Study(design, parameters, _BOTH_CASES, t_end=_T_END, outputs=outputs)
            rows = compute_rows(study, 0, study.members)
            for values in rows.numbers.values():
                content.update(values.tobytes())
            content.update("\n".join(rows.reasons).encode())
    return content.hexdigest()[:_DIGITS]
