"""Zero-suppressed decision diagrams with saturation, and explicit exploration, for 1-safe Petri nets."""

from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from typing_extensions import disjoint_base

class BudgetExceeded(RuntimeError):
    """An operation needed more new nodes or more steps than its budget; the store remains usable."""

class MemoryLimit(MemoryError):
    """The store's memory limit was hit; the store remains usable."""

class Cancelled(RuntimeError):
    """The store was told to give up: :meth:`Store.cancel`."""

def force(groups: Sequence[Sequence[int]], start: Sequence[int], rounds: int) -> list[int]:
    """An order that keeps the numbers of each group near each other: FORCE from a given order.

    Args:
        groups: Numbers below ``len(start)``, each group without repeats; the wider, the less it pulls.
        start: The order to begin with.
        rounds: How many to make at most.

    Returns:
        The order of least total span that was passed, with each span divided by the group's width.
    """

def closing(groups: Sequence[Sequence[int]], start: Sequence[int]) -> list[int]:
    """A greedy order: the next number is the one that brings groups under way nearest to their end.

    Args:
        groups: Numbers below ``len(start)``, each group without repeats.
        start: Where equals stand.
    """

def sloan(groups: Sequence[Sequence[int]], start: Sequence[int]) -> list[int]:
    """Sloan's order of the graph in which those of a group are neighbours.

    Args:
        groups: Numbers below ``len(start)``, each group without repeats.
        start: The first of each component says where its ends are looked for.
    """

def clustered(groups: Sequence[Sequence[int]], start: Sequence[int]) -> list[int]:
    """An order in which those stand together that many groups hold, and few others beside them.

    Args:
        groups: Numbers below ``len(start)``, each group without repeats; the wider, the less it pulls.
        start: Of two parts that become one, the one that is further up there on the average comes first.
    """

def stable_ends(
    offsets: npt.NDArray[np.int64], targets: npt.NDArray[np.int64], transient: npt.NDArray[np.bool_]
) -> tuple[npt.NDArray[np.int64], int]:
    """The one stable end of each state of a graph in compressed sparse rows; a stable state is its own.

    Returns:
        The ends, -1 where internal evolution need not end, and -1; or what was found of them up to a state
        whose successors have two ends, and that state.
    """

def incoming(
    offsets: npt.NDArray[np.int64], targets: npt.NDArray[np.uint32], keep: npt.NDArray[np.bool_] | None = ...
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.uint32]]:
    """A graph in rows by target: offsets, and the states before; of some edges where a mask is given."""

def spread(
    offsets: npt.NDArray[np.int64],
    targets: npt.NDArray[np.uint32],
    begin: npt.NDArray[np.bool_],
    along: npt.NDArray[np.bool_] | None = ...,
    keep: npt.NDArray[np.bool_] | None = ...,
) -> npt.NDArray[np.bool_]:
    """The states that some lead to through others, those they begin from included."""

def staying(
    offsets: npt.NDArray[np.int64],
    targets: npt.NDArray[np.uint32],
    incoming_offsets: npt.NDArray[np.int64],
    sources: npt.NDArray[np.uint32],
    along: npt.NDArray[np.bool_],
) -> npt.NDArray[np.bool_]:
    """The states from which some maximal run stays in a set."""

def sweep_reaching(
    offsets: npt.NDArray[np.int64],
    targets: npt.NDArray[np.uint32],
    goal: npt.NDArray[np.bool_],
    along: npt.NDArray[np.bool_] | None = ...,
    keep: npt.NDArray[np.bool_] | None = ...,
) -> tuple[npt.NDArray[np.bool_], bool]:
    """States that lead to a goal through others, found by sweeps over all states; whether these are all."""

def sweep_staying(
    offsets: npt.NDArray[np.int64], targets: npt.NDArray[np.uint32], along: npt.NDArray[np.bool_]
) -> tuple[npt.NDArray[np.bool_], bool]:
    """A set without states that leave it, dropped by sweeps over all states; whether none is left."""

def stays(
    offsets: npt.NDArray[np.int64],
    targets: npt.NDArray[np.uint32],
    begin: npt.NDArray[np.bool_],
    along: npt.NDArray[np.bool_],
) -> bool:
    """Whether a maximal run from one of some states stays in a set."""

