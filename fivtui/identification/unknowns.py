"""Unknowns of a fit: parameters and components of the start, each within bounds."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from fivtui.model import (
    ALL_PARAMETERS,
    InputError,
    check_known,
    check_varied_are_used,
    parse_number,
)
from fivtui.scene import Scene
from fivtui.transient import START_SPECS, VARIABLES, resolve_start

# Bounds of a positive value without bounds: its value in the scene divided and multiplied by this.
_DEFAULT_FACTOR: Final = 100.0


@dataclass(frozen=True, slots=True)
class Unknown:
    """A parameter, or a component of the start, with its bounds and its first value.

    A value that is positive throughout is fitted by its logarithm. `record` is the index of the
    file to which an own value belongs; None for a value common to all files.
    """

    name: str
    low: float
    high: float
    value: float
    record: int | None = None

    @property
    def key(self) -> str:
        """Name in results; with the number of the file, from 1, for an own value."""
        return self.name if self.record is None else f"{self.name}.{self.record + 1}"

    @property
    def is_logarithmic(self) -> bool:
        """Whether the logarithm of the value is fitted."""
        return self.low >= 0.0 and self.value > 0.0

    def coordinate(self, value: float) -> float:
        """The number that is fitted: the value, or its logarithm."""
        if not self.is_logarithmic:
            return value
        return math.log(value) if value > 0.0 else -math.inf

    def value_at(self, coordinate: float) -> float:
        """The value for a fitted number."""
        value = math.exp(coordinate) if self.is_logarithmic else coordinate
        return min(max(value, self.low), self.high)


def parse_unknowns(
    scene: Scene, fit: Sequence[str], own: Sequence[str], files: int
) -> list[Unknown]:
    """The unknowns in texts ``NAME`` or ``NAME=LOW:HIGH``; `own` have a value for each file."""
    unknowns: dict[str, Unknown] = {}
    for text, flag in [*((text, "--fit") for text in fit), *((text, "--own") for text in own)]:
        unknown = _parse_unknown(scene, flag, text)
        if unknown.name in unknowns:
            raise InputError(f"{flag} {text}: {unknown.name} is given twice")
        unknowns[unknown.name] = unknown
    if not unknowns:
        raise InputError("--fit NAME: must be given, e.g. --fit mu")
    if own and not files:
        raise InputError(f"--own {own[0]}: must be given with --measured")
    check_varied_are_used(scene.parameters, unknowns)
    own_names = list(unknowns)[len(fit) :]
    return [
        *(unknowns[name] for name in unknowns if name not in own_names),
        *(replace(unknowns[name], record=index) for index in range(files) for name in own_names),
    ]


def _parse_unknown(scene: Scene, flag: str, text: str) -> Unknown:
    name, equals, bounds = (part.strip() for part in text.partition("="))
    check_known("parameter", name, VARIABLES)
    spec, value = VARIABLES[name], _first_value(scene, name)
    if value is None:
        raise InputError(
            f"{flag} {name}: must have a value in the scene, from which the fit begins"
        )
    low, high = spec.lower, spec.upper
    if value != 0.0 and (spec.lower >= 0.0 or name == "v_belt"):
        near, far = sorted((value / _DEFAULT_FACTOR, value * _DEFAULT_FACTOR))
        low, high = max(low, near), min(high, far)
    if equals:
        low_text, colon, high_text = bounds.partition(":")
        if not colon:
            raise InputError(f"{flag} {text}: must be NAME or NAME=LOW:HIGH")
        low, high = (
            spec.check(parse_number(f"{flag} {text}", bound, "NAME=LOW:HIGH"))
            for bound in (low_text, high_text)
        )
        if low >= high:
            raise InputError(f"{flag} {text}: LOW must be below HIGH")
    if not low <= value <= high:
        value = math.sqrt(low * high) if low > 0.0 else 0.5 * (low + high)
    return Unknown(name, low, high, value)


def _first_value(scene: Scene, name: str) -> float | None:
    if name in ALL_PARAMETERS:
        value: float | None = getattr(scene.parameters, name)
        return value
    return resolve_start(scene.system, scene.start)[list(START_SPECS).index(name)]
