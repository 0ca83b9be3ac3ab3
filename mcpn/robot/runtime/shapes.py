"""What a JSON document must be, declared once.

A :class:`Document` says of each value what it may be and what it means. What reads a file back holds it
against the declaration (:meth:`JsonShape.check`); the JSON Schemas that ``mcpn schema`` prints and the
tables of the page on formats are made of the same declarations.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from copy import copy
from math import inf
from typing import Any, TypeVar

_Shape = TypeVar("_Shape", bound="JsonShape")


class Misfit(ValueError):
    """A JSON value is not what its declaration says.

    Args:
        found: The value, or a key of it.
        expected: What was expected, in words.

    Attributes:
        where: The place inside the document, as ``sections[2].name``.
    """

    def __init__(self, found: object, expected: str) -> None:
        super().__init__(found, expected)
        self.found, self.expected, self.where = found, expected, ""

    def below(self, step: str) -> Misfit:
        """The same fault, seen from the value around."""
        self.where = step + self.where
        return self

    def __str__(self) -> str:
        try:
            found = json.dumps(self.found)
        except (TypeError, ValueError):  # what no file says, but an object of Python may
            found = repr(self.found)
        fault = f"found {found[:80]}, expected {self.expected}"
        return f"{self.where.lstrip('.')}: {fault}" if self.where else fault


class JsonShape:
    """What a JSON value may be.

    Args:
        meaning: What the value means.
    """

    def __init__(self, meaning: str = "") -> None:
        self.meaning = meaning

    def check(self, value: Any) -> None:
        """Holds a value against the shape.

        Args:
            value: The JSON value.

        Raises:
            Misfit: It is something else.
        """
        self._check(value)

    def _check(self, value: Any) -> None:
        """What :meth:`check` does, of each kind of value."""

    def meant(self: _Shape, meaning: str) -> _Shape:
        """The same shape, for a value that means something else."""
        other = copy(self)
        other.meaning = meaning
        return other


class Anything(JsonShape):
    """Any value."""


class String(JsonShape):
    """A text."""

    def _check(self, value: Any) -> None:
        if type(value) is not str:
            raise Misfit(value, "a text")


class Boolean(JsonShape):
    """True or false."""

    def _check(self, value: Any) -> None:
        if type(value) is not bool:
            raise Misfit(value, "true or false")


class Integer(JsonShape):
    """An integer of any size.

    Args:
        meaning: What it means.
        least: The least that it may be; None for no bound.
    """

    def __init__(self, meaning: str = "", least: int | None = 0) -> None:
        super().__init__(meaning)
        self.least = least

    def _check(self, value: Any) -> None:
        if type(value) is not int or (self.least is not None and value < self.least):
            raise Misfit(value, "an integer" if self.least is None else f"an integer from {self.least}")


class Number(JsonShape):
    """A finite number, whole or not.

    Args:
        meaning: What it means.
        least: The least that it may be; None for no bound.
        above: What it is greater than; None for no bound.
    """

    def __init__(self, meaning: str = "", least: float | None = None, above: float | None = None) -> None:
        super().__init__(meaning)
        self.least, self.above = least, above

    def _check(self, value: Any) -> None:
        if (
            type(value) not in (int, float)
            or not -inf < value < inf
            or (self.least is not None and value < self.least)
            or (self.above is not None and value <= self.above)
        ):
            bounds = "" if self.least is None else f" from {self.least}"
            bounds += "" if self.above is None else f" greater than {self.above}"
            raise Misfit(value, f"a number{bounds}")


class OneOf(JsonShape):
    """One of some values.

    Args:
        meaning: What it means.
        *values: The values.
    """

    def __init__(self, meaning: str, *values: Any) -> None:
        super().__init__(meaning)
        self.values = values

    def _check(self, value: Any) -> None:
        if not any(type(value) is type(each) and value == each for each in self.values):
            some = "one of " if len(self.values) > 1 else ""
            raise Misfit(value, some + ", ".join(map(str, self.values)))


class Nullable(JsonShape):
    """A value, or null.

    Args:
        shape: What the value may be, and what it means.
    """

    def __init__(self, shape: JsonShape) -> None:
        super().__init__(shape.meaning)
        self.shape = shape

    def _check(self, value: Any) -> None:
        if value is not None:
            self.shape._check(value)


class Either(JsonShape):
    """A value of one of some shapes.

    Args:
        meaning: What it means.
        *shapes: The shapes.
    """

    def __init__(self, meaning: str, *shapes: JsonShape) -> None:
        super().__init__(meaning)
        self.shapes = shapes

    def _check(self, value: Any) -> None:
        expected = []
        for shape in self.shapes:
            try:
                return shape._check(value)
            except Misfit as fault:
                expected.append(fault.expected)
        raise Misfit(value, " or ".join(expected))


class ListOf(JsonShape):
    """A list.

    Args:
        meaning: What it means.
        item: What each item may be.
        differ: Whether no two items may be equal.
    """

    def __init__(self, meaning: str, item: JsonShape, differ: bool = False) -> None:
        super().__init__(meaning)
        self.item, self.differ = item, differ

    def _check(self, value: Any) -> None:
        if type(value) is not list:
            raise Misfit(value, "a list")
        number, check = 0, self.item._check
        try:
            for number, item in enumerate(value):  # noqa: B007  # the last one is told
                check(item)
        except Misfit as fault:
            raise fault.below(f"[{number}]") from None
        if self.differ and len(set(value)) < len(value):
            raise Misfit(value, "items that differ")


class MapOf(JsonShape):
    """An object with any keys.

    Args:
        meaning: What it means.
        value: What each value may be.
    """

    def __init__(self, meaning: str, value: JsonShape) -> None:
        super().__init__(meaning)
        self.value = value

    def _check(self, value: Any) -> None:
        if type(value) is not dict:
            raise Misfit(value, "an object")
        key, check = "", self.value._check
        try:
            for key, item in value.items():  # noqa: B007
                check(item)
        except Misfit as fault:
            raise fault.below(f".{key}") from None


class ObjectOf(JsonShape):
    """An object with known keys.

    Args:
        meaning: What it means.
        keys: What each value may be, by key. A key that ends in ``?`` may be missing; the mark is no part
            of it.
        others: Whether there may be other keys, too, of which nothing is said.
    """

    def __init__(self, meaning: str, keys: Mapping[str, JsonShape], *, others: bool = False) -> None:
        super().__init__(meaning)
        self.others = others
        self.keys = {key.removesuffix("?"): shape for key, shape in keys.items()}
        self.required = [key for key in keys if not key.endswith("?")]

    def _check(self, value: Any) -> None:
        if type(value) is not dict:
            raise Misfit(value, "an object")
        for key in self.required:
            if key not in value:
                raise Misfit(list(value), f"the key {key}")
        for key in () if self.others else value:
            if key not in self.keys:
                raise Misfit(key, f"one of the keys {', '.join(self.keys)}")
        key = ""
        try:
            for key, item in value.items():
                if key in self.keys:
                    self.keys[key]._check(item)
        except Misfit as fault:
            raise fault.below(f".{key}") from None


class Shared(JsonShape):
    """A shape with a name, of which a document speaks in several places; what it means there is its own.

    Args:
        name: The name.
        shape: The shape.
    """

    def __init__(self, name: str, shape: JsonShape) -> None:
        super().__init__()
        self.name, self.shape = name, shape

    def _check(self, value: Any) -> None:
        self.shape._check(value)


class Document:
    """A format.

    Args:
        name: Its name, as ``mcpn schema`` takes it.
        title: What prints or writes it.
        shape: What it may be.
    """

    def __init__(self, name: str, title: str, shape: JsonShape) -> None:
        self.name, self.title, self.shape = name, title, shape
