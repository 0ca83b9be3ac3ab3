"""The state spaces of one net: the one place where engines are built, each space once.

Questions ask :class:`Spaces` for a space by an engine (:mod:`mcpn.spaces.engines`). What has been built for
one question is there for the next.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import cached_property, update_wrapper
from inspect import signature
from math import inf
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Self, TypeAlias, TypeVar, Unpack

from mcpn._kernel import Exploration
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.algebra import Space
from mcpn.spaces.diagrams.bounded import reach_markings, reaching_markings
from mcpn.spaces.diagrams.race import Resting
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reaching
from mcpn.spaces.engine_names import EXPLICIT, LOCAL, Asked, Asking, Engine, On
from mcpn.spaces.engines import FEW_FIRINGS, Choice, choices_of_net, refuse_unknown
from mcpn.spaces.formula_names import PROGRESS, Names
from mcpn.spaces.markings.explicit import MAX_MARKINGS, Counts, KernelNet, count, explore
from mcpn.spaces.stable.run_to_completion import MAX_STABLE_STATES, PROOF_BY_MARKINGS
from mcpn.steps import Doing, step
from mcpn.turns import Pausing

if TYPE_CHECKING:
    from mcpn.spaces.arrays import ArraySpace
    from mcpn.spaces.bits import BitSpace
    from mcpn.spaces.diagrams.order import Order
    from mcpn.spaces.pyeda_reference import ReferenceCounts
    from mcpn.spaces.search.goal import Formula
    from mcpn.spaces.stable.alternatives import AlternativesGraph

# Each engine is loaded when it is asked.

FEW_STATES, FEW_EDGES = 1_000, 10_000
"""States, and edges between them, up to which a graph is held in integers in place of arrays."""

Owner = TypeVar("Owner", bound="Spaces")
Given = ParamSpec("Given")
Built = TypeVar("Built")
Builder: TypeAlias = Callable[Concatenate[Owner, Given], Built]
Subject: TypeAlias = "Spaces | PetriNet"
"""What questions are asked of: spaces that may be there already, or the net that they are to be built of."""


class _Listing:
    """The stable states of a net, listed and proved: in integers where they are few, in arrays when asked.

    Args:
        prepared: The net.
        exploration: The states, whose arrays are taken from it once.
    """

    def __init__(self, prepared: KernelNet, exploration: Exploration) -> None:
        self._prepared, self._exploration = prepared, exploration
        self.few: BitSpace | None = None
        if exploration.states <= FEW_STATES and exploration.edges <= FEW_EDGES:
            from mcpn.spaces.bits import BitSpace

            self.few = BitSpace(prepared.net, *prepared.lists(exploration))

    @cached_property
    def graph(self) -> AlternativesGraph:
        """The graph in arrays."""
        from mcpn.spaces.stable.alternatives import of_listing

        return of_listing(self._prepared, self._exploration)

    @cached_property
    def space(self) -> ArraySpace:
        """Its space."""
        from mcpn.spaces.arrays import ArraySpace

        return ArraySpace(self.graph)


def kept(limit: str | None = None) -> Callable[[Builder[Owner, Given, Built]], Builder[Owner, Given, Built]]:
    """Makes a method of spaces build once for equal arguments, and return that, or raise its error, again.

    Args:
        limit: The argument that limits the states, or states and firings, if one does. What was built within
            a limit serves every higher one; a limit that was hit does not.
    """

    def once(build: Builder[Owner, Given, Built]) -> Builder[Owner, Given, Built]:
        bind = signature(build).bind

        def built(self: Owner, /, *args: Given.args, **kwargs: Given.kwargs) -> Built:
            given = bind(self, *args, **kwargs)
            given.apply_defaults()
            most = 0 if limit is None else given.arguments.pop(limit)
            key = build.__name__, *[*given.arguments.values()][1:]
            if key in self._kept:
                before, outcome = self._kept[key]
                if before == most or (before < most and not isinstance(outcome, LimitError)):
                    if isinstance(outcome, LimitError | SemanticsError):
                        raise copy.copy(outcome)
                    return outcome  # type: ignore[no-any-return]
            try:
                outcome = build(self, *args, **kwargs)
            except (LimitError, SemanticsError) as error:
                self._kept[key] = most, copy.copy(error)  # without its traceback, which holds much
                raise
            self._kept[key] = most, outcome
            return outcome

        update_wrapper(built, build)
        return built

    return once


class Spaces:
    """The state spaces of one net, each built when it is first asked for, and then kept.

    Also an error is kept: a limit that was hit, a net that is not safe, an event with two outcomes. What was
    built within a limit on states serves every higher limit. Who listens and which workers help
    (:mod:`mcpn.steps`, :mod:`mcpn.workers`) matters while a space is built; the space does not depend on it.

    What questions must know of what the net means is asked here, too: which graph they speak of, what names
    stand for, which engine comes first. Here it means nothing but itself; for a mission's net,
    :class:`mcpn.answers.spaces_by_engine.MissionSpaces` says more.

    Args:
        net: The net; an attribute, too.

    Attributes:
        asked_on: The graph that questions speak of by default.
        one_outcome: Whether each event is known to have one outcome before any space is built.
        engine: Who is asked, ``auto`` unless :meth:`bound` says another.
        max_states: The user's limit on states that are listed; ``None`` for that of each engine.
    """

    asked_on: On = "markings"
    one_outcome: bool = False
    engine: Asked = "auto"
    max_states: int | None = None

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self._kept: dict[Hashable, tuple[Any, Any]] = {}

    def bound(self, **asked: Unpack[Asking]) -> Self:
        """The same spaces, asked of an engine or within a limit; what one of them builds, all have.

        Raises:
            InputError: There is no such engine.
        """
        if not asked:
            return self
        refuse_unknown(asked.get("engine", "auto"))
        other = copy.copy(self)
        vars(other).update(asked)
        return other

    def names(self) -> Names:
        """Looks up what names in formulas stand for."""
        return Names(self.net)

    def progress(self) -> Sequence[tuple[Formula, tuple[int, ...]]]:
        """The fairness constraint of that name: conditions and transitions, as of a Justice.

        Raises:
            InputError: The net is of no mission.
        """
        raise InputError.at(None, f"the constraint {PROGRESS} speaks of missions, and this net is of none")

    def choices(self, on: On) -> Iterator[Choice]:
        """The engines to ask, the one that promises most first; see :mod:`mcpn.spaces.engines`."""
        refuse_unknown(on=on)
        return choices_of_net(self.engine, self.max_states)

    def few(self) -> bool:
        """Whether few stable states are expected, so that they are listed before anything else is tried."""
        return False

    def space(
        self,
        by: Choice | Engine,
        on: On = "markings",
        *,
        tokens: bool = True,
    ) -> Space[Any]:
        """The space on one of the graphs, by one of the engines.

        Args:
            by: The engine.
            on: The graph; the alternatives graph is of nets with priorities.
            tokens: Whether the places of a net without priorities may hold several tokens.

        Raises:
            InputError: The net has no such graph.
            SemanticsError: The net is unbounded, or not 1-safe though it has priorities or may hold no more
                than one token in a place; of the alternatives graph, internal evolution is not confluent or
                divergent.
            LimitError: A limit was hit.
        """
        by = Choice(by) if isinstance(by, str) else by
        if on == "alternatives" and not self.net.priorities:
            raise InputError.at(None, "the alternatives graph is of missions: this net has no priorities")
        if by.engine == LOCAL:
            message = (
                "composition makes the alternatives graph of a mission: sections hand on stable states only"
            )
            raise InputError.at(None, message)
        if on == "markings":
            return self.markings(by, tokens=tokens)
        return self._listed(self.within(by)).space if by.engine == EXPLICIT else self.reduced(by)[0]

    def within(self, by: Choice) -> tuple[int, float]:
        """How many stable states may be listed, and how many firings that may take.

        Raises:
            LimitError: There are too many in any case.
        """
        return by.limit, FEW_FIRINGS if by.brief else inf

    def stable(self, by: Choice) -> tuple[Space[Any], str]:
        """The alternatives graph by listing, and the proof of confluence used; see :meth:`space`.

        Few states are not in arrays, for to load these takes longer than to answer.
        """
        listing = self._listed(self.within(by))
        return listing.few or listing.space, PROOF_BY_MARKINGS

    def listed(self) -> AlternativesGraph:
        """The alternatives graph with its stable states listed, and proved; its errors are the net's own."""
        return self._listed((MAX_STABLE_STATES if self.max_states is None else self.max_states, inf)).graph

    @kept("within")
    def _listed(self, within: tuple[int, float]) -> _Listing:
        """The stable states within limits on states and on firings."""
        from mcpn.spaces.stable.nearest_nonconfluence import proved

        step(Doing.LISTING)
        max_states, firings = within
        prepared = KernelNet(self.net)
        max_firings = None if firings == inf else int(firings)
        return _Listing(prepared, proved(prepared, max_states=max_states, max_firings=max_firings))

    @kept("max_states")
    def unproved(self, max_states: int) -> ArraySpace:
        """The alternatives graph with its stable states listed, confluence taken for granted."""
        from mcpn.spaces.arrays import ArraySpace
        from mcpn.spaces.stable.alternatives import direct

        return ArraySpace(direct(self.net, proof=False, max_states=max_states))

    def markings(self, by: Choice, *, tokens: bool = True) -> ArraySpace | DiagramMarkings:
        """The markings graph; see :meth:`space`."""
        tokens = tokens and not self.net.priorities  # else the net must be 1-safe
        if by.engine == EXPLICIT:
            return self._arrays(tokens, by.limit)
        return self._drawn(tokens, self._lists_early(by))

    def _lists_early(self, by: Choice) -> bool:
        """Whether few markings are listed: ``auto`` chose, no diagram was asked for by name."""
        return by.why is not None and not self.net.priorities

    @kept("max_states")
    def _arrays(self, tokens: bool, max_states: int) -> ArraySpace:
        step(Doing.LISTING_MARKINGS)
        from mcpn.spaces.arrays import ArraySpace

        if not tokens:
            return ArraySpace(explore(self.net, max_states=max_states))
        from mcpn.spaces.markings.counted import explore_markings

        return ArraySpace(explore_markings(self.net, max_states=max_states))

    @kept()
    def _drawn(self, tokens: bool, edges: bool) -> ArraySpace | DiagramMarkings:
        """The markings graph on a diagram, or on arrays where the markings were listed."""
        space = self.symbolic(tokens=tokens, edges=edges)
        if space.listed is None:
            return DiagramMarkings(space)
        from mcpn.spaces.arrays import ArraySpace

        return ArraySpace(space.listed)

    def symbolic(self, *, tokens: bool = True, edges: bool = False) -> SymbolicSpace:
        """All markings as a diagram.

        Args:
            tokens: Whether places may hold several tokens.
            edges: Whether firings are kept where the markings were listed, if they fit.
        """
        return self._symbolic(tokens and not self.net.priorities, edges)

    @kept()
    def _symbolic(self, tokens: bool, edges: bool) -> SymbolicSpace:
        step(Doing.MAKING_DIAGRAM)
        return self._reaching(tokens, edges).made

    @kept()
    def _reaching(self, tokens: bool, edges: bool) -> Resting[SymbolicSpace]:
        work = reaching_markings if tokens else reaching  # without tokens the net must be 1-safe
        return Resting(work(self.net, edges=edges))

    @property
    @kept()
    def diagram(self) -> DiagramMarkings:
        """All markings of a bounded net on a diagram, with as many tokens as there are."""
        return DiagramMarkings(self.symbolic())

    def reduced(self, by: Choice, *, proof: bool = True) -> tuple[Space[Any], str]:
        """The alternatives graph by way of all markings of a 1-safe net, and the proof of confluence."""
        return self._reduced(by.engine, self._lists_early(by), proof, by.limit)

    @kept("max_states")
    def _reduced(
        self, engine: Engine, lists_early: bool, proof: bool, max_states: int
    ) -> tuple[Space[Any], str]:
        explicit = engine == EXPLICIT
        markings = self._arrays(False, max_states) if explicit else self._drawn(False, lists_early)
        step(Doing.PROVING)
        if not isinstance(markings, DiagramMarkings):
            from mcpn.spaces.stable.alternatives import by_reduction

            graph = by_reduction(markings.graph)
            return type(markings)(graph), graph.proof or ""
        from mcpn.spaces.stable.confluence_by_sets import prove_confluent

        space = markings.space
        proved = prove_confluent(self.net, space) if proof else ""
        return DiagramAlternatives(space), proved

    def ordered(self, order: Order | None = None, seed: int | None = None) -> SymbolicSpace:
        """All markings on a diagram whose order of places is given, or raced with one that a seed draws."""
        return self._ordered(None if order is None else tuple(order), seed)

    @kept()
    def _ordered(self, order: Order | None, seed: int | None) -> SymbolicSpace:
        return reach_markings(self.net, order=order, seed=seed)

    def going_on(self, steps: int) -> Pausing[bool]:
        """Goes on with the diagram of all markings of a net without priorities, as ``auto`` asks for it.

        Args:
            steps: How many the rounds of the race of orders may have.

        Returns:
            Whether it has ended; where an error has ended it, whoever asks for the space meets it.
        """
        return self._reaching(tokens=True, edges=True).going_on(steps)

    def counted(self, max_states: int | None = None, *, tokens: bool = True) -> Counts:
        """The sizes of the markings graph, counted marking by marking without keeping the firings."""
        return self._counted(tokens and not self.net.priorities, max_states or MAX_MARKINGS)

    @kept("max_states")
    def _counted(self, tokens: bool, max_states: int) -> Counts:
        if not tokens:
            return count(self.net, max_states=max_states)
        from mcpn.spaces.markings.counted import count_markings

        return count_markings(self.net, max_states=max_states)

    def reference(self, seconds: float | None = None) -> ReferenceCounts:
        """What the independent reference counts.

        Args:
            seconds: How much CPU time it may take.

        Raises:
            UnsafeError: The net is not 1-safe.
            LimitError: pyeda holds too many nodes, the time is over, or pyeda is not installed.
        """
        try:
            from mcpn.spaces import pyeda_reference

            return self._reference(pyeda_reference.MAX_SECONDS if seconds is None else seconds)
        except ImportError as error:
            raise LimitError("the reference engine needs pyeda: pip install 'mcpn[pyeda]'") from error

    @kept()
    def _reference(self, seconds: float) -> ReferenceCounts:
        from mcpn.spaces import pyeda_reference

        return pyeda_reference.count(self.net, seconds=seconds)

    @kept("max_states")
    def with_tokens(self, max_states: int) -> ArraySpace:
        """All markings of a bounded net listed, with as many tokens as there are, priorities respected."""
        from mcpn.spaces.arrays import ArraySpace
        from mcpn.spaces.markings.counted import explore_tokens

        return ArraySpace(explore_tokens(self.net, max_states=max_states))


def spaces_of(subject: Subject, **asked: Unpack[Asking]) -> Spaces:
    """The spaces of a net, bound to who is asked; those that are given, if they are."""
    return (subject if isinstance(subject, Spaces) else Spaces(subject)).bound(**asked)