def weigh(
    markings: npt.NDArray[np.uint64], terms: Sequence[tuple[int, int, int, int]]
) -> npt.NDArray[np.int64]:
    """By marking, a sum of fields of its words: each given by word, lowest bit, width and weight.

    Raises:
        OverflowError: A sum is beyond 64 bits.
    """

def satisfying(
    markings: npt.NDArray[np.uint64],
    alternatives: Sequence[Sequence[tuple[Sequence[tuple[int, int, int, int]], int]]],
) -> npt.NDArray[np.bool_]:
    """Which markings satisfy, of one of some alternatives, all bounds on sums of fields from above.

    Sums are exact; bounds beyond 2^126 are taken for that.
    """

def before(
    offsets: npt.NDArray[np.int64],
    targets: npt.NDArray[np.uint32],
    into: npt.NDArray[np.bool_],
    keep: npt.NDArray[np.bool_] | None = ...,
) -> npt.NDArray[np.bool_]:
    """The states with an edge into some states."""

@disjoint_base
class Zdd:
    """A set of markings; a marking is the set of its marked levels. Equal sets are equal handles.

    Events and conditions are those of the set's store; any other number is a ValueError.
    """

    def __or__(self, other: Zdd) -> Zdd: ...
    def __and__(self, other: Zdd) -> Zdd: ...
    def __sub__(self, other: Zdd) -> Zdd: ...
    def __bool__(self) -> bool: ...
    def __hash__(self) -> int: ...
    def subset(self, marked: Sequence[int] = ..., unmarked: Sequence[int] = ...) -> Zdd:
        """The markings with these levels marked and those unmarked."""

    def without(self, conditions: Sequence[int]) -> Zdd:
        """The markings that satisfy none of some conditions."""

    def onto(self, levels: Sequence[int]) -> Zdd:
        """What the markings are on some levels, all others forgotten and unmarked."""

    def count(self) -> int:
        """The exact number of markings."""

    def counts(self, conditions: Sequence[int]) -> list[int]:
        """The exact number of markings that satisfy each condition."""

    def first(self, conditions: Sequence[int]) -> int:
        """Index of the first condition that some marking satisfies, or -1."""

    def largest(self, weights: Sequence[int]) -> int:
        """The most weight of marked levels in one marking.

        Raises:
            ValueError: The set is empty, or a weight is beyond 2^105.
        """

    def nodes(self) -> int:
        """Number of nodes of the diagram, terminals aside."""

    def to_bytes(self) -> bytes:
        """The set as a table of its nodes, for :meth:`Store.from_bytes` of a store with as many levels."""

    def pick(self) -> list[int] | None:
        """Some marking, the same each time."""

    def images(self, events: Sequence[int], within: Zdd | None = ...) -> Zdd:
        """The markings after one firing of any of some events, those of a set only where one is given."""

    def beyond(self, before: Zdd, events: Sequence[int]) -> Zdd:
        """This set minus the images of `before` under `events`."""

    def saturate(
        self, events: Sequence[int], max_nodes: int = ..., within: Zdd | None = ..., max_steps: int = ...
    ) -> Zdd:
        """The markings reachable by any number of firings.

        Args:
            events: What may fire.
            max_nodes: Bounds the nodes made; 0 for no bound.
            within: Where given, only markings of this set are begun from and passed through.
            max_steps: Bounds the steps: results that the store does not remember; 0 for no bound. A closure
                that a budget ended goes on from what is remembered of it when it is asked for again.
        """

    def weighing(self, weights: Sequence[int], least: int, most: int) -> Zdd:
        """The markings whose marked levels weigh at least and at most so much.

        Raises:
            ValueError: A weight is beyond 2^105. Sums and bounds are exact, whatever they are.
        """

    def __iter__(self) -> Markings:
        """Each marking as its marked levels, in a fixed order."""

@disjoint_base
class Markings(Iterator[list[int]]):
    """The markings of a set, one by one."""

    def __iter__(self) -> Markings: ...
    def __next__(self) -> list[int]: ...

