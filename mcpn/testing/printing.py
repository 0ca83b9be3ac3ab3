"""What hypothesis prints of the mission or net of a failing property: a mission as a file, a net whole.

Releases of hypothesis before 6.125 print dataclasses by their repr; with these printers all print the same.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from hypothesis.vendor.pretty import for_type_by_name

from mcpn.mission.model import Mission
from mcpn.mission.writer import written


def as_xml(mission: Mission) -> str:
    """A mission as the file that says it, valid or not.

    Raises:
        ValueError: A text holds a character that XML cannot.
    """
    return written(mission).decode().partition("?>")[2].strip()


def print_mission(example: Mission, printer: Any, cycle: bool) -> None:
    """Prints a mission as its file, to save and to read again."""
    try:
        lines = as_xml(example).splitlines()
    except (ValueError, TypeError, AttributeError):  # what no file can say
        print_whole(example, printer, cycle)
        return
    for number, line in enumerate(lines):
        if number:
            printer.break_()
        printer.text(line)


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
    for_type_by_name("mcpn.mission.model", "Mission", print_mission)
    for_type_by_name("mcpn.nets.petri", "PetriNet", print_whole)
