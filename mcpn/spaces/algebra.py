"""Sets of states and spaces of states: the small algebra in which every question is asked once.

Three spaces satisfy it: the graph in arrays (:mod:`mcpn.spaces.arrays`), the decision diagram
(:mod:`mcpn.spaces.diagrams.spaces`), and the composite of a mission's sections
(:mod:`mcpn.composite.composite`).
Each is either the *markings graph*, whose edges are firings, or the *alternatives graph*, whose states are
stable and whose edges are events, each run to completion. Places and transitions are always those of the
whole net, by index, so that a question is the same for every space.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence, Set
from functools import reduce
from operator import or_
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeAlias, TypeVar

from mcpn._kernel import Zdd
from mcpn.nets.petri import Marking, PetriNet
from mcpn.records import record
from mcpn.spaces.projections import ImageStore


class States(Protocol):
    """A set of states of one space. Sets never change, and sets of two spaces do not mix."""

    def __and__(self, other: Self, /) -> Self: ...
    def __or__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __bool__(self) -> bool:
        """Whether the set has a member."""

    def count(self) -> int:
        """How many members the set has, exact at any size."""

    def pick(self) -> Any:
        """One member, the same each time; what it is only its space knows. ``None`` for the empty set."""


S = TypeVar("S", bound=States)
Known = TypeVar("Known")
T = TypeVar("T")


Guards: TypeAlias = Mapping[int, S] | None
"""By transition, the states from which its edges may be taken."""


class Edge(NamedTuple):
    """One edge of a run.

    Args:
        transition: The transition of the event, or of the firing on a markings graph.
        target: The state after it, a member as :meth:`States.pick` gives it; ``None`` inside a run that
            a search has found, of which the end alone is kept.
        internal: The internal transitions fired after the event until the target is stable, where the space
            knows them; empty on markings graphs.
    """

    transition: int
    target: Any
    internal: tuple[int, ...] = ()


class Piece(NamedTuple, Generic[S]):
    """Some states of one part of a space.

    Args:
        states: The states.
        kind: Equal for pieces that differ in the names of objectives alone; ``None`` where none is alike.
        names: The objectives of the part, in the same order for pieces that are alike.
    """

    states: S
    kind: Hashable = None
    names: tuple[str, ...] = ()


@record(frozen=True, eq=False, slots=True)
class Without(Set[int]):
    """All of some transitions but a few: many such collections share the large set.

    Args:
        many: The transitions.
        few: Those that are left out.
    """

    many: frozenset[int]
    few: frozenset[int]

    def __contains__(self, transition: object) -> bool:
        return transition in self.many and transition not in self.few

    def __iter__(self) -> Iterator[int]:
        return (t for t in self.many if t not in self.few)

    def __len__(self) -> int:
        return len(self.many) - len(self.many & self.few)

    @classmethod
    def _from_iterable(cls, transitions: Iterable[Any]) -> frozenset[Any]:
        """What becomes of it in unions and other operations on sets."""
        return frozenset(transitions)


class Alike(Generic[Known]):
    """A memo of results that pieces which are alike share, but for names."""

    def __init__(self) -> None:
        self._known: dict[Hashable, tuple[tuple[str, ...], Known]] = {}

    def known(
        self, key: Hashable, names: tuple[str, ...], compute: Callable[[], Known]
    ) -> tuple[Known, Mapping[str, str]]:
        """The result for a key, computed once.

        Args:
            key: Equal where results are the same but for names.
            names: The names of the piece that is asked for.
            compute: Computes the result.

        Returns:
            The result, and a renaming of the names that it was computed with to those of the piece.
        """
        if key not in self._known:
            self._known[key] = names, compute()
        first_names, result = self._known[key]
        return result, dict(zip(first_names, names, strict=True))


class Space(Protocol[S]):
    """A finite graph of states, all reachable from its initial ones.

    ``transitions`` limits which transitions an edge may carry (all by default), and ``guards`` from which
    states some of them may be taken (from all by default); ``along`` limits the states that a run may pass
    (all by default).
    """

    @property
    def net(self) -> PetriNet:
        """The net whose places and transitions questions name."""

    @property
    def initial(self) -> S:
        """The initial state, as a set of one."""

    @property
    def everything(self) -> S:
        """All states."""

    @property
    def nothing(self) -> S:
        """No state."""

    @property
    def dead(self) -> S:
        """States without an edge."""

    @property
    def stable(self) -> S:
        """States that enable no internal transition; all where the net has no priorities."""

    @property
    def regions(self) -> Sequence[S]:
        """A partition of the states such that each cycle of the graph stays in one of its sets."""

    def single(self, state: Any) -> S:
        """The set that holds one member."""

    def marking(self, state: Any) -> Marking:
        """The marking of a member, as tokens by place."""

    def marked(self, places: Collection[int]) -> S:
        """States that mark at least one of some places."""

    def at_most(self, weights: Mapping[int, int], bound: int) -> S:
        """States whose weighted sum of tokens is at most a bound."""

    def restricted(self, states: S, marked: Collection[int], unmarked: Collection[int]) -> S:
        """Those of some states that mark all of some places, and none of others."""

    def varying(self, states: S) -> Collection[int]:
        """Places that may be marked in some of these states otherwise than initially; hardware aside."""

    def pieces(self, states: S) -> Iterator[Piece[S]]:
        """The states, part by part where the space has parts with places of their own."""

    def enabling(self, transitions: Collection[int]) -> S:
        """States with an edge of some of these transitions."""

    def firings(self, states: S) -> Mapping[int, int]:
        """In how many of some states each transition has an edge; transitions with none may be left out."""

    def image(self, states: S, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places: the image of a set on the hardware, say.

        Args:
            states: The states.
            places: The places.
            images: Where the image is made; number ``i`` stands for ``places[i]``.

        Returns:
            The family of the sets of numbers whose places a state marks.
        """

    def before(
        self,
        states: S,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
        among: S | None = None,
    ) -> S:
        """States with an edge into some states.

        Args:
            states: The states that edges lead to.
            transitions: What the edges may carry.
            guards: From where some of them may be taken.
            among: The states that are asked; a space with parts visits these parts alone.
        """

    def after(self, states: S, transitions: Collection[int] | None = None, guards: Guards[S] = None) -> S:
        """States that an edge leads to from some states."""

    def reaching(
        self,
        goal: S,
        along: S | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
    ) -> S:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""

    def reached(
        self,
        begin: S,
        along: S | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
    ) -> S:
        """States of ``along`` to which some run through it leads, those it begins from included."""

    def crossing(self, among: S, into: S) -> Iterator[tuple[int, S]]:
        """Transitions with edges from some states into others, each with the states before it.

        Args:
            among: The states before.
            into: The states after.

        Yields:
            Each transition once, in ascending order.
        """

    def staying(self, along: S, asked: S | None = None, transitions: Collection[int] | None = None) -> S:
        """States from which some maximal run, endless or ending in a dead state, stays in a set.

        Where transitions are given, a run is maximal that none of these continues.

        Args:
            along: The set.
            asked: Where given, the caller asks only whether some of these are among them: a space may stop
                as soon as it knows, with a set that meets these just where the exact one does.
            transitions: What the edges of the run may carry.
        """

    def reaches_without(self, goal: S, left_out: Sequence[frozenset[int]]) -> Sequence[bool]:
        """Whether the initial state reaches a goal without some transitions, for each of several sets."""

    def edges(self, state: Any) -> Iterator[Edge]:
        """The edges of one member."""

    def run(
        self,
        begin: Any,
        goal: S,
        along: S | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
    ) -> list[Edge] | None:
        """A short run from a member into a goal; a shortest one on arrays and diagrams.

        Args:
            begin: The member to begin from; the run is empty where it is in the goal.
            goal: Where the run leads.
            along: What it may pass before its last state.
            transitions: What its edges may carry.
            guards: From where some of them may be taken.

        Returns:
            The run, the same each time; ``None`` where there is none.
        """


