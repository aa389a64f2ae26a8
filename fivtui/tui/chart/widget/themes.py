"""Themes with the colours of charts."""

from collections.abc import Collection
from dataclasses import replace
from typing import Final

from textual.theme import Theme

from fivtui.charts import INKS

# Roles of charts by the attributes of a theme that have the same meaning.
_ROLES: Final = {"error": "danger", "warning": "warning", "success": "safe"}


def with_chart_colours(theme: Theme, chosen: Collection[str] = ()) -> Theme:
    """A theme with the colours of charts as variables, named as their roles.

    Error, warning and success have the colours of danger, warning and safe; if `chosen` contains
    them, these roles have the colours of the theme.
    """
    colours = {role: ink.dark if theme.dark else ink.light for role, ink in INKS.items()}
    colours |= {_ROLES[name]: getattr(theme, name) for name in _ROLES if name in chosen}
    danger, warning, safe = (colours[role] for role in _ROLES.values())
    texts = {f"text-{name}": colours[role] for name, role in _ROLES.items()}
    variables = theme.variables | colours | texts
    return replace(theme, variables=variables, error=danger, warning=warning, success=safe)
