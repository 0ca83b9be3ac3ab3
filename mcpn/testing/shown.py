"""What hypothesis prints of the mission or net of a failing property: all of it, though its repr is short.

Releases of hypothesis before 6.125 print dataclasses by their repr; with these printers all print the same.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from hypothesis.vendor.pretty import for_type_by_name

SHOWN = (("mcpn.mission.model", "Mission"), ("mcpn.net.petri", "PetriNet"))
"""Classes with a short repr, by module and name."""


def print_whole(example: Any, printer: Any, cycle: bool) -> None:
    """Prints a dataclass with the fields that make it, whatever its repr says."""
    name = type(example).__name__
    if cycle:
        printer.text(f"{name}(...)")
        return
    with printer.group(4, f"{name}(", ")"):
        for number, field in enumerate(f for f in fields(example) if f.init):
            if number:
                printer.text(",")
                printer.breakable()
            printer.text(f"{field.name}=")
            printer.pretty(getattr(example, field.name))


def register() -> None:
    """Tells hypothesis to print missions and nets so."""
    for module, name in SHOWN:
        for_type_by_name(module, name, print_whole)
