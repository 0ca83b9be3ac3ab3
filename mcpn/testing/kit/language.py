"""Templates against the page on the language: what the interpreter says that draws no net.

The interpreter (:mod:`mcpn.testing.judge`) shares no template, and nothing that composes or explores nets. So
a set of templates is held to what the language says, and not to what another set draws.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from mcpn.errors import ConfluenceError, DivergenceError
from mcpn.nets.game import TokenGame
from mcpn.nets.petri import PetriNet
from mcpn.testing.judge.interpreter import Happening
from mcpn.testing.judge.lockstep import Judge, Mismatch, OfGraph, TooLargeError, happening
from mcpn.testing.kit.properties import event_deterministic
from mcpn.testing.kit.subject import Subject, Violation

MOST_STATES = 400
"""Stable states of missions that the interpreter is asked about; larger ones are passed over."""

SEEN = {
    "running": "objectives that run",
    "pending": "objectives about to begin",
    "ended": "branches that have ended",
    "mode": "activities that run",
    "waiting": "activities that wait",
    "refused": "activities that are refused",
    "out": "hardware out of service",
    "unnoticed": "hardware whose loss is not noticed",
    "facts": "facts",
    "outcome": "how the mission has ended",
}
"""What can be seen of a mission, by field of :class:`~mcpn.testing.judge.interpreter.Seen`, in words."""


def as_the_language_says(subject: Subject) -> None:
    """After each run of events the mission is as the page on the language says, and the same may happen.

    Where the language leaves open who comes first, what follows is not compared.

    Raises:
        Violation: It is not, with a shortest run that shows it.
    """
    event_deterministic(subject)
    judge = Judge(subject.mission_net.mission)
    try:
        determined = judge.explore(MOST_STATES)
        graph = subject.reduced()
    except ConfluenceError as error:
        if determined:
            message = f"the language gives each event one outcome here: {error}"
            raise Violation(message, error.runs, subject.net) from None
        return
    except (TooLargeError, DivergenceError):
        return  # that internal evolution ends is another property
    try:
        judge.lockstep("the net", OfGraph(subject.mission_net, graph))
    except Mismatch as found:
        raise Violation(told(found), [fired(subject.net, found.run)], subject.net) from None


def told(found: Mismatch) -> str:
    """What differs, in words."""
    if found.kind == "possible":
        sides = (("the language", found.expected), ("these templates", found.found))
        only = [f"{events} may happen by {side} alone" for side, events in sides if events]
        return "; ".join(only)
    said = [_difference(one, other) for one, other in _both_ways(found.expected, found.found)]
    return f"{SEEN[found.kind]}: expected {said[0]}, found {said[1]}"


def _both_ways(one: object, other: object) -> tuple[tuple[object, object], tuple[object, object]]:
    return (one, other), (other, one)


def _difference(said: object, other: object) -> str:
    """What one side says and the other does not."""
    if not isinstance(said, Collection) or not isinstance(other, Collection) or isinstance(said, str):
        return str(said or "not yet")
    more = sorted(each for each in said if each not in other)
    names = (each if isinstance(each, str) else ": ".join(filter(None, each)) for each in more)
    return ", ".join(names) or "none beside these"


def fired(net: PetriNet, run: Sequence[Happening]) -> list[str]:
    """What fires in a net as events happen, which are possible one after the other."""
    game = TokenGame(net)
    game.settle()
    for event in run:
        possible = (t for t in game.enabled if net.transitions[t].event is not None)
        game.fire(next(t for t in possible if happening(net.transitions[t].event) == event))
        game.settle()
    return [net.transitions[t].name for t in game.run]
