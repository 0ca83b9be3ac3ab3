"""Translates decorators into missions: outcomes turned round, retries, rounds, time, what data decides."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import ABORT, FAIL, SUCCEED, Block, Handler, Objective, Recursive
from mcpn.trees.controls import became, ended, seen_between
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.pieces import Part, Result, bare, handled, placed, tidied, wrapped
from mcpn.trees.translator import Context, Rule, Translator, called

COPIES = 1000
"""More tries or rounds than these are not written out."""


def turning(good: bool, bad: bool) -> Rule:
    """The rule of a node that turns outcomes: what success and failure of its child mean."""

    def turned(at: Translator, node: TreeNode, context: Context) -> Result:
        result = at.piece(node.children[0], context)
        if isinstance(result, bool):
            made: Result = good if result else bad
        else:
            made = replace(result, good=good if result.good else bad, bad=good if result.bad else bad)
        at.note(node, became(made), Kind.EXACT)
        return made

    return turned


def transparent(at: Translator, node: TreeNode, context: Context) -> Result:
    """Returns what the child returns."""
    result = at.piece(node.children[0], context)
    at.note(node, became(result), Kind.EXACT)
    return result


def retry(at: Translator, node: TreeNode, context: Context) -> Result:
    """The child again, as often as it fails."""
    return _loop(at, node, context, fails=True)


def repeat(at: Translator, node: TreeNode, context: Context) -> Result:
    """The child again, as often as it succeeds."""
    return _loop(at, node, context, fails=False)


def _loop(at: Translator, node: TreeNode, context: Context, *, fails: bool) -> Result:
    count = at.rounds(node)
    result = at.piece(node.children[0], replace(context, again=context.again or count != 1))
    over = count == 0 or result is fails
    if over or (isinstance(result, bool) and count is not None and count > 0):
        # Its rounds, each of which ends at once, end in different ticks.
        end = not fails if count == 0 else bool(result)
        made = end if over or count == 1 else at.later(f"{called(node)}_rounds", context, end)
        at.note(node, became(made), *seen_between(context, isinstance(made, Part)))
        return made
    if count is None or not 0 < count <= COPIES:
        times = next(iter(node.ports.values()), "")
        return _endless(at, node, context, result, fails, exact=count == -1, why=times)
    assert isinstance(result, Part)
    # What has rounds or tries already gets an objective around it.
    block = wrapped(result, at.names.fresh(called(node, f"{result.block.name}_again"))).block
    block = replace(block, retries=count - 1) if fails else replace(block, repeat=count)
    kind, why = Kind.EXACT, ""
    if count > 1 and result.skips and context.again:
        kind, why = Kind.LEFT_OUT, "that it goes on counting after its child was skipped is not modelled"
    at.note(node, block.name, kind, why)
    return Part(block if count > 1 else replace(block, repeat=None), skips=result.skips)


def _endless(
    at: Translator, node: TreeNode, context: Context, result: Result, fails: bool, *, exact: bool, why: str
) -> Part:
    """The child again and again; where its number is not known, up to a moment that is free."""
    if isinstance(result, bool) and exact:
        return at.forever(node, context)
    own = result.block.name if isinstance(result, Part) else called(node)
    name = at.names.fresh(called(node, f"{own}_loop"))
    blocks: list[Block] = []
    if exact and isinstance(result, Part):
        blocks.append(placed(result, SUCCEED if fails else own, own if fails else FAIL))
        at.note(node, name, Kind.EXACT)
        meant = "entered" if fails else "endless"
        return Part(Recursive(name=name, blocks=tidied(blocks), nominal=meant), skips=result.skips)
    asked = at.choice(f"{name}_more", context, f"Whether there is another round of {why or 'them'}")
    again = asked.name
    if isinstance(result, Part):
        blocks.append(placed(result, SUCCEED if fails else again, again if fails else FAIL))
    blocks.append(replace(asked, success=own if blocks else again, failure=FAIL if fails else SUCCEED))
    at.note(node, name, Kind.MORE, f"how many rounds there are is free ({why or 'no number'})")
    # A choice that may go on for ever is none that the author meant.
    skips = isinstance(result, Part) and result.skips
    return Part(Recursive(name=name, blocks=tidied(blocks), nominal="endless"), skips=skips)


def keep_running(at: Translator, node: TreeNode, context: Context) -> Result:
    """The child again and again until it fails."""
    result = at.piece(node.children[0], replace(context, again=True))
    if result is False:
        at.note(node, became(result), Kind.EXACT)
        return result
    if result is True:
        return at.forever(node, context)
    return _endless(at, node, context, _skipping_on(at, result), False, exact=True, why="")


def _skipping_on(at: Translator, piece: Part) -> Part:
    """A child after which the next round begins, be it that it is skipped."""
    if not piece.skips:
        return piece
    inner = placed(piece, SUCCEED, FAIL, SUCCEED)
    return Part(Recursive(name=at.names.fresh(f"{piece.block.name}_round"), blocks=tidied([inner])))


def loop(at: Translator, node: TreeNode, context: Context) -> Result:
    """LoopInt and its kin: the child once for each value of a queue."""
    queue = node.ports["queue"]
    literal = bool(queue) and "{" not in queue and not queue.startswith("json:")
    empty = at.forest.choice.value(node, "if_empty").upper()
    count = len(queue.removesuffix(";").split(";")) if literal else None  # nothing follows a last ;
    result = at.piece(node.children[0], replace(context, again=True))
    result = _skipping_on(at, result) if isinstance(result, Part) else result
    end = SUCCEED if empty == "SUCCESS" else FAIL if empty == "FAILURE" else ABORT
    if count is not None and (result is False or count <= COPIES):
        return _each(at, node, context, result, count, end)
    name = at.names.fresh(called(node))
    asked = at.choice(f"{name}_more", context, f"Whether the queue {queue} has another value")
    again = result.block.name if isinstance(result, Part) else asked.name if result else FAIL
    blocks: list[Block] = [replace(asked, success=again, failure=end)]
    blocks += [placed(result, asked.name, FAIL)] if isinstance(result, Part) else []
    at.note(node, name, Kind.MORE, "how many values the queue has is free")
    return Part(Recursive(name=name, blocks=tuple(blocks), nominal="endless"), skips=end == ABORT)


def _each(at: Translator, node: TreeNode, context: Context, result: Result, count: int, end: str) -> Result:
    """The child so often as a queue has values; that it is empty is found at the tick after the last."""
    good = end == SUCCEED
    if result is False or (result is True and not context.seen and end != ABORT):
        at.note(node, became(result and good), Kind.EXACT)
        return result and good
    kind, why = seen_between(context, context.seen)
    why = why or "values of the queue are not modelled"
    name = at.names.fresh(called(node))
    if context.seen or result is True:
        last: Block = at.constant(f"{name}_empty", context, True, "at a later tick").block
        blocks = [replace(last, success=end, failure=end)]
    else:
        blocks = []
    if isinstance(result, Part):
        rounds = wrapped(result, at.names.fresh(f"{result.block.name}_rounds"))
        block = replace(rounds.block, repeat=count) if count > 1 else rounds.block
        if not blocks and good:
            at.note(node, block.name, kind, why)
            return Part(block)
        blocks.insert(0, placed(replace(rounds, block=block), blocks[0].name if blocks else end, FAIL))
    at.note(node, name, kind, why)
    return Part(Recursive(name=name, blocks=tidied(blocks)), skips=end == ABORT)


def timeout(at: Translator, node: TreeNode, context: Context) -> Result:
    """The child is halted when its time is over, and then the node fails."""
    result = at.piece(node.children[0], replace(context, halted=True))
    (port,) = row.ports if (row := at.forest.row(node)) is not None and row.ports else ("msec",)
    text = at.forest.choice.value(node, port)
    if isinstance(result, bool) or (port == "msec" and text.strip() == "0"):
        at.note(node, became(result), Kind.EXACT)
        return result
    try:
        seconds = int(text) / 1000 if port == "msec" else float(text)
    except ValueError:
        seconds = 0.0
    known = 0.001 <= seconds <= 2_592_000
    if known and isinstance(result.block, Objective) and result.block.timeout is None and bare(result):
        made = Part(replace(result.block, timeout=seconds))
        at.note(node, made.block.name, Kind.TIME)
        return made
    name = result.block.name
    over = at.event(
        f"{name}_time_over", f"{text} {'ms' if port == 'msec' else 's'} are over while {name} runs"
    )
    # The event leads to the exit of what is around, which must be the child's alone.
    timed = handled(placed(result, SUCCEED, FAIL), [Handler(event=over, goto=FAIL)], at.instants)
    around = at.names.fresh(called(node, f"{name}_timed"))
    made = Part(Recursive(name=around, blocks=tidied([timed])), skips=result.skips)
    at.note(node, made.block.name, Kind.TIME, f"the event {over} stands for its end")
    return made


def delay(at: Translator, node: TreeNode, context: Context) -> Result:
    """A wait, then the child."""
    wait = at.waiting(node, context, f"{node.ports.get('delay_msec', '?')} ms")
    result = at.piece(node.children[0], context)
    name = at.names.fresh(called(node, f"{node.id}ed"))
    if isinstance(result, bool):
        return replace(wait, good=result, bad=result)
    blocks = [placed(wait, result.block.name, FAIL), placed(result, SUCCEED, FAIL)]
    return Part(Recursive(name=name, blocks=tidied(blocks)), skips=result.skips)


AWAITED: dict[str, str] = {
    "waiting_rate": "the next period",
    "waiting_speed": "the next period",
    "waiting_distance": "the next stretch of way",
    "waiting_goal": "a new goal",
}
"""By rule of a decorator that ticks its child as it is begun, and later only now and then: what it awaits."""


def waiting(at: Translator, node: TreeNode, context: Context) -> Result:
    """Nav2's RateController and its kin, where nothing ticks them again after they have succeeded."""
    result = failing_itself(at, node, at.piece(node.children[0], context), context)
    awaited = AWAITED[at.forest.rule(node)]
    kind, why = Kind.TIME, f"its child is begun at once, or after {awaited}"
    if isinstance(result, Part) and result.skips:
        kind, why = Kind.LEFT_OUT, "what it does with a child that is skipped is not modelled"
    at.note(node, became(result), kind, why)
    return result


