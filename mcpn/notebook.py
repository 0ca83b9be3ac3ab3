"""Base classes of objects that a notebook shows as the report draws them.

A check or a net must not import the report, for imports point from report to check. So the report's module is
named here as a text, and imported when the first object is shown.
"""

from __future__ import annotations

from importlib import import_module

SHOWN_BY = "mcpn.report.notebook"
"""The module whose ``show`` is given an object and ``svg`` or ``html``."""


def _shown(what: object, kind: str) -> str | None:
    shown: str | None = import_module(SHOWN_BY).show(what, kind)
    return shown


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