def partition(
    space: Space[S], states: S, places: Sequence[int], images: ImageStore
) -> Iterator[tuple[frozenset[int], S]]:
    """Some states by which of some places they mark.

    Args:
        space: Their space.
        states: The states.
        places: The places.
        images: Where their image is made; it has at least as many numbers.

    Yields:
        For each combination that occurs, the places marked and the states that mark just these.
    """
    family = list(space.image(states, places, images))
    for numbers in family:
        marked = frozenset(places[number] for number in numbers)
        unmarked = [p for p in places if p not in marked]
        yield marked, states if len(family) == 1 else space.restricted(states, marked, unmarked)


def by_region(space: Space[S], unmet: Sequence[tuple[T, S]]) -> Iterator[tuple[S, list[T]]]:
    """The regions of a space, each with the constraints that some of its states do not meet.

    Regions are bisected, so that a constraint that most of the space meets is not asked of each region.

    Args:
        space: The space.
        unmet: Constraints, each with the states that do not meet it.

    Yields:
        Each region with its constraints, in the order of :attr:`Space.regions`.
    """

    def halved(regions: Sequence[S], unmet: Sequence[tuple[T, S]]) -> Iterator[tuple[S, list[T]]]:
        if len(regions) == 1 or not unmet:
            yield from ((region, [constraint for constraint, _ in unmet]) for region in regions)
            return
        half = len(regions) // 2
        for part in (regions[:half], regions[half:]):
            together = reduce(or_, part, space.nothing)
            yield from halved(part, [(c, states) for c, states in unmet if together & states])

    return halved(space.regions, unmet)
