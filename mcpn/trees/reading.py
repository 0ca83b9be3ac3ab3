"""What is known of nodes by their registered names: those of BehaviorTree.CPP 4 and of Nav2.

Source: BehaviorTree.CPP 4.10 (controls, decorators, actions) and the plugins of nav2_behavior_tree, read for
what they do when they are ticked; nothing of them is copied.
"""

from __future__ import annotations

import re
from pathlib import Path
from types import MappingProxyType

from lxml import etree

from mcpn.errors import InputError, Problem, Source
from mcpn.trees.nodes import Forest, Tree, TreeNode
from mcpn.xmlio import parse_xml

_ANY = 200_000
CONTROLS = MappingProxyType(
    {
        "Sequence": (1, _ANY),
        "AsyncSequence": (1, _ANY),
        "SequenceWithMemory": (1, _ANY),
        "SequenceStar": (1, _ANY),
        "ReactiveSequence": (1, _ANY),
        "Fallback": (1, _ANY),
        "AsyncFallback": (1, _ANY),
        "ReactiveFallback": (1, _ANY),
        "Parallel": (1, _ANY),
        "ParallelAll": (1, _ANY),
        "IfThenElse": (2, 3),
        "WhileDoElse": (2, 3),
        "TryCatch": (2, _ANY),
        **{f"Switch{n}": (n + 1, n + 1) for n in range(2, 7)},
        "RecoveryNode": (2, 2),
        "PipelineSequence": (1, _ANY),
        "RoundRobin": (1, _ANY),
    }
)
"""Control nodes that are translated, with the least and the largest number of their children."""
WAITING = MappingProxyType(
    {
        "RateController": "the next period",
        "SpeedController": "the next period",
        "DistanceController": "the next stretch of way",
        "GoalUpdatedController": "a new goal",
    }
)
"""Decorators that tick their child as they are begun, and later only now and then: what they await."""
TRANSPARENT = frozenset({"GoalUpdater"})
"""Decorators that return what their child returns, and write the blackboard."""
DECORATORS = frozenset(
    {
        "Inverter",
        "ForceSuccess",
        "ForceFailure",
        "RetryUntilSuccessful",
        "RetryUntilSuccesful",
        "Repeat",
        "KeepRunningUntilFailure",
        "Timeout",
        "Delay",
        "RunOnce",
        "Precondition",
        "LoopInt",
        "LoopBool",
        "LoopDouble",
        "LoopString",
        "SingleTrigger",
        "PathLongerOnApproach",
        "SkipUnlessUpdated",
        "WaitValueUpdate",
        *WAITING,
        *TRANSPARENT,
    }
)
"""Decorators whose effect is known."""
SCRIPTS = frozenset({"Script", "SetBlackboard", "UnsetBlackboard", "AlwaysSuccess"})
"""Leaves that succeed at once and do nothing but write the blackboard."""
UNTRANSLATED = MappingProxyType(
    {
        "ManualSelector": "a person chooses its child",
        "PersistentSequence": "its index is data on the blackboard",
        "NonblockingSequence": "it ticks later children while earlier ones still run",
        "PauseResumeController": "services of ROS pause it",
        "ConsumeQueue": "its queue is data on the blackboard",
    }
)
"""Nodes that are known and not translated, and why."""
_CONDITIONS = """
GoalReached IsStuck TransformAvailable GoalUpdated GlobalUpdatedGoal IsBatteryLow IsBatteryCharging
DistanceTraveled TimeExpired PathExpiringTimer InitialPoseReceived WouldAControllerRecoveryHelp
WouldAPlannerRecoveryHelp WouldASmootherRecoveryHelp WouldARouteRecoveryHelp AreErrorCodesPresent
ArePosesNear IsGoalNearby IsWithinPathTrackingBounds IsStopped IsPoseOccupied ScriptCondition
WasEntryUpdated
"""
_AT_ONCE = """
TruncatePath TruncatePathLocal PlannerSelector ControllerSelector SmootherSelector
GoalCheckerSelector ProgressCheckerSelector PathHandlerSelector RemovePassedGoals GetPoseFromPath
GetCurrentPose ConcatenatePaths AppendGoalPoseToGoals ExtractRouteNodesAsGoals GetNextFewGoals
"""
CATEGORIES = MappingProxyType(
    dict.fromkeys(_CONDITIONS.split(), "Condition")
    | dict.fromkeys([*_AT_ONCE.split(), *SCRIPTS, "AlwaysFailure", "Sleep"], "Action")
)
"""What known leaves are."""
AT_ONCE = frozenset([*_CONDITIONS.split(), *_AT_ONCE.split(), *SCRIPTS, "AlwaysFailure"])
"""Known leaves that answer in the tick in which they are asked, and never run on."""
LOOKS_LIKE_CONDITION = re.compile(
    r"(Is|Are|Check|Has|Have|Would|Can|Was|is_|are_|has_|check_|can_)(?![a-z])|(is|has|are)[A-Z]"
)
"""Names that people give to conditions: IsBatteryFull, check_door."""
_SPELLED = {name.lower(): name for name in (*CONTROLS, *DECORATORS, *SCRIPTS, "AlwaysFailure")}
V3 = MappingProxyType({"RetryUntilSuccesful": "RetryUntilSuccessful", "SequenceStar": "SequenceWithMemory"})
"""Names of version 3 that version 4 spells otherwise."""


