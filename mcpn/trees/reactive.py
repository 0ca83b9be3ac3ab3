"""Reactive control nodes of BehaviorTree.CPP: all of them, which ask earlier children again at each tick.

What an earlier child answers then is free, and it is an event that interrupts: ``door_is_open_fails``. A
child that answers at once can only go on or end the node; one that may run halts the later one and begins
again.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from mcpn.mission.model import FAIL, SUCCEED, Block, Handler, Recursive
from mcpn.mission.robot import FactChange
from mcpn.trees.controls import (
    became,
    branching,
    ended,
    series,
    skipped_condition,
)
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.pieces import Part, Result, handled
from mcpn.trees.translator import TURNS, Context, Rule, Translator, called

BETWEEN_CONDITIONS = "when conditions answer, of a child that returns between them, is free"
"""Why a node that halts its children has more runs: a condition that it asks answers before."""

ONE_TICK = "behind a child that runs on whenever it is asked again, a later one has no more than a tick"
"""Why such a node has more runs: in the mission later children go on."""


def _reactive(at: Translator, node: TreeNode, context: Context, *, stops: bool) -> Result:
    name = at.names.fresh(called(node))
    slow = [not at.at_once(child) for child in node.children]
    last = max((place for place, runs in enumerate(slow) if runs), default=-1)
    results: list[Result] = []
    behind: list[Block] = []
    lingering = [place < last and at.lingers(child) for place, child in enumerate(node.children)]
    for place, child in enumerate(node.children):
        guarded = place > 0 and slow[place]
        again = context.again or place < last or (guarded and sum(slow) > 1)
        told = at.forest.rule(child) in TURNS and not context.halted
        halted = context.halted or (guarded and not told)
        inside = replace(context, again=again, halted=halted, asked=guarded or lingering[place])
        result = at.piece(child, inside)
        if guarded and isinstance(result, Part):
            result, resets = _guarded(at, context, results, slow, stops, result)
            behind += resets
        results.append(result)
        if result is stops:
            break
    result = series(at, name, results, context, stops=stops)
    if behind and isinstance(result, Part) and isinstance(result.block, Recursive):
        result = replace(result, block=replace(result.block, blocks=(*ended(result.block.blocks), *behind)))
    kind, why = Kind.EXACT, "an earlier child that runs again halts a later one" if sum(slow) > 1 else ""
    if sum(slow) > 1 and any(map(at.returns_between, node.children[1:])):
        kind, why = Kind.MORE, BETWEEN_CONDITIONS
    if any(lingering):
        first = lingering.index(True) + 1
        if sum(slow[first:]) > 1 or not all(map(at.prompt, node.children[first:])):
            kind, why = Kind.MORE, ONE_TICK
    earlier = (child for place, child in enumerate(node.children) if slow[place] and place < last)
    if any(at.remembers(child) for child in earlier):
        kind = Kind.LEFT_OUT
        why = "what an earlier child remembers when it is asked again, and answers at once, is not modelled"
    at.note(node, became(result), kind, why)
    return result


reactive_sequence: Rule = partial(_reactive, stops=False)
"""Later children run only as long as earlier ones succeed."""
reactive_fallback: Rule = partial(_reactive, stops=True)
"""Later children run only as long as earlier ones fail."""


def _guarded(
    at: Translator, context: Context, before: list[Result], slow: list[bool], stops: bool, piece: Part
) -> tuple[Part, list[Block]]:
    """A child that runs, with what earlier ones may answer meanwhile, and blocks that halts lead to."""
    out, behind = SUCCEED if stops else FAIL, list[Block]()
    memory = at.memories.get(piece.block.name)
    handlers: list[Handler] = []
    for place, earlier in enumerate(before):
        if not isinstance(earlier, Part):
            continue
        named = earlier.block.name
        if slow[place]:
            event, goto = f"{named}_again", named
            why = f"{named} is ticked again and runs, while {piece.block.name} does"
        elif len(at.answers(earlier)) < 2:
            continue  # it never answers anything else
        else:
            leaf = earlier.good is stops  # which end of the block it is that counts
            what = "succeeds" if leaf else "fails"
            event, goto, why = f"{named}_{what}", out, f"{named} {what} while {piece.block.name} runs"
        if memory is not None:
            change = FactChange(fact=memory[0], to=memory[1])
            reset = at.setting(f"{piece.block.name}_halted", context, change, goto)
            behind.append(reset)
            goto = reset.name
        told = at.event(event, why)
        handlers.append(Handler(event=told, goto=goto))
        if not slow[place]:
            at.heard[told] = (named, event.endswith("succeeds"))
    return replace(piece, block=handled(piece.block, handlers, at.instants)), behind


def while_do_else(at: Translator, node: TreeNode, context: Context) -> Result:
    """A condition that is asked at each tick, and what runs while it holds or does not."""
    name = at.names.fresh(called(node))
    inside = replace(context, again=True, halted=True)
    asked = at.piece(node.children[0], inside)
    then, *others = (at.piece(child, inside) for child in node.children[1:])
    other: Result = others[0] if others else False
    if isinstance(asked, bool):
        result = then if asked else other
        at.note(node, became(result), Kind.EXACT)
        return result
    branches: list[Result] = []
    for place, (each, beside) in enumerate(((then, other), (other, then))):
        changes = len(at.answers(asked)) > 1
        if changes and isinstance(each, Part) and not at.at_once(node.children[1 + place]):
            what = "succeeds" if asked.good is (place == 1) else "fails"
            why = f"{asked.block.name} {what} while {each.block.name} runs"
            event = at.event(f"{asked.block.name}_{what}", why)
            at.heard[event] = (asked.block.name, what == "succeeds")
            goto = beside.block.name if isinstance(beside, Part) else SUCCEED if beside else FAIL
            each = replace(each, block=handled(each.block, [Handler(event=event, goto=goto)], at.instants))
        branches.append(each)
    made = branching(name, asked, *branches)
    if asked.skips:
        at.note(node, name, *skipped_condition(asked))
    elif not at.at_once(node.children[0]):
        at.note(node, name, Kind.LEFT_OUT, "that its condition runs again in parallel is not modelled")
    elif any(map(at.returns_between, node.children[1:])):
        at.note(node, name, Kind.MORE, BETWEEN_CONDITIONS)
    else:
        at.note(node, name, Kind.EXACT)
    return made


REACTIVE: dict[str, Rule] = {
    "reactive_sequence": reactive_sequence,
    "reactive_fallback": reactive_fallback,
    "while_do_else": while_do_else,
}
"""How they are translated, by the rule that the table of nodes names."""
