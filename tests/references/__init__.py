"""Stored high-precision transients (see ``make.py``)."""

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


def _state(texts: list[str]) -> State:
    x, vx, y, vy = map(float, texts)
    return (x, vx, y, vy)


def load() -> dict[str, Reference]:
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


REFERENCES = load()
