"""Numbers as text; without rich, so that printing a result imports little."""


def number(value: float, digits: int = 6) -> str:
    """A number with a few significant digits."""
    return f"{value:.{digits}g}"
