"""Alt with a letter or digit as a key, never as text."""

from contextlib import suppress
from dataclasses import dataclass
from string import ascii_lowercase, digits
from typing import Any, Final, cast

from textual.events import Key

# Signs typed with a Mac's Option key if the terminal does not send Alt.
_OPTION_DIGITS: Final = dict(zip("¡™£¢∞§¶•ªº", "1234567890", strict=True))
_NAMES: Final = {sign: sign for sign in digits + ascii_lowercase} | {
    "-": "minus",
    "=": "equals_sign",
}

# Alt+f goes to the fields; the word forward is Ctrl+→, too.
_TAKEN: Final = "f"


@dataclass(frozen=True, slots=True)
class _AltKey:
    # A key in the form of Textual's table.
    value: str


def know_alt_keys() -> None:
    """Make Textual read Alt with a letter or digit as that key; it would insert a symbol."""
    # A Textual without this table makes no symbols.
    with suppress(ImportError):
        from textual._ansi_sequences import ANSI_SEQUENCES_KEYS

        known = cast("dict[str, Any]", ANSI_SEQUENCES_KEYS)
        for sign, name in _NAMES.items():
            # Existing keys, such as Alt+b (word back), stay, but for the one that is a key here.
            if sign in _TAKEN or isinstance(known.get(f"\x1b{sign}", ""), str):
                known[f"\x1b{sign}"] = (_AltKey(f"alt+{name}"),)


def take_for_alt(key: Key, *, option: bool) -> None:
    """Turn a key with Alt into a key without text.

    `option` also takes the signs that Option and a digit type on a Mac as Alt and that digit.
    """
    digit = _OPTION_DIGITS.get(key.character or "")
    if option and digit is not None:
        key.key = f"alt+{digit}"
    if "alt" in key.key.split("+")[:-1]:
        key.character = None
