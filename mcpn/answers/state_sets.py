"""The states that satisfy a formula, on any engine: counted, sampled, walked, handed on to other libraries.

>>> import mcpn
>>> study = mcpn.open("experiments/ulysse/mission.xml")
>>> lost = study.satisfying("!(success | failure) & !EF success", engine="symbolic")
>>> lost.count, len(list(lost)) == lost.count
(8, True)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any, TypeAlias

from mcpn.answers.verdicts.modes import Situation, in_fields, situation
from mcpn.errors import LimitError
from mcpn.spaces.algebra import Space

if TYPE_CHECKING:
    import networkx as nx
    import pandas as pd

    from mcpn.drawing.compose import MissionNet
    from mcpn.spaces.diagrams.export import Diagram

MAX_LISTED = 1_000_000
"""States that are listed for another library."""

Said: TypeAlias = Situation | Mapping[str, int]
"""A state of a mission in mission words; of a net the tokens by the name of each marked place."""


@dataclass(frozen=True, eq=False)
class FoundStates:
    """Some states of one space, a set: ``&``, ``|`` and ``-`` make others; ``for`` walks it in mission words.

    Args:
        formula: What they satisfy, or how they were made of others.
        space: Their space.
        states: The set, as the space holds it.
        engine: The engine that holds it.
        mission_net: The mission's net; ``None`` for a net of no mission.
    """

    formula: str
    space: Space[Any]
    states: Any
    engine: str
    mission_net: MissionNet | None

    def __repr__(self) -> str:
        return f"<{self.count} states, engine {self.engine}: {self.formula}>"

    @property
    def count(self) -> int:
        """How many states, exact at any size."""
        return int(self.states.count())

    def __len__(self) -> int:
        return self.count

    def __bool__(self) -> bool:
        return bool(self.states)

    def __and__(self, other: FoundStates) -> FoundStates:
        return self._made(self.states & self._of_same(other), f"({self.formula}) & ({other.formula})")

    def __or__(self, other: FoundStates) -> FoundStates:
        return self._made(self.states | self._of_same(other), f"({self.formula}) | ({other.formula})")

    def __sub__(self, other: FoundStates) -> FoundStates:
        return self._made(self.states - self._of_same(other), f"({self.formula}) & !({other.formula})")

    def _of_same(self, other: FoundStates) -> Any:
        if other.space is not self.space:
            raise ValueError("sets of two spaces do not mix: ask both of one study, with the same engine")
        return other.states

    def _made(self, states: Any, formula: str) -> FoundStates:
        return FoundStates(formula, self.space, states, self.engine, self.mission_net)

    def said(self, state: Any) -> Said:
        """A member, as the space gives it, in mission words, or as tokens by place."""
        marking = self.space.marking(state)
        if self.mission_net is not None:
            return situation(self.mission_net, tuple(marking))
        places = (place.name for place in self.space.net.places)
        return {name: tokens for name, tokens in zip(places, marking, strict=True) if tokens}

    def members(self) -> Iterator[Any]:
        """The states as the space gives them, one after the other; no more is done than is asked for."""
        left = self.states
        while left:
            state = left.pick()
            yield state
            left = left - self.space.single(state)

    def __iter__(self) -> Iterator[Said]:
        return map(self.said, self.members())

    def sample(self, n: int, seed: int = 0) -> list[Said]:
        """Different states, drawn so that each is as probable as any other.

        Args:
            n: How many; all of them where there are fewer.
            seed: The same one draws the same states, on any engine.
        """
        draw, left, found = Random(seed), self.states, list[Said]()
        while left and len(found) < n:
            state = self._drawn(left, draw.randrange(left.count()))
            found.append(self.said(state))
            left = left - self.space.single(state)
        return found

    def _drawn(self, states: Any, number: int) -> Any:
        """The state with a number, counted by the tokens of the first place, then by those of the next."""
        for place in range(len(self.space.net.places)):
            if states.count() == 1:
                break
            tokens = 0
            while True:
                fewer = (
                    self.space.restricted(states, (), (place,))
                    if tokens == 0
                    else states & self.space.at_most({place: 1}, tokens)
                )
                if number < (count := fewer.count()):
                    states = fewer
                    break
                states, number, tokens = states - fewer, number - count, tokens + 1
        return states.pick()

    def to_networkx(self) -> nx.MultiDiGraph[int]:
        """These states with the edges between them, in networkx.

        Returns:
            States as numbers; of a mission with ``objectives``, ``mode``, ``waiting``, ``refused``,
            ``out_of_service``, ``facts`` and ``outcome``, of a net with its ``marking``. Each edge has its
            ``transition`` and its ``event`` (``None``: internal).

        Raises:
            LimitError: There are more than a million.
        """
        import networkx

        self._few()
        graph: nx.MultiDiGraph[int] = networkx.MultiDiGraph(name=self.formula)
        states = list(self.members())
        number = {tuple(self.space.marking(state)): n for n, state in enumerate(states)}
        for n, state in enumerate(states):
            said = self.said(state)
            graph.add_node(n, **(in_fields(said) if isinstance(said, Situation) else {"marking": dict(said)}))
        for n, state in enumerate(states):
            for edge in self.space.edges(state):
                target = number.get(tuple(self.space.marking(edge.target)))
                if target is not None:
                    transition = self.space.net.transitions[edge.transition]
                    event = None if transition.event is None else str(transition.event)
                    graph.add_edge(n, target, transition.name, transition=transition.name, event=event)
        return graph

    def to_pandas(self) -> pd.DataFrame:
        """These states as a table, a row for each.

        Returns:
            Of a mission a column for each objective (whether it runs), each activity (its alternative, or
            none), each hardware resource (whether it is in service) and each fact (its value), and
            ``outcome``, with the kind before a name that several have; of a net one for each place (its
            tokens).

        Raises:
            LimitError: There are more than a million, or pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise LimitError("a table needs pandas: pip install 'mcpn[pandas]'") from error
        self._few()
        some = self.said(self.space.everything.pick())  # so that a table without rows has its columns
        return pandas.DataFrame([self._row(said) for said in self], columns=list(self._row(some)))

    def _row(self, said: Said) -> dict[str, object]:
        if not isinstance(said, Situation):
            return {place.name: said.get(place.name, 0) for place in self.space.net.places}
        found = self.mission_net
        assert found is not None, "situations are of missions"
        row: dict[tuple[str, str], object] = {
            ("objective", s.name): s.name in said.objectives for s in found.graph.walk()
        }
        row |= {("activity", name): said.mode.get(name) for name in found.usage.started}
        row |= {("hardware", h.name): h.name not in said.out_of_service for h in found.core.hardware}
        row |= {("fact", name): value for name, value in said.facts.items()}
        row["mission", "outcome"] = said.outcome
        times = Counter(name for _, name in row)
        return {name if times[name] == 1 else f"{kind}:{name}": value for (kind, name), value in row.items()}

    def _few(self) -> None:
        if (count := self.count) > MAX_LISTED:
            raise LimitError(f"{count} states, more than {MAX_LISTED}: the limit on a list of them was hit")

    def diagram(self) -> Diagram:
        """The decision diagram that holds these states, node by node, to draw or to look at.

        Raises:
            LimitError: Another engine holds them, or the diagram has too many nodes.
        """
        from mcpn.spaces.diagrams.base import Diagrams
        from mcpn.spaces.diagrams.export import diagram_of

        if not isinstance(self.space, Diagrams):
            raise LimitError(f"engine {self.engine} holds no diagram: ask with engine='symbolic'")
        return diagram_of(self.space.encoding, self.space.net, self.states)