def spelled(tag: str) -> str:
    """The registered name that a tag means: some files write ``inverter``."""
    return tag if tag not in _SPELLED.values() and tag.lower() not in _SPELLED else _SPELLED[tag.lower()]


# Reads behaviour trees: the XML of BehaviorTree.CPP, versions 3 and 4, with includes and node models.
#
# Files are untrusted as missions are (:mod:`mcpn.xmlio`): no DTD, no entities, bounded size, depth and
# number; includes stay inside the folder of the main file. All problems of all files are raised in one go.

MAX_BYTES = 16 << 20
MAX_FILES = 1000
MAX_NODES = 200_000
MAX_DEPTH = 64
EXPLICIT = ("Action", "Condition", "Control", "Decorator", "SubTree", "SubTreePlus")
"""Elements whose attribute ID says which node it is."""


def read_forest(path: Path, models: tuple[Path, ...] = (), main: str | None = None) -> Forest:
    """Reads a file of trees with all that it includes.

    Args:
        path: The file.
        models: Further files with a ``TreeNodesModel``, which say what is an action and what a condition.
        main: The tree to execute; by default what the file says, or its only tree that no other uses.

    Returns:
        The trees; every node has its file and line.

    Raises:
        InputError: Everything that is wrong, by file and line.
    """
    reader = _Reader(path.parent.resolve())
    for model in models:
        reader.models(model)
    root = reader.file(path, path.name)
    trees = reader.trees
    if root is None or reader.problems:
        raise InputError(reader.problems)
    main = main or root.get("main_tree_to_execute")
    at = Source(str(path), _line(root))
    if main is None:
        inside = {node.id for tree in trees.values() for node in tree.root.walk()}
        alone = [name for name in reader.own if name not in inside]
        alone = reader.own if len(reader.own) == 1 else alone
        main = alone[0] if len(alone) == 1 else None
    if main is None:
        named = ", ".join(sorted(trees)) or "none"
        raise InputError.at(at, f"no main_tree_to_execute, expected one of {named}")
    if main not in trees:
        raise InputError.at(at, f"no tree {main!r} to execute, expected one of {', '.join(sorted(trees))}")
    forest = Forest(trees, trees[main], reader.categories)
    problems = list(_cycles(forest))
    if problems:
        raise InputError(problems)
    return forest


