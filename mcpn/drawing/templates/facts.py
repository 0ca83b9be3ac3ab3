"""Facts of the world: a place for each value, changed by events, read by what they decide.

The values of a fact are a unit: one of its places is marked. The end of an objective, or a declared event,
changes facts in its own transition, which then stands once for each combination of values that matter: those
before, of facts that it changes, and those of facts that decide where it leads. Objectives that change facts
as they are entered do so by internal transitions of ranks of their own, after all other control and before
any activity looks (:class:`mcpn.drawing.templates.ranks.Ranks`). So nothing that reads a fact races with
what changes it.

A value for which blocks may be left has a second place, *became*: whatever changes the fact to it marks this
one, too, and when facts have been asked (:mod:`mcpn.drawing.templates.control`) it is forgotten. So it is
empty in every stable state.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

from mcpn.drawing.templates.canvas import Canvas
from mcpn.errors import LimitError
from mcpn.events import Event, What
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.robot import Fact

MAX_WAYS = 4096
"""Combinations of values of facts that one event may be drawn for."""


class FactArcs(NamedTuple):
    """What a transition does with facts, and where it then leads.

    Args:
        consume: Values that it ends.
        produce: Values that it begins.
        read: Values that it asks for.
        target: The next section, or an exit of the graph.
    """

    consume: list[str]
    produce: list[str]
    read: list[str]
    target: str


def draw_facts(canvas: Canvas) -> None:
    """Draws all facts of a canvas with the declared events that change them."""
    for fact in canvas.facts:
        _draw_fact(canvas, fact)
    drawn = {fact.name: fact for fact in canvas.facts}
    for event, changes in canvas.usage.world.changing.items():
        first = drawn.get(next(iter(changes)))
        if first is not None:
            pen = canvas.of("fact", first.name, first.source)
            for number, way in enumerate(changing(canvas, changes, f"event {event}"), 1):
                if way.consume:
                    declared = Event(What.DECLARED, event)
                    part = f"EV{number}_{event}"
                    pen.transition(part, way.consume, way.produce, read=way.read, event=declared)


def _draw_fact(canvas: Canvas, fact: Fact) -> None:
    pen = canvas.of("fact", fact.name, fact.source)
    places = {value: pen.place(value, initial=int(value == fact.start)) for value in fact.values}
    for value, place in places.items():
        canvas.role(place, ("fact", f"{fact.name}={value}"))
    canvas.unit([*places.values()])
    for value in fact.values:
        if (fact.name, value) in canvas.usage.world.watched:
            became = pen.place(f"became:{value}")
            says = "the fact has taken this value in this reaction"
            canvas.meet(became, says, owner="tp", control="pr", event="p")
            pen.transition(f"forget:{value}", [became], [], rank=canvas.ranks.forgetting)


def changing(canvas: Canvas, changes: Mapping[str, Mapping[str, str]], what: str) -> Iterator[FactArcs]:
    """What an event does to facts, by value before: one for each combination of values.

    Raises:
        LimitError: There are too many combinations.
    """
    for number, before in enumerate(product(*changes.values())):
        _refuse_more(number, what)
        yield _arcs(
            canvas, [(name, was, changes[name][was]) for name, was in zip(changes, before, strict=True)]
        )


def _refuse_more(number: int, what: str) -> None:
    if number == MAX_WAYS:
        raise LimitError(f"{what}: more than {MAX_WAYS} combinations of facts: the limit was hit")


def _arcs(
    canvas: Canvas, turned: Sequence[tuple[str, str, str]], read: Iterable[str] = (), target: str = ""
) -> FactArcs:
    """What a transition does where facts go from one value to another, or the same."""
    kept = [canvas.fact(name, was) for name, was, now in turned if was == now]
    ended = [canvas.fact(name, was) for name, was, now in turned if was != now]
    changed = [(name, now) for name, was, now in turned if was != now]
    begun = [canvas.fact(*to) for to in changed]
    begun += [canvas.became(*to) for to in changed if to in canvas.usage.world.watched]
    return FactArcs(ended, begun, [*read, *kept], target)


def ways(
    canvas: Canvas, default: str, cases: Sequence[FactCase], changes: Mapping[str, str], what: str
) -> list[FactArcs]:
    """The ways of a transition: one for each combination of values of facts that it changes or is led by.

    Args:
        canvas: Names the places.
        default: Where it leads if no case fits.
        cases: The first that fits counts.
        changes: The values that facts are given before.
        what: What does so, for an error.

    Raises:
        LimitError: There are too many combinations of values.
    """
    if not cases and not changes:
        return [FactArcs([], [], [], default)]
    facts, leads = canvas.usage.world.facts, list[FactArcs]()
    for known, target in _decided(cases, default, dict(changes), facts):
        read = [canvas.fact(name, value) for name, value in known.items() if name not in changes]
        for before in product(*(facts[name].values for name in changes)):
            _refuse_more(len(leads), what)
            turned = [(name, was, changes[name]) for name, was in zip(changes, before, strict=True)]
            leads.append(_arcs(canvas, turned, read, target))
    return leads


def _decided(
    cases: Sequence[FactCase], default: str, known: dict[str, str], facts: Mapping[str, Fact]
) -> Iterator[tuple[dict[str, str], str]]:
    """The leaves of a decision tree over the cases, one of which holds: values of facts, and the target."""
    for number, case in enumerate(cases):
        if any(known.get(name, value) != value for name, value in case.when):
            continue
        undecided = next((name for name, _ in case.when if name not in known), None)
        if undecided is None:
            yield known, case.target
            return
        for value in facts[undecided].values:
            yield from _decided(cases[number:], default, {**known, undecided: value}, facts)
        return
    yield known, default
