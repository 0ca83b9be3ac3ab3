"""The types of the fields of a mission built in Python, which Python does not enforce."""

from __future__ import annotations

from collections.abc import Iterator
from types import NoneType
from typing import Any

from mcpn.errors import Problem, Source
from mcpn.mission.language.forms import Field, form_of
from mcpn.mission.model import Mission
from mcpn.mission.robot import Described

_WORDS = {
    str: "a text",
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    NoneType: "None",
    Source: "a source",
}


def _fits(value: object, classes: tuple[type, ...]) -> bool:
    """Whether a value, or a member of one, is of some classes."""
    if isinstance(value, bool):
        return bool in classes
    if isinstance(value, int) and float in classes:
        return abs(value).bit_length() <= 1000  # so that there is such a float
    return isinstance(value, classes)


def wrong_types(mission: Mission) -> Iterator[Problem]:
    """Fields of a mission whose values are not what the model says.

    Args:
        mission: A mission built in Python.

    Returns:
        Problems, with lines where the elements have them. The walk keeps its own stack and is linear in the
        mission's size.
    """
    stack: list[Any] = [mission]
    while stack:
        element = stack.pop()
        for field in form_of(element.__class__).fields:
            value = getattr(element, field.name)
            if field.several and not isinstance(value, tuple):
                yield _misfit(element, field, f"is {_shown(value)}")
                continue
            for member in value if field.several else (value,):
                if not _fits(member, field.classes):
                    yield _misfit(element, field, f"{'holds' if field.several else 'is'} {_shown(member)}")
                elif isinstance(member, Described):
                    stack.append(member)


def _misfit(element: Any, field: Field, found: str) -> Problem:
    source = element.source if isinstance(element.source, Source) else None
    name = getattr(element, "name", None) or getattr(element, "event", None)
    owner = type(element).__name__ + (f" {name}" if isinstance(name, str) else "")
    words = " or ".join(_WORDS.get(kind) or f"{kind.__name__} objects" for kind in field.classes)
    expected = f"a tuple of {words}" if field.several else words
    return Problem(source, f"{field.name} of {owner} {found}, expected {expected}")


def _shown(value: object) -> str:
    """A value as an error shows it: short, whatever it is."""
    if value is None or isinstance(value, bool | int | float | str):
        text = repr(value) if not isinstance(value, int) or abs(value).bit_length() < 200 else "a huge number"
        return text if len(text) <= 60 else f"{text[:57]}..."
    return f"a {type(value).__name__}"