def failing_itself(at: Translator, node: TreeNode, result: Result, context: Context) -> Result:
    """What a child becomes inside of a node that may fail whatever its child does: DistanceController.

    Without the pose of the robot it fails: before its child is begun, while that runs, and after its success.
    """
    if at.forest.rule(node) != "waiting_distance":
        return result
    name = at.names.fresh(called(node))
    before = at.choice(f"{name}_pose", context, "Whether the pose of the robot is known")
    if isinstance(result, bool):
        made = replace(before, success=SUCCEED if result else FAIL, failure=FAIL)
        return Part(Recursive(name=name, blocks=tidied([made])))
    after = at.choice(f"{name}_pose_after", context, "Whether the pose of the robot is known then")
    lost = at.event(f"{name}_pose_lost", f"The pose of the robot is not known while {result.block.name} runs")
    child = handled(placed(result, after.name, FAIL), [Handler(event=lost, goto=FAIL)], at.instants)
    blocks: list[Block] = [replace(before, success=child.name, failure=FAIL), child]
    blocks.append(replace(after, success=SUCCEED, failure=FAIL))
    return Part(Recursive(name=name, blocks=tidied(blocks)), skips=result.skips)


def once(at: Translator, node: TreeNode, context: Context) -> Result:
    """RunOnce, SingleTrigger: the child only the first time, then something that was decided then."""
    result = at.piece(node.children[0], context)
    if not context.again:
        at.note(node, became(result), Kind.EXACT)
        return result
    name = at.names.fresh(called(node))
    asked = at.choice(f"{name}_again", context, "Whether its child is run, or has been before")
    trigger = at.forest.rule(node) == "trigger"
    skips = not trigger and at.forest.choice.value(node, "then_skip").lower() not in ("false", "0")
    at.note(node, name, Kind.MORE, "whether its child has been run before is free")
    if skips or trigger:
        return _if(name, asked, result, ABORT if skips else FAIL)
    before = at.choice(f"{name}_before", context, "What it returned before")
    made = _if(name, asked, result, before.name)
    block = made.block
    assert isinstance(block, Recursive)
    return replace(made, block=replace(block, blocks=(*ended(block.blocks), before)))


