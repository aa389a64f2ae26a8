"""The module that the wrapper of the model-exchange FMU imports; it looks for a class here."""

from typing import Any

from pythonfmu3 import Fmi3SlaveBase, ModelExchange

from fmu_src.slave.exchange import ExchangeModel


class SliderBelt(ExchangeModel, Fmi3SlaveBase, ModelExchange):  # type: ignore[misc]
    """One instance of the slider-belt model for model exchange."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
