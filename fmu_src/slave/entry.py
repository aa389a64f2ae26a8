"""The module that pythonfmu's wrapper imports, and executes again for every instance.

The wrapper never frees what an execution creates, so this module defines nothing.
"""

from fmu_src.slave.slider_belt import SliderBeltInstance

__all__ = ["SliderBeltInstance"]

# At every instantiation the wrapper releases a reference to these globals that it does not own:
# add one.
globals().setdefault("_references", []).append(globals())
