"""What a sweep's file says of its making: which sweep it is of, and what computed it."""

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any, Final

from fivtui.model import InputError, Parameters
from fivtui.version import __version__

from .arithmetic import arithmetic_of
from .design import Axis, Design, Range
from .formats import SweepFormat
from .study import Study

FORMAT_VERSION: Final = 1
ARITHMETIC: Final = "arithmetic"
# Packages that decide the last bits of a result.
_PACKAGES: Final = ("numpy", "scipy", "numba", "llvmlite")


def versions(package: str = "") -> dict[str, str]:
    """Versions of what the last bits of a result depend on.

    Parameters
    ----------
    package : str
        One more package.

    Returns
    -------
    dict of str
        Versions by name.
    """
    names = [*_PACKAGES, package] if package else _PACKAGES
    return {"fivtui": __version__, **{name: version(name) for name in names}}


def study_to_dict(study: Study) -> dict[str, Any]:
    """A sweep as data that JSON can hold.

    Parameters
    ----------
    study : Study
        The sweep.

    Returns
    -------
    dict
        Everything that decides its rows.
    """
    design = study.design
    return {
        "parameters": study.parameters.as_dict(),
        "start": study.start if isinstance(study.start, str) else list(study.start),
        "t_end": study.t_end,
        "tol": study.tol,
        "accuracy": dict(study.accuracy),
        "separation": list(study.cases),
        "design": {
            "kind": design.kind,
            "count": design.count,
            "seed": design.seed,
            "axes": [[name, _axis_to_data(axis)] for name, axis in design.axes.items()],
        },
        "outputs": list(study.outputs),
    }


def _axis_to_data(axis: Axis) -> Any:
    if isinstance(axis, Range):
        return {"start": axis.start, "stop": axis.stop, "count": axis.count, "log": axis.log}
    return list(axis)


def study_from_dict(data: Any) -> Study:
    """The sweep that a file or a folder of pieces says it is of, see `study_to_dict`.

    Parameters
    ----------
    data : dict
        What `study_to_dict` gave.

    Returns
    -------
    Study
        The checked sweep.

    Raises
    ------
    InputError
        If the data are of another form, or a value is not allowed.
    """
    try:
        design, start = data["design"], data["start"]
        return Study(
            design=Design(
                {str(name): _axis_from_data(axis) for name, axis in design["axes"]},
                design["kind"],
                design["count"],
                design["seed"] if design["kind"] in ("random", "sobol") else None,
            ),
            parameters=Parameters().with_values(data["parameters"]),
            cases=tuple(bool(case) for case in data["separation"]),
            start="static" if start == "static" else [float(value) for value in start],
            t_end=float(data["t_end"]),
            tol=float(data["tol"]),
            accuracy=tuple(data["accuracy"].items()),
            outputs=tuple(map(str, data["outputs"])),
        )
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError("does not say which sweep it is of") from None


def _axis_from_data(data: Any) -> Axis:
    return Range(**data) if isinstance(data, dict) else tuple(float(value) for value in data)


def described(study: Study, form: SweepFormat) -> dict[str, Any]:
    """What a file of a format says of a sweep: which one it is, and versions.

    Parameters
    ----------
    study : Study
        The sweep.
    form : SweepFormat
        The format.

    Returns
    -------
    dict
        As JSON can hold it.
    """
    return {
        "fivtui_sweep": FORMAT_VERSION,
        "sweep": study_to_dict(study),
        "versions": versions(form.package),
    }


def provenance_of(study: Study, form: SweepFormat) -> dict[str, Any]:
    """What a file that this machine makes says: `described`, and the arithmetic.

    Parameters
    ----------
    study, form
        As in `described`.

    Returns
    -------
    dict
        As JSON can hold it.

    Raises
    ------
    ComputationError
        If the compiled kernel is needed and cannot be loaded.
    """
    return {**described(study, form), ARITHMETIC: arithmetic_of(study)}


def carried_over(said: Mapping[str, Any], form: SweepFormat) -> dict[str, Any]:
    """What a file of another format says of rows that were read from a file.

    Parameters
    ----------
    said : mapping
        What that file said of its making.
    form : SweepFormat
        The format to be written.

    Returns
    -------
    dict
        The same, with the versions that the format names.
    """
    before = said.get("versions", {})
    named = {name: before.get(name, number) for name, number in versions(form.package).items()}
    return {**said, "versions": named}
