"""Tolerances for the comparison of a run with a measurement."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

from fivtui.model import InputError, parse_number

_BAND_VALUES: Final = "a number above 0, or a percentage such as '5%'"
_FRACTIONS: Final = "a percentage such as '5%', or a fraction above 0 such as 0.05"


class Tolerance(NamedTuple):
    """A limit of a difference: in the unit of the signal, or relative to the computed signal."""

    value: float
    relative: bool = False


@dataclass(frozen=True, slots=True, init=False)
class Tolerances:
    """Criteria of a comparison; None for a criterion that is not applied.

    Texts have the meaning of the command line: ``band="5%"`` is relative, ``band="0.2"`` and
    ``band=0.2`` are in the unit of the signal. `share`, `frequency` and `amplitude` are texts such
    as ``"5%"``, or fractions such as 0.05. Anything else raises `InputError`.

    Attributes
    ----------
    band : Tolerance or None
        Half width of the band around the computed signal: in the unit of the signal, or relative to
        its half peak-to-peak.
    share : float
        Least share of the samples within the band.
    frequency : float or None
        Limit of the relative difference of the frequencies with the largest amplitude.
    amplitude : float or None
        Limit of the relative difference of half peak-to-peak.
    """

    band: Tolerance | None = None
    share: float = 1.0
    frequency: float | None = None
    amplitude: float | None = None

    def __init__(
        self,
        band: Tolerance | str | float | None = None,
        share: str | float = 1.0,
        frequency: str | float | None = None,
        amplitude: str | float | None = None,
    ) -> None:
        values = {
            "band": _check_band(band),
            "share": _check_fraction("share", share),
            "frequency": None if frequency is None else _check_fraction("frequency", frequency),
            "amplitude": None if amplitude is None else _check_fraction("amplitude", amplitude),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if self.share > 1.0:
            raise InputError(f"share = {share}: must be at most 100%, or 1")
        if self.band is None and self.share < 1.0:
            raise InputError("share: must be given with band")


def _check_band(band: object) -> Tolerance | None:
    if band is None:
        return None
    if isinstance(band, str):
        return read_tolerance("band", band)
    value, relative = band if isinstance(band, Tolerance) else (band, False)
    return Tolerance(_check_positive("band", value, _BAND_VALUES), relative)


def _check_fraction(name: str, value: object) -> float:
    if not isinstance(value, str):
        return _check_positive(name, value, _FRACTIONS)
    tolerance = read_tolerance(name, value)
    if not tolerance.relative:
        raise InputError(f"{name} = {value}: must be {_FRACTIONS}")
    return tolerance.value


def _check_positive(name: str, value: object, allowed: str) -> float:
    number = parse_number(name, value, allowed)
    if number <= 0.0:
        raise InputError(f"{name} = {number:g}: must be {allowed}")
    return number


def read_tolerance(name: str, text: str) -> Tolerance:
    """Parse a tolerance such as ``0.2`` or ``5%``; `InputError` if it is not a number above 0."""
    relative = text.rstrip().endswith("%")
    digits = text.rstrip().removesuffix("%") if relative else text
    value = parse_number(name, digits, "a number above 0, or a percentage such as 5%")
    if value <= 0.0:
        raise InputError(f"{name} = {text}: must be above 0")
    return Tolerance(0.01 * value if relative else value, relative)


def read_tolerances(texts: Mapping[str, str | None], prefix: str = "") -> Tolerances:
    """Parse tolerances from texts by name; error messages have `prefix` before the names.

    Raises `InputError` for a text that is not a tolerance, and for a share above 100 % or without a
    band.
    """
    percentages = {}
    for name in ("share", "frequency", "amplitude"):
        text = texts.get(name)
        if text:
            tolerance = read_tolerance(f"{prefix}{name}", text)
            if not tolerance.relative:
                raise InputError(f"{prefix}{name} {text}: must be a percentage such as 5%")
            if name == "share" and tolerance.value > 1.0:
                raise InputError(f"{prefix}share {text}: must be at most 100%")
            percentages[name] = tolerance.value
    band = texts.get("band")
    if "share" in percentages and not band:
        raise InputError(f"{prefix}share: must be given with {prefix}band")
    return Tolerances(read_tolerance(f"{prefix}band", band) if band else None, **percentages)
