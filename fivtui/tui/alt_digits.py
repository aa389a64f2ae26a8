"""Alt and a digit: what most terminals send for it reaches an app as another character."""

from typing import Final

ALT_DIGITS: Final = dict(zip("¡™£¢∞§¶•ª", "123456789", strict=True))


def keys_of(key: str) -> str:
    """The keys of a binding.

    Parameters
    ----------
    key : str
        ``alt+`` and a digit from 1 to 9.

    Returns
    -------
    str
        The key itself and the character that may come in its place, with a comma between.
    """
    character = next(sign for sign, digit in ALT_DIGITS.items() if digit == key[-1])
    return f"{key},{character}"
