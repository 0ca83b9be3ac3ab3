"""Translates the nodes of a behaviour tree into blocks of a mission, and keeps the ledger.

Each kind of node has a function of its own (``controls``, ``reactive``, ``decorators``, ``nav2``) that says
what it becomes; here is what they share: leaves, subtrees, preconditions, choices, events and facts.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from mcpn.did_you_mean import did_you_mean
from mcpn.errors import InputError, Problem
from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    Block,
    FactRoute,
    Handler,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
)
from mcpn.mission.robot import DeclaredEvent, Fact, FactChange, Parameter
from mcpn.trees.ledger import Kind, LedgerEntry
from mcpn.trees.nodes.forest import Forest, tree_of
from mcpn.trees.nodes.node import PRECONDITIONS, Tree, TreeNode
from mcpn.trees.nodes.row import NodeRow
from mcpn.trees.nodes.table import TABLE
from mcpn.trees.nodes.versions import PY_TREES, told
from mcpn.trees.pieces import Part, Result, answers, placed, sourced, tidied
from mcpn.trees.tree_names import Lane, TreeNames, readable

TURNS = frozenset({"round_robin", "round_robin_wraps_or_not"})
MEMORIES = frozenset({"with_memory", "with_memory_unhalted"})
STATEFUL = TURNS | MEMORIES | {"once", "trigger"}
"""Rules of nodes that remember something from one entry to the next."""
CONSTANT = MappingProxyType({"succeeds": True, "fails": False})
"""Rules of leaves that always answer the same, at once."""
RETURNING = MEMORIES | {"async_sequence", "async_fallback"}
"""Rules of nodes that return between their children, so that they may be interrupted."""
LOOPS = frozenset({"retry", "repeat"})
"""Rules of nodes that run their child so often as their port says."""
RUNNING_ON = RETURNING | LOOPS | {"keep_running", "loop"}
"""Rules of nodes that return between their children or rounds."""
PROMPT = frozenset({"sequence", "fallback", "inverter", "force_success", "force_failure"})
"""Rules of nodes that tick no child a second time before they end."""
LOOKS_LIKE_CONDITION = re.compile(
    r"(Is|Are|Check|Has|Have|Would|Can|Was|is_|are_|has_|check_|can_)(?![a-z])|(is|has|are)[A-Z]"
)
"""Names that people give to conditions: IsBatteryFull, check_door."""


@dataclass(frozen=True, slots=True)
class Context:
    """Where a node stands.

    Args:
        lane: The branches of parallel blocks around it.
        again: Whether it may be entered again after it has ended or was halted.
        halted: Whether it may be halted while it runs, by something that does not say so.
        asked: Whether it may be halted while it runs, by something that says so.
        piped: Whether it is in a pipeline whose stages run, and are ticked again beside later ones.
    """

    lane: Lane = ()
    again: bool = False
    halted: bool = False
    asked: bool = False
    piped: bool = False

    @property
    def seen(self) -> bool:
        """Whether it is seen that it returns once more before it ends: something may come first."""
        return bool(self.lane) or self.halted or self.asked

    def branch(self, block: int, number: int) -> Context:
        """That of a branch of a parallel block."""
        return replace(self, lane=(*self.lane, (block, number)))


Chain = tuple[TreeNode, ...]


@dataclass(frozen=True, slots=True)
class BlockOrigin:
    """What a block stands for.

    Args:
        chain: The nodes that use trees around the leaf, the outermost first, in the text of the block.
        leaf: The leaf; ``None`` for a block that uses a protocol.
    """

    chain: Chain = ()
    leaf: TreeNode | None = None


Rule = Callable[["Translator", TreeNode, Context], Result]
"""How a kind of node is translated."""


@dataclass(slots=True)
class Translator:
    """Makes blocks of nodes.

    Args:
        forest: The trees.
        rules: By registered name, how control nodes and decorators are translated.
        unknown: How a decorator is translated of which nothing is known.
    """

    forest: Forest
    rules: Mapping[str, Rule]
    unknown: Rule
    names: TreeNames = field(default_factory=TreeNames)
    entries: list[LedgerEntry] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    events: dict[str, DeclaredEvent] = field(default_factory=dict)
    facts: dict[str, Fact] = field(default_factory=dict)
    activities: dict[str, tuple[str, bool]] = field(default_factory=dict)
    """Activities with what they are for, and whether they are leaves of the tree."""
    protocols: dict[str, Protocol] = field(default_factory=dict)
    """By identifier of their tree, or by name."""
    skipping: set[str] = field(default_factory=set)
    """Protocols that may be skipped."""
    memories: dict[str, tuple[str, str]] = field(default_factory=dict)
    """By block the fact that remembers where it goes on, and its value where it begins anew."""
    instants: set[str] = field(default_factory=set)
    """Objectives that stand for no time in the tree, and whose end is decided as they begin."""
    parallels: int = 0
    chain: Chain = ()
    """The uses of trees around the node that is translated, in the text that it is written in."""
    origins: dict[str, BlockOrigin] = field(default_factory=dict)
    """By block, as it is written, the leaf that it stands for, or the use of a tree."""
    heard: dict[str, tuple[str, bool]] = field(default_factory=dict)
    """By event, the block of the leaf that answers otherwise then, and whether that is success."""
    silent: set[str] = field(default_factory=set)
    """Objectives whose end no leaf decides, and whose outcome makes no difference."""
    parameters: dict[str, set[str]] = field(default_factory=dict)
    """By tree, the ports that any use of it gives."""

    def __post_init__(self) -> None:
        for tree in self.forest.trees.values():
            for node in tree.root.walk():
                if (used := tree_of(self.forest, node)) is not None:
                    self.parameters.setdefault(used.id, set()).update(node.ports)

    def piece(self, node: TreeNode, context: Context) -> Result:
        """What a node becomes, with its preconditions; blocks have the place of their node."""
        free = any(rule in node.rules for rule in PRECONDITIONS)
        made = self.conditional(node, context) if free else self.ticked(node, context)
        return made if isinstance(made, bool) else replace(made, block=sourced(made.block, node.source))

    def ticked(self, node: TreeNode, context: Context) -> Result:
        """What a node becomes once it is ticked."""
        if (tree := tree_of(self.forest, node)) is not None:
            return self.subtree(node, tree, context)
        rows = self.forest.choice.rows(node)
        rules = frozenset(row.rule for row in rows)
        if rules <= self.rules.keys() and rows:
            made = self.rules[rows[-1].rule](self, node, context)
            if len(rules) > 1:
                self.depends(node, rows)
            return made
        if rows and rows[-1].exact == "refused":
            return self.refused(node, f"{node.title} has no translation: {rows[-1].rule}")
        if len(node.children) == 1:
            return self.unknown(self, node, context)
        if node.children:
            return self.refused(
                node,
                f"{node.title} has {len(node.children)} children, and what it does with them is not known"
                f"{did_you_mean(node.id, (row.node for row in TABLE if row.children[1] > 1))}",
            )
        return self.leaf(node, context)

    def leaf(self, node: TreeNode, context: Context) -> Result:
        """What a leaf becomes: an objective with one activity, or what it always returns."""
        rule = self.forest.rule(node)
        if rule in CONSTANT:
            self.note(node, "succeeds at once" if CONSTANT[rule] else "fails at once", Kind.EXACT)
            return CONSTANT[rule]
        if rule == "sleep":
            if node.ports["msec"].strip() == "0":
                self.note(node, "succeeds at once", Kind.EXACT)
                return True
            return self.waiting(node, context, f"{node.ports['msec']} ms")
        name = self.names.fresh(called(node))
        objective = Objective(
            name=name,
            activities=(self.activity(node.id, context, leaf=True),),
            parameters=parameters(node),
            description=described(node),
            nominal="unknown"
            if self.condition(node)
            else "entered",  # success may be no good news: GoalUpdated
        )
        self.origins[name] = BlockOrigin(self.chain, node)
        self.note(
            node, name, Kind.EXACT, "" if self.sure(node) else "taken for a condition because of its name"
        )
        return Part(objective)

    def waiting(self, node: TreeNode, context: Context, awaited: str, kind: Kind = Kind.TIME) -> Part:
        """An objective that ends some day, and well."""
        name = self.names.fresh(called(node, f"{node.id}_wait"))
        self.note(node, name, kind, f"waits for {awaited}")
        if self.forest.rule(node) == "sleep":
            self.origins[name] = BlockOrigin(self.chain, node)
        else:
            self.silent.add(name)
        made = Objective(
            name=name, activities=(self.activity("wait", context),), description=f"Awaits {awaited}"
        )
        return Part(made, bad=True)

    def constant(self, wish: str, context: Context, ends: bool, when: str) -> Part:
        """An objective that stands for what always ends the same way, whatever its activity does."""
        activity = self.activity("idle", context)
        said = f"{'Succeeds' if ends else 'Fails'} {when}"
        made = Objective(name=self.names.fresh(wish), activities=(activity,), description=said)
        self.silent.add(made.name)
        return Part(made, good=ends, bad=ends)

    def later(self, wish: str, context: Context, ends: bool) -> Result:
        """What always ends the same way, but not in the tick in which it is begun."""
        return self.constant(wish, context, ends, "at a later tick") if context.seen else ends

    def forever(self, node: TreeNode, context: Context) -> Part:
        """What runs until it is halted."""
        name = self.names.fresh(called(node))
        self.note(node, name, Kind.EXACT, "it runs until it is halted")
        idle = Objective(name=name, activities=(self.activity("idle", context),), success=name, failure=name)
        self.silent.add(name)
        return Part(Recursive(name=self.names.fresh(f"{name}_loop"), blocks=(idle,)))

    def activity(self, what: str, context: Context, *, leaf: bool = False) -> str:
        """The activity for a leaf, or for an objective that is none."""
        name = self.names.activity(what if leaf else f"bt_{what}", context.lane)
        self.activities[name] = (what, leaf)
        return name

    def choice(self, wish: str, context: Context, why: str) -> Objective:
        """An objective that ends either way: what nothing in the mission decides."""
        return Objective(
            name=self.names.fresh(wish), activities=(self.activity("decide", context),), description=why
        )

    def event(self, wish: str, why: str) -> str:
        """A declared event."""
        name, count = wish, 1
        wish = name = self.names.fresh(wish)
        while name in self.events:
            count += 1
            name = f"{wish}{count}"
        self.events[name] = DeclaredEvent(name=name, description=why)
        return name

    def fact(self, wish: str, values: Sequence[str], why: str) -> str:
        """A fact with some values, the first at the start."""
        name = self.names.fresh(wish)
        self.facts[name] = Fact(name=name, values=tuple(values), description=why)
        return name

    def turn(self, wish: str, context: Context, fact: str, targets: Mapping[str, str]) -> Objective:
        """An objective that does nothing and leads where a fact says: by value, the block."""
        values = list(targets)
        routes = [
            FactRoute(when=(f"{fact}={value}",), goto=targets[value], on=outcome)
            for value in values[1:]
            for outcome in ("success", "failure")
        ]
        first = targets[values[0]]
        made = self.choice(wish, context, f"Goes on where {fact} says")
        self.instants.add(made.name)
        self.silent.add(made.name)
        return replace(made, success=first, failure=first, routes=tuple(routes))

    def returning(self, wish: str, context: Context, answer: bool) -> Part:
        """An objective for what always answers the same at once, where a block must stand for it."""
        said = f"{'Succeeds' if answer else 'Fails'} at once"
        made = self.choice(f"{wish}_returns", context, said)
        self.instants.add(made.name)
        self.silent.add(made.name)
        return Part(made, good=answer, bad=answer)

    def setting(self, wish: str, context: Context, change: FactChange, goto: str) -> Objective:
        """An objective that does nothing but set a fact, and leads on."""
        made = self.choice(wish, context, f"Notes {change.fact}={change.to}")
        self.instants.add(made.name)
        self.silent.add(made.name)
        return replace(made, sets=(replace(change, on="start"),), success=goto, failure=goto)

    def subtree(self, node: TreeNode, tree: Tree, context: Context) -> Result:
        """A subtree: a use of a protocol, or what it holds, where branches or memories must not be shared."""
        stateful = any(self.forest.rule(n) in STATEFUL for t in self.below(tree) for n in t.root.walk())
        if context.seen or stateful:
            result = self.inside(tree, (*self.chain, node), context)
            self.note(node, f"tree {tree.id}, written out", Kind.EXACT)
            return result
        if tree.id not in self.protocols:
            result = self.inside(tree, (), replace(context, again=True))
            if isinstance(result, bool):
                self.note(node, "succeeds at once" if result else "fails at once", Kind.EXACT)
                return result
            self.protocol(tree.id, result, tree.id)
        known = self.protocols[tree.id]
        name = self.names.fresh(called(node, tree.id))
        self.origins[name] = BlockOrigin((*self.chain, node))
        given = tuple(p for p in parameters(node) if p.name in {k.name for k in known.parameters})
        self.note(node, f"{name}, a use of protocol {known.name}", Kind.EXACT)
        return Part(Use(name=name, protocol=known.name, parameters=given), skips=tree.id in self.skipping)

    def inside(self, tree: Tree, chain: Chain, context: Context) -> Result:
        """What a tree becomes behind some nodes that use trees."""
        around, self.chain = self.chain, chain
        result = self.piece(tree.root, context)
        self.chain = around
        return result

    def protocol(self, key: str, piece: Part, wish: str) -> Protocol:
        """Makes a protocol of a piece."""
        ports = sorted(self.parameters.get(key, ()))
        declared = tuple(Parameter(name=port, value="") for port in ports if _is_name(port))
        taken = {protocol.name for protocol in self.protocols.values()}
        name, count = _named(wish), 1
        while name in taken:
            count += 1
            name = f"{_named(wish)}{count}"
        made = Protocol(name=name, parameters=declared, blocks=series_of(piece))
        self.protocols[key] = made
        if piece.skips:
            self.skipping.add(key)
        return made

    def below(self, tree: Tree) -> list[Tree]:
        """A tree and all that it uses."""
        found: dict[str, Tree] = {tree.id: tree}
        stack = [tree]
        while stack:
            for node in stack.pop().root.walk():
                used = tree_of(self.forest, node)
                if used is not None and used.id not in found:
                    found[used.id] = used
                    stack.append(used)
        return list(found.values())

    def conditional(self, node: TreeNode, context: Context) -> Result:
        """A node with preconditions: what they say is free."""
        name = self.names.fresh(f"{called(node)}_if")
        result = self.ticked(node, replace(context, halted=context.halted or "_while" in node.rules))
        exits = {"_failureIf": FAIL, "_successIf": SUCCEED, "_skipIf": ABORT, "_while": ABORT}
        choices: list[Objective] = []
        for rule in PRECONDITIONS:
            if rule in node.rules:
                asked = self.choice(f"{called(node)}{rule}", context, f"{rule}: {node.rules[rule]}")
                choices.append(replace(asked, failure=exits[rule]))
        if isinstance(result, bool):
            asked = self.choice(f"{called(node)}_returns", context, "What it returns at once")
            result = Part(asked, good=result, bad=result)
        inner = placed(result, SUCCEED, FAIL)
        if "_while" in node.rules:
            over = self.event(f"{name}_over", f"No more so: {node.rules['_while']}")
            inner = replace(inner, handlers=(Handler(event=over, goto=ABORT), *inner.handlers))
        names = [*(c.name for c in choices[1:]), inner.name]
        blocks: list[Block] = [replace(c, success=to) for c, to in zip(choices, names, strict=True)]
        skips = result.skips or any(rule in node.rules for rule in ("_skipIf", "_while"))
        said = " ".join(f"{rule}={node.rules[rule]!r}" for rule in PRECONDITIONS if rule in node.rules)
        self.note(node, name, Kind.MORE, f"{said} is free")
        return Part(Recursive(name=name, blocks=tidied([*blocks, inner])), skips=skips)

    def note(self, node: TreeNode, became: str, kind: Kind, why: str = "") -> None:
        """Enters a node into the ledger."""
        self.entries.append(LedgerEntry(node, became, kind, why))

    def refused(self, node: TreeNode, why: str) -> bool:
        """Notes that a node has no translation; all such nodes are reported together."""
        self.problems.append(Problem(node.source, why))
        return True

    def category(self, node: TreeNode) -> str:
        """Action, Condition or nothing: what is known of a leaf."""
        row = self.forest.row(node)
        return node.category or self.forest.categories.get(node.id) or (row.role if row else "")

    def sure(self, node: TreeNode) -> bool:
        """Whether that a leaf is a condition, or is none, is more than a guess by its name."""
        return bool(self.category(node)) or not LOOKS_LIKE_CONDITION.match(node.id)

    def condition(self, node: TreeNode) -> bool:
        """Whether a leaf is a condition, or is taken for one because of its name."""
        category = self.category(node)
        return category == "Condition" or (not category and bool(LOOKS_LIKE_CONDITION.match(node.id)))

    def at_once(self, node: TreeNode, *, rounds: bool = True) -> bool:
        """Whether a node answers in the tick in which it is asked, and never runs on.

        Args:
            node: The node.
            rounds: Whether loops count as running on between their rounds, and the like.
        """
        if (tree := tree_of(self.forest, node)) is not None:
            return self.at_once(tree.root, rounds=rounds)
        rule = self.forest.rule(node)
        if node.children:
            slow = rule == "delay" or (rounds and self._returns(node))
            return not slow and all(self.at_once(child, rounds=rounds) for child in node.children)
        return rule == "asked" or rule in CONSTANT or self.condition(node)

    def _returns(self, node: TreeNode) -> bool:
        """Whether a node itself returns between its rounds or children."""
        rule = self.forest.rule(node)
        if rule in LOOPS:
            return self.rounds(node) not in (0, 1)
        return rule in RUNNING_ON and (rule not in RETURNING or len(node.children) > 1)

    def lingers(self, node: TreeNode) -> bool:
        """Whether a node may run on though none of its leaves does."""
        if (tree := tree_of(self.forest, node)) is not None:
            return self.lingers(tree.root)
        if self.forest.rule(node) in ("delay", "sleep") or (node.children and self._returns(node)):
            return True
        return any(self.lingers(child) for child in node.children)

    def prompt(self, node: TreeNode) -> bool:
        """Whether all that a node may do happens in one tick, if each of its leaves answers in its first."""
        if (tree := tree_of(self.forest, node)) is not None:
            return self.prompt(tree.root)
        rule = self.forest.rule(node)
        return all(map(self.prompt, node.children)) and (rule in PROMPT if node.children else rule != "sleep")

    def returns_between(self, node: TreeNode) -> bool:
        """Whether a node runs on only because it returns between leaves that answer at once."""
        return self.at_once(node, rounds=False) and not self.at_once(node)

    def asks(self, node: TreeNode) -> bool:
        """Whether a leaf of a node is a condition, or answers at once as one does."""
        if (tree := tree_of(self.forest, node)) is not None:
            return self.asks(tree.root)
        if node.children:
            return any(self.asks(child) for child in node.children)
        return self.at_once(node) and self.forest.rule(node) not in CONSTANT

    def answers(self, piece: Part) -> frozenset[bool]:
        """What a piece may return."""
        return answers(piece, {protocol.name: protocol for protocol in self.protocols.values()})

    def rounds(self, node: TreeNode) -> int | None:
        """How often a loop runs its child, -1: for ever; ``None``: it is data."""
        row = self.forest.row(node)
        (port,) = row.ports if row and row.ports else ("",)
        try:
            count = int(node.ports.get(port, ""))
        except ValueError:
            return None
        if row is not None and row.library == PY_TREES and count < 1:
            return 1 if row.rule == "retry" else -1  # it counts up, and looks behind each round
        return count if count >= -1 else 0  # the library makes no round then

    def depends(self, node: TreeNode, rows: Sequence[NodeRow]) -> None:
        """Says that what a node does depends on the version, and what it does in which."""
        which: dict[str, list[NodeRow]] = {}
        for row in rows:
            which.setdefault(row.rule, []).append(row)
        meant = []
        for each in which.values():
            library = each[-1].library
            versions = frozenset[str]().union(*(row.versions for row in each))
            meant.append(
                f"in {told(library, versions & self.forest.choice.allowed[library])}: {each[-1].outcome}"
            )
        entry = self.entries.pop()
        said = "; ".join([*meant, *([entry.why] if entry.why else [])])
        kind = entry.kind if entry.kind is Kind.LEFT_OUT else Kind.MORE
        self.note(node, entry.became, kind, f"depends on the version: {said}")

    def remembers(self, node: TreeNode) -> bool:
        """Whether a node, once it has ended, goes on elsewhere when it is entered again."""
        tree = tree_of(self.forest, node)
        if tree is not None:
            return self.remembers(tree.root)
        own = self.forest.rule(node) in TURNS | MEMORIES and len(node.children) > 1
        return own or any(self.remembers(child) for child in node.children)

    def done(self) -> None:
        """Ends the translation.

        Raises:
            InputError: Some node has no translation: each with its line.
        """
        if self.problems:
            raise InputError(sorted(set(self.problems)))

    def next_parallel(self) -> int:
        """A number for a parallel block."""
        self.parallels += 1
        return self.parallels


def series_of(piece: Part) -> tuple[Block, ...]:
    """The blocks of a mission or of a protocol that is one piece."""
    block = piece.block
    alone = block.retries == 0 and block.repeat is None and not block.handlers and not block.routes
    if isinstance(block, Recursive) and piece.plain and alone and not block.parameters:
        return block.blocks
    return tidied([placed(piece, SUCCEED, FAIL)])


def parallel(name: str, branches: Sequence[Block], success: str = "all", failure: str = "all") -> Parallel:
    """A parallel block."""
    return Parallel(name=name, blocks=tuple(branches), success_when=success, failure_when=failure)


def parameters(node: TreeNode) -> tuple[Parameter, ...]:
    """The ports of a node as parameters; one handed on under its own name is left to what is around."""
    return tuple(
        Parameter(name=port, value=value)
        for port, value in node.ports.items()
        if _is_name(port) and value.strip() not in (f"{{{port}}}", "{=}")
    )


def called(node: TreeNode, otherwise: str = "") -> str:
    """What a block is called after a node: its name where that is readable, else what it is."""
    return next((text for text in (node.name or "", otherwise, node.id) if readable(text)), "node")


def described(node: TreeNode) -> str | None:
    """What a node is called in letters that no name has."""
    titles = (node.name or "", "" if node.name else node.id)
    return next((text for text in titles if text and not text.isascii()), None)


def _is_name(text: str) -> bool:
    from mcpn.mission.language.datatypes import NAME

    return NAME.matches(text)


def _named(text: str) -> str:
    return TreeNames().fresh(text)
