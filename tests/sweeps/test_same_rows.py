"""Rows of a sweep have the same bits with every processor and mathematical library."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
from numpy._core import _multiarray_umath  # type: ignore[attr-defined]

from fivtui.equilibrium.arrays import judge_stability
from fivtui.kernel import why_interpreted
from fivtui.model import Parameters
from fivtui.ranges import log_spaced
from fivtui.sweeps.arithmetic import _TRIAL_DESIGNS
from fivtui.sweeps.rows import compute_rows
from fivtui.sweeps.study import STABILITY_COLUMNS, TRANSIENT_COLUMNS, Study
from tests.support.processes import run_python

ROOT = Path(__file__).parents[2]
# Number of random parameter sets.
SETS = 20_000


def digests() -> str:
    """Digests of rows with all outputs, of growth rates, and of logarithmic spacings.

    The rows are of the designs by which the program tells the arithmetic of machines apart.
    """
    contents = []
    for design in _TRIAL_DESIGNS:
        outputs = tuple(column.name for column in (*TRANSIENT_COLUMNS, *STABILITY_COLUMNS))
        study = Study(design, Parameters(), (True, False), t_end=10.0, outputs=outputs)
        rows = compute_rows(study, 0, study.members)
        contents += [values.tobytes() for values in rows.numbers.values()]
    rng = np.random.default_rng(2)
    varied = {"F": rng.uniform(-50.0, 300.0, SETS), "mu": rng.uniform(0.0, 1.5, SETS)}
    varied["k_nl"] = rng.uniform(0.0, 500.0, SETS) * (rng.random(SETS) < 0.9)
    # Dampings are equal, nearly equal or different; modes coalesce for equal ones.
    varied["c1"] = rng.choice([0.32, 0.32 * (1.0 + 1e-9), 0.8, 0.0], SETS)
    growth_rates, *_ = judge_stability(Parameters(), varied, np.ones(SETS, dtype=bool))
    contents.append(growth_rates.tobytes())
    contents.append(log_spaced(0.3, 700.0, rng.random(SETS)).tobytes())
    return " ".join(hashlib.sha256(content).hexdigest()[:16] for content in contents)


def without_extensions() -> dict[str, str]:
    """Environment variables that disable NumPy's and libm's code for newer processors."""
    dispatched = [
        name
        for name in _multiarray_umath.__cpu_dispatch__
        if _multiarray_umath.__cpu_features__.get(name)
    ]
    if not dispatched:
        pytest.skip("NumPy has no faster code for this processor than its baseline")
    return {
        "NPY_DISABLE_CPU_FEATURES": " ".join(dispatched),
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F",
        "OPENBLAS_CORETYPE": "Nehalem",
    }


@pytest.mark.skipif(why_interpreted() is not None, reason="the kernel is not compiled")
def test_rows_do_not_depend_on_the_processor_or_the_mathematical_library() -> None:
    code = f"from {__name__} import digests; print(digests())"
    assert run_python("-c", code, environment=without_extensions()).strip() == digests()
