"""Control nodes of py_trees: series with and without memory, and parallel nodes with a policy."""

from __future__ import annotations

from dataclasses import replace

from mcpn.errors import Problem
from mcpn.trees.controls import became, fallback, free, in_parallel, sequence
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.pieces import Part, Result
from mcpn.trees.reactive import reactive_fallback, reactive_sequence
from mcpn.trees.translator import Context, Rule, Translator, called, parallel


def _by_memory(remembering: Rule, reactive: Rule) -> Rule:
    """A series: without memory earlier children are ticked again at each tick."""

    def chosen(at: Translator, node: TreeNode, context: Context) -> Result:
        # py_trees takes all that is not "true" for false.
        keeps = at.forest.choice.value(node, "memory").lower() == "true"
        return (remembering if keeps else reactive)(at, node, context)

    return chosen


def by_policy(at: Translator, node: TreeNode, context: Context) -> Result:
    """Children at the same time, up to the first failure, and the first success or that of all."""
    policy = at.forest.choice.value(node, "policy")
    if policy == "success_on_selected":
        said = (
            f"{node.title}: py_trees cannot make success_on_selected of XML, expected success_on_all or _one"
        )
        at.problems.append(Problem(node.source, said))
        return True
    everybody = policy == "success_on_all"
    name = at.names.fresh(called(node))
    number = at.next_parallel()
    inside = replace(context, halted=True)
    results = [at.piece(child, inside.branch(number, i)) for i, child in enumerate(node.children)]
    pieces = [result for result in results if isinstance(result, Part)]
    if False in results or not pieces:
        at.note(node, became(False not in results), Kind.EXACT)
        return False not in results
    if True in results and not everybody:
        return free(
            at, node, name, pieces, context, "what its other children answer to the first tick is free"
        )
    branches = in_parallel(at, pieces)
    kind, why = Kind.EXACT, ""
    if not everybody and len(branches) > 1:
        kind, why = Kind.MORE, "a failure counts before a success in the same tick"
    made = (
        parallel(name, branches, "all" if everybody else "any", "any") if len(branches) > 1 else branches[0]
    )
    at.note(node, made.name, kind, why)
    return Part(made)


PY_TREES_RULES: dict[str, Rule] = {
    "sequence_by_memory": _by_memory(sequence, reactive_sequence),
    "selector_by_memory": _by_memory(fallback, reactive_fallback),
    "parallel_by_policy": by_policy,
}
"""How these nodes are translated, by the rule that the table of nodes names."""
