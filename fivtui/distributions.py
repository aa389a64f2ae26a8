"""Distributions of a named quantity, read from texts such as ``F~normal:80:8``."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from .model import PARAMETERS, InputError, ParameterSpec, check_known, parse_number
from .ranges import number_text

Floats = NDArray[np.float64]

_INPUT_FORM: Final = "NAME~DISTRIBUTION:NUMBER:…"
_EXAMPLE: Final = "F~normal:80:8"
# Number of quantiles from which moments are computed.
_MOMENT_QUANTILES: Final = 1 << 14


@dataclass(frozen=True, slots=True)
class _Family:
    # Names of the numbers, the condition that they must meet, as text and as a function, and the
    # function that makes the frozen distribution of `scipy.stats`.
    number_names: tuple[str, ...]
    condition: str
    meets_condition: Callable[..., bool]
    make_frozen: Callable[..., Any]


def _uniform(low: float, high: float) -> Any:
    from scipy import stats

    return stats.uniform(low, high - low)


def _normal(mean: float, sd: float) -> Any:
    from scipy import stats

    return stats.norm(mean, sd)


def _lognormal(mean: float, sd: float) -> Any:
    from scipy import stats

    log_variance = math.log1p((sd / mean) ** 2)
    return stats.lognorm(math.sqrt(log_variance), scale=mean * math.exp(-0.5 * log_variance))


def _triangular(low: float, mode: float, high: float) -> Any:
    from scipy import stats

    return stats.triang((mode - low) / (high - low), low, high - low)


def _beta(low: float, high: float, a: float, b: float) -> Any:
    from scipy import stats

    return stats.beta(a, b, low, high - low)


FAMILIES: Final[Mapping[str, _Family]] = {
    "uniform": _Family(
        ("LOW", "HIGH"), "LOW must be below HIGH", lambda low, high: low < high, _uniform
    ),
    "normal": _Family(("MEAN", "SD"), "SD must be above 0", lambda _mean, sd: sd > 0.0, _normal),
    "lognormal": _Family(
        ("MEAN", "SD"),
        "MEAN and SD, both of the quantity itself, must be above 0",
        lambda mean, sd: mean > 0.0 and sd > 0.0,
        _lognormal,
    ),
    "triangular": _Family(
        ("LOW", "MODE", "HIGH"),
        "LOW, MODE and HIGH must ascend, and LOW be below HIGH",
        lambda low, mode, high: low <= mode <= high and low < high,
        _triangular,
    ),
    "beta": _Family(
        ("LOW", "HIGH", "A", "B"),
        "LOW must be below HIGH, and A and B above 0",
        lambda low, high, a, b: low < high and a > 0.0 and b > 0.0,
        _beta,
    ),
}


@dataclass(frozen=True, slots=True)
class Distribution:
    """A continuous distribution, maybe truncated.

    Parameters
    ----------
    name : str
        ``uniform`` (low, high), ``normal`` (mean, SD), ``lognormal`` (mean and SD of the quantity
        itself), ``triangular`` (low, mode, high) or ``beta`` (low, high, a, b); or the name of
        another continuous distribution in `scipy.stats`.
    numbers : tuple of float
        The numbers in the order above; for `scipy.stats` the shapes, then loc and scale.
    low, high : float
        Bounds of truncation: the density between them is scaled to an area of 1.

    Raises
    ------
    InputError
        If the name is unknown, the numbers are not allowed, or truncation leaves no values.

    Examples
    --------
    >>> from fivtui import Distribution
    >>> Distribution("normal", (80.0, 8.0)).at([0.5]).tolist()
    [80.0]
    """

    name: str
    numbers: tuple[float, ...]
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", tuple(float(number) for number in self.numbers))
        if not all(math.isfinite(number) for number in self.numbers):
            raise InputError(f"{self}: its numbers must be finite")
        if self.name in FAMILIES:
            family = FAMILIES[self.name]
            if len(self.numbers) != len(family.number_names):
                raise InputError(f"{self}: must be {self.name}:{':'.join(family.number_names)}")
            if not family.meets_condition(*self.numbers):
                raise InputError(f"{self}: {family.condition}")
        else:
            _check_scipy_family(self)
        cdf_low, cdf_high = self._cdf_bounds()
        if not cdf_high > cdf_low:
            raise InputError(f"{self}: must have values from {self.low:g} to {self.high:g}")

    def __str__(self) -> str:
        return ":".join([self.name, *map(number_text, self.numbers)])

    def truncate(self, low: float, high: float) -> Self:
        """A copy that is also truncated at these bounds."""
        return replace(self, low=max(low, self.low), high=min(high, self.high))

    @property
    def truncated_share(self) -> float:
        """The share of values beyond the bounds of truncation, 0 to 1."""
        frozen = _frozen(self.name, self.numbers)
        return float(frozen.cdf(self.low) + frozen.sf(self.high))

    def at(self, shares: Floats | Sequence[float]) -> Floats:
        """Quantiles at `shares`, numbers between 0 and 1; the result has the same shape."""
        cdf_low, cdf_high = self._cdf_bounds()
        probabilities = cdf_low + (cdf_high - cdf_low) * np.asarray(shares, dtype=float)
        values: Floats = np.asarray(_frozen(self.name, self.numbers).ppf(probabilities))
        return np.clip(values, self.low, self.high)

    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation, from 16,384 quantiles."""
        values = self.at((np.arange(_MOMENT_QUANTILES) + 0.5) / _MOMENT_QUANTILES)
        return float(values.mean()), float(values.std())

    def _cdf_bounds(self) -> tuple[float, float]:
        frozen = _frozen(self.name, self.numbers)
        return float(frozen.cdf(self.low)), float(frozen.cdf(self.high))


