"""Methods and functions that keep their results, for as long as the object lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, partial
from typing import Concatenate, ParamSpec, TypeVar, cast

Key = TypeVar("Key")
Owner = TypeVar("Owner")
Given = ParamSpec("Given")
Result = TypeVar("Result")


def memoized(
    method: Callable[Concatenate[Owner, Given], Result],
) -> cached_property[Callable[Given, Result]]:
    """Makes a method that keeps its result for equal arguments, in the object itself.

    ``functools.cache`` on a method would keep every object alive in a table of the class.
    """
    return cached_property(lambda owner: cast(Callable[Given, Result], cache(partial(method, owner))))


class ByKey(dict[Key, Result]):
    """What a function of one argument gives, found when it is first asked for.

    It is quicker to make than ``functools.cache``, which counts where functions are made by the thousand.

    Args:
        find: The function.
    """

    __slots__ = ("_find",)

    def __init__(self, find: Callable[[Key], Result]) -> None:
        super().__init__()
        self._find = find

    def __missing__(self, key: Key) -> Result:
        self[key] = found = self._find(key)
        return found