@disjoint_base
class Store:
    """Owns nodes, their unique table and a bounded operation cache; sets of two stores do not mix.

    Garbage is collected when there is much of it and before memory runs out. Operations release the GIL;
    a store does one at a time, and another thread that asks meanwhile gets a RuntimeError.
    """

    def __new__(cls, levels: int, memory_limit: int = ...) -> Store: ...
    def empty(self) -> Zdd: ...
    def from_bytes(self, data: bytes) -> Zdd:
        """The set that :meth:`Zdd.to_bytes` told; a ValueError for anything else."""

    def from_markings(self, rows: npt.NDArray[np.uint64], bits: Sequence[int]) -> Zdd:
        """The set of markings given as rows of words.

        ``bits`` says by level which bit tells of it, -1 that it is unmarked.
        """

    def singleton(self, marked: Sequence[int]) -> Zdd: ...
    def event(
        self,
        consume: Sequence[int],
        produce: Sequence[int],
        read: Sequence[int] = ...,
        zero: Sequence[int] = ...,
    ) -> int:
        """An event: levels that go from marked to unmarked, back, stay marked, stay unmarked."""

    def condition(self, marked: Sequence[int], unmarked: Sequence[int] = ...) -> int:
        """A condition on markings: these levels marked, those unmarked."""

    def branch(
        self,
        level: int,
        consume: int | None = ...,
        produce: int | None = ...,
        read: int | None = ...,
        zero: int | None = ...,
    ) -> int:
        """An event, or a condition, that goes on depending on a level.

        Args:
            level: The level.
            consume: What follows on levels below where it goes from marked to unmarked; ``None``: it never
                does.
            produce: The same where it goes from unmarked to marked.
            read: The same where it is marked and stays so.
            zero: The same where it is unmarked and stays so.
        """

    def collect(self) -> None:
        """Frees every node that no handle reaches."""

    def cancel(self) -> None:
        """Ends the operation under way in another thread, and any that is begun later: :class:`Cancelled`."""

    progress: Callable[[int], object] | None
    """Called about each hundredth of a second of CPU time with the number of nodes, garbage included."""

    @property
    def levels(self) -> int: ...
    @property
    def live_nodes(self) -> int: ...
    @property
    def peak_nodes(self) -> int:
        """Most nodes at once during the last operation, garbage included."""

    @property
    def steps(self) -> int:
        """Steps of the last operation: results that the store did not remember."""

    @property
    def closed(self) -> int:
        """How far the last closure came: levels from this one on are closed; the number of levels: none."""

    @property
    def collections(self) -> int: ...
    @property
    def bytes(self) -> int:
        """What the memory limit bounds: nodes, tables, and what counts and sums keep while they work."""

class StateLimit(RuntimeError):
    """An exploration found more states than allowed."""

@disjoint_base
class Exploration:
    """Markings found one by one, and the firings between them if they were asked for."""

    @property
    def states(self) -> int: ...
    @property
    def edges(self) -> int: ...
    @property
    def dead(self) -> int: ...
    @property
    def stable(self) -> int: ...
    @property
    def most_tokens(self) -> int: ...
    @property
    def transient(self) -> int:
        """Transient markings kept by a proof of :meth:`SafeNet.settle`."""

    @property
    def parted(self) -> int:
        """Transient markings that it left in all ways."""

    @property
    def decided(self) -> list[int]:
        """Edges by what it took to know that one order is enough behind them.

        No two transitions could fire at a time; their arcs do not conflict; units exclude those that do; what
        may fire behind the event does not conflict; or the transient markings were left in all ways.
        """

    @property
    def bounds(self) -> list[int]:
        """Most tokens by place, of a :class:`CountedNet`."""

    @property
    def trouble(self) -> tuple[int, list[int], Literal["unsafe", "endless", "parted"]] | None:
        """Where it ended early: a state, the firings from there on, and what the last of them is.

        It is unsafe; or it closes a circle of internal firings; or it and the one before it are two ways from
        one marking, each to one stable end, and not to the same.
        """

    def run(self, state: int) -> list[int]:
        """The transitions by which a state was found: a shortest run."""

    def lists(self) -> tuple[list[int], list[int], list[int], list[int]]:
        """The words of all markings, offsets, targets and labels, for small results: nothing is taken."""

    def take_markings(self) -> npt.NDArray[np.uint64]:
        """Rows of words, a bit for each place; may be taken once, as the other arrays."""

    def take_offsets(self) -> npt.NDArray[np.uint64]: ...
    def take_targets(self) -> npt.NDArray[np.uint32]: ...
    def take_labels(self) -> npt.NDArray[np.uint32]:
        """Empty after :meth:`SafeNet.explore`: see :meth:`SafeNet.labels`."""