def _if(name: str, asked: Objective, result: Result, other: str) -> Part:
    """The child if a choice succeeds, else another end."""
    if isinstance(result, bool):
        return Part(
            Recursive(
                name=name, blocks=(replace(asked, success=SUCCEED if result else FAIL, failure=other),)
            ),
            skips=other == ABORT,
        )
    blocks = tidied([replace(asked, success=result.block.name, failure=other), placed(result, SUCCEED, FAIL)])
    return Part(Recursive(name=name, blocks=blocks), skips=result.skips or other == ABORT)


def precondition(at: Translator, node: TreeNode, context: Context) -> Result:
    """The child if a script is true, else another outcome; what it says is free."""
    name = at.names.fresh(called(node))
    result = at.piece(node.children[0], context)
    asked = at.choice(f"{name}_holds", context, f"Whether {node.ports.get('if', 'it')} is so")
    other = {"FAILURE": FAIL, "SUCCESS": SUCCEED}.get(at.forest.choice.value(node, "else").upper(), ABORT)
    at.note(node, name, Kind.MORE, f"whether {node.ports.get('if', 'its script')} is so is free")
    return _if(name, asked, result, other)


def on_approach(at: Translator, node: TreeNode, context: Context) -> Result:
    """Nav2's PathLongerOnApproach: the child while the path has become longer near the goal, else success."""
    name = at.names.fresh(called(node))
    result = at.piece(node.children[0], replace(context, again=True, halted=True))
    asked = at.choice(f"{name}_holds", context, "Whether the new path is longer, near the goal")
    at.note(
        node, name, Kind.MORE, "whether the path has become longer is free, and its child may run on beside"
    )
    made = _if(name, asked, result, SUCCEED)
    if isinstance(result, bool):
        return made
    block = made.block
    assert isinstance(block, Recursive)
    over = at.event(f"{name}_over", "The path is no longer longer")
    child = handled(block.blocks[-1], [Handler(event=over, goto=SUCCEED)])
    return replace(made, block=replace(block, blocks=(*block.blocks[:-1], child)))


