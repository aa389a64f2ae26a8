"""The module that the wrapper of the brake actuator's FMU imports; see `entry`."""

from fmu_src.slave.actuator import BrakeActuator

__all__ = ["BrakeActuator"]

# The wrapper gives back, at every instantiation, a reference to these globals that it never took.
globals().setdefault("_references", []).append(globals())