class _Reader:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[Problem] = []
        self.trees: dict[str, Tree] = {}
        self.own: list[str] = []  # identifiers in the main file
        self.categories: dict[str, str] = {}
        self.seen: set[Path] = set()
        self.nodes = 0

    def models(self, path: Path) -> None:
        """Reads node models from a file that holds nothing else."""
        root = self.parsed(path)
        if root is None:
            return
        found = [root] if root.tag == "TreeNodesModel" else root.findall("TreeNodesModel")
        if not found:
            self.wrong(Source(str(path), 1), "expected <TreeNodesModel>, found none")
        for model in found:
            self.model(model)

    def model(self, element: etree._Element) -> None:
        for each in element:
            if isinstance(each.tag, str) and each.get("ID"):
                self.categories[str(each.get("ID"))] = each.tag

    def parsed(self, path: Path) -> etree._Element | None:
        try:
            return parse_xml(path, MAX_BYTES)
        except InputError as error:
            self.problems.extend(error.problems)
            return None

    def file(self, path: Path, shown: str) -> etree._Element | None:
        """Reads one file of trees and what it includes."""
        self.seen.add(path.resolve())
        main = len(self.seen) == 1
        root = self.parsed(path)
        if root is None:
            return None
        here = Source(str(path), _line(root))
        if root.tag != "root":
            self.wrong(here, f"expected <root> of a behaviour tree, found <{_tag(root)}>")
            return None
        if (version := root.get("BTCPP_format", "3")) not in ("3", "4"):
            self.wrong(here, f"BTCPP_format {version!r}, expected 3 or 4")
            return None
        for element in root:
            source = Source(str(path), _line(element))
            match _tag(element):
                case "include":
                    self.include(element, path, source)
                case "TreeNodesModel":
                    self.model(element)
                case "BehaviorTree":
                    if tree := self.tree(element, path, source, shown):
                        self.own += [tree] if main else []
                case other:
                    self.wrong(
                        source, f"found <{other}>, expected <include>, <BehaviorTree> or <TreeNodesModel>"
                    )
        return root

    def include(self, element: etree._Element, path: Path, source: Source) -> None:
        href = element.get("path")
        if element.get("ros_pkg"):
            self.wrong(source, f"include of a file in package {element.get('ros_pkg')!r}: give a plain path")
            return
        if not href:
            self.wrong(source, "include without a path")
            return
        try:
            # As BT.CPP: relative to the including file; some write it relative to the main file.
            beside, below = path.parent / href, self.folder / href
            target = beside if beside.is_file() or not below.is_file() else below
            real = target.resolve()
            there = target.is_file()
        except (OSError, ValueError, RuntimeError) as error:
            self.wrong(source, f"include of {href[:80]!r}: {error}")
            return
        if not real.is_relative_to(self.folder):
            self.wrong(source, f"include of {href} leaves the folder of the main file")
        elif not there:
            self.wrong(source, f"include of {href}: no such file")
        elif real not in self.seen:
            if len(self.seen) >= MAX_FILES:
                self.wrong(source, f"include of {href}: more than {MAX_FILES} files, the limit on includes")
            else:
                self.file(target, href)

    def tree(self, element: etree._Element, path: Path, source: Source, shown: str) -> str | None:
        name = element.get("ID") or path.stem
        children = [child for child in element if isinstance(child.tag, str)]
        if len(children) != 1:
            self.wrong(source, f"tree {name} has {len(children)} roots, expected one")
            return None
        if name in self.trees:
            self.wrong(source, f"there is already a tree {name!r} ({self.trees[name].source}), in {shown}")
            return None
        root = self.node(children[0], path, 1)
        if root is None:
            return None
        self.trees[name] = Tree(name, root, source)
        return name

    def node(self, element: etree._Element, path: Path, depth: int) -> TreeNode | None:
        source = Source(str(path), _line(element))
        self.nodes += 1
        if depth > MAX_DEPTH or self.nodes > MAX_NODES:
            limit = (
                f"nested more than {MAX_DEPTH} deep" if depth > MAX_DEPTH else f"more than {MAX_NODES} nodes"
            )
            self.wrong(source, f"{limit}, the limit of trees")
            return None
        tag = _tag(element)
        attributes = {str(key): str(value) for key, value in element.attrib.items()}
        explicit = tag in EXPLICIT
        name = attributes.pop("name", None)
        if explicit and not attributes.get("ID"):
            self.wrong(source, f"<{tag}> without ID")
            return None
        id_ = attributes.pop("ID") if explicit else spelled(tag)
        category = "SubTree" if tag == "SubTreePlus" else tag if explicit else ""
        if explicit:
            id_ = id_ if category == "SubTree" else spelled(id_)
        children = [self.node(child, path, depth + 1) for child in element if isinstance(child.tag, str)]
        if any(child is None for child in children):
            return None
        rules = {key: value for key, value in attributes.items() if key.startswith("_")}
        ports = {key: value for key, value in attributes.items() if not key.startswith("_")}
        inside = tuple(child for child in children if child is not None)
        node = TreeNode(id_, category, name, ports, rules, inside, source)
        return node if self.counted(node) else None

    def counted(self, node: TreeNode) -> bool:
        """Whether a known node has as many children as it must have."""
        least, most = 0, MAX_NODES
        if node.category != "SubTree" and node.id in CONTROLS:
            least, most = CONTROLS[node.id]
        elif node.category != "SubTree" and (node.id in DECORATORS or node.category == "Decorator"):
            least, most = 1, 1
        elif node.category in ("SubTree", "Action", "Condition") or node.id in CATEGORIES:
            most = 0
        if least <= len(node.children) <= most:
            return True
        wanted = (
            str(least)
            if least == most
            else f"at least {least}"
            if most == MAX_NODES
            else f"{least} to {most}"
        )
        self.wrong(node.source, f"{node.title} has {len(node.children)} children, expected {wanted}")
        return False

    def wrong(self, source: Source, message: str) -> None:
        self.problems.append(Problem(source, message))


def _tag(element: etree._Element) -> str:
    return str(element.tag)


def _line(element: etree._Element) -> int:
    line = element.sourceline
    return line if isinstance(line, int) else 1


def _cycles(forest: Forest) -> list[Problem]:
    """What is wrong with the use of trees in trees: none of that name, or one that holds itself."""
    problems = []
    state: dict[str, int] = {}
    stack: list[tuple[str, list[TreeNode]]] = []

    def uses(tree: Tree) -> list[TreeNode]:
        return [node for node in tree.root.walk() if tree_of(forest, node) is not None or _asks(node)]

    for start in forest.trees:
        if start in state:
            continue
        state[start] = 1
        stack.append((start, uses(forest.trees[start])))
        while stack:
            name, todo = stack[-1]
            if not todo:
                state[name] = 2
                stack.pop()
                continue
            node = todo.pop()
            if node.id not in forest.trees:
                known = ", ".join(sorted(forest.trees))
                problems.append(Problem(node.source, f"no tree {node.id!r}, expected one of {known}"))
            elif state.get(node.id) == 1:
                problems.append(Problem(node.source, f"tree {node.id} holds itself"))
            elif node.id not in state:
                state[node.id] = 1
                stack.append((node.id, uses(forest.trees[node.id])))
    return problems


def _asks(node: TreeNode) -> bool:
    return node.category == "SubTree"


def tree_of(forest: Forest, node: TreeNode) -> Tree | None:
    """The tree that a node runs: a ``<SubTree>``, or, as some write it, an element of the tree's name."""
    if node.category == "SubTree" or (not node.children and node.category == ""):
        return forest.trees.get(node.id)
    return None