def updated(at: Translator, node: TreeNode, context: Context) -> Result:
    """SkipUnlessUpdated, WaitValueUpdate: the child once an entry of the blackboard has changed."""
    kind, why = Kind.MORE, ""
    if (context.halted or context.asked) and not at.at_once(node.children[0]):
        kind, why = Kind.LEFT_OUT, "halted, it does not halt its child, which runs on: not modelled"
    if at.forest.rule(node) == "wait_value_update":
        wait = at.waiting(node, context, "a change of the blackboard", Kind.MORE)
        if why:
            at.note(node, wait.block.name, kind, why)  # the weaker one counts
        result = at.piece(node.children[0], context)
        if isinstance(result, bool):
            return replace(wait, good=result, bad=result)
        blocks = [placed(wait, result.block.name, FAIL), placed(result, SUCCEED, FAIL)]
        return Part(Recursive(name=at.names.fresh(f"{node.id}ed"), blocks=tidied(blocks)), skips=result.skips)
    name = at.names.fresh(called(node))
    result = at.piece(node.children[0], context)
    asked = at.choice(f"{name}_holds", context, "Whether the entry has changed")
    at.note(node, name, kind, why or "whether the entry has changed is free")
    return _if(name, asked, result, ABORT)


def unknown(at: Translator, node: TreeNode, context: Context) -> Result:
    """A decorator of which nothing is known: its child any number of times, and any end at any moment."""
    name = at.names.fresh(called(node))
    result = at.piece(node.children[0], replace(context, again=True, halted=True))
    asked = at.choice(f"{name}_ticks", context, f"Whether {node.id} ticks its child")
    verdict = at.choice(f"{name}_returns", context, f"What {node.id} returns")
    at.note(node, name, Kind.MORE, f"what {node.id} does with its child is not known")
    if isinstance(result, bool):
        return Part(replace(verdict, name=name))
    over = at.event(f"{name}_over", f"{node.id} ends whatever its child does")
    child = placed(result, asked.name, asked.name, asked.name)
    child = replace(child, handlers=(Handler(event=over, goto=verdict.name), *child.handlers))
    return Part(
        Recursive(
            name=name,
            blocks=(replace(asked, success=child.name, failure=verdict.name), child, verdict),
            nominal="endless",
        )
    )


DECORATING: dict[str, Rule] = {
    "inverter": turning(False, True),
    "force_success": turning(True, True),
    "force_failure": turning(False, False),
    "retry": retry,
    "repeat": repeat,
    "keep_running": keep_running,
    "loop": loop,
    "timeout": timeout,
    "delay": delay,
    "once": once,
    "trigger": once,
    "precondition": precondition,
    "on_approach": on_approach,
    "skip_unless_updated": updated,
    "wait_value_update": updated,
    "transparent": transparent,
    **dict.fromkeys(AWAITED, waiting),
}
"""How decorators are translated, by the rule that the table of nodes names."""
