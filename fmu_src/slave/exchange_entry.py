"""The slave of the FMU for model exchange, where pythonfmu3's wrapper looks for its class."""

from typing import Any

from pythonfmu3 import Fmi3SlaveBase, ModelExchange

from fmu_src.slave.exchange import ExchangeModel


class SliderBelt(ExchangeModel, Fmi3SlaveBase, ModelExchange):  # type: ignore[misc]
    """One instance of the slider-belt model.

    Parameters
    ----------
    **kwargs
        What the wrapper knows of the instance.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
