"""An interpreter of missions: stable states and events, from ``docs/language.md`` and without a net.

It knows the model classes and nothing else of mcpn: no net, no space, no expansion of its own but the one
beside this module. What it says of a mission is what the page says, so that engines which share one template
and agree on an answer are still found wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from mcpn.mission.model import ABORT, FAIL, SUCCEED, Handler, Mission, walk
from mcpn.testing.judge.blocks import TIMED_OUT, WrittenBlock, written_out
from mcpn.testing.judge.robot import REFUSED, Acting, Activities, At, Reactions, so

START = "start"
SUCCESS = "success"
FAILURE = "failure"
TIMEOUT = "timeout"
OUT_OF_SERVICE = "out of service"
REPAIRED = "repaired"
DETECTED = "detected"
DECLARED = "declared"
ABORTED = "abort"
ENDS = {SUCCEED: SUCCESS, FAIL: FAILURE, ABORT: ABORTED}

Happening = tuple[str, str]
"""An event: what happens, in the words above, and to which element; the start is of none.

A failure for a reason says it, ``failure no_path``, and so does the exit by which a block fails for it.
"""


class Undetermined(Exception):
    """Two activities ask for one thing at the same moment: the page does not say who has it."""


@dataclass(frozen=True)
class State:
    """A stable state of a mission.

    Args:
        running: Elementary objectives that run.
        pending: Those about to begin, which wait until another branch has ended an activity of theirs.
        ended: Children of parallel blocks that have ended while others run, and whether in success.
        activities: Those that are not idle: what they do, and with which alternative.
        out: Hardware out of service.
        happened: Handlers that happen once and have.
        facts: The value of every fact; what objectives have succeeded, of those that are read.
        outcome: ``success``, ``failure`` or ``abort`` at the end, ``None`` before it and before the start.
        begun: Whether the mission has started.
        unnoticed: Hardware out of service of which the robot does not know that it is.
        suspected: That of it which is found out when who has it lets it go.
        paused: By what is run while a block pauses, the objectives that are entered again after it; what is
            run may be stopped itself.
        under_way: Within a reaction: the blocks that ran before it and have not been left since; none in a
            stable state.
    """

    running: frozenset[str] = frozenset()
    pending: frozenset[str] = frozenset()
    ended: frozenset[tuple[str, bool]] = frozenset()
    activities: frozenset[tuple[str, At]] = frozenset()
    out: frozenset[str] = frozenset()
    happened: frozenset[tuple[str, str, str]] = frozenset()
    facts: frozenset[tuple[str, str]] = frozenset()
    outcome: str | None = None
    begun: bool = False
    unnoticed: frozenset[str] = frozenset()
    suspected: frozenset[str] = frozenset()
    paused: frozenset[tuple[str, frozenset[str]]] = frozenset()
    under_way: frozenset[WrittenBlock] = frozenset()


@dataclass(frozen=True)
class Seen:
    """What can be seen of a state, by names alone.

    Args:
        running: Elementary objectives that run.
        pending: Objectives about to begin.
        ended: Branches that have ended while others run.
        mode: The alternative of each activity that runs.
        waiting: The alternative of each activity that waits.
        refused: Activities without a possible alternative.
        out: Hardware out of service.
        unnoticed: What of it the robot does not know.
        facts: The value of every fact.
        outcome: ``success``, ``failure``, ``abort`` or ``None``.
    """

    running: frozenset[str]
    pending: frozenset[str]
    ended: frozenset[str]
    mode: frozenset[tuple[str, str]]
    waiting: frozenset[tuple[str, str]]
    refused: frozenset[str]
    out: frozenset[str]
    unnoticed: frozenset[str]
    facts: frozenset[tuple[str, str]]
    outcome: str | None


class Interpreter:
    """A mission that can be played.

    Args:
        mission: A valid mission.
    """

    def __init__(self, mission: Mission) -> None:
        self.mission = mission
        self.robot = Reactions(mission)
        self.root = written_out(mission)
        self.objectives = {leaf.name: leaf for leaf in _leaves(self.root)}
        self.branches = {branch.name: branch for branch in _branches(self.root)}
        self.left_by_facts = [node for node in _nodes(self.root) if any(h.when for h in node.handlers)]
        self.timed = {node.name: node for node in _nodes(self.root) if node.timeout is not None}
        self.pause_graphs = {pause_graph.name: pause_graph for pause_graph in _shelters(self.root)}
        values = {fact.name: fact.initial or fact.values[0] for fact in mission.every_fact}
        # Core missions declare and set them.
        self.kept = frozenset(_read_of_objectives(mission)) - values.keys()
        values |= dict.fromkeys(self.kept, "false")
        hardware = [h for robot in mission.robots for h in robot.hardware]
        self.lasting = {h.name for h in hardware if not h.repairable}
        self.lasting |= {f.name for robot in mission.robots for f in robot.faults if not f.repairable}
        self.lasting |= {c.name for robot in mission.robots for c in robot.crashes if not c.repairable}
        for activity in self.robot.activities.values():
            self.lasting |= {activity.name} if activity.faulty and not activity.recovers else set()
            ways = (way.name for way in activity.alternatives if way.faulty and not way.recovers)
            self.lasting |= {f"{activity.name}.{way}" for way in ways}
        self.late = {h.name for h in hardware if h.detected == "late"}
        out = frozenset(h.name for h in hardware if h.initial == "oos")
        self.initial = State(out=out, facts=frozenset(values.items()))
        self.changing = {e.name: {c.fact: c.to for c in e.sets} for e in mission.events if e.changes_facts}

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware that may go out of service."""
        faulty = (h.name for robot in self.mission.robots for h in robot.hardware if h.faulty)
        return (*faulty, *(fault.name for robot in self.mission.robots for fault in robot.faults))

    def possible(self, state: State) -> set[Happening]:
        """The events that may happen in a stable state."""
        found = {(OUT_OF_SERVICE, h) for h in self.faulty if h not in state.out}
        found |= {(REPAIRED, h) for h in state.out - self.lasting - state.unnoticed}
        for name, (doing, rank) in state.activities:
            if doing is Acting.RUNS:
                found |= {(DETECTED, h) for h in self.robot.activities[name].detects if h in state.unnoticed}
                found |= {(OUT_OF_SERVICE, crash) for crash in self.robot.crashes(name, rank)}
        if not state.begun:
            found.add((START, ""))
        runs = {name for name, (doing, _) in state.activities if doing is Acting.RUNS}
        found |= {(TIMEOUT, name) for name, block in self.timed.items() if self.under_way(block, state)}
        for name in state.running:
            found.add((FAILURE, name))
            found |= {(f"{FAILURE} {why}", name) for why in self.objectives[name].failures}
            if runs.issuperset(self.objectives[name].activities) and not self.misused(state, name):
                found.add((SUCCESS, name))
        found.update(
            (DECLARED, name)
            for name, changes in self.changing.items()
            if not state.facts >= {*changes.items()}
        )
        found.update(
            (DECLARED, e.name) for e in self.mission.events if self.handling(self.root, e.name, state)
        )
        return found

    def held(self, state: State) -> set[str]:
        """What some activity has, or has asked for."""
        return {k for _, consumes in self.robot.holding(self.robot_in(state)) for k in consumes}

    def misused(self, state: State, objective: str) -> frozenset[str]:
        """What somebody has though it is lost, and the objective may use, itself or through producers."""
        reached, stack = set[str](), [*self.objectives[objective].activities]
        while stack:
            activity = self.robot.activities[stack.pop()]
            consumed = {k for way in activity.alternatives for k in way.consumes} - reached
            reached |= consumed
            stack += [self.robot.producer[k] for k in consumed if k in self.robot.producer]
        return state.unnoticed & self.held(state) & reached

    def handling(self, node: WrittenBlock, event: str, state: State) -> list[tuple[WrittenBlock, Handler]]:
        """The blocks that handle an event, in a block that runs: the innermost of each branch."""
        if not self.runs(node, state):
            return []
        inner = [found for child in node.children.values() for found in self.handling(child, event, state)]
        if inner:
            return inner
        own = (h for h in node.handlers if h.event == event and place(node, h) not in state.happened)
        return [(node, handler) for handler in own][:1]

    def runs(self, node: WrittenBlock, state: State) -> bool:
        """Whether an objective in a block runs or is about to begin."""
        return any(self.objectives[name].within(node) for name in state.running | state.pending)

    def under_way(self, node: WrittenBlock, state: State) -> bool:
        """Whether the time of an objective runs, or of a block; that which begins waits until it does."""
        return self.runs(node, state) if node.children else node.name in state.running

    def after(self, state: State, happening: Happening) -> State:
        """The stable state that an event leads to.

        Args:
            state: A stable state.
            happening: An event that is possible there.

        Raises:
            Undetermined: Two activities or objectives ask for one thing at the same moment.
        """
        what, element = happening
        under_way = (node for node in self.left_by_facts if self.under_way(node, state))
        before = state = replace(state, under_way=frozenset(under_way))
        routes: list[tuple[WrittenBlock, str | WrittenBlock]] = []
        if what == OUT_OF_SERVICE:
            unnoticed = {element} & self.late
            state = replace(state, out=state.out | {element}, unnoticed=state.unnoticed | unnoticed)
        elif what == DETECTED:
            noticed = {element}
            state = replace(state, unnoticed=state.unnoticed - noticed, suspected=state.suspected - noticed)
        elif what == REPAIRED:
            state = replace(state, out=state.out - {element})
        elif what == START:
            state, routes = replace(state, begun=True), [(self.root, self.root.first)]
        elif what == DECLARED and element in self.changing:
            state = changed(state, self.changing[element])
        elif what == DECLARED:
            found = self.handling(self.root, element, state)
            once = {place(node, handler) for node, handler in found if handler.once}
            state = replace(state, happened=state.happened | once)
            for node, handler in found:
                if handler.pause is None:
                    routes.append((node, chosen(state, handler)))
                else:
                    pause_graph, at = self.paused(node, handler, state), self.within(node, state)
                    state = replace(state, paused=state.paused | {(pause_graph.name, at)})
                    routes.append((node, pause_graph))
        else:
            node = self.timed[element] if what == TIMEOUT else self.objectives[element]
            occasion = SUCCESS if what == SUCCESS else FAILURE
            if what != SUCCESS and not node.children:
                state = replace(state, suspected=state.suspected | self.misused(state, element))
            state = changed(state, {c.fact: c.to for c in node.sets if (c.on or SUCCESS) == occasion})
            done = f"done({node.written})"
            if what == SUCCESS and done in self.kept:
                state = changed(state, {done: "true"})
            by = {SUCCESS: SUCCEED, TIMEOUT: TIMED_OUT}.get(what) or what.replace(FAILURE, FAIL, 1)
            routes = [led(state, node, by)]
        # All that is left stops first, what aborts with it; then what follows begins.
        for node, route in routes:
            pausing = what == DECLARED and isinstance(route, WrittenBlock)
            state = self.stopped(state, node) if pausing else self.left(state, node)
        aborted: list[WrittenBlock] = []
        after, waiting = state, state.pending
        for node, route in routes:
            if not any(node.within(block) for block in aborted):
                after = self.follow(after, node, route, aborted)
        after = self.left_as_facts_are(before, self.decided(after, aborted), aborted)
        for block in aborted:
            state = self.left(state, block)
        for name in self.objectives:  # in document order
            if name in after.pending - waiting:
                sets = self.objectives[name].sets
                after = changed(after, {c.fact: c.to for c in sets if c.on == START})
        after = replace(after, under_way=frozenset())
        rest = self.at_rest(state)
        learnt = state.suspected - self.held(replace(state, activities=rest))
        after = replace(after, unnoticed=after.unnoticed - learnt, suspected=after.suspected - learnt)
        return self.reaction(replace(after, activities=rest))

    def left_as_facts_are(self, before: State, state: State, stopped: list[WrittenBlock]) -> State:
        """Leaves all blocks under way for which facts have become so, and notes them.

        A block around comes before those in it, which it stops. Those side by side are all left, whatever
        their order; only then blocks around end by that.
        """
        new = state.facts - before.facts
        while True:
            becoming = (
                (node, chosen(state, handler))
                for node in self.left_by_facts
                if node in state.under_way and self.runs(node, state)
                for handler in node.handlers
                if so(state.facts, handler.when) and any(so(new, (word,)) for word in handler.when)
            )
            if (found := next(becoming, None)) is None:
                return self.decided(state, stopped)
            node, route = found
            stopped.append(node)
            state = self.follow(self.left(state, node), node, route, stopped)

    def paused(self, node: WrittenBlock, handler: Handler, state: State) -> WrittenBlock:
        """What is run while a block pauses, made for the objective that runs in it."""
        whole = block = self.objectives[next(iter(self.within(node, state)))]
        while block is not node:
            pause_graph = self.pause_graphs.get(block.name) is block
            if pause_graph and isinstance(block.success, WrittenBlock) and block.success.whole:
                whole = block = block.success
                continue
            assert block.parent is not None
            block = block.parent
            whole = block if block.whole else whole
        return node.pauses[handler.pause or "", whole.name]

    def within(self, node: WrittenBlock, state: State) -> frozenset[str]:
        """The objectives in a block that run or are about to begin."""
        return frozenset(n for n in state.running | state.pending if self.objectives[n].within(node))

    def stopped(self, state: State, node: WrittenBlock) -> State:
        """No objective in a block runs any more; what has ended in it, and what it paused for, stays."""
        gone = self.within(node, state)
        stopped = {a for name in gone & state.running for a in self.objectives[name].activities}
        return replace(
            state,
            running=state.running - gone,
            pending=state.pending - gone,
            activities=frozenset((a, at) for a, at in state.activities if a not in stopped),
        )

    def left(self, state: State, node: WrittenBlock) -> State:
        """Nothing in a block runs any more, nor goes on later."""
        state = self.stopped(state, node)
        inner = {name for name, by in self.pause_graphs.items() if by is not node and by.within(node)}
        return replace(
            state,
            ended=frozenset(e for e in state.ended if not self.branches[e[0]].within(node)),
            paused=frozenset(p for p in state.paused if p[0] not in inner),
        )

    def resumed(self, state: State, by: WrittenBlock) -> State:
        """A block goes on where it was, after what was run meanwhile has succeeded."""
        (at,) = (at for name, at in state.paused if name == by.name)
        return replace(
            state, pending=state.pending | at, paused=frozenset(p for p in state.paused if p[0] != by.name)
        )

    def given_up(self, state: State, by: WrittenBlock) -> State:
        """What is run while a block pauses leads elsewhere: nothing in the block goes on."""
        block = next(node for node in _nodes(self.root) if by in node.pauses.values())
        state = self.left(state, block)
        return replace(state, paused=frozenset(p for p in state.paused if p[0] != by.name))

    def follow(
        self, state: State, node: WrittenBlock, route: str | WrittenBlock, aborted: list[WrittenBlock]
    ) -> State:
        """A block is left by one of its routes; parallel blocks that this aborts are noted."""
        gone = {block for block in state.under_way if block.within(node)}
        state = replace(state, under_way=state.under_way - gone)
        route = self.admitted(state, node, route)
        if self.pause_graphs.get(node.name) is node:
            if route is node.success:
                return self.resumed(state, node)
            state = self.given_up(state, node)
        if isinstance(route, WrittenBlock):
            return self.enter(state, route)
        parent = self.root if node is self.root else node.parent
        assert parent is not None
        if route == TIMED_OUT or unnamed(route) in ENDS:
            if not parent.parallel:
                return self.end(state, parent, route, aborted)
            if route != ABORT:
                return self.branch_ends(state, node, route == SUCCEED, aborted)
            aborted.append(parent)  # the branches beside it are stopped
            return self.end(self.left(state, parent), parent, route, aborted)
        return self.enter(state, parent.children[route])

    def admitted(self, state: State, node: WrittenBlock, route: str | WrittenBlock) -> str | WrittenBlock:
        """Where a route from a block leads as guards are: past siblings that are not entered as facts are."""
        parent = self.root if node is self.root else node.parent
        assert parent is not None
        while isinstance(route, str) and route in parent.children:
            failing = (g for g in parent.children[route].guards if not so(state.facts, g.when))
            if (guard := next(failing, None)) is None:
                break
            route = guard.otherwise
        return route

    def branch_ends(
        self, state: State, branch: WrittenBlock, well: bool, aborted: list[WrittenBlock]
    ) -> State:
        """A child of a parallel block has ended; with the last of them the block does."""
        assert branch.parent is not None
        ended = dict(state.ended) | {branch.name: well}
        siblings = branch.parent.children.values()
        if any(sibling.name not in ended for sibling in siblings):
            return replace(state, ended=frozenset(ended.items()))
        well = all(ended[sibling.name] or not sibling.mandatory for sibling in siblings)
        if (needed := branch.parent.needed) is not None:
            well = sum(ended[sibling.name] for sibling in siblings) >= needed
        others = frozenset(e for e in ended.items() if self.branches[e[0]].parent is not branch.parent)
        return self.end(replace(state, ended=others), branch.parent, SUCCEED if well else FAIL, aborted)

    def decided(self, state: State, stopped: list[WrittenBlock]) -> State:
        """Parallel blocks whose end is decided are left, and noted.

        A block waits for those in it: what they lead to may end branches of it, too.
        """
        while (found := self.decision(dict(state.ended))) is not None:
            block, by = found
            stopped.append(block)
            state = self.end(self.left(state, block), block, by, stopped)
        return state

    def decision(self, ended: dict[str, bool]) -> tuple[WrittenBlock, str] | None:
        """A parallel block that no longer waits, and none in it does, and by which exit it is left."""
        for block in reversed([node for node in _nodes(self.root) if node.parallel]):  # what it holds before
            children = block.children.values()
            well = sum(ended.get(child.name, False) for child in children)
            if block.needed is not None and well >= block.needed:
                return block, SUCCEED
            if fails(block, [child for child in children if ended.get(child.name) is False]):
                return block, FAIL
        return None

    def end(self, state: State, node: WrittenBlock, by: str, aborted: list[WrittenBlock]) -> State:
        """A block ends by one of its exits; with the mission's own blocks the mission does."""
        if node is self.root:
            return replace(state, outcome=ENDS[unnamed(by)])
        # What is ended as one, however much it held, fails for no reason.
        return self.follow(state, *led(state, node, unnamed(by) if node.whole else by), aborted)

    def enter(self, state: State, node: WrittenBlock) -> State:
        """A block is entered: at its first, or at all its children."""
        if not node.children:
            return replace(state, pending=state.pending | {node.name})
        for child in node.children.values() if node.parallel else (node.first,):
            state = self.enter(state, child)
        return state

    def robot_in(self, state: State) -> Activities:
        """The activities of a state."""
        wanted = {name: self.objectives[name].activities for name in sorted(state.pending)}
        known, suspected = state.out - state.unnoticed, state.suspected
        return Activities(dict(state.activities), wanted, known, state.facts, suspected)

    def at_rest(self, state: State) -> frozenset[tuple[str, At]]:
        """The activities when all that stops has stopped."""
        return frozenset(self.robot.stopped(self.robot_in(state)).at.items())

    def reaction(self, state: State) -> State:
        """The stable state that the activities come to."""
        ends = self.robot.settled(self.robot_in(state))
        if len(ends) > 1:
            raise Undetermined
        (end,) = ends
        return replace(
            state,
            running=state.running | (state.pending - set(end.wanted)),
            pending=frozenset(end.wanted),
            activities=frozenset(end.at.items()),
            unnoticed=state.unnoticed - end.out,
            suspected=end.suspected,
        )

    def seen(self, state: State) -> Seen:
        """A state by names, as reports and controllers tell it."""
        by_doing: dict[Acting, set[tuple[str, str]]] = {doing: set() for doing in Acting}
        for name, at in state.activities:
            by_doing[at[0]].add((name, "" if at == REFUSED else self.robot.way(name, at).name))
        return Seen(
            running=state.running,
            pending=state.pending,
            ended=frozenset(name for name, _ in state.ended),
            mode=frozenset(by_doing[Acting.RUNS]),
            waiting=frozenset(by_doing[Acting.TRIES] | by_doing[Acting.ASKS]),
            refused=frozenset(name for name, _ in by_doing[Acting.REFUSED]),
            out=state.out,
            unnoticed=state.unnoticed,
            facts=frozenset((fact, value) for fact, value in state.facts),
            outcome=state.outcome,
        )

    def parameters(self, objective: str | None, activity: str, alternative: str) -> dict[str, str]:
        """The parameters in force for an alternative that an objective runs, or a request."""
        declaring = self.robot.activities[activity]
        (way,) = (way for way in declaring.alternatives if way.name == alternative)
        declared = {p.name: p.value for p in (*declaring.parameters, *way.parameters)}
        return {**declared, **(self.objectives[objective].parameters if objective else {})}


