"""Hypothesis strategies for parameter sets and states."""

from hypothesis import strategies as st

from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State


def magnitudes(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers, log-uniform from 10**low to 10**high."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def wide_parameters(*, damped_and_coupled: bool = False) -> st.SearchStrategy[Parameters]:
    """Parameter sets over many orders of magnitude."""

    def zero_or(positive: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
        return positive if damped_and_coupled else st.one_of(st.just(0.0), positive)

    return st.builds(
        Parameters,
        m=magnitudes(-3.0, 3.0),
        k1=magnitudes(-1.0, 5.0),
        k2=magnitudes(-1.0, 5.0),
        k3=zero_or(magnitudes(-1.0, 5.0)),
        c1=zero_or(magnitudes(-3.0, 2.0)),
        c2=zero_or(magnitudes(-3.0, 2.0)),
        F=st.one_of(st.just(0.0), magnitudes(-3.0, 5.0)),
        k_nl=st.one_of(st.just(0.0), magnitudes(-2.0, 8.0)),
        mu=st.floats(0.0, 5.0),
    )


def moderate(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers from `low` to `high`; magnitudes below 1e-9 become zero."""
    return st.floats(low, high).map(lambda value: value if abs(value) >= 1e-9 else 0.0)


def moderate_parameters() -> st.SearchStrategy[Parameters]:
    """Parameter sets around the base set, for which runs of seconds are cheap."""
    return st.builds(
        Parameters,
        m=st.floats(1.0, 10.0),
        k1=st.floats(20.0, 200.0),
        k2=st.floats(20.0, 200.0),
        k3=st.one_of(st.just(0.0), st.floats(1.0, 150.0)),
        c1=moderate(0.0, 2.0),
        c2=moderate(0.0, 2.0),
        F=moderate(0.0, 150.0),
        k_nl=moderate(0.0, 500.0),
        mu=moderate(0.0, 1.5),
    )


def states(size: float = 2.0) -> st.SearchStrategy[State]:
    """States (x, ẋ, y, ẏ) of moderate size."""
    coordinate = st.floats(-size, size)
    return st.tuples(coordinate, coordinate, coordinate, coordinate)
