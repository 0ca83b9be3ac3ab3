"""What names in formulas and conditions mean, once it is known what is declared."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace

from mcpn.editor.symbols import Symbol
from mcpn.mission.language.references import happening
from mcpn.mission.model import Use

_LOOSE = ("objective", "block path", "loss", "happening")


def resolved(symbols: list[Symbol]) -> list[Symbol]:
    """Names as they are read, each as the elements that it means.

    A name of an objective, or of copies of it, is taken apart: ``visit_12.shelter_at_travel`` names three
    blocks. What means nothing stays, as a name of its last part.

    Args:
        symbols: Of all files of a mission.
    """
    if not any(symbol.kind in _LOOSE or symbol.kind == "alternative" for symbol in symbols):
        return symbols
    meaning = _Meaning(symbols)
    return [each for symbol in symbols for each in meaning.of(symbol)]


class _Meaning:
    def __init__(self, symbols: Iterable[Symbol]) -> None:
        self.blocks = defaultdict[str, dict[str, Symbol]](dict)
        """By text (a protocol; the mission itself has no name) and name, blocks that are declared."""
        self.declared = set[tuple[str, str]]()
        self.alternatives = defaultdict[str, list[str]](list)
        """By name of an alternative its activities."""
        for symbol in symbols:
            if symbol.declares:
                self.declared.add((symbol.kind, symbol.name))
                if symbol.kind == "block":
                    self.blocks[symbol.scope or ""].setdefault(symbol.name, symbol)
                elif symbol.kind == "alternative":
                    self.alternatives[symbol.name].append(symbol.scope or "")

    def of(self, symbol: Symbol) -> Iterable[Symbol]:
        if symbol.declares:
            return (symbol,)
        match symbol.kind:
            case "objective" | "block path":
                return self.path(symbol)
            case "loss":
                return self.loss(symbol)
            case "happening" if ("event", symbol.name) in self.declared:
                return (replace(symbol, kind="event", scope=""),)
            case "happening":
                of = happening(symbol.name)
                found = replace(symbol, kind=of.kind, name=of.name, place=symbol.place + of.place)
                return (replace(found, scope=""),) if of.kind == "event" else self.of(found)
            case "alternative" if (symbol.scope or "") not in self.alternatives.get(symbol.name, ()):
                # An activity that says no alternative has one of its own name.
                return (
                    (replace(symbol, kind="activity", scope=""),)
                    if symbol.name == symbol.scope
                    else (symbol,)
                )
        return (symbol,)

    def loss(self, symbol: Symbol) -> Iterator[Symbol]:
        """Hardware, or what may crash: an activity, or an alternative that its activity may qualify."""
        activity, dot, way = symbol.name.rpartition(".")
        if dot:
            yield replace(symbol, kind="activity", scope="", name=activity)
            place = symbol.place + len(activity) + 1
            yield from self.of(replace(symbol, kind="alternative", scope=activity, name=way, place=place))
        elif ("resource", way) in self.declared or not self._crashes(way):
            yield replace(symbol, kind="resource", scope="")
        elif ("activity", way) in self.declared:
            yield replace(symbol, kind="activity", scope="")
        else:
            (of,) = self.alternatives[way]
            yield replace(symbol, kind="alternative", scope=of)

    def _crashes(self, name: str) -> bool:
        return ("activity", name) in self.declared or len(self.alternatives.get(name, ())) == 1

    # --- blocks ---

    def path(self, symbol: Symbol) -> Iterable[Symbol]:
        """The blocks of a qualified name, in its own text, else in the only text that has such blocks."""
        own = self._path(symbol, symbol.scope or "")
        if own:
            return own
        found = [path for text in self.blocks if (path := self._path(symbol, text))]
        if len(found) == 1:
            return found[0]
        last = symbol.name.rpartition(".")[2]
        place = symbol.place + len(symbol.name) - len(last)
        return (replace(symbol, kind="block", scope=None, name=last, place=place),)

    def _path(self, symbol: Symbol, text: str) -> list[Symbol]:
        """The blocks of a qualified name that begins in a text; none where there are no such blocks."""
        found, place = list[Symbol](), symbol.place
        parts = symbol.name.split(".")
        for number, part in enumerate(parts):
            named = list(self._copy(part, text))
            if not named:
                return []
            for at, of, name in named:
                found.append(replace(symbol, kind="block", scope=of, name=name, place=place + at))
            block = self.blocks[text][named[0][2]].element
            if number == len(parts) - 1:
                elementary = block.tag == "objective" and "activities" in block.texts
                return found if elementary or symbol.kind == "block path" else []
            text = self._inside(text, named[0][2])
            place += len(part) + 1
        return []

    def _inside(self, text: str, name: str) -> str:
        """The text of the blocks that stand in a block: of a use of a protocol, the protocol."""
        block = self.blocks[text][name].element
        return block.texts.get("protocol", "") if block.tag == Use.TAG else text

    def _copy(self, name: str, text: str) -> Iterator[tuple[int, str, str]]:
        """The blocks that the name of a copy is made of: where each stands in it, its text and its name."""
        known = self.blocks.get(text, {})
        base = _longest(name, known)
        if base is None:
            return
        yield 0, text, base
        rest, at = name[len(base) + 1 :], len(base) + 1
        if rest.startswith("at_"):
            for place, of, other in self._stopped(rest[3:], text):
                yield at + 3 + place, of, other
        elif (recovered := _numbered(rest, known)) is not None:
            yield at, text, recovered

    def _stopped(self, name: str, text: str) -> Iterator[tuple[int, str, str]]:
        """The blocks of a qualified name whose dots have become ``_``, as :meth:`_copy` tells them."""
        base = _longest(name, self.blocks.get(text, {}))
        inside = self._inside(text, base) if base is not None else text
        if base is None or inside == text:
            yield from self._copy(name, text)
            return
        yield 0, text, base
        # What tells its own copies apart, as ``run2``, stands before the blocks in it.
        starts = [at + 1 for at in range(len(base), len(name)) if name[at] == "_"]
        for start in starts:
            if _longest(name[start:], self.blocks.get(inside, {})) is not None:
                for place, of, other in self._stopped(name[start:], inside):
                    yield start + place, of, other
                return


def _longest(name: str, known: dict[str, Symbol]) -> str | None:
    """The block itself of this name, else that of the longest name that ``_`` and more follow."""
    if name in known:
        return name
    ends = (end for end in range(len(name) - 1, 0, -1) if name[end] == "_")
    return next((name[:end] for end in ends if name[:end] in known), None)


def _numbered(name: str, known: dict[str, Symbol]) -> str | None:
    """The block that recovers, where a name begins with it and the number of its recovery."""
    ends = (end for end in range(len(name) - 1, 0, -1) if name[end].isdigit())
    return next((name[:end] for end in ends if name[:end] in known), None)
