"""Alt and a key is never text, whatever a terminal and Textual make of it."""

from contextlib import suppress
from dataclasses import dataclass
from string import ascii_lowercase, digits
from typing import Any, Final, cast

from textual.events import Key

# What a Mac types with its Option key where the terminal does not take it for Alt.
_OPTION_DIGITS: Final = dict(zip("¡™£¢∞§¶•ªº", "1234567890", strict=True))
_NAMES: Final = {sign: sign for sign in digits + ascii_lowercase} | {
    "-": "minus",
    "=": "equals_sign",
}


@dataclass(frozen=True, slots=True)
class _AltKey:
    # A key as Textual's table wants it.
    value: str


def know_alt_keys() -> None:
    """Let Textual read what terminals send for Alt and a digit as that: it makes symbols of it."""
    # A Textual without this table makes no symbols.
    with suppress(ImportError):
        from textual._ansi_sequences import ANSI_SEQUENCES_KEYS

        known = cast("dict[str, Any]", ANSI_SEQUENCES_KEYS)
        for sign, name in _NAMES.items():
            # Those that are keys already, such as Alt+b for a word back, stay so.
            if isinstance(known.get(f"\x1b{sign}", ""), str):
                known[f"\x1b{sign}"] = (_AltKey(f"alt+{name}"),)


def take_for_alt(key: Key, *, option: bool) -> None:
    """Take the text from a key that is held together with Alt.

    Parameters
    ----------
    key : Key
        The key; it is changed.
    option : bool
        Whether what Option and a digit type on a Mac is Alt and that digit, where nobody wants
        such a sign as text.
    """
    digit = _OPTION_DIGITS.get(key.character or "")
    if option and digit is not None:
        key.key = f"alt+{digit}"
    if "alt" in key.key.split("+")[:-1]:
        key.character = None