@disjoint_base
class Explorer:
    """An exploration that can stop and go on; another thread may only cancel it."""

    def run(self, max_firings: int) -> bool:
        """Goes on for about so many firings (0: any number); whether it came to its end.

        Raises:
            MemoryLimit: Its tables do not fit.
            Cancelled: It was cancelled.
        """

    def take(self) -> Exploration:
        """What was found; nothing can be asked of this object afterwards."""

    def cancel(self) -> None:
        """Ends what it does now and later, from another thread."""

    @property
    def states(self) -> int:
        """Markings found."""

    @property
    def explored(self) -> int:
        """Markings whose firings are all known."""

    @property
    def edges(self) -> int: ...
    @property
    def bytes(self) -> int: ...

class BigSteps:
    """The big steps of the events of a net: what they make of stable markings, proved to be the one outcome.

    Each is of every stable marking that marks some places and leaves some others empty; several that fit one
    marking make the same of it. They stand in bytes, as 32-bit numbers: how many levels of a store it
    touches, and for each, in their order, the level times 4 with what happens to it: 0 it goes from marked to
    unmarked, 1 back, 2 it stays marked, 3 unmarked. Or a function tells of a set of markings at once: 2^32 -
    1, how many numbers it has, and four for each of its parts, of which the last is the whole: a level, what
    happens to it, the part for the levels below (0: they stay as they are), and the part for what else may
    happen to that level (0: nothing); parts are numbered from 1 on, and name those before them.

    Args:
        net: The net, with priorities.
        initial: Its initially marked places.
        places: By level of the store, the place that it says is marked; -1 where it speaks of none.
        partners: Places without a level, each with the level that says that it is not marked.
        max_bytes: Bytes that markings may take.
        max_transient: Transient markings that may be kept behind one event.
        few_cases: Cases that may tell where a transition may fire alone, before it is asked of whole sets.
    """

    def __init__(
        self,
        net: SafeNet,
        initial: Sequence[int],
        places: Sequence[int],
        partners: Sequence[tuple[int, int]],
        max_bytes: int,
        max_transient: int,
        few_cases: int,
    ) -> None: ...
    def start(self, store: Store) -> Zdd | None:
        """The stable marking behind the initial one; ``None`` where it is not one, or a firing is unsafe."""

    def cover(self, markings: Zdd, event: int, most: int) -> tuple[bytes, int, bool] | None:
        """Big steps of an event that fit some stable markings, which enable it; how many; whether all.

        They are ``most`` at most; ``None`` where it has no outcome, or may have two, or a firing is unsafe.
        """

    def after(self, markings: Zdd, event: int) -> tuple[Zdd, Zdd, Firings] | None:
        """The stable markings behind an event from some that enable it, run from all of them at once.

        Returns:
            The stable markings; those of the given ones that are left, for in some marking behind them no
            transition may fire alone; and what fired. ``None`` where a firing is unsafe, or evolution does
            not end.
        """

    def after_together(
        self, starts: Sequence[tuple[Zdd, int]], most_steps: int = 0
    ) -> tuple[Zdd, list[tuple[Zdd, Firings]]] | None:
        """The same of several events, each from markings of its own: evolution is run once behind all.

        Returns:
            The stable markings behind any of them; by event those that are left, and what fired. Where a
            budget of steps is not 0 and they are more, it raises :class:`BudgetExceeded`.
        """

    def function(self, markings: Zdd, firings: Firings, wide: bool = False) -> bytes | None:
        """What firings make of each of the markings in which they happened, as one function.

        It is of these markings alone, unless it may be wide: then it is of others, too, where that makes it
        smaller, and is asked of reachable ones only. It is ``None`` where it is too large. What an evolution
        makes of the markings that its events made is found once for those of its events that come in a row.

        Raises:
            ValueError: The event can happen in none of the markings.
        """