@lru_cache(maxsize=64)
def _frozen(name: str, numbers: tuple[float, ...]) -> Any:
    if name in FAMILIES:
        return FAMILIES[name].make_frozen(*numbers)
    from scipy import stats

    return getattr(stats, name)(*numbers)


def _check_scipy_family(distribution: Distribution) -> None:
    from scipy import stats

    family = getattr(stats, distribution.name, None)
    if not isinstance(family, stats.rv_continuous):
        raise InputError(
            f"unknown distribution {distribution.name!r}: must be {', '.join(FAMILIES)}, or a "
            "continuous one of scipy.stats"
        )
    shapes = [name.strip() for name in (family.shapes or "").split(",") if name.strip()]
    number_names = [name.upper() for name in (*shapes, "loc", "scale")]
    if not len(shapes) <= len(distribution.numbers) <= len(number_names):
        raise InputError(
            f"{distribution}: must be {distribution.name}:{':'.join(number_names)}; "
            "LOC and SCALE are optional"
        )
    if not math.isfinite(float(family(*distribution.numbers).ppf(0.5))):
        raise InputError(
            f"{distribution}: scipy.stats.{distribution.name} does not allow these numbers"
        )


def parse_distribution(text: str) -> Distribution:
    """The distribution in a text such as ``normal:80:8``; raises `InputError` as `Distribution`."""
    name, *parts = (part.strip() for part in text.split(":"))
    return Distribution(
        name, tuple(parse_number(text, part, "DISTRIBUTION:NUMBER:…") for part in parts)
    )


def truncate_at_bounds(
    name: str, value: object, specs: Mapping[str, ParameterSpec]
) -> Distribution:
    """A distribution, truncated at the bounds of its quantity; `InputError` if it is none."""
    check_known("name", name, specs)
    if not isinstance(value, Distribution):
        raise InputError(f"{name} = {value!r}: must be a distribution, such as normal:80:8")
    try:
        return value.truncate(specs[name].lower, specs[name].upper)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def parse_named_distribution(
    flag: str, text: str, specs: Mapping[str, ParameterSpec] = PARAMETERS
) -> tuple[str, Distribution]:
    """The name and the distribution in a text such as ``F~normal:80:8``; messages name `flag`."""
    name, tilde, distribution = (part.strip() for part in text.partition("~"))
    if not tilde or not name or not distribution:
        raise InputError(f"{flag} {text}: must be {_INPUT_FORM}, e.g. {flag} {_EXAMPLE}")
    check_known("parameter", name, specs)
    return name, parse_distribution(distribution)
