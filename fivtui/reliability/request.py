"""The request for an uncertainty study, as the study of a scattered sweep."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.distributions import Distribution, parse_distribution, parse_named_distribution
from fivtui.equilibrium import has_finite_speed
from fivtui.model import (
    PARAMETERS,
    InputError,
    Interval,
    OnProgress,
    Parameters,
    System,
)
from fivtui.safety import MAX_FOLDS, safe_table
from fivtui.scene import Scene
from fivtui.sweeps import (
    OUTPUTS as SWEEP_OUTPUTS,
    Correlations,
    Scatter,
    ScatterKind,
    Study,
    scene_study,
)
from fivtui.transient import VARIABLES

DEFAULT_SAMPLES: Final = 1 << 14
# First number of samples of a study that doubles them until the required error is reached.
FIRST_SAMPLES: Final = 1 << 10
DEFAULT_REPEATS: Final = 16
MAX_SAMPLES: Final = 1 << 24
# The output safe μ: the least μ of stable limit cycles on the branch from the Hopf point.
SAFE_MU: Final = "safe_mu"
# Greatest number of members whose branches of limit cycles are followed one by one. The safe μ of
# more members is interpolated in a table.
_MAX_CONTINUED: Final = 64
# Quantile levels of inputs at the ends of a table of safe μ: 1 in 50,000 values is outside.
_TABLE_LEVELS: Final = (1e-5, 1.0 - 1e-5)
# Truncated share of a distribution up to which there is no warning.
_NEGLIGIBLE_SHARE: Final = 1e-9
# Outputs that every study computes, for its probabilities.
STABILITY_OUTPUTS: Final = ("growth_rate", "stable")
DEFAULT_OUTPUTS: Final = ("growth_rate", "critical_mu", "safe_mu", "y_half_range", "P_max")
# Outputs that are numbers, not truth values.
OUTPUTS: Final = tuple(name for name, column in SWEEP_OUTPUTS.items() if column.kind != "truth")
_UNTIL_RANGE: Final = Interval(0.0, 1.0, lower_open=True)


def parse_inputs(texts: Sequence[str]) -> dict[str, Distribution]:
    """Distributions by name from the texts of ``--vary``, ``NAME~DISTRIBUTION:NUMBER:…``."""
    distributions: dict[str, Distribution] = {}
    for text in texts:
        name, distribution = parse_named_distribution("--vary", text, VARIABLES)
        if name in distributions:
            raise InputError(f"--vary {text}: {name} is given twice")
        distributions[name] = distribution
    return distributions


def as_distributions(inputs: Mapping[str, Distribution | str]) -> dict[str, Distribution]:
    """Distributions by name; texts such as ``normal:80:8`` are parsed."""
    return {
        name: parse_distribution(distribution) if isinstance(distribution, str) else distribution
        for name, distribution in inputs.items()
    }


def check_until(value: object) -> float:
    """The required error of probabilities; `InputError` unless above 0 and at most 1."""
    return _UNTIL_RANGE.check("until", value)


def scattered_study(
    scene: Scene,
    inputs: Mapping[str, Distribution],
    *,
    correlations: Correlations | None = None,
    design: ScatterKind = "sobol",
    samples: int = DEFAULT_SAMPLES,
    seed: int = 0,
    repeats: int = DEFAULT_REPEATS,
    indices: bool | None = None,
    outputs: Sequence[str] = DEFAULT_OUTPUTS,
) -> Study:
    """The study of a scene whose quantities follow distributions; arguments as in `uncertainty`.

    `inputs` add to the distributions of the scene, or replace them by name.
    `samples` are rounded up to a power of two in every scrambling. If `indices` is None, indices
    are computed unless inputs are correlated.
    """
    inputs = {**dict(scene.scatter), **inputs}
    if not inputs:
        raise InputError(
            "nothing scatters: give --vary NAME~DISTRIBUTION:…, e.g. --vary F~normal:80:8, or a "
            "scene with a table [scatter]"
        )
    number: object = samples
    if not isinstance(number, int | np.integer) or not 1 <= number <= MAX_SAMPLES:
        raise InputError(f"samples = {samples}: must be a whole number from 1 to {MAX_SAMPLES}")
    for name in outputs:
        if name not in OUTPUTS and name in SWEEP_OUTPUTS:
            raise InputError(f"output {name}: must be a number; probabilities are always computed")
    if has_finite_speed(scene.parameters, inputs):
        outputs = _outputs_on_belt(scene.parameters, outputs, inputs)
    # No parameter may follow a table over time.
    scene.check_constant("an uncertainty study")
    if correlations is None:
        correlations = scene.correlation
    with_indices = not correlations if indices is None else indices
    # In every scrambling a point has one sample, or the samples A and B of Sobol indices.
    samples_per_point = max(repeats, 1) * (2 if with_indices else 1)
    points = math.ceil(samples / samples_per_point)
    scatter = Scatter(
        _truncate_friction(scene.parameters, inputs),
        design,
        # The least power of two that is not below the number of points.
        count=1 << (points - 1).bit_length(),
        seed=seed,
        repeats=repeats,
        indices=with_indices,
        correlations=correlations,
    )
    return scene_study(
        scene,
        scatter,
        outputs=tuple(dict.fromkeys((*STABILITY_OUTPUTS, *outputs))),
    )


def _truncate_friction(
    p: Parameters, inputs: Mapping[str, Distribution]
) -> Mapping[str, Distribution]:
    # If only one of μ and μ_s scatters, truncate its distribution at the value of the other.
    if "mu" in inputs and "mu_s" not in inputs and p.mu_s is not None:
        return {**inputs, "mu": inputs["mu"].truncate(-math.inf, p.mu_s)}
    if "mu_s" in inputs and "mu" not in inputs:
        return {**inputs, "mu_s": inputs["mu_s"].truncate(p.mu, math.inf)}
    return inputs


def _outputs_on_belt(
    p: Parameters, outputs: Sequence[str], inputs: Collection[str]
) -> tuple[str, ...]:
    # Leave out defaults. Safe μ requires a belt that is always faster than the slider. The critical
    # μ costs more than a transient if friction falls with the sliding speed, over the speed `v_s`.
    if tuple(outputs) == DEFAULT_OUTPUTS:
        has_friction_law = p.v_s is not None or "v_s" in inputs
        dropped = {SAFE_MU, "critical_mu"} if has_friction_law else {SAFE_MU}
        return tuple(name for name in outputs if name not in dropped)
    if SAFE_MU in outputs:
        raise InputError(
            f"output {SAFE_MU}: must be left out on a belt of finite speed; use critical_mu instead"
        )
    return tuple(outputs)


def add_safe_table(study: Study, progress: OnProgress | None = None) -> Study:
    """Add a table of safe μ to a study that outputs it and has enough members.

    Safe μ depends on dimensionless groups such as k2/k1. A table over one group spans the values
    between `_TABLE_LEVELS`, one over several groups is fitted at random draws of the inputs.
    """
    design = study.design
    if SAFE_MU not in study.outputs or study.safe is not None or study.members <= _MAX_CONTINUED:
        return study
    if not isinstance(design, Scatter):
        return study
    names = [name for name in design.axes if name in PARAMETERS and name != "mu"]
    ranges: dict[str, tuple[float, float]] = {}
    for name in names:
        low, high = design.axes[name].at(_TABLE_LEVELS).tolist()
        ranges[name] = low, high
    # A table is computed from at most `MAX_FOLDS` values of safe μ: as many draws, half of them in
    # each of two scramblings, the least number.
    draw_design = replace(design, kind="sobol", count=MAX_FOLDS // 2, repeats=2, indices=False)
    draws = draw_design.columns(np.arange(draw_design.size))
    table = safe_table(
        System(study.parameters, study.cases[0]),
        ranges,
        {name: draws[name] for name in names},
        progress=progress,
    )
    return replace(study, safe=table)


def truncated_distribution_warnings(study: Study) -> list[str]:
    """Warnings about distributions that are truncated at bounds of parameters."""
    warnings = []
    for name, axis in study.design.axes.items():
        if isinstance(axis, Distribution) and axis.truncated_share > _NEGLIGIBLE_SHARE:
            warnings.append(
                f"{name}~{axis}: truncated to {axis.low:g} to {axis.high:g}, which leaves out "
                f"{axis.truncated_share:.2g} of its values"
            )
    return warnings
