"""How objects show themselves in a notebook.

A check or a net must not import the report, which stands behind it. So the report's way to show things is
registered here, by :mod:`mcpn.face`, which is loaded when the first object is to be shown.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

_show: Callable[[object, str], str | None] | None = None


def show_with(show: Callable[[object, str], str | None]) -> None:
    """Registers what shows objects.

    Args:
        show: Given an object and ``svg`` or ``html``, the text, or ``None`` where it cannot be shown so.
    """
    global _show
    _show = show


def _shown(what: object, kind: str) -> str | None:
    if _show is None:
        import_module("mcpn.face")
    return None if _show is None else _show(what, kind)


class Drawn:
    """An object that a notebook shows as a picture."""

    __slots__ = ()

    def _repr_svg_(self) -> str | None:
        return _shown(self, "svg")


class Told:
    """An object that a notebook shows as a table."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        return _shown(self, "html")
