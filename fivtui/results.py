"""How results present themselves in a session: a few lines, or a table in a notebook."""

from collections.abc import Sequence
from html import escape

from fivtui.model import PARAMETERS, Parameters


class Result:
    """Base of what computations return: it prints in a few lines, whatever it holds.

    A result also has, where they make sense, ``to_dict()``: the object that the command line prints
    with ``--json``; ``to_columns()``: one-dimensional arrays by name, as pandas and polars take
    them; and ``figure()``: a matplotlib figure.
    """

    __slots__ = ()

    def _summary(self) -> Sequence[tuple[str, str]]:
        raise NotImplementedError

    def __repr__(self) -> str:
        rows = self._summary()
        width = max(len(name) for name, _ in rows)
        return "\n".join(
            [type(self).__name__, *(f"  {name:<{width}}  {text}" for name, text in rows)]
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, text in self._summary()
        )
        return f"<table><caption>{type(self).__name__}</caption><tbody>{rows}</tbody></table>"


def scene_text(p: Parameters, *, separation: bool, without: Sequence[str] = ()) -> str:
    """What a parameter set changes of the base set, and the physics, in one phrase."""
    changed = [
        f"{name}={value:g}"
        for name, value in p.as_dict().items()
        if value != PARAMETERS[name].default and name not in without
    ]
    base = f"base set with {', '.join(changed)}" if changed else "base set"
    return base if separation else f"{base}; separation ignored"
