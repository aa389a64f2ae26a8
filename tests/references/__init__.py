"""Stored high-precision transients (see ``make.py`` and ``make_promise.py``)."""

import json
from dataclasses import dataclass
from pathlib import Path

from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State
from fivtui.transient.request import Start


@dataclass(frozen=True)
class Reference:
    """A transient to 25 digits, as doubles."""

    parameters: Parameters
    separation: bool
    start: Start
    t_end: float
    final: State
    peak_y_abs: float
    separations: int
    separated_time: float
    switch_times: list[float]


@dataclass(frozen=True)
class RandomScene:
    """A random scene: final state and peaks to 25 digits, as doubles, and scales of its errors.

    `scales` belong to x, ẋ, y, ẏ; `growth` and `fast_periods` are G and N of
    `docs/explanation/tolerance.md`.
    """

    parameters: Parameters
    separation: bool
    start: State
    t_end: float
    final: State
    peaks: tuple[float, float]
    scales: State
    growth: float
    fast_periods: float


PROMISE_FILE = "promise.json"


def random_scenes() -> list[RandomScene]:
    """All random scenes."""
    text = Path(__file__).with_name(PROMISE_FILE).read_text(encoding="utf-8")
    return [
        RandomScene(**entry | {"parameters": Parameters(**entry["parameters"])})
        for entry in json.loads(text)
    ]


def _state(texts: list[str]) -> State:
    x, vx, y, vy = map(float, texts)
    return (x, vx, y, vy)


def load_references() -> dict[str, Reference]:
    """All references by name."""
    text = Path(__file__).with_name("transients.json").read_text(encoding="utf-8")
    return {
        name: Reference(
            parameters=Parameters(**entry["parameters"]),
            separation=entry["separation"],
            start=entry["start"],
            t_end=entry["t_end"],
            final=_state(entry["final"]),
            peak_y_abs=float(entry["peak_y_abs"]),
            separations=entry["separations"],
            separated_time=float(entry["separated_time"]),
            switch_times=[float(time) for time in entry["switch_times"]],
        )
        for name, entry in json.loads(text).items()
    }


REFERENCES = load_references()