@disjoint_base
class Firings:
    """An event and the internal transitions that fired behind it, each in all markings in which it might."""

def choices(store: Store, ways: bytes, as_: str, marked: Sequence[int]) -> list[int]:
    """Events of the store that together do what some big steps do, as few as that is quick.

    Args:
        store: The store.
        ways: The big steps; where several fit a marking they make the same of it.
        as_: "ahead"; "back": events undo them; "where": they are conditions, that one of them fits.
        marked: Levels that must be marked, too.
    """

class SafeNet:
    """A net as it acts on 1-safe markings.

    Each transition is given by the places that it needs, takes from and puts to, its rank
    (:attr:`mcpn.nets.petri.PetriNet.ranks`), and whether it is unsafe wherever it fires.
    """

    def __init__(
        self,
        places: int,
        transitions: Sequence[tuple[Sequence[int], Sequence[int], Sequence[int], int, bool]],
        priorities: bool,
    ) -> None: ...
    def explore(
        self,
        initial: Sequence[int],
        edges: bool,
        max_states: int,
        max_bytes: int,
        progress: Callable[[int, int], object] | None = ...,
    ) -> Exploration:
        """Every reachable marking, breadth first, priorities respected; edges are kept where asked for."""

    def explorer(self, initial: Sequence[int], max_bytes: int, edges: bool = ...) -> Explorer:
        """An exploration as :meth:`explore` makes that has not begun yet; edges are kept if they fit."""

    def labels(self, markings: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint32]:
        """The transitions on the edges of some markings, as :meth:`explore` lists edges."""

    def passages(
        self,
        markings: npt.NDArray[np.uint64],
        offsets: npt.NDArray[np.int64],
        targets: npt.NDArray[np.int64],
        events: npt.NDArray[np.uint32],
        leaving: Sequence[Sequence[int]],
        control: Sequence[tuple[Sequence[int], Sequence[int]]],
    ) -> tuple[npt.NDArray[np.uint32], list[tuple[list[int], list[int]]]]:
        """Which activities leave an alternative, and which of them come to rest, on the way of each edge.

        Each event is run to completion, the lowest internal transition of the first rank first.

        Args:
            markings: Stable markings, of a net with priorities.
            offsets: Where the edges of each begin, and where the last end.
            targets: By edge, the marking that it leads to.
            events: By edge, its transition.
            leaving: By transition, the activities of which it leaves an alternative.
            control: By activity, its places, and those that are marked while it rests.

        Returns:
            By edge, the number of what happens on its way, 2^32 - 1 where it does not end in its target; and
            what happens, by number: activities left, and those of them that have come to rest.
        """

    def units(self, initial: Sequence[int]) -> list[list[int]]:
        """Sets of places that hold one token at most together, from a marking on: no firing adds to one.

        A search of bounded length finds them; places may be in several, or in none.
        """

    def settle(
        self,
        initial: Sequence[int],
        orders: Literal["one", "enough", "every"],
        max_states: int,
        max_transient: int,
        max_bytes: int,
        progress: Callable[[int, int], object] | None = ...,
        max_firings: int = ...,
    ) -> Exploration:
        """Stable markings and events only, of a net with priorities.

        Each event is run to completion in one order of internal transitions, or in enough of them to prove
        that all have one end, or in every order. A run in one order that is very long is called endless, too.
        """

class CountedNet:
    """A net with several tokens in a place; a marking is a row of words, a field for each place.

    Each field is given by its word, its lowest bit there and its width of at most 62 bits; fields do not
    overlap. Each transition is given by the tokens that it needs, by what it changes, and its rank.
    """

    def __init__(
        self,
        fields: Sequence[tuple[int, int, int]],
        transitions: Sequence[tuple[Sequence[tuple[int, int]], Sequence[tuple[int, int]], int]],
        priorities: bool,
    ) -> None: ...
    def explore(
        self,
        initial: Sequence[int],
        edges: bool,
        max_states: int,
        max_bytes: int,
        progress: Callable[[int, int], object] | None = ...,
    ) -> Exploration:
        """Every reachable marking, as :meth:`SafeNet.explore`; trouble is a firing beyond a field."""