def place(node: WrittenBlock, handler: Handler) -> tuple[str, str, str]:
    """Where a handler is written: the text, the block and the event."""
    return node.text, node.written, handler.event or ""


def fails(block: WrittenBlock, failed: Sequence[WrittenBlock]) -> bool:
    """Whether a parallel block fails at once as some of its children have failed."""
    required = any(child.mandatory for child in failed)
    if (block.hasty and required) or (block.failing is not None and len(failed) >= block.failing):
        return True
    if not block.doomed:
        return False
    return required if block.needed is None else len(block.children) - len(failed) < block.needed


def changed(state: State, facts: Mapping[str, str]) -> State:
    """The same with some facts changed."""
    return replace(state, facts=frozenset({**dict(state.facts), **facts}.items())) if facts else state


def unnamed(exit_: str) -> str:
    """An exit without the reason for which a block fails by it."""
    return FAIL if exit_.startswith(f"{FAIL} ") else exit_


def chosen(state: State, handler: Handler) -> str:
    """Where a handler leads as facts are; those of core missions may have several targets."""
    return next((r.goto for r in handler.routes if so(state.facts, r.when)), handler.goto or ABORT)


def led(state: State, node: WrittenBlock, by: str) -> tuple[WrittenBlock, str | WrittenBlock]:
    """Where an outcome of a block leads: the first of its routes whose facts are so, else the default.

    What fails for a reason asks first the routes for that, of the whole block where it is a copy. Where it
    leads to ``fail``, the block around fails for the same reason; what is run for a block fails it for none.

    Returns:
        The block that is left, the whole one where a route of that counts, and the route.
    """
    if by == TIMED_OUT and node.timed_out is not None:
        late = (r.goto for r in node.deciding if r.on == TIMEOUT and so(state.facts, r.when))
        return node, next(late, node.timed_out)
    whole, by = node, unnamed(by) if node.helper else by
    while unnamed(by) != by:
        for route in whole.deciding:
            if f"{FAIL} {route.reason}" == by and so(state.facts, route.when):
                return whole, by if route.goto == FAIL else route.goto
        if not whole.copy:
            break
        assert whole.parent is not None
        whole = whole.parent
    outcome = {SUCCEED: SUCCESS, FAIL: FAILURE, TIMED_OUT: FAILURE, ABORT: ABORT}.get(unnamed(by))
    asked = (r for r in node.deciding if r.on == outcome and r.reason is None)
    ways = {SUCCEED: node.success, FAIL: node.failure, TIMED_OUT: node.failure, ABORT: node.abort}
    to = next((route.goto for route in asked if so(state.facts, route.when)), ways[unnamed(by)])
    return node, by if (to, unnamed(by)) == (FAIL, FAIL) else to


