"""Rows of a document that are many and say few things, and their text as JSON, without an object for each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, overload

AT_ONCE = 1024
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
        gaps = [key for key in keys if key in self._columns]
        # What stands before each gap, and behind the last one, by kind.
        between = [list[str]() for _ in range(len(gaps) + 1)]
        for shared in self._shared:
            text, number = "{", 0
            for i, key in enumerate(keys):
                text += (comma if i else "") + encode(key) + colon
                if key in self._columns:
                    between[number].append(text)
                    text, number = "", number + 1
                else:
                    text += encode(shared[key])
            between[number].append(f"{text}}}{comma}")
        # A row is a row of texts, those that are the same of all kinds joined to what stands behind them.
        parts: list[tuple[Callable[[Any], str], Sequence[Any]]] = []
        for key, before in zip(gaps, between, strict=False):
            lead = before[0] if len({*before}) == 1 else ""
            if not lead:
                parts.append((before.__getitem__, self._kinds))
            column = self._columns[key]
            said = {v: f"{lead}{v if isinstance(v, int) else encode(v)}" for v in {*column}}
            parts.append((said.__getitem__, column))
        parts.append((between[-1].__getitem__, self._kinds))
        yield "["
        for begin in range(0, len(self), AT_ONCE):
            some = slice(begin, begin + AT_ONCE)
            texts = [""] * (len(parts) * len(self._kinds[some]))
            for number, (text_of, column) in enumerate(parts):
                texts[number :: len(parts)] = map(text_of, column[some])
            if begin + AT_ONCE >= len(self):
                texts[-1] = texts[-1].removesuffix(comma)
            yield "".join(texts)
        yield "]"
