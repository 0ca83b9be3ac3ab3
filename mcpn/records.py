"""What records have in common, so that it is not compiled for each class of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import cache
from operator import attrgetter
from typing import Any


class ValueRecord:
    """A dataclass without methods of its own to compare, to hash and to show it: ``eq=False, repr=False``.

    The standard library compiles each method for each class, which takes longer than small missions do.
    """

    __slots__ = ()

    @classmethod
    @cache
    def _said(cls) -> Callable[[object], object]:
        """What it says, to compare by."""
        record: Any = cls
        return attrgetter(*(each.name for each in fields(record) if each.compare))

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and (said := self._said())(self) == said(other)

    def __hash__(self) -> int:
        return hash(self._said()(self))

    def __repr__(self) -> str:
        made: Any = self
        values = ", ".join(f"{each.name}={getattr(self, each.name)!r}" for each in fields(made) if each.repr)
        return f"{type(self).__name__}({values})"
