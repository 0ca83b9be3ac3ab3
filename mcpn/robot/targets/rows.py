"""Rows of a document that are many and say few things, and their text as JSON, without an object for each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import mod
from typing import Any, overload

AT_ONCE = 256
"""Rows that are written together: their text is short beside that of all."""


class Rows(Sequence[dict[str, Any]]):
    """Objects with the same keys; what many have in common is kept once.

    Args:
        keys: In their order.
        columns: By key, what each row says: numbers and texts.
        kinds: By row, the number of what it says besides.
        shared: By number, the values of all other keys.
    """

    def __init__(
        self,
        keys: Sequence[str],
        columns: Mapping[str, Sequence[int | str]],
        kinds: Sequence[int],
        shared: Sequence[Mapping[str, Any]],
    ) -> None:
        self._keys, self._columns, self._kinds, self._shared = keys, columns, kinds, shared

    def __len__(self) -> int:
        return len(self._kinds)

    @overload
    def __getitem__(self, number: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, number: slice) -> Rows: ...
    def __getitem__(self, number: int | slice) -> dict[str, Any] | Rows:
        if isinstance(number, slice):
            some = {key: column[number] for key, column in self._columns.items()}
            return Rows(self._keys, some, self._kinds[number], self._shared)
        shared = self._shared[self._kinds[number]]
        columns = self._columns
        return {key: columns[key][number] if key in columns else shared[key] for key in self._keys}

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return map(self.__getitem__, range(len(self)))

    def pieces(
        self, encode: Callable[[object], str], comma: str, colon: str, *, ordered: bool
    ) -> Iterator[str]:
        """The list of the rows as JSON, :data:`AT_ONCE` rows at a time.

        Args:
            encode: Makes JSON of a value.
            comma: What stands between members.
            colon: What stands behind keys.
            ordered: Whether keys are sorted.
        """
        keys = sorted(self._keys) if ordered else self._keys

        def form(shared: Mapping[str, Any]) -> str:
            """The text of all rows of a kind, with a gap for each column."""
            said = (
                encode(key).replace("%", "%%")
                + colon
                + ("%s" if key in self._columns else encode(shared[key]).replace("%", "%%"))
                for key in keys
            )
            return "{" + comma.join(said) + "}"

        forms = [form(shared) for shared in self._shared]
        columns = [self._columns[key] for key in keys if key in self._columns]
        numbers = [{*map(type, column)} <= {int} for column in columns]  # which have no need of encoding
        yield "["
        for begin in range(0, len(self), AT_ONCE):
            some = slice(begin, begin + AT_ONCE)
            gaps = [
                column[some] if plain else [v if isinstance(v, int) else encode(v) for v in column[some]]
                for column, plain in zip(columns, numbers, strict=True)
            ]
            kinds = map(forms.__getitem__, self._kinds[some])
            yield (comma if begin else "") + comma.join(map(mod, kinds, zip(*gaps, strict=True)))
        yield "]"
