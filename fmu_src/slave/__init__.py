"""The FMU's code, as hosts call it. Imports the standard library and pythonfmu alone."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .actuator_variables import (
        ACTUATOR_SUMMARY as ACTUATOR_SUMMARY,
        ACTUATOR_TABLE as ACTUATOR_TABLE,
    )
    from .motion import SliderBeltMotion as SliderBeltMotion, start_state as start_state
    from .variable import (
        Role as Role,
        Type as Type,
        Variable as Variable,
        VariableTable as VariableTable,
    )
    from .variables import (
        SLIDER_BELT_TABLE as SLIDER_BELT_TABLE,
        STATES as STATES,
        SUMMARY as SUMMARY,
        VARIABLES as VARIABLES,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
