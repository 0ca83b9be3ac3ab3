"""The space of a net that each engine makes: the one place where a question meets the engines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from mcpn.errors import InputError, LimitError
from mcpn.net.petri import PetriNet
from mcpn.space.algebra import Space
from mcpn.space.diagrams.bounded import reach_markings
from mcpn.space.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.space.diagrams.symbolic import reach
from mcpn.space.markings.counted import explore_markings
from mcpn.space.markings.explicit import DEFAULT_MAX_STATES, Progress, explore
from mcpn.steps import step

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet
    from mcpn.space.arrays import ArraySpace

# Each engine is loaded when it is asked.

On: TypeAlias = Literal["markings", "alternatives"]
Engine: TypeAlias = Literal["explicit", "symbolic", "local"]
"""Arrays, decision diagrams or composition."""


def space_of(
    net: PetriNet,
    mission_net: MissionNet | None = None,
    *,
    engine: Engine = "symbolic",
    on: On = "markings",
    max_states: int | None = None,
    progress: Progress | None = None,
    tokens: bool = True,
    direct: bool = False,
) -> Space[Any]:
    """The space of a net, on one of its graphs, by one of the engines.

    Args:
        net: The net.
        mission_net: The mission that it is of; composition needs one.
        engine: Arrays, diagrams or composition.
        on: The graph; the alternatives graph is of nets with priorities.
        max_states: Limit on states that are listed one by one.
        progress: Called now and then with states and edges that are listed, or with local spaces done and to
            do.
        tokens: Whether the places of a net without priorities may hold several tokens.
        direct: Whether arrays go from one stable state of a mission to the next, not through all markings.

    Raises:
        InputError: The net has no such graph, or composition is asked of a net of no mission.
        UnsafeError: The net is not 1-safe, and has priorities or may hold no more than one token in a place.
        UnboundedError: The net is unbounded.
        ConfluenceError: The alternatives graph is asked for, and internal evolution is not confluent.
        DivergenceError: The same, and internal evolution need not end.
        LimitError: A limit was hit.
    """
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    if on == "alternatives" and not net.priorities:
        raise InputError.at(None, "the alternatives graph is of missions: this net has no priorities")
    if engine == "local" and (mission_net is None or on == "markings"):
        raise InputError.at(
            None,
            "composition makes the alternatives graph of a mission: sections hand on stable states only",
        )
    if on == "markings":
        return markings_by(net, engine, limit, progress, tokens=tokens)
    from mcpn.space.stable.clash import in_mission_words

    with in_mission_words(mission_net):
        if engine == "local" and mission_net is not None:
            from mcpn.space.local.composing import Options, composite_space

            return composite_space(mission_net, Options(progress=progress))
        if engine == "explicit" and direct and mission_net is not None:
            return _from_stable_to_stable(mission_net, limit, progress)
        return alternatives_by(markings_by(net, engine, limit, progress, tokens=tokens), limit)[0]


def _from_stable_to_stable(mission_net: MissionNet, max_states: int, progress: Progress | None) -> Space[Any]:
    # Before the mission begins any set of hardware may be out of service, each in a stable state of its own.
    faulty = sum(h.faulty for h in mission_net.mission.hardware)
    if 2**faulty > max_states:
        found = f"{faulty} hardware resources that may fail have 2^{faulty} states"
        raise LimitError(f"{found}, the limit on states is {max_states}: use --engine local")
    from mcpn.space.arrays import ArraySpace
    from mcpn.space.stable.confluence import direct_with_proof

    return ArraySpace(direct_with_proof(mission_net.net, max_states=max_states, progress=progress))


def stable_space(
    mission_net: MissionNet,
    *,
    engine: Engine = "symbolic",
    max_states: int | None = None,
    progress: Progress | None = None,
    direct: bool = True,
) -> Space[Any]:
    """The alternatives graph of a mission; see :func:`space_of`."""
    return space_of(
        mission_net.net,
        mission_net,
        engine=engine,
        on="alternatives",
        max_states=max_states,
        progress=progress,
        direct=direct,
    )


def mortal_space(
    mission_net: MissionNet, *, engine: Engine = "symbolic", max_states: int | None = None
) -> Space[Any]:
    """The alternatives graph of a mission whose hardware may die (:mod:`mcpn.net.mortal`).

    Args:
        mission_net: The mission's net, whose internal evolution is confluent and ends.
        engine: Arrays, diagrams or composition.
        max_states: Limit on states that are listed one by one.

    Raises:
        LimitError: A limit was hit.
    """
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    if engine == "local":
        from mcpn.space.local.composing import Options, composite_space

        return composite_space(mission_net, Options(mortal=True))
    from mcpn.net.mortal import mortal

    net = mortal(mission_net).net
    # Dying changes nothing but what may be repaired: what was confluent still is.
    if engine == "explicit":
        from mcpn.space.arrays import ArraySpace
        from mcpn.space.stable.alternatives import direct

        return ArraySpace(direct(net, proof=False, max_states=limit))
    return DiagramAlternatives(reach(net))


def markings_by(
    net: PetriNet,
    engine: Engine,
    max_states: int,
    progress: Progress | None = None,
    *,
    tokens: bool = True,
) -> ArraySpace | DiagramMarkings:
    """The markings graph of a net; see :func:`space_of`."""
    step("listing the markings" if engine == "explicit" else "making a diagram of all markings")
    if engine == "explicit":
        from mcpn.space.arrays import ArraySpace

        listed = explore_markings if tokens else explore
        return ArraySpace(listed(net, max_states=max_states, progress=progress))
    return DiagramMarkings(reach_markings(net) if tokens else reach(net))


def alternatives_by(markings: ArraySpace | DiagramMarkings, max_states: int) -> tuple[Space[Any], str]:
    """The alternatives graph of a net whose markings graph is there, and the proof of confluence used."""
    step("proving that each event has one outcome")
    if not isinstance(markings, DiagramMarkings):
        from mcpn.space.stable.alternatives import by_reduction

        graph = by_reduction(markings.graph)
        return type(markings)(graph), graph.proof or ""
    from mcpn.space.stable.confluence import prove_confluent

    proof = prove_confluent(markings.net, max_states=max_states, space=markings.space)
    return DiagramAlternatives(markings.space), proof
