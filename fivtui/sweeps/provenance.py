"""Provenance of the file of a sweep: study, versions and arithmetic of the computation.

The arithmetic is a set of digests that are equal on machines with the same last bits of results.
"""

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any, Final

from fivtui.distributions import Distribution
from fivtui.model import InputError, Parameters
from fivtui.results import from_data, to_data
from fivtui.safety import SafeTable
from fivtui.scene import over_time_to_dict, parse_over_time
from fivtui.version import __version__

from .arithmetic import arithmetic_digests
from .design import Axis, Design, Range
from .formats import SweepFormat
from .scatter import Scatter, StudyDesign
from .study import BATCH_METHOD, Study

FORMAT_VERSION: Final = 1
ARITHMETIC: Final = "arithmetic"
VERSIONS: Final = "versions"
# Key of the scattered names; only files of scattered sweeps have it.
SCATTERED: Final = "scattered"
# Packages that decide the last bits of a result.
_PACKAGES: Final = ("numpy", "scipy")


def versions(package: str = "") -> dict[str, str]:
    """Versions of `package` and of the packages that decide the last bits of results."""
    names = [*_PACKAGES, package] if package else _PACKAGES
    return {"fivtui": __version__, **{name: version(name) for name in names}}


def study_to_dict(study: Study) -> dict[str, Any]:
    """A study as data for JSON: everything that decides its rows."""
    return {
        "parameters": study.parameters.as_dict(),
        "start": study.start if isinstance(study.start, str) else list(study.start),
        "t_end": study.t_end,
        "tol": study.tol,
        "accuracy": dict(study.accuracy),
        "separation": list(study.cases),
        "design": _design_to_data(study.design),
        "outputs": list(study.outputs),
        # The table from which safe μ, the least μ of a stable limit cycle, is interpolated.
        **({} if study.safe is None else {"safe_mu": to_data(study.safe)}),
        **({} if study.method == BATCH_METHOD else {"method": study.method}),
        **({"over_time": over_time_to_dict(study.over_time)} if study.over_time else {}),
    }


def _design_to_data(design: StudyDesign) -> dict[str, Any]:
    data: dict[str, Any] = {"kind": design.kind, "count": design.count, "seed": design.seed}
    if isinstance(design, Scatter):
        # The number of scramblings, and whether the design is for Sobol indices.
        data |= {
            "repeats": design.repeats,
            "indices": design.indices,
            "correlations": [list(correlation) for correlation in design.correlations],
        }
    elif design.starts is not None:
        data["starts"] = design.starts
    return data | {"axes": [[name, _axis_to_data(axis)] for name, axis in design.axes.items()]}


def _design_from_data(data: Any) -> StudyDesign:
    axes = {str(name): _axis_from_data(axis) for name, axis in data["axes"]}
    if "repeats" not in data:
        has_seed = data["kind"] in ("random", "sobol") or "starts" in data
        seed = data["seed"] if has_seed else None
        return Design(axes, data["kind"], data["count"], seed, data.get("starts"))
    return Scatter(
        axes,
        data["kind"],
        count=int(data["count"]),
        seed=int(data["seed"]),
        repeats=int(data["repeats"]),
        indices=bool(data["indices"]),
        correlations=tuple(
            (str(first), str(second), float(value)) for first, second, value in data["correlations"]
        ),
    )


def _axis_to_data(axis: Axis | Distribution) -> Any:
    if isinstance(axis, Distribution):
        return {
            "distribution": axis.name,
            "numbers": list(axis.numbers),
            "low": axis.low,
            "high": axis.high,
        }
    if isinstance(axis, Range):
        return {"start": axis.start, "stop": axis.stop, "count": axis.count, "log": axis.log}
    return list(axis)


def study_from_dict(data: Any) -> Study:
    """Convert data of `study_to_dict` back to a study; `InputError` if that fails."""
    try:
        start = data["start"]
        return Study(
            design=_design_from_data(data["design"]),
            parameters=Parameters().with_values(data["parameters"]),
            cases=tuple(bool(case) for case in data["separation"]),
            start="static" if start == "static" else [float(value) for value in start],
            t_end=float(data["t_end"]),
            tol=float(data["tol"]),
            accuracy=tuple(data["accuracy"].items()),
            outputs=tuple(map(str, data["outputs"])),
            safe=from_data(data["safe_mu"], SafeTable) if "safe_mu" in data else None,
            method=str(data.get("method", BATCH_METHOD)),
            over_time=parse_over_time("over_time", data.get("over_time", {})),
        )
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError("has no complete description of its sweep") from None


def _axis_from_data(data: Any) -> Any:
    if isinstance(data, dict) and "distribution" in data:
        return Distribution(
            data["distribution"], tuple(data["numbers"]), float(data["low"]), float(data["high"])
        )
    return Range(**data) if isinstance(data, dict) else tuple(float(value) for value in data)


def study_header(study: Study, file_format: SweepFormat) -> dict[str, Any]:
    """The provenance without the arithmetic: format version, study and versions."""
    is_scattered = isinstance(study.design, Scatter)
    return {
        "fivtui_sweep": FORMAT_VERSION,
        **({SCATTERED: list(study.design.axes)} if is_scattered else {}),
        "sweep": study_to_dict(study),
        VERSIONS: versions(file_format.table.package),
    }


def make_provenance(study: Study, file_format: SweepFormat) -> dict[str, Any]:
    """The header with this machine's arithmetic; `ComputationError` if no kernel can be loaded."""
    return {**study_header(study, file_format), ARITHMETIC: arithmetic_digests(study)}


def convert_provenance(provenance: Mapping[str, Any], file_format: SweepFormat) -> dict[str, Any]:
    """Convert the provenance read from a file for a file of another format."""
    stored_versions = provenance.get(VERSIONS, {})
    new_versions = {
        name: stored_versions.get(name, number)
        for name, number in versions(file_format.table.package).items()
    }
    return {**provenance, VERSIONS: new_versions}
