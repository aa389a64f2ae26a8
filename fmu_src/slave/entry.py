"""The module that the FMU's wrapper imports, and executes once more for every instance.

The wrapper keeps what an execution makes: this file makes nothing, the class lives elsewhere.
"""

from fmu_src.slave.slider_belt import SliderBeltInstance

__all__ = ["SliderBeltInstance"]

# The wrapper gives back, at every instantiation, a reference to these globals that it never took.
globals().setdefault("_references", []).append(globals())
