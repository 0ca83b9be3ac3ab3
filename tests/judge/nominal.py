"""What a mission does while nothing fails, by the interpreter and by its text: no net, no space."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from hypothesis import strategies as st

from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Block, Each, Mission, Parallel, Recursive
from mcpn.testing.judge.blocks import TIMED_OUT, WrittenBlock, objectives
from mcpn.testing.judge.interpreter import REPAIRED, START, SUCCESS, Interpreter, State

MOST_STATES = 3_000


@dataclass(frozen=True)
class WhileNothingFails:
    """What the interpreter finds.

    Args:
        ends: How runs end but by success: the outcome, or nothing where nobody can succeed.
        circles: Whether some run goes on for ever, but in what is meant to be endless.
        left_out: Objectives that none enters, though the text does not allow it.
    """

    ends: frozenset[str | None]
    circles: bool
    left_out: frozenset[str]

    @property
    def holds(self) -> bool:
        return not (self.ends or self.circles or self.left_out)


def played(of: Mission) -> WhileNothingFails | None:
    """All orders of successes; ``None`` where there are too many.

    Raises:
        Undetermined: Two activities ask for one thing at the same moment.
    """
    interpreter = Interpreter(of)
    begin = interpreter.initial
    for name in sorted(begin.out - interpreter.lasting):
        begin = interpreter.after(begin, (REPAIRED, name))
    onward: dict[State, list[State]] = {}
    stack = [begin]
    while stack:
        if (state := stack.pop()) in onward:
            continue
        happen = [e for e in interpreter.possible(state) if e[0] in (START, SUCCESS)]
        onward[state] = [interpreter.after(state, e) for e in sorted(happen)]
        stack += onward[state]
        if len(onward) > MOST_STATES:
            return None
    ends = {s.outcome for s, after in onward.items() if not after and s.outcome != "success"}
    entered = {name for state in onward for name in state.running}
    endless = {name for name, leaf in interpreter.objectives.items() if says(leaf, "endless")}
    inside = {s for s in onward if not s.running & endless}
    while pruned := {s for s in inside if inside.isdisjoint(onward[s])}:
        inside -= pruned
    optional = {name for name, leaf in interpreter.objectives.items() if says(leaf, "optional")}
    wanted = {leaf.name for leaf in Level(interpreter.root).meant()}
    return WhileNothingFails(frozenset(ends), bool(inside), frozenset(wanted - entered - optional))


@st.composite
def said(draw: st.DrawFn, missions: st.SearchStrategy[Mission]) -> Mission:
    """Missions of which some blocks say what is meant while nothing fails."""
    of, words = draw(missions), ("entered", "entered", "endless", "optional")

    def block(each: Block) -> Block:
        each = replace(each, nominal=draw(st.sampled_from(words)))
        if isinstance(each, Recursive | Parallel | Each):
            return replace(each, blocks=tuple(map(block, each.blocks)))
        return each

    if not draw(st.booleans()):
        return of
    return replace(of, blocks=tuple(map(block, of.blocks)))


@st.composite
def cut_short(draw: st.DrawFn, missions: st.SearchStrategy[Mission]) -> Mission:
    """Missions of which some blocks end what is around them by their success: nothing leads to the next."""
    of = draw(missions)

    def block(each: Block) -> Block:
        if draw(st.integers(0, 3)) == 0:
            each = replace(each, success=draw(st.sampled_from((SUCCEED, FAIL))))
        if isinstance(each, Recursive | Parallel | Each):
            return replace(each, blocks=tuple(map(block, each.blocks)))
        return each

    protocols = tuple(replace(each, blocks=tuple(map(block, each.blocks))) for each in of.protocols)
    cut = replace(of, blocks=tuple(map(block, of.blocks)), protocols=protocols)
    try:
        compose(cut)
    except InputError:
        return of
    return cut


def says(leaf: WrittenBlock, nominal: str) -> bool:
    return any(node.nominal == nominal for node in with_parents(leaf))


def with_parents(leaf: WrittenBlock) -> Iterator[WrittenBlock]:
    node: WrittenBlock | None = leaf
    while node is not None:
        yield node
        node = node.parent


class Level:
    """The objectives and parallel blocks of a mission, or of a branch, and where each leads in effect.

    Args:
        of: The mission's node, or a branch's.
    """

    def __init__(self, of: WrittenBlock) -> None:
        self.of = of
        self.units = list(_units(of))
        self.within = {id(u): [Level(b) for b in u.children.values()] for u in self.units if u.parallel}
        self.by_success: dict[int, list[WrittenBlock]] = {id(unit): [] for unit in self.units}
        self.otherwise: dict[int, list[WrittenBlock]] = {id(unit): [] for unit in self.units}
        self.ends: dict[int, set[str]] = {id(unit): set() for unit in self.units}
        self.units = [unit for unit in self.units if not only_helps(unit)]
        self.lead(self.units)

    def lead(self, units: Iterable[WrittenBlock]) -> None:
        for unit in units:
            self.unit = unit
            way, aside = self.by_success[id(unit)], self.otherwise[id(unit)]
            self.follow(unit, SUCCEED, way, aside)
            self.follow(unit, FAIL, aside, aside)
            if unit.timeout is not None:
                self.follow(unit, TIMED_OUT, aside, aside)
            if any(ABORT in level.may_end for level in self.within.get(id(unit), ())):
                self.follow(unit, ABORT, aside, aside)
            self.interrupted(unit, aside)

    def interrupted(self, unit: WrittenBlock, aside: list[WrittenBlock]) -> None:
        """Where events lead, and times of blocks; an event outside of another handler of it never counts."""
        node, handled = unit, set[str]()
        stopped = {around.name for around in with_parents(unit)}
        while True:
            if node is not unit and node.timeout is not None:
                self.follow(node, TIMED_OUT, aside, aside)
            for handler in (h for h in node.handlers if h.event not in handled):
                if handler.pause is not None:
                    aside += [
                        entry(by)
                        for (name, at), by in node.pauses.items()
                        if name == handler.pause and at in stopped
                    ]
                elif node.parent is None and handler.goto in node.children:
                    aside.append(entry(node.children[handler.goto]))
                else:
                    self.goto(node, handler.goto or ABORT, aside, aside)
            handled |= {h.event for h in node.handlers if h.event is not None and not h.once}
            if node is self.of or node.parent is None:
                return
            node = node.parent

    @property
    def may_end(self) -> set[str]:
        """By which exits it may be left, as routes are written."""
        return {end for unit in self.reached for end in self.ends[unit]}

    @property
    def reached(self) -> set[int]:
        both = {unit: [*self.by_success[unit], *self.otherwise[unit]] for unit in self.by_success}
        return closed([entry(self.of)], both)

    def meant(self) -> Iterator[WrittenBlock]:
        """Objectives on the way of successes from the first, and those that nothing leads to."""
        wanted, reached = closed([entry(self.of)], self.by_success), self.reached
        left = [unit for unit in self.units if id(unit) not in reached]
        left = [unit for unit in left if not all(map(helps, objectives(unit)))]
        for unit in self.units:
            if id(unit) in wanted or unit in left:
                if unit.parallel:
                    for level in self.within[id(unit)]:
                        yield from level.meant()
                else:
                    yield unit

    def follow(
        self, node: WrittenBlock, exit_: str, way: list[WrittenBlock], aside: list[WrittenBlock]
    ) -> None:
        """Where an exit of a node leads in effect; where facts choose that, it is aside."""
        on = {SUCCEED: "success", FAIL: "failure", TIMED_OUT: "failure"}.get(exit_)
        if exit_ == TIMED_OUT and node.timed_out is not None:
            on = None
        for route in (r for r in node.deciding if r.on == on):
            way = aside
            self.goto(node, route.goto, aside, aside)
        leads: dict[str, str | WrittenBlock] = {SUCCEED: node.success, FAIL: node.failure, ABORT: node.abort}
        leads[TIMED_OUT] = node.timed_out or node.failure
        self.goto(node, leads[exit_], way, aside)

    def goto(
        self,
        node: WrittenBlock,
        route: str | WrittenBlock,
        way: list[WrittenBlock],
        aside: list[WrittenBlock],
    ) -> None:
        if isinstance(route, WrittenBlock):
            way.append(entry(route))
        elif node is not self.of and node.parent is not None and route in node.parent.children:
            child = node.parent.children[route]
            for guard in child.guards:
                self.goto(node, guard.otherwise, aside, aside)
            (aside if child.guards else way).append(entry(child))
        elif node is self.of or node.parent is None or node.parent.parent is None:
            self.ends[id(self.unit)].add(str(route))
        else:
            self.follow(node.parent, str(route), way, aside)


def closed(begin: list[WrittenBlock], onward: dict[int, list[WrittenBlock]]) -> set[int]:
    found, stack = set[int](), list(begin)
    while stack:
        if id(unit := stack.pop()) not in found:
            found.add(id(unit))
            stack += onward[id(unit)]
    return found


def _units(node: WrittenBlock) -> Iterator[WrittenBlock]:
    """Objectives and parallel blocks in a node, but what stands in parallel blocks."""
    if node.parallel or not node.children:
        yield node
    else:
        for child in node.children.values():
            yield from _units(child)


def entry(node: WrittenBlock) -> WrittenBlock:
    while node.children and not node.parallel:
        node = node.first
    return node


def led_otherwise(node: WrittenBlock) -> bool:
    """Whether its text leads to it by anything but success, or runs it for a sibling."""
    assert node.parent is not None
    siblings, root = node.parent.children, node.parent.parent is None
    targets: set[str | WrittenBlock | None] = {handler.goto for handler in node.parent.handlers if root}
    for key, of in siblings.items():
        if of.written == node.written and key != node.written:
            return True
        targets |= {of.failure, of.abort, of.timed_out, *(route.goto for route in of.deciding)}
        targets |= {guard.otherwise for guard in of.guards}
        targets |= {handler.goto for handler in of.handlers}
    return node.written in targets


def helps(leaf: WrittenBlock) -> bool:
    """Whether it is a helper, or stands in one."""
    node = leaf
    while node.parent is not None:
        if not node.copy and led_otherwise(node):
            return True
        node = node.parent
    return False


def only_helps(unit: WrittenBlock) -> bool:
    """Whether it stands in a sibling of which copies alone are run, for others: no route leads to it."""
    node = unit
    while node.parent is not None:
        siblings = node.parent.children
        copied = any(of.written == node.written and key != node.written for key, of in siblings.items())
        if copied and siblings.get(node.written) is node and node.parent.first is not node:
            routes = {
                to for of in siblings.values() for to in (of.success, of.failure, of.abort, of.timed_out)
            }
            routes |= {route.goto for of in siblings.values() for route in of.deciding}
            routes |= {guard.otherwise for of in siblings.values() for guard in of.guards}
            routes |= {handler.goto for of in siblings.values() for handler in of.handlers}
            routes |= {handler.goto for handler in node.parent.handlers if node.parent.parent is None}
            if node.written not in routes:
                return True
        node = node.parent
    return False
