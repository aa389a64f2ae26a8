"""The module that pythonfmu's wrapper imports, and executes again for every instance.

The wrapper never frees what an execution creates, so the class is defined in another module.
"""

from fmu_src.slave.slider_belt import SliderBeltInstance

__all__ = ["SliderBeltInstance"]

# For every instance the wrapper also releases one reference too many to these globals: each
# execution adds a reference to make up for it.
globals().setdefault("_references", []).append(globals())
