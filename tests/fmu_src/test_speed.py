"""A communication step within a Taylor step computes no new Taylor step."""

from pathlib import Path

import pytest

from fivtui.taylor.stepper import TaylorStepper
from fmu_src.slave.motion import SliderBeltMotion
from fmu_src.slave.slider_belt import SliderBeltInstance
from fmu_src.slave.variables import REFERENCES


def test_steps_without_outputs_only_advance_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = {"advance": 0, "state_at": 0, "move_to": 0}

    def count_calls(owner: type, name: str) -> None:
        original = getattr(owner, name)

        def wrapper(self: object, *args: object, **options: object) -> object:
            counts[name] += 1
            return original(self, *args, **options)

        monkeypatch.setattr(owner, name, wrapper)

    count_calls(TaylorStepper, "advance")
    count_calls(SliderBeltMotion, "state_at")
    count_calls(SliderBeltMotion, "move_to")
    slave = SliderBeltInstance(instance_name="one", resources=str(Path.cwd()), visible=False)
    slave.setup_experiment(0.0, 10.0, 1e-9)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    counts.update(advance=0, state_at=0, move_to=0)
    for step in range(2000):
        assert slave.do_step(step * 1e-3, 1e-3)
    # A period is about a second, and a Taylor step is a large part of it.
    assert counts["advance"] < 100
    # The motion moves only where a communication step passes the end of the Taylor step, and then
    # computes new ones; one further move is allowed.
    assert counts["move_to"] <= counts["advance"] + 1
    assert counts["state_at"] == 0
    (y,) = slave.get_real([REFERENCES["y"]])
    assert y != 0.0
    assert counts["state_at"] == 1
