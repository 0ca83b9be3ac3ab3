"""Why a mission is not confluent: who wants what at the same moment, and what can be changed.

Two runs of a :class:`mcpn.errors.ConfluenceError` part at two internal transitions that take the same token.
The token's element is what is wanted, the elements of the transitions are the rivals. Every engine finds its
error on its own; :mod:`mcpn.composite.clash` says the clash in a sentence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product
from typing import NamedTuple

from mcpn.drawing.compose import MissionNet
from mcpn.errors import ConfluenceError
from mcpn.mission.core.objectives_graph import ParallelSection
from mcpn.nets.petri import Marking, Transition
from mcpn.nets.provenance import Provenance


class Rival(NamedTuple):
    """One who wants what another wants at the same moment.

    Args:
        kind: ``activity``, ``objective``, or ``software`` for a resource that is asked for.
        name: Its name.
        objectives: Objectives that run, or are about to, and need it; in the mission's order.
    """

    kind: str
    name: str
    objectives: tuple[str, ...] = ()


class Clash(NamedTuple):
    """What two want at the same moment, so that the outcome depends on who comes first.

    Args:
        kind: ``hardware`` or ``software`` (both ask for it), ``activity`` (both start it), ``producer`` (one
            stops it while another asks for what it produces), ``stop`` (an activity is stopped while it
            changes its alternative), or empty where it is none of these.
        wanted: Names of what is wanted, in the net's order.
        rivals: Both, in the order of their names.
        where: ``branches`` (of a parallel block), ``objective`` (both are for the same one), ``chain`` (and
            one activity of it needs both).
        block: The innermost parallel block whose branches they are in, if there is one.
    """

    kind: str
    wanted: tuple[str, ...]
    rivals: tuple[Rival, Rival]
    where: str
    block: str | None


def find_clash(mission_net: MissionNet, error: ConfluenceError) -> Clash:
    """Finds who wants what where the two runs of an error part.

    Args:
        mission_net: The net of the mission, or of a part of it, that the error's runs are of.
        error: The error.
    """
    net = mission_net.net
    first, second = error.runs
    parted = next(i for i, (a, b) in enumerate(zip(first, second, strict=False)) if a != b)
    marking = net.initial
    for name in first[:parted]:
        marking = net.fire(marking, net.transition_index[name])
    rest = [[net.transitions[net.transition_index[name]] for name in run[parted:]] for run in (first, second)]
    return _Finding(mission_net, marking).clash(*_rivals(*rest))


def _rivals(first: Sequence[Transition], second: Sequence[Transition]) -> tuple[Transition, Transition]:
    """The first two firings, one of each run, of which one takes what the other needs.

    They are those at which the runs part, but where priorities hold back what follows the other one: then
    those two share no token, and the runs go on to two that do.
    """
    pairs = sorted(product(range(len(first)), range(len(second))), key=lambda pair: (sum(pair), pair))
    for i, j in pairs:
        one, other = first[i], second[j]
        if one != other and _contended(one, other):
            return one, other
    return first[0], second[0]


def _contended(one: Transition, other: Transition) -> list[int]:
    """Places of the tokens that one of them takes and the other needs."""
    takes = [{p for p, _ in t.consume} for t in (one, other)]
    needs = [{p for p, _ in (*t.consume, *t.read)} for t in (one, other)]
    return sorted(takes[0] & needs[1] | takes[1] & needs[0])


class _Finding:
    def __init__(self, mission_net: MissionNet, marking: Marking) -> None:
        self.mission_net = mission_net
        self.usage = mission_net.usage
        said = [mission_net.roles[p] for p, tokens in enumerate(marking) if tokens and p in mission_net.roles]
        here = {name for kind, name in said if kind in ("objective", "pending")}
        self.objectives = [section for section in mission_net.graph.walk() if section.name in here]

    def clash(self, one: Transition, other: Transition) -> Clash:
        wanted = dict.fromkeys(self._contended(one, other))
        kinds = {kind for kind, _ in wanted}
        rivals = sorted((self._rival(one), self._rival(other)), key=lambda r: (r.name, r.kind))
        names = tuple(name for _, name in wanted)
        objectives = {rival.kind for rival in rivals} == {"objective"}
        if rivals[0].kind == "activity" and rivals[0] == rivals[1]:
            kind, names = "stop", (rivals[0].name,)
        elif kinds and kinds <= {"hardware", "software"} and {r.kind for r in rivals} == {"activity"}:
            kind = "hardware" if "hardware" in kinds else "software"
        elif kinds == {"activity"} and objectives:
            kind = "activity"
        elif "software" in {r.kind for r in rivals}:
            asked = next(r.name for r in rivals if r.kind == "software")
            kind, names = "producer", (self.usage.producer[asked],)
        else:
            kind = ""
        a, b = rivals
        return Clash(kind, names, (a, b), self._where(a, b), self._block(a, b))

    def _where(self, one: Rival, other: Rival) -> str:
        if one.kind != "activity" or other.kind != "activity" or one.objectives != other.objectives:
            return "branches"
        named = {
            a for section in self.objectives if section.name in one.objectives for a in section.activities
        }
        needs = (self.usage.closure(a) for a in named)
        return "chain" if any({one.name, other.name} <= below for below in needs) else "objective"

    def _contended(self, one: Transition, other: Transition) -> Iterator[tuple[str, str]]:
        """Elements of the tokens that one of them takes and the other needs."""
        for place in _contended(one, other):
            origin = self.mission_net.net.places[place].provenance
            if origin is not None:
                yield origin.kind, origin.name

    def _rival(self, transition: Transition) -> Rival:
        origin = transition.provenance or Provenance("transition", transition.name)
        if origin.kind not in ("activity", "alternative"):
            return Rival(origin.kind, origin.name)
        activity = origin.name.partition(".")[0]
        needing = (
            section.name
            for section in self.objectives
            if any(activity in self.usage.closure(a) for a in section.activities)
        )
        return Rival("activity", activity, tuple(needing))

    def _block(self, one: Rival, other: Rival) -> str | None:
        sides = [set(r.objectives) if r.kind == "activity" else {r.name} for r in (one, other)]
        innermost = None
        for graph in self.usage.graphs():
            for section in graph.sections:
                branches = section.branches if isinstance(section, ParallelSection) else ()
                inside = [{inner.name for inner in b.graph.walk()} | {b.name} for b in branches]
                if any(sides[0] & a and sides[1] & b for a, b in permutations(inside, 2)):
                    innermost = section.name
        return innermost