def _read_of_objectives(mission: Mission) -> Iterator[str]:
    """Facts of the form ``done(x)`` that a mission reads."""
    whens = [a.requires for a in mission.activities]
    whens += [way.requires for a in mission.activities for way in a.alternatives]
    texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
    every = [block for blocks in texts for block in walk(blocks)]
    whens += [guard.when for block in every for guard in block.guards]
    handlers = [handler for block in every for handler in block.handlers]
    whens += [handler.when for handler in handlers]
    whens += [route.when for handler in handlers for route in handler.routes]
    whens += [route.when for block in every for route in block.routes]
    yield from (word.lstrip("!").partition("=")[0] for when in whens for word in when if "done(" in word)


def _nodes(node: WrittenBlock) -> Iterator[WrittenBlock]:
    yield node
    for child in node.children.values():
        yield from _nodes(child)


def _shelters(node: WrittenBlock) -> Iterator[WrittenBlock]:
    for inner in _nodes(node):
        yield from inner.pauses.values()


def _leaves(node: WrittenBlock) -> Iterator[WrittenBlock]:
    if not node.children:
        yield node
    for child in node.children.values():
        yield from _leaves(child)


def _branches(node: WrittenBlock) -> Iterator[WrittenBlock]:
    for child in node.children.values():
        if node.parallel:
            yield child
        yield from _branches(child)


def words(happenings: Iterable[Happening]) -> str:
    """Events as text, for messages."""
    return ", ".join(" ".join(filter(None, (element, what))) for what, element in happenings)
