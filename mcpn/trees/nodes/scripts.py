"""Scripts in nodes of trees: what no version of BehaviorTree.CPP takes is refused, the rest warned of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mcpn.errors import Problem
from mcpn.trees.nodes.choosing import VersionChoice, is_entry
from mcpn.trees.nodes.node import POSTCONDITIONS, PRECONDITIONS, TreeNode
from mcpn.trees.nodes.script_grammar import BrokenAt, misread
from mcpn.trees.nodes.versions import BTCPP, between

_PORTS = {"Script": "code", "ScriptCondition": "code", "Precondition": "if"}
_LATER = between(BTCPP, "4.10")
_EARLIER = between(BTCPP, "4.0") - _LATER
_BY_GRAMMAR = ((False, "up to 4.9", _EARLIER), (True, "from 4.10 on", _LATER))


def script_problems(nodes: Iterable[TreeNode], choice: VersionChoice) -> tuple[list[Problem], list[Problem]]:
    """What is wrong with the scripts of trees, and what only some versions refuse.

    Args:
        nodes: All nodes of all trees.
        choice: The versions that the trees are for.

    Returns:
        What every version refuses, and what is read with a warning.
    """
    refused, told = list[Problem](), list[Problem]()
    allowed = choice.allowed.get(BTCPP, frozenset())
    grammars = [(later, name) for later, name, versions in _BY_GRAMMAR if versions & allowed]
    if not grammars:
        return refused, told
    for node in nodes:
        for name, script in _scripts(node):
            if is_entry(script) and name in node.ports:
                said = f"{node.title}: {name} is a script on the blackboard, {script}, which is not read"
                told.append(Problem(node.source, said))
                continue
            wrong = [(misread(script, later=later), versions) for later, versions in grammars]
            broken = [(found, versions) for found, versions in wrong if found is not None]
            if len(broken) == len(grammars) and allowed <= _EARLIER | _LATER:
                refused.append(Problem(node.source, _said(node, name, script, broken[-1][0])))
            elif broken:
                found, versions = broken[0]
                said = f"{_said(node, name, script, found)}: BehaviorTree.CPP {versions} refuses that"
                told.append(Problem(node.source, said))
    return refused, told


def _scripts(node: TreeNode) -> Iterator[tuple[str, str]]:
    """By attribute the scripts of a node."""
    yield from ((rule, node.rules[rule]) for rule in (*PRECONDITIONS, *POSTCONDITIONS) if rule in node.rules)
    port = _PORTS.get(node.id)
    script = None if port is None else node.ports.get(port)
    if port is not None and script is not None and (script or node.id != "Script"):  # which may be empty
        yield port, script


def _said(node: TreeNode, name: str, script: str, found: BrokenAt) -> str:
    if not script.strip():
        return f"{node.title}: {name} is empty, expected a script"
    shown = script if len(script) <= 60 else f"{script[:57]}..."
    return f"{node.title}: {name} is {shown!r}, in column {found.column} {found.what}"
