"""Roles: what the places of a mission's net say of its elements, beyond the element's own template."""

from __future__ import annotations

WAITING = ("wait", "want")
"""Roles of places that say of an alternative that it waits: for answers, or for what it has asked for."""
