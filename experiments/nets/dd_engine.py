"""An engine of one's own: the binary decision diagrams of the package dd, for ``mcpn compare``.

Run: cd experiments/nets; mcpn compare --family philosophers 2..8 --engine dd_engine:DdSets

The five methods that :class:`mcpn.spaces.custom_engine.Sets` asks for, and two more for columns of the table.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from dd.autoref import BDD

from mcpn.nets.petri import PetriNet


class DdSets:
    """Sets of markings of a net: a variable for each place, in the net's order."""

    order = "file"

    def __init__(self, net: PetriNet) -> None:
        self.names = [f"p{place}" for place in range(len(net.places))]
        self.bdd = BDD()
        self.bdd.declare(*self.names)

    def single(self, marked: Collection[int]) -> Any:
        """The set of one marking."""
        return self._cube({place: place in marked for place in range(len(self.names))})

    def moved(self, states: Any, before: Mapping[int, bool], after: Mapping[int, bool]) -> Any:
        """Those markings that are as asked, changed."""
        asked = states & self._cube(before)
        return self.bdd.exist([self.names[place] for place in after], asked) & self._cube(after)

    def union(self, one: Any, other: Any) -> Any:
        """Markings of either set."""
        return one | other

    def minus(self, one: Any, other: Any) -> Any:
        """Markings of the first set that are not in the second."""
        return one & ~other

    def count(self, states: Any) -> int:
        """How many markings."""
        return int(self.bdd.count(states, len(self.names)))

    def nodes(self, states: Any) -> int:
        """The nodes of a set's diagram."""
        return len(states)

    def _cube(self, tokens: Mapping[int, bool]) -> Any:
        return self.bdd.cube({self.names[place]: marked for place, marked in tokens.items()})
