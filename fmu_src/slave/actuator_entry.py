"""The module that the wrapper of the brake actuator's FMU imports; see `entry`."""

from fmu_src.slave.actuator import BrakeActuator

__all__ = ["BrakeActuator"]

# At every instantiation the wrapper releases a reference to these globals that it does not own:
# add one.
globals().setdefault("_references", []).append(globals())