class Goals:
    """Conditions on markings, as nodes that name earlier ones.

    Each node is a kind (``all``, ``any``, ``at_most``, ``dead``, ``not_dead``), the nodes inside it, and for
    ``at_most`` weights of places and the bound of their sum.
    """

    def __init__(
        self, places: int, nodes: Sequence[tuple[str, Sequence[int], Sequence[tuple[int, int]], int]]
    ) -> None: ...

class TokenNet:
    """A net with any number of tokens in a place, for walks and searches that store no whole space.

    Each transition is given by the tokens that it needs, by what it changes, and its rank.
    """

    def __init__(
        self,
        places: int,
        transitions: Sequence[tuple[Sequence[tuple[int, int]], Sequence[tuple[int, int]], int]],
        priorities: bool,
    ) -> None: ...
    def walk(
        self,
        initial: Sequence[int],
        goals: Goals,
        roots: Sequence[int],
        steps: int,
        length: int,
        seed: int,
        unsafe: bool = ...,
        counts: Sequence[int] = ...,
        order: Sequence[int] = ...,
    ) -> list[tuple[int, list[int]]]:
        """Runs to the goals that were met; a second token in a place has the number after the last goal."""

    def seek(self, initial: Sequence[int], goals: Goals, root: int, stubborn: bool) -> GoalSearch:
        """Best-first search for a marking of a goal."""

    def plan(self, initial: Sequence[int], goals: Goals, root: int, seed: int) -> GoalSearch:
        """Greedy best-first search by the additive heuristic of planning.

        The seed draws the order of markings that are equally near.
        """

@disjoint_base
class GoalSearch:
    """A search of a net for a marking of a goal; it goes on where it rested or where a limit ended it."""

    def search(self, max_states: int, max_bytes: int) -> tuple[str, int, list[int]]:
        """``reached``, ``unreachable``, ``pause`` or the limit hit; the markings seen; the run."""

@disjoint_base
class PathFinder:
    """Looks for paths from a marking that an automaton accepts.

    An edge of the automaton is given by the roots that hold, the bits of its marks, its target, what fires
    (``None``: anything) and whether nothing may; it accepts every path from states of ``accepting_all``.
    States of one strongly connected component have one number in ``components``.
    """

    def __init__(
        self,
        net: TokenNet,
        initial: Sequence[int],
        goals: Goals,
        roots: Sequence[int],
        edges: Sequence[Sequence[tuple[Sequence[int], int, int, Sequence[int] | None, bool]]],
        marks: int,
        accepting_all: Sequence[bool],
        components: Sequence[int],
    ) -> None: ...
    def search(
        self, max_steps: int, max_bytes: int, seed: int, guided: bool, pause: int
    ) -> tuple[str, list[int], int | None]:
        """``found``, ``none``, the limit hit (``steps``, ``bytes`` or ``tokens``) or ``pause``; run; cycle.

        Depth first a step follows an edge of the product; guided by the additive heuristic it evaluates one
        of its members. A pause comes after so many steps: asked the same again, it goes on from there.
        """

@disjoint_base
class Checker:
    """Decides formulas of CTL at a marking, looking at no more markings than a depth-first search needs.

    Each operator is a kind (``goal``, ``not``, ``all``, ``any``, ``next``, ``until``, ``always``) and the
    numbers of earlier operators inside it; of ``goal`` the number of a node of the goals. Paths are maximal.
    """

    def __init__(
        self,
        net: TokenNet,
        initial: Sequence[int],
        goals: Goals,
        operators: Sequence[tuple[str, Sequence[int]]],
        max_bytes: int,
    ) -> None: ...
    def decide(self, root: int, max_steps: int, seed: int = ..., pause: int = ...) -> str:
        """``yes`` or ``no``, or the limit that was hit: ``steps``, ``bytes`` or ``tokens``; or ``pause``.

        What is found out is kept, for other operators and for the same one with more steps. The seed draws
        the order in which successors are tried; 0 for that of the transitions. A pause comes about every so
        many steps: asked the same again, it goes on from there; asked anything else, it begins anew.
        """

    @property
    def markings(self) -> int:
        """Markings looked at."""
