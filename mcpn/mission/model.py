"""What the designer writes: the mission as frozen dataclasses that remember their lines.

The model keeps the mission as it was written (uses of protocols are not expanded, imports are merged);
:mod:`mcpn.mission.core.flattening` turns it into the objectives graph. Two missions are equal when they say
the same, wherever they were written: sources take no part in comparisons.

The model is also the declaration of the language of mission files (:mod:`mcpn.mission.language`): the
reader, the writer, the schema, the tables of the language page and the renaming follow from it. ``TAG`` is
the name of an element in files, its docstring says what it means there, ``NAMED`` is the kind of names
among which its own is unique. A field is an attribute, or it holds elements inside; one without a default
is required. Beside its type stands what it means, and what else :mod:`mcpn.mission.language.datatypes`
knows to say.

Source: the paper, section 4 (objective, parallel block, activity, alternative, resource).
"""

from collections.abc import Iterator
from dataclasses import field
from typing import Annotated, TypeAlias

from mcpn.mission.language.datatypes import (
    COUNT,
    FAITH,
    IMPOSSIBLE,
    NAME,
    NAMES,
    NOMINAL,
    OUTCOME,
    QUORUM,
    ROUNDS,
    ROUTE,
    VALUES,
    Activities,
    Called,
    Children,
    Core,
    EventName,
    Hours,
    Probability,
    ProtocolName,
    ReasonName,
    Rounds,
    Route,
    Seconds,
    Shares,
    Times,
    Tries,
    Values,
    When,
)
from mcpn.mission.requirement import Requirement
from mcpn.mission.robot import (
    Activity,
    Crash,
    DeclaredEvent,
    Described,
    Element,
    Fact,
    FactChange,
    Fault,
    Hardware,
    Parameter,
    Robot,
    Software,
)
from mcpn.notebook import Drawn
from mcpn.records import record

SUCCEED = "succeed"
"""The route to the success exit of the enclosing block."""
FAIL = "fail"
"""The route to the failure exit of the enclosing block."""
ABORT = "abort"
"""The route to the abort exit of the enclosing block: it is given up, in a safe way."""
TIMED_OUT = "timed out"
"""In core missions the exit of what is left as its time is over, and that outcome: no block is called so."""
UNNAMED = "fail without reason"
"""In core missions the exit of what fails without a reason, whatever it failed for itself: no block is so."""
WHOLE = ".0"
"""Ends the name of the one branch of a block that is stopped as a whole; no name begins with a digit."""


def failing_for(reason: str) -> str:
    """In core missions the exit by which blocks are left that fail for a reason; no block is called so."""
    return f"{FAIL} {reason}"


@record(frozen=True, slots=True, kw_only=True)
class FactRoute(Described):
    """Where the block around it leads when facts are so as it ends, or as it fails for a reason.

    The first that fits counts, of those that name the reason before others.
    """

    TAG = "route"
    when: Annotated[When, "Facts that must all hold: battery=low !holding. Required without reason."] = ()
    goto: Annotated[str, ROUTE, "Where the block leads."]
    on: Annotated[str, OUTCOME, "The outcome of the block."] = "success"
    reason: Annotated[
        ReasonName,
        "With on=failure: one of the failures of an objective in the block. The route is followed at once, "
        "before any further try or recovery.",
    ] = None


@record(frozen=True, slots=True, kw_only=True)
class Handler(Described):
    """What the block around it does when an event happens, or facts become so, while it runs.

    Everything in the block stops, and it is left (``goto``) or paused (``pause``).
    """

    TAG = "on"
    event: Annotated[EventName, "A declared event."] = None
    when: Annotated[
        When, "In place of event: facts that, once all of them hold, end the block: battery=low !docked."
    ] = ()
    goto: Annotated[
        Route,
        "Where it leads. From the mission: one of its own blocks, or an exit.",
    ] = None
    pause: Annotated[
        Route,
        "In place of goto: a sibling that runs; then what was stopped is entered again. Its copy for the "
        "objective travel is named shelter_at_travel.",
    ] = None
    fails_as: Annotated[
        Route, Core(), "With pause: a further run of the block, whose failure is that of what runs meanwhile."
    ] = None
    once: Annotated[
        bool,
        "true: it is taken at most once in the whole mission, in whichever copy of the block; then the next "
        "handler outwards counts.",
    ] = False
    routes: Annotated[tuple[FactRoute, ...], Core()] = ()

    @property
    def targets(self) -> tuple[str, ...]:
        """Where it leads, whatever facts are; of a pause nowhere."""
        return () if self.goto is None else (self.goto, *(route.goto for route in self.routes))


