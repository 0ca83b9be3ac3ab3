"""Declared events that change nothing: ignored, or answered already.

An event that no block around what runs handles changes nothing, and in formulas it does not happen there. So
"after a leak the robot comes up" is met by a mission that handles no leak. It is **answered** already while
what a handler of it leads to runs, in whichever copy and however that was entered: a robot that is on its way
home is not called home. In all other states in which nothing handles it, it is **ignored**.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mcpn.answers.verdicts.never import objectives_run
from mcpn.drawing.compose import MissionNet
from mcpn.mission.expansion.copies import Copies, Written
from mcpn.mission.model import ABORT, Block, Holder, Mission, Use, walk
from mcpn.mission.static.warnings import names_of_objectives
from mcpn.nets.events import Event, What
from mcpn.sentences import shortened
from mcpn.spaces.algebra import S, Space

MOST_TOLD = 12
"""Objectives that a sentence on an ignored event names; copies of one block count as one."""


@dataclass(frozen=True)
class Ignored:
    """A declared event that changes nothing in some state in which an objective runs.

    Args:
        event: Its name.
        objectives: Those that run in some state in which it is ignored, in document order.
        required: Whether its declaration says that it must always be handled.
        words: The same for a reader, without the event: copies of one objective are said together.
        answering: The objectives in what its handlers lead to that run in some state in which it is answered
            already and handled no more, in document order.
        answering_words: The same for a reader.
    """

    event: str
    objectives: tuple[str, ...]
    required: bool
    words: str
    answering: tuple[str, ...] = ()
    answering_words: str = ""

    @property
    def sentence(self) -> str:
        """What is ignored, and while what runs."""
        return f"{self.event} is ignored while {self.words}"


def changing_nothing(mission_net: MissionNet, space: Space[S]) -> Iterator[Ignored]:
    """The declared events that are ignored or answered already in some state, in document order.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
    """
    graph, transitions = mission_net.graph, mission_net.net.transitions
    answers = targets(mission_net.mission)
    for declared in mission_net.mission.events:
        if declared.sets:
            continue  # it changes facts, and interrupts nothing
        event = Event(What.DECLARED, declared.name)
        own = [t for t, transition in enumerate(transitions) if transition.event == event]
        unhandled = space.stable - space.enabling(own) if own else space.stable
        led = _inside(graph.copies, answers.get(declared.name, frozenset()))
        places = [p for name in led for p in mission_net.by_role.get(("objective", name), ())]
        answered = unhandled & space.marked(places) if places else unhandled - unhandled
        running = objectives_run(mission_net, space, unhandled - answered)
        meanwhile = objectives_run(mission_net, space, answered) & led
        ignored, answering = (
            tuple(section.name for section in graph.walk() if section.name in names)
            for names in (running, meanwhile)
        )
        if ignored or answering:
            every = names_of_objectives(graph)
            words, during = (_while(graph.copies, names, every) for names in (ignored, answering))
            yield Ignored(declared.name, ignored, declared.required, words, answering, during)


def _inside(copies: Copies, blocks: frozenset[Written]) -> set[str]:
    """The objectives in some blocks, in all copies of them."""
    return {name for name in copies.objectives if blocks and not blocks.isdisjoint(copies.around(name))}


def _while(copies: Copies, names: tuple[str, ...], every: list[str]) -> str:
    told = copies.told(names, every)
    return f"{shortened(told, MOST_TOLD)} {'runs' if len(told) == 1 else 'run'}"


def targets(mission: Mission) -> Mapping[str, frozenset[Written]]:
    """By declared event the blocks that its handlers lead to: by their names, or by an abort that is caught.

    Where a handler says ``succeed`` or ``fail``, what follows is what follows without the event, too.
    """
    texts: dict[str, tuple[Block, ...]] = {"": mission.blocks}
    texts |= {protocol.name: protocol.blocks for protocol in mission.protocols}
    around: dict[Written, Written] = {}
    users: dict[str, list[Written]] = {}
    blocks: dict[Written, Block] = {}
    for text, roots in texts.items():
        for block in walk(roots):
            blocks[text, block.name] = block
            if isinstance(block, Holder):
                around |= {(text, inner.name): (text, block.name) for inner in block.blocks}
            if isinstance(block, Use):
                users.setdefault(block.protocol, []).append((text, block.name))

    def caught(block: Written) -> Iterator[Written]:
        """Where an abort of the parent of a block is caught."""
        outer, seen = [around[block]] if block in around else list(users.get(block[0], ())), set[Written]()
        while outer:
            here = outer.pop()
            if here in seen:
                continue
            seen.add(here)
            to = (here[0], blocks[here].abort or ABORT)
            if to in blocks:
                yield to
            elif to[1] == ABORT:
                outer += [around[here]] if here in around else users.get(here[0], ())

    found: dict[str, set[Written]] = {}
    owners = [(name, block.handlers) for name, block in blocks.items()]
    for owner, handlers in (*owners, (("", ""), mission.handlers)):
        for handler in handlers:
            if handler.event is None:
                continue
            led = (owner[0], handler.goto or handler.pause or "")
            leads = found.setdefault(handler.event, set())
            if led in blocks:
                leads.add(led)
            elif led[1] == ABORT and owner[1]:
                leads.update(caught(owner))
    return {event: frozenset(leads) for event, leads in found.items()}
