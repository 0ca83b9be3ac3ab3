"""What Python does not enforce of a mission built from the classes of the model: the types of its fields."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from mcpn.errors import Problem, Source
from mcpn.mission.model import Element, Handler, Mission

_WORDS = {
    str: "a text",
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    NoneType: "None",
    Source: "a source",
}


@dataclass(frozen=True, slots=True)
class _Field:
    """What a field of an element may hold.

    Args:
        name: Its name.
        classes: Those of its value, or of the members of the tuple that its value is.
        several: Whether it is a tuple.
    """

    name: str
    classes: tuple[type, ...]
    several: bool

    def fits(self, value: object) -> bool:
        """Whether a value, or a member of one, is of the classes."""
        if isinstance(value, bool):
            return bool in self.classes
        if isinstance(value, int) and float in self.classes:
            return abs(value).bit_length() <= 1000  # so that there is such a float
        return isinstance(value, self.classes)

    @property
    def expected(self) -> str:
        """What may stand there, in words."""
        words = [_WORDS.get(of) or f"{of.__name__} objects" for of in self.classes]
        return " or ".join(words) if not self.several else f"a tuple of {' or '.join(words)}"


@cache
def _fields(element: type) -> tuple[_Field, ...]:
    hints = get_type_hints(element)
    found = []
    for name in (f.name for f in fields(element) if f.init):
        hint, several = hints[name], get_origin(hints[name]) is tuple
        of = get_args(hint)[0] if several else hint
        classes = get_args(of) if get_origin(of) in (UnionType, Union) else (of,)
        found.append(_Field(name, classes, several))
    return tuple(found)


def find_misfits(mission: Mission) -> Iterator[Problem]:
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
        for of in _fields(element.__class__):
            value = getattr(element, of.name)
            if of.several and not isinstance(value, tuple):
                yield _misfit(element, of, f"is {_shown(value)}")
                continue
            for member in value if of.several else (value,):
                if not of.fits(member):
                    yield _misfit(element, of, f"{'holds' if of.several else 'is'} {_shown(member)}")
                elif isinstance(member, Element | Handler):
                    stack.append(member)


def _misfit(element: Any, of: _Field, found: str) -> Problem:
    source = element.source if isinstance(element.source, Source) else None
    name = getattr(element, "name", None) or getattr(element, "event", None)
    owner = type(element).__name__ + (f" {name}" if isinstance(name, str) else "")
    return Problem(source, f"{of.name} of {owner} {found}, expected {of.expected}")


def _shown(value: object) -> str:
    """A value as an error shows it: short, whatever it is."""
    if value is None or isinstance(value, bool | int | float | str):
        text = repr(value) if not isinstance(value, int) or abs(value).bit_length() < 200 else "a huge number"
        return text if len(text) <= 60 else f"{text[:57]}..."
    return f"a {type(value).__name__}"