@record(frozen=True, slots=True, kw_only=True)
class EntryGuard(Described):
    """A guard: facts that must hold for the block around it to be entered, and what is entered in its place.

    It is checked whenever a route or a handler leads to the block, not between its tries, rounds and runs. Of
    several, the first that does not hold counts. Not allowed in the first block of a series, in a child of a
    parallel block, and in a block that runs for another one.
    """

    TAG = "enter"
    when: Annotated[When, "Facts that must all hold: door=open !holding."]
    otherwise: Annotated[
        str,
        ROUTE,
        Called("else"),
        "Where to go if they do not hold: an exit, or a sibling, whose own guard is then checked.",
    ]


@record(frozen=True, slots=True, kw_only=True)
class BlockElement(Element):
    """What every block carries, whatever its kind."""

    TAG = "routing"
    NAMED = "block"
    success: Annotated[
        Route, "Where its success leads. Default: the next sibling; from the last, succeed."
    ] = None
    failure: Annotated[Route, "Where its failure leads. Default: fail."] = None
    abort: Annotated[
        Route, "Where it leads when something inside it aborts. Default: abort, further outwards."
    ] = None
    mandatory: Annotated[
        bool, "Of a child of a parallel block: false if that block may succeed without it."
    ] = True
    retries: Annotated[
        Tries, "How many more tries it has when it fails. Tries are named visit_try1, visit_try2."
    ] = 0
    repeat: Annotated[
        Rounds,
        "How many rounds are run, up to the first that fails; each has its own retries. Rounds are named "
        "visit_1, visit_2, and have the parameter round.",
    ] = None
    recover: Annotated[
        Route,
        "A sibling that runs when it fails; then it is entered again. Its runs are named visit_run1, "
        "visit_run2, those of the sibling back_off_visit1.",
    ] = None
    times: Annotated[Times, "With recover: how many times at most, each time the block around runs."] = 1
    timeout: Annotated[
        Seconds,
        "How long each try may run; then what runs in it is stopped, and it fails. It starts anew after a "
        "pause.",
    ] = None
    timeout_goto: Annotated[
        Route,
        "Where its timeout leads, whatever tries and rounds remain. Default: as its failure, to the next try "
        "first.",
    ] = None
    nominal: Annotated[
        str,
        NOMINAL,
        "What is meant while nothing fails. entered: it is entered, and ends. endless: the mission may stay "
        "in it for ever. optional: the mission may leave it out. fails: its failure is how it goes, as of a "
        "condition that finds nothing. unknown: nobody has said which of its ends is, as of a condition of a "
        "behaviour tree.",
    ] = "entered"
    guards: tuple[EntryGuard, ...] = ()
    routes: tuple[FactRoute, ...] = ()
    handlers: tuple[Handler, ...] = ()
    resumes: Annotated[
        Route,
        Core(),
        "In place of success, of what runs while a block pauses: the objective or parallel block that was "
        "stopped.",
    ] = None
    copy: Annotated[
        tuple[str, ...],
        VALUES,
        Core(),
        "What tells it from other copies of one block, and ends its name: values, runs, rounds, tries.",
    ] = ()

    @property
    def left_by_facts(self) -> bool:
        """Whether it is left when facts become so."""
        return any(handler.when for handler in self.handlers)

    @property
    def own(self) -> str:
        """Its name, without what says that it is all there is in a block that is stopped as a whole."""
        return self.name.removesuffix(WHOLE)

    @property
    def stem(self) -> str:
        """Its name in its place, whichever copy it is."""
        own = self.own
        return own[: len(own) - sum(len(suffix) + 1 for suffix in self.copy)] if self.copy else own

    @property
    def written(self) -> str:
        """Its name in the text that it is written in."""
        return self.stem.rpartition(".")[2]

    @property
    def prefix(self) -> str:
        """What qualifies its name, with the dot."""
        return self.stem.removesuffix(self.written)


@record(frozen=True, slots=True, kw_only=True)
class Objective(BlockElement):
    """With activities it is elementary: the activities run together until it succeeds or fails."""  # 4.1

    TAG = "objective"
    activities: Annotated[Activities, "Activities that run together; none of them produces."]
    duration: Annotated[Hours, "Risk: mean duration in hours."] = None
    failure_probability: Annotated[
        Probability, "Risk: the probability, 0 to 1, that it fails though it could succeed."
    ] = None
    failures: Annotated[
        Shares,
        "Reasons for which it may fail, with those of its activities; each perhaps with its part of "
        "failure_probability: no_path=0.02 blocked.",
    ] = ()
    sets: tuple[FactChange, ...] = ()
    parameters: tuple[Parameter, ...] = ()


