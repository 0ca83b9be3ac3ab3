"""The blocks of a mission written out: uses, values, rounds and tries, each with its name and its routes.

Made from the language page alone. A place in the mission is a :class:`WrittenBlock`; the names of nodes are
the qualified names of the page. A handler is told from others by where it is written, however many copies of
its block there are.

Core missions, in which passes have written this out, are read as others are: their names are whole, and a
block in one that is written as the same block is a copy of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

from mcpn.mission.model import (
    ABORT,
    FAIL,
    ROUND,
    SUCCEED,
    Block,
    Each,
    EntryGuard,
    FactRoute,
    Handler,
    Mission,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
)
from mcpn.mission.robot import FactChange, Parameter

TIMED_OUT = "timed out"
"""The exit of a copy of an objective whose time is over, where the objective says where that leads."""

Values = Mapping[str, str]
"""Parameters in force, by name."""


@dataclass(eq=False)
class WrittenBlock:
    """A block in its place, or one copy of it.

    Args:
        name: Its qualified name.
        parent: The node that it stands in; ``None`` for the mission.
        parallel: Whether its children run at the same time; else one runs after the other.
        mandatory: Whether a parallel block needs its success.
        needed: How many children of a parallel block must succeed, if so many decide that it does.
        hasty: Whether a parallel block fails as soon as a mandatory child does.
        failing: How many failed children fail a parallel block, if so many do.
        doomed: Whether a parallel block fails as soon as it cannot succeed any more.
        success: Where success leads: the written name of a sibling, ``succeed`` or ``fail``.
        failure: Where failure leads.
        abort: Where it leads that something in it aborts.
        timeout: After how many seconds it is over by itself, if it is.
        timed_out: Where that leads; ``None`` for where failure does.
        handlers: What it does on events.
        children: By written name (of copies: by number), in order; none for an elementary objective.
        activities: What an elementary objective runs.
        parameters: Those in force in an elementary objective.
        written: Its name in the text; that of a copy is its block's.
        copy: Whether it is a copy of its parent: a round, a try, a run or a value of it.
        helper: Whether it is a copy of a sibling that is run for a block.
        use: The protocol that what it holds is written in, if it is written in one.
        failures: The reasons for which an elementary objective may fail.
        sets: Facts that an elementary objective changes.
        guards: What must be for it to be entered by a route, and where that leads else, in order.
        deciding: Its own routes that facts decide, in order.
        pauses: What is run while it pauses, by the written name of that and the objective, or parallel block,
            that is stopped.
        nominal: What its author says of it for runs on which nothing fails.
    """

    name: str
    parent: WrittenBlock | None = None
    parallel: bool = False
    mandatory: bool = True
    needed: int | None = None
    hasty: bool = False
    failing: int | None = None
    doomed: bool = False
    success: str | WrittenBlock = SUCCEED
    failure: str | WrittenBlock = FAIL
    abort: str = ABORT
    timeout: float | None = None
    timed_out: str | None = None
    handlers: tuple[Handler, ...] = ()
    children: dict[str, WrittenBlock] = field(default_factory=dict)
    activities: tuple[str, ...] = ()
    parameters: Values = field(default_factory=dict)
    written: str = ""
    copy: bool = False
    helper: bool = False
    use: str = ""
    failures: tuple[str, ...] = ()
    sets: tuple[FactChange, ...] = ()
    guards: tuple[EntryGuard, ...] = ()
    deciding: tuple[FactRoute, ...] = ()
    pauses: dict[tuple[str, str], WrittenBlock] = field(default_factory=dict)
    nominal: str = "entered"

    @property
    def first(self) -> WrittenBlock:
        """The child that a series is entered at."""
        return next(iter(self.children.values()))

    @property
    def text(self) -> str:
        """The protocol that it is written in, if it is written in one."""
        node = self.parent
        while node is not None and not node.use:
            node = node.parent
        return node.use if node is not None else ""

    @property
    def whole(self) -> bool:
        """Whether it is stopped as a whole: what has branches, a time of its own, or is left by facts."""
        by_facts = any(handler.when for handler in self.handlers)
        return bool(self.children) and (self.parallel or self.timeout is not None or by_facts)

    def within(self, other: WrittenBlock) -> bool:
        """Whether it is another node, or stands in it at any depth."""
        node: WrittenBlock | None = self
        while node is not None and node is not other:
            node = node.parent
        return node is other


@dataclass(frozen=True)
class _Scope:
    """What a block takes from around it.

    Args:
        prefix: Qualifies its name.
        suffix: Says which copy it is.
        said: Parameters that the blocks around say, values and rounds among them.
        defaults: Parameters of the protocols around, which count where no block says them.
    """

    prefix: str = ""
    suffix: str = ""
    said: Values = field(default_factory=dict)
    defaults: Values = field(default_factory=dict)

    def copy(self, suffix: object, value: Values | None = None) -> _Scope:
        """The scope of one copy."""
        return replace(self, suffix=f"{self.suffix}_{suffix}", said={**self.said, **(value or {})})

    def inside(self, block: Block, parameters: tuple[Parameter, ...] = ()) -> _Scope:
        """The scope of what a block holds: a copy qualifies the names in it."""
        prefix = f"{self.prefix}{block.name}{self.suffix}." if self.suffix else self.prefix
        return replace(self, prefix=prefix, suffix="", said={**self.said, **_values(parameters)})

    def protocol(self, use: Use, protocol: Protocol) -> _Scope:
        """The scope of a protocol's blocks."""
        return _Scope(
            f"{self.prefix}{use.name}{self.suffix}.",
            "",
            {**self.said, **_values(use.parameters)},
            {**self.defaults, **_values(protocol.parameters)},
        )


