"""The module that the wrapper of the brake actuator's FMU imports; see `entry`."""

from fmu_src.slave.actuator import BrakeActuator

__all__ = ["BrakeActuator"]

# For every instance the wrapper executes this module again, and releases one reference too many to
# these globals: each execution adds a reference to make up for it.
globals().setdefault("_references", []).append(globals())