@record(frozen=True, slots=True, kw_only=True)
class Recursive(BlockElement):
    """With blocks it is recursive: the blocks run one after the other."""  # paper, 4.1

    TAG = "objective"
    protocol: Annotated[str | None, NAME, Core(), "The protocol that it is a use of."] = None
    declares: Annotated[tuple[str, ...], NAMES, Core(), "Parameters that the protocol declares."] = ()
    requirements: Annotated[tuple[Requirement, ...], Core()] = ()
    parameters: tuple[Parameter, ...] = ()
    blocks: "tuple[Block, ...]"


@record(frozen=True, slots=True, kw_only=True)
class Parallel(BlockElement):
    """Blocks that run at the same time. When all have ended it succeeds if every mandatory one did."""  # 4.2

    TAG = "parallel"
    success_when: Annotated[
        str,
        QUORUM,
        "any or a number: it succeeds as soon as so many children, mandatory or not, have succeeded, and "
        "stops the others.",
    ] = "all"
    failure_when: Annotated[
        str,
        QUORUM,
        "any: it fails as soon as a mandatory child has failed, and stops the others. A number: as soon as "
        "so many children, mandatory or not, have failed; success decided at the same moment counts first.",
    ] = "all"
    impossible: Annotated[
        str,
        IMPOSSIBLE,
        "Once success_when can no longer be met. fails: it fails at once. waits: its other children run on.",
    ] = "waits"
    failing: Annotated[
        int | None, ROUNDS, Core(), "So many failed children, mandatory or not, fail it at once."
    ] = None
    blocks: 'Annotated[tuple[Block, ...], Children(without=("parallel",))]'


@record(frozen=True, slots=True, kw_only=True)
class Use(BlockElement):
    """A protocol in this place.

    Names inside it are qualified: objective travel of use visit is visit.travel.
    """

    TAG = "use"
    protocol: Annotated[ProtocolName, "The protocol's name."]
    parameters: tuple[Parameter, ...] = ()


@record(frozen=True, slots=True, kw_only=True)
class Each(BlockElement):
    """Blocks run once for each value, one round after the other, up to the first that fails.

    A block inside is named with the value, visit_12, and so is what it holds, visit_12.travel.
    """

    TAG = "each"
    values: Annotated[Values, Called("in"), "The values: letters, digits and _, separated by spaces."]
    parameter: Annotated[
        str | None,
        NAME,
        "The parameter that has the value inside, also in protocols used there. Default: its name.",
    ] = None
    parameters: Annotated[tuple[Parameter, ...], Core()] = ()
    blocks: "tuple[Block, ...]"

    @property
    def bound(self) -> str:
        """The name of the parameter that has the value."""
        return self.parameter or self.written


Block: TypeAlias = Objective | Recursive | Parallel | Use | Each
"""Whatever stands in a series."""
Holder: TypeAlias = Recursive | Parallel | Each
"""Blocks that hold blocks."""
ROUND = "round"
"""The parameter that has the number of the round, from 1, in a block that is repeated."""