def _values(parameters: tuple[Parameter, ...]) -> dict[str, str]:
    return {parameter.name: parameter.value for parameter in parameters}


def written_out(mission: Mission) -> WrittenBlock:
    """The mission's own node, with all that stands in it."""
    return _Writing(mission).mission()


def objectives(node: WrittenBlock) -> list[WrittenBlock]:
    """The elementary objectives in a node, at any depth."""
    return [leaf for child in node.children.values() for leaf in objectives(child)] or [node]


def stopped(node: WrittenBlock) -> list[WrittenBlock]:
    """What one copy of a sibling is run for: the objectives in a node, but some blocks whole."""
    if node.whole or not node.children:
        return [node]
    inside = (child for child in node.children.values() if not _within_parallel(child))
    return [at for child in inside for at in stopped(child)]


def _within_parallel(shelter: WrittenBlock) -> bool:
    """Whether it is what runs while a block pauses as a whole: with that block it is stopped."""
    return isinstance(shelter.success, WrittenBlock) and shelter.success.whole


def _every(node: WrittenBlock) -> list[WrittenBlock]:
    return [node, *(inner for child in node.children.values() for inner in _every(child))]


class _Writing:
    def __init__(self, mission: Mission) -> None:
        self.written = mission
        self.protocols = {protocol.name: protocol for protocol in mission.protocols}

    def mission(self) -> WrittenBlock:
        root = WrittenBlock(self.written.name)
        self.series(root, self.written.blocks, _Scope())
        # Handlers of the mission lead to its own blocks, as those of a block lead to its siblings.
        root.handlers = self.written.handlers
        return root

    def series(self, parent: WrittenBlock, blocks: tuple[Block, ...], scope: _Scope) -> None:
        """Writes out blocks that run one after the other, or as branches."""
        aside = {block.recover for block in blocks} | {h.pause for block in blocks for h in block.handlers}
        aside |= {block.name for block in blocks if block.resumes}
        by_name = {block.name: block for block in blocks}
        for number, block in enumerate(blocks):
            after = [b.name for b in blocks[number + 1 :] if b.name not in aside and not parent.parallel]
            following = after[0] if after else SUCCEED
            node = self.block(block, parent, scope)
            node.success, node.failure = block.success or following, block.failure or FAIL
            node.abort = block.abort or ABORT
            node.timed_out = block.timeout_goto
            node.guards, node.deciding = block.guards, block.routes
            node.mandatory, node.handlers = block.mandatory, block.handlers
            parent.children[block.name] = node
            node.copy = parent.written == block.written and parent.name.startswith(block.stem)
            if block.recover is not None:
                self.recoveries(node, block, by_name[block.recover], scope)
            for name, fails in {h.pause: h.fails_as for h in block.handlers if h.pause is not None}.items():
                if name in by_name:  # else its copies are written out
                    self.pauses(node, by_name[name], scope, by_name[fails] if fails else block)
        for block in blocks:
            if block.resumes:
                self.resuming(parent.children[block.name], block, parent, scope)

    def pauses(self, node: WrittenBlock, by: Block, scope: _Scope, failing: Block) -> None:
        """Gives each objective in a block what is run when it is stopped, which leads back to it.

        A parallel block in it has one for all of its objectives.
        """
        assert node.parent is not None
        for leaf in stopped(node):
            at = leaf.name.removeprefix(f"{scope.prefix}{by.prefix}").replace(".", "_")
            shelter = self.helper(node, (by, failing), scope.copy(f"at_{at}"), leaf)
            node.pauses[by.name, leaf.name] = shelter
            node.parent.children[f"{by.name} at {leaf.name}"] = shelter

    def resuming(self, copy: WrittenBlock, block: Block, parent: WrittenBlock, scope: _Scope) -> None:
        """Lets a copy that is written out run while what it resumes is stopped, as core missions say it."""
        inside = (node for child in parent.children.values() for node in _every(child))
        resumed = f"{scope.prefix}{block.resumes}{scope.suffix}"  # a pause may be copied with those in it
        copy.success = at = next(node for node in inside if node.name == resumed)
        by = block.name.removesuffix(f"_{block.copy[-1]}")
        for node in parent.children.values():
            if at.within(node):
                node.pauses[by, at.name] = copy

    def recoveries(self, node: WrittenBlock, block: Block, by: Block, scope: _Scope) -> None:
        """Lets each run of a block but the last lead by its failure to a recovery, that to the next run."""
        assert node.parent is not None
        runs = list(node.children.values())
        for number, (run, again) in enumerate(pairwise(runs), 1):
            recovery = self.helper(node, (by, block), scope.copy(f"{block.name}{number}"), again)
            run.failure = recovery
            node.parent.children[f"{block.name} {number}"] = recovery

    def helper(
        self, node: WrittenBlock, which: tuple[Block, Block], scope: _Scope, success: WrittenBlock
    ) -> WrittenBlock:
        """A copy of a sibling that is run for a block: its success leads back, its failure fails a block."""
        assert node.parent is not None
        by, failing = which
        found = self.block(by, node.parent, scope)
        found.success, found.failure = success, failing.failure or FAIL
        found.abort, found.handlers, found.helper = by.abort or ABORT, by.handlers, True
        on_failure = (route for route in failing.routes if route.on == "failure")
        outwards = (route for route in by.routes if route.on in ("abort", "timeout"))
        found.deciding = (*(route for route in on_failure if route.reason is None), *outwards)
        found.timed_out = by.timeout_goto
        return found

    def block(self, block: Block, parent: WrittenBlock, scope: _Scope) -> WrittenBlock:
        """A block without what its parent sees of it: rounds, in each its tries, in each the block."""
        node = WrittenBlock(f"{scope.prefix}{block.name}{scope.suffix}", parent, written=block.written)
        node.nominal = block.nominal
        if block.timeout_goto is not None:
            node.timed_out = TIMED_OUT  # of a copy; what its parent sees of a block comes later
        if block.recover is not None:
            once = replace(block, recover=None, times=1)
            runs = [scope.copy(f"run{n}") for n in range(1, block.times + 2)]
            self.copies(node, [self.block(once, node, run) for run in runs])
            for run in node.children.values():
                run.success = SUCCEED
        elif block.repeat is not None:
            once = replace(block, repeat=None)
            rounds = [scope.copy(n, {ROUND: str(n)}) for n in range(1, block.repeat + 1)]
            self.copies(node, [self.block(once, node, round_) for round_ in rounds])
        elif block.retries:
            once = replace(block, retries=0)
            tries = [scope.copy(f"try{n}") for n in range(1, block.retries + 2)]
            self.copies(node, [self.block(once, node, try_) for try_ in tries], tries=True)
        else:
            self.single(node, block, scope)
        return node

    def single(self, node: WrittenBlock, block: Block, scope: _Scope) -> None:
        """Writes out what a block holds, which is no copy of another and has none but those of its values."""
        node.timeout = block.timeout
        if isinstance(block, Each):
            inside = scope.inside(block)
            values = [WrittenBlock(node.name, node) for _ in block.values]
            for round_, value in zip(values, block.values, strict=True):
                self.series(round_, block.blocks, inside.copy(value, {block.bound: value}))
            self.copies(node, values)
        elif isinstance(block, Objective):
            said = [
                name for a in self.written.activities if a.name in block.activities for name in a.failures
            ]
            said += [text.split("=")[0] for text in block.failures]
            node.activities, node.failures = block.activities, tuple(dict.fromkeys(said))
            node.sets = block.sets
            node.parameters = {**scope.defaults, **scope.said, **_values(block.parameters)}
        elif isinstance(block, Parallel):
            node.parallel, node.hasty = True, block.failure_when == "any"
            if block.success_when != "all":
                node.needed = 1 if block.success_when == "any" else int(block.success_when)
            limits = (number for number in (block.failure_when, str(block.failing)) if number.isdecimal())
            node.failing = min(map(int, limits), default=None)
            node.doomed = block.impossible == "fails"
            self.series(node, block.blocks, scope.inside(block))
        elif isinstance(block, Recursive):
            node.use = block.protocol or ""  # of a use that is written out, as core missions have them
            self.series(node, block.blocks, scope.inside(block, block.parameters))
        else:
            protocol = self.protocols[block.protocol]
            self.series(node, protocol.blocks, scope.protocol(block, protocol))
            node.use = block.protocol

    def copies(self, parent: WrittenBlock, copies: list[WrittenBlock], *, tries: bool = False) -> None:
        """Rounds, where each success leads to the next, or tries, where each failure does."""
        for number, node in enumerate(copies):
            following = str(number + 1) if number + 1 < len(copies) else None
            node.success = SUCCEED if tries else following or SUCCEED
            node.failure = following or FAIL if tries else FAIL
            node.copy, parent.children[str(number)] = True, node
