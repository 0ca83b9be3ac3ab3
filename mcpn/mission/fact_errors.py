"""What is wrong with the facts of a mission: values, changes, conditions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property

from mcpn.did_you_mean import Hints, did_you_mean
from mcpn.errors import Problem, Source
from mcpn.mission.fact_conditions import is_boolean, objective_done, word
from mcpn.mission.language.datatypes import CONDITION, CORE_OUTCOME, OCCASION, OUTCOME, VALUE
from mcpn.mission.model import Block, Handler, Mission, Objective, Parallel, Use, walk
from mcpn.mission.robot import Fact, FactChange


def fact_errors(mission: Mission, hints: Hints) -> Iterator[Problem]:
    """What is wrong with the facts of a mission, but for names that are declared twice and where routes lead.

    Args:
        mission: A mission whose fields are of the right types.
        hints: Finds what unknown names may have been meant as.
    """
    return _FactChecks(mission, hints).errors()


_JOINING = {
    "or": "for either of two write an alternative, a route or a handler for each",
    "and": "all words of a condition must be so, with spaces between them",
    "not": "write !NAME of a fact that is false or true, and the other values of one with values",
}
"""Words with which conditions are joined elsewhere, each with what to write."""


class _FactChecks:
    def __init__(self, mission: Mission, hints: Hints) -> None:
        self.mission = mission
        self.hints = hints
        self.facts = {fact.name: fact for fact in mission.every_fact}
        texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
        self.blocks: list[Block] = [block for blocks in texts for block in walk(blocks)]
        self.changing = {event.name for event in mission.events if event.changes_facts}

    @cached_property
    def elementary(self) -> dict[str, None]:
        """Names of elementary objectives."""
        return {block.written: None for block in self.blocks if isinstance(block, Objective)}

    def errors(self) -> Iterator[Problem]:
        mission = self.mission
        for fact in mission.facts:
            yield from self.values(fact)
        for activity in mission.activities:
            yield from self.condition(
                activity.source, f"activity {activity.name} requires", activity.requires
            )
            for way in activity.alternatives:
                who = f"alternative {way.name} of activity {activity.name} requires"
                yield from self.condition(way.source, who, way.requires)
                yield from self.both(way.source, who, (*activity.requires, *way.requires))
        for event in mission.events:
            yield from self.changes(f"event {event.name}", event.sets, of_event=True)
        yield from self.handled(mission.name, mission.handlers)
        for block in self.blocks:
            if block.handlers:
                yield from self.handled(block.name, block.handlers)
            for guard in block.guards:
                who = f"a guard of {block.name} asks for"
                yield from self.condition(guard.source, who, guard.when)
                yield from self.both(guard.source, who, guard.when)
                if not guard.when:
                    yield Problem(guard.source, f"a guard of {block.name} asks for no fact")
            if len(block.guards) > 1:
                words = (text for guard in block.guards for text in guard.when)
                yield from self.both(block.source, f"the guards of {block.name} ask for", words)
            for route in block.routes:
                who = f"a route of {block.name} asks for"
                yield from self.condition(route.source, who, route.when)
                yield from self.both(route.source, who, route.when)
                if not (outcome := CORE_OUTCOME if mission.core else OUTCOME).allows(route.on):
                    found = f"on of a route of {block.name} is {route.on}"
                    yield Problem(route.source, f"{found}, expected {outcome.allowed}")
            if isinstance(block, Objective) and block.sets:
                yield from self.changes(f"objective {block.name}", block.sets)
                yield from self.at_starts(block)

    def values(self, fact: Fact) -> Iterator[Problem]:
        wrong = [value for value in fact.values if not VALUE.matches(value)]
        for value in wrong:
            message = f"fact {fact.name} has the value {value!r}, expected {VALUE.expected}"
            yield Problem(fact.source, message)
        if len(set(fact.values)) < 2:
            count = len(set(fact.values))
            said = f"fact {fact.name} has {count} value{'s'[: count != 1]}, expected at least two"
            yield Problem(fact.source, said)
        elif fact.start not in fact.values:
            yield self.unknown_value(fact.source, f"initial of fact {fact.name} is", fact, fact.start)

    def changes(
        self, who: str, changes: Iterable[FactChange], *, of_event: bool = False
    ) -> Iterator[Problem]:
        met = set[tuple[str, str]]()
        for change in changes:
            if change.fact not in self.facts:
                yield self.unknown(change.source, f"{who} sets", change.fact)
            elif change.to not in self.facts[change.fact].values:
                fact = self.facts[change.fact]
                yield self.unknown_value(change.source, f"{who} sets {fact.name} to", fact, change.to)
            if of_event and change.on is not None:
                message = f"{who} sets {change.fact} on {change.on}, expected no on: it does as it happens"
                yield Problem(change.source, message)
            elif not OCCASION.allows(change.occasion):
                found = f"{who} sets {change.fact} on {change.on!r}"
                yield Problem(change.source, f"{found}, expected {OCCASION.allowed}")
            if (change.fact, change.occasion) in met:
                when = "" if of_event else f" on {change.occasion}"
                yield Problem(change.source, f"{who} sets {change.fact} twice{when}")
            met.add((change.fact, change.occasion))

    def at_starts(self, objective: Objective) -> Iterator[Problem]:
        """Facts set as an objective starts, where blocks are left by facts.

        By the facts that are asked for, blocks might be left that have not begun yet. In branches, a block
        that is left as a whole begins after what stands beside it has looked at the facts.
        """
        for change in objective.sets if self.left_by else ():
            if change.on != "start":
                continue
            block = self.left_by.get((change.fact, change.to))
            message = f"objective {objective.name} sets {change.fact} to {change.to} as it starts"
            remedy = "set it by the success of an objective, or by an event"
            if block is not None:
                yield Problem(
                    change.source, f"{message}, and {block} is left when it becomes so (on when): {remedy}"
                )
            elif objective.name in self.in_branches:
                some = next(iter(self.left_by.values()))
                yield Problem(
                    change.source,
                    f"{message} in a branch of a <parallel>, and {some} is left by facts (on when): {remedy}",
                )

    @cached_property
    def in_branches(self) -> set[str]:
        """Elementary objectives in branches of parallel blocks, written there or in what is used there."""
        protocols = {protocol.name: protocol.blocks for protocol in self.mission.protocols}
        todo = [child for block in self.blocks if isinstance(block, Parallel) for child in block.blocks]
        found = set[str]()
        while todo:
            for block in walk((todo.pop(),)):
                if isinstance(block, Objective):
                    found.add(block.name)
                elif isinstance(block, Use):
                    todo += protocols.pop(block.protocol, ())
        return found

    @cached_property
    def left_by(self) -> Mapping[tuple[str, str], str]:
        """By fact and value, a block that may be left as the fact becomes so."""
        found = dict[tuple[str, str], str]()
        for block in self.blocks:
            for text in (text for handler in block.handlers for text in handler.when):
                said = word(text) if CONDITION.matches(text) and len(text.split()) == 1 else None
                if said is not None:
                    value = said.value or ("false" if said.negated else "true")
                    found.setdefault((said.fact, value), block.name)
        return found

    def handled(self, owner: str, handlers: Iterable[Handler]) -> Iterator[Problem]:
        """Handlers of facts, and of events that change facts: such events happen whatever runs."""
        for handler in handlers:
            if handler.when:
                who = f"<on when> of {owner} asks for"
                yield from self.condition(handler.source, who, handler.when)
                yield from self.both(handler.source, who, handler.when)
            for route in handler.routes:
                yield from self.condition(route.source, f"a route of {owner} asks for", route.when)
                yield from self.both(route.source, f"a route of {owner} asks for", route.when)
            if handler.event in self.changing:
                message = f"the event {handler.event} changes facts: it interrupts nothing by itself"
                remedy = "handle what the facts become, with <on when=...>"
                yield Problem(handler.source, f"{message}; {remedy}")

    def condition(self, source: Source | None, who: str, texts: Iterable[str]) -> Iterator[Problem]:
        for text in texts:
            if text.lower() in _JOINING and text not in self.facts:
                yield Problem(source, f"{who} {text!r}, which joins nothing: {_JOINING[text.lower()]}")
                continue
            if not CONDITION.matches(text) or len(text.split()) != 1:
                yield Problem(source, f"{who} {text!r}, expected {CONDITION.expected}")
                continue
            said = word(text)
            objective = objective_done(said.fact)
            if said.fact in self.facts:
                yield from self.asked(source, f"{who} {text}", text, self.facts[said.fact])
            elif objective is None:
                yield self.unknown(source, who, said.fact)
            elif objective not in self.elementary:
                message = f"{who} {said.fact}, and no elementary objective is named {objective}"
                last = objective.rpartition(".")[2]
                if last != objective and last in self.elementary:
                    hint = (
                        f"; done({last}) is of any copy of it: to tell copies apart, write their blocks out"
                    )
                else:
                    hint = self.hints.known(objective, self.elementary)
                yield Problem(source, f"{message}{hint}")
            else:
                yield from self.asked(source, f"{who} {text}", text, Fact(name=said.fact))

    def asked(self, source: Source | None, found: str, text: str, fact: Fact) -> Iterator[Problem]:
        said = word(text)
        if said.negated and said.value is not None:
            if is_boolean(fact):
                expected = f"{fact.name} or !{fact.name}: ! stands before a name alone"
            else:
                others = [f"{fact.name}={value}" for value in fact.values if value != said.value]
                expected = f"{' or '.join(others)}: ! stands before a name alone, and {_JOINING['or']}"
            yield Problem(source, f"{found}, expected {expected}")
        elif said.value is None and not is_boolean(fact):
            values = ", ".join(f"{fact.name}={value}" for value in fact.values)
            yield Problem(source, f"{found} without a value, expected one of {values}")
        elif said.value is not None and said.value not in fact.values:
            yield self.unknown_value(source, f"{found}:", fact, said.value)

    def both(self, source: Source | None, who: str, texts: Iterable[str]) -> Iterator[Problem]:
        """Words of a condition that contradict each other."""
        texts = tuple(texts)
        asked = dict[str, str]()
        if any(text.lower() in _JOINING for text in texts):
            return  # it is said what is wrong with these
        for text in texts:
            said = word(text) if CONDITION.matches(text) and len(text.split()) == 1 else None
            if said is None or (said.fact not in self.facts and objective_done(said.fact) is None):
                continue
            value = said.value or ("false" if said.negated else "true")
            if asked.setdefault(said.fact, value) != value:
                message = f"{who} {said.fact}={asked[said.fact]} and {said.fact}={value} at once"
                yield Problem(source, message)

    def unknown(self, source: Source | None, who: str, name: str) -> Problem:
        known = self.hints.known(name, self.facts)
        return Problem(source, f"{who} the fact {name}, which is not declared{known}")

    def unknown_value(self, source: Source | None, who: str, fact: Fact, value: str) -> Problem:
        near = did_you_mean(value, fact.values)
        return Problem(source, f"{who} {value}, expected one of {', '.join(fact.values)}{near}")