@record(frozen=True, slots=True, kw_only=True)
class Protocol(Element):
    """A reusable series of blocks, entered at the first."""

    TAG = "protocol"
    NAMED = "protocol"
    parameters: tuple[Parameter, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    blocks: "tuple[Block, ...]"


@record(frozen=True, slots=True, kw_only=True)
class Import(Described):
    """Another file, a robot or protocols. It is read once, wherever it is imported."""

    TAG = "import"
    href: Annotated[str, "The file, relative to this one and inside the directory of the mission."]


@record(frozen=True, slots=True, kw_only=True)
class Protocols(Described):
    """What the protocols' author writes: reusable series of blocks."""

    TAG = "protocols"
    name: Annotated[str | None, NAME, "For the reader; nothing refers to it."] = None
    protocols: tuple[Protocol, ...] = ()


@record(frozen=True, slots=True, kw_only=True)
class Approximation(Described):
    """A node of a behaviour tree that the mission does not say exactly; its description says what differs."""

    TAG = "approximation"
    node: Annotated[str, "The node, as people call it."]
    kind: Annotated[
        str,
        FAITH,
        "time: exact but for time. more: the mission has all runs of the tree, and more. left_out: the "
        "mission lacks something of it.",
    ]
    line: Annotated[int | None, COUNT, "Its line in the file of the tree."] = None


@record(frozen=True, slots=True, kw_only=True)
class Translated(Described):
    """That the mission was made of a behaviour tree: how much of it is exact, and what is not.

    It changes nothing in the verification: check and the report say with it which answers hold of the tree.
    """

    TAG = "translated"
    tree: Annotated[str, Called("from"), "The file of the tree."]
    library: Annotated[str | None, "The libraries and versions as which it was read, with what decided."] = (
        None
    )
    exact: Annotated[int, COUNT, "How many of its nodes the mission says exactly."]
    approximations: tuple[Approximation, ...] = ()


@record(frozen=True, slots=True, kw_only=True)
class Mission(Drawn, Element):
    """The mission itself, which the operator assembles.

    Its blocks run one after the other; its exits are mission success, mission failure and mission abort.
    """

    TAG = "mission"
    core: Annotated[bool, Core(), "Whether copies are written out, or begin to be, and names qualified."] = (
        False
    )
    translated: tuple[Translated, ...] = ()
    robots: tuple[Robot, ...] = ()
    protocols: Annotated[tuple[Protocol, ...], Children(inside=Protocols)] = ()
    requirements: tuple[Requirement, ...] = ()
    handlers: tuple[Handler, ...] = ()
    blocks: "tuple[Block, ...]"
    # Whether it has been found valid, so that it is not checked again.
    checked: bool = field(default=False, init=False, repr=False, compare=False)

    def __repr__(self) -> str:
        sizes = {
            "blocks": sum(1 for _ in walk(self.blocks)),
            "protocols": len(self.protocols),
            "activities": len(self.activities),
            "hardware": len(self.hardware) + len(self.faults) + self._crashing,
        }
        return f"<mission {self.name}: {', '.join(f'{n} {what}' for what, n in sizes.items())}>"

    @property
    def files(self) -> tuple[str, ...]:
        """The files in which its elements stand, its own first; none of one built in Python."""
        elements = (self, *self.robots, *self.protocols, *self.requirements, *self.blocks)
        return tuple(dict.fromkeys(element.source.file for element in elements if element.source))

    @property
    def hardware(self) -> tuple[Hardware, ...]:
        """All hardware resources, in document order, then what stands for crashes in a core mission."""
        return (*(resource for robot in self.robots for resource in robot.hardware), *self.crashes)

    @property
    def declared_hardware(self) -> tuple[Hardware, ...]:
        """The hardware resources that authors declare, in document order."""
        return tuple(h for robot in self.robots for h in robot.hardware if not h.affects)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All common causes of failures, in document order."""
        return tuple(fault for robot in self.robots for fault in robot.faults)

    @property
    def common_causes(self) -> tuple[Hardware, ...]:
        """Of a core mission: the hardware that stands for common causes of failures, in document order."""
        return tuple(resource for resource in self.hardware if resource.affects)

    @property
    def late(self) -> tuple[Hardware, ...]:
        """Hardware whose loss is detected late, in document order."""
        return tuple(h for robot in self.robots for h in robot.hardware if h.detected == "late")

    @property
    def crashes(self) -> tuple[Crash, ...]:
        """Of a core mission: what stands for activities and alternatives that crash, in document order."""
        return tuple(crash for robot in self.robots for crash in robot.crashes)

    @property
    def _crashing(self) -> int:
        ways = (way for activity in self.activities for way in activity.alternatives)
        return sum(activity.faulty for activity in self.activities) + sum(way.faulty for way in ways)

    @property
    def software(self) -> tuple[Software, ...]:
        """All software resources, in document order."""
        return tuple(resource for robot in self.robots for resource in robot.software)

    @property
    def activities(self) -> tuple[Activity, ...]:
        """All activities, in document order."""
        return tuple(activity for robot in self.robots for activity in robot.activities)

    @property
    def facts(self) -> tuple[Fact, ...]:
        """All facts that its author declares, in document order."""
        return tuple(fact for fact in self.every_fact if "(" not in fact.name)

    @property
    def every_fact(self) -> tuple[Fact, ...]:
        """Those, and in a core mission what objectives have done (``done(x)``)."""
        return tuple(fact for robot in self.robots for fact in robot.facts)

    @property
    def requires(self) -> bool:
        """Whether it, or a protocol in its files, has a requirement."""
        return bool(self.all_requirements)

    @property
    def all_requirements(self) -> tuple[Requirement, ...]:
        """Its own, then those of protocols; of uses that are written out those of each."""
        found = [*self.requirements, *(each for protocol in self.protocols for each in protocol.requirements)]
        for block in walk(self.blocks) if self.core else ():
            found += block.requirements if isinstance(block, Recursive) else ()
        return tuple(found)

    @property
    def events(self) -> tuple[DeclaredEvent, ...]:
        """All declared events, in document order."""
        return tuple(event for robot in self.robots for event in robot.events)


def walk(blocks: tuple[Block, ...]) -> Iterator[Block]:
    """Every block at any depth, parents first, in document order; uses are not expanded.

    The walk keeps its own stack, so depth is bounded by memory alone.
    """
    stack = list(reversed(blocks))
    while stack:
        block = stack.pop()
        yield block
        if not isinstance(block, Objective) and isinstance(block, Holder):  # of most blocks one is asked
            stack.extend(reversed(block.blocks))
