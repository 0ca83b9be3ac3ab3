"""What is read of a tree though a library may refuse it: a warning for each, with its place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mcpn.errors import Problem
from mcpn.trees.nodes.forest import Forest, tree_of
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.nodes.versions import BTCPP

ModelPorts = Mapping[str, Mapping[str, bool]]
"""By node of a ``TreeNodesModel`` its ports, and whether each must be given."""


def doubts(forest: Forest, models: ModelPorts, spelt: Mapping[int, str]) -> Iterator[Problem]:
    """What BehaviorTree.CPP refuses in trees that are read all the same.

    Args:
        forest: The trees.
        models: What a ``TreeNodesModel`` says of ports.
        spelt: By identity of a node, how its name is written, where no library has it so.
    """
    if BTCPP not in forest.choice.libraries:
        return
    for tree in forest.trees.values():
        for node in tree.root.walk():
            if written := spelt.get(id(node)):
                yield Problem(node.source, f"{written} is read as {node.id}: libraries have no {written}")
            yield from _of_models(forest, node, models.get(node.id, {}))
            if forest.rule(node) == "reactive_sequence":
                yield from _explicit(node)


def _of_models(forest: Forest, node: TreeNode, ports: Mapping[str, bool]) -> Iterator[Problem]:
    if forest.row(node) is not None or not ports:
        return
    if tree_of(forest, node) is None:
        for port in node.ports.keys() - ports.keys():
            expected = ", ".join(ports)
            yield Problem(
                node.source, f"{node.title} has no port {port!r} in its model, which has {expected}"
            )
        return
    if node.rules.get("_autoremap", "").lower() not in ("1", "true"):
        for port in (port for port, required in ports.items() if required and port not in node.ports):
            said = f"{node.title} does not give {port}, which its model wants"
            yield Problem(node.source, f"{said}: BehaviorTree.CPP 4 refuses that")


def _explicit(node: TreeNode) -> Iterator[Problem]:
    for child in node.children:
        if child.category not in ("", "SubTree"):
            said = f"<{child.category} ID={child.id!r}> in a ReactiveSequence"
            yield Problem(child.source, f"{said}: BehaviorTree.CPP 4.8 refuses that, and takes <{child.id}>")
