"""Code that runs inside the Python FMUs; it imports only the standard library and pythonfmu."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .actuator_variables import ACTUATOR_SUMMARY, ACTUATOR_TABLE
    from .motion import SliderBeltMotion, start_state
    from .variable import Role, Type, Variable, VariableTable
    from .variables import SLIDER_BELT_TABLE, SUMMARY, VARIABLES
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
