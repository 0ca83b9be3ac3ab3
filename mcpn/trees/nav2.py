"""Control nodes of Nav2: recovery that is bounded, pipelines, taking turns."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import FAIL, SUCCEED, Block, FactRoute, Handler, Objective, Recursive, Use
from mcpn.mission.robot import FactChange
from mcpn.trees.controls import became, fallback, series
from mcpn.trees.decorators import COPIES
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes import TreeNode
from mcpn.trees.pieces import Part, Result, handled, marked, placed, tidied, wrapped
from mcpn.trees.reading import WAITING
from mcpn.trees.translator import Context, Rule, Translator, parallel


def recovery(at: Translator, node: TreeNode, context: Context) -> Result:
    """The first child; when it fails the second is run, then the first again, so many times."""
    name = at.names.fresh(node.name or node.id)
    text = node.ports.get("number_of_retries", "1")
    count = int(text) if text.strip().lstrip("-").isdigit() else None
    inside = replace(context, again=True)
    main = at.piece(node.children[0], inside if count != 0 else context)
    back = at.piece(node.children[1], inside)
    if main is False and isinstance(back, Part) and count != 0:
        return _vainly(at, node, context, name, back, count)
    if isinstance(main, bool) or back is False or count == 0:
        at.note(node, became(main), Kind.EXACT)
        return main
    if count is not None and count < 0:
        count = 0
    if count is None or count > COPIES:
        again = back.block.name if isinstance(back, Part) else main.block.name
        blocks: list[Block] = [placed(main, SUCCEED, again)]
        blocks += [placed(back, main.block.name, FAIL, FAIL)] if isinstance(back, Part) else []
        at.note(node, name, Kind.MORE, f"it recovers any number of times, not {text}")
        return Part(Recursive(name=name, blocks=tidied(blocks)), skips=main.skips)
    main = wrapped(main, at.names.fresh(f"{main.block.name}_main"))
    at.note(node, name, Kind.EXACT)
    if back is True:
        return Part(replace(main.block, retries=main.block.retries + count), skips=main.skips)
    assert isinstance(back, Part)
    back = wrapped(back, at.names.fresh(f"{back.block.name}_recovers"))
    first = replace(main.block, recover=back.block.name, times=count, success=SUCCEED)
    second = placed(back, SUCCEED, FAIL, FAIL)
    return Part(Recursive(name=name, blocks=(first, replace(second, success=None))), skips=main.skips)


def _vainly(
    at: Translator, node: TreeNode, context: Context, name: str, back: Part, count: int | None
) -> Part:
    """A recovery from what always fails: the second child, so many times as it succeeds, and then failure."""
    if count == 1:
        at.note(node, name, Kind.EXACT)
        return Part(Recursive(name=name, blocks=tidied([placed(back, FAIL, FAIL, FAIL)])))
    again = at.choice(f"{name}_again", context, "Whether it recovers once more")
    at.note(node, name, Kind.MORE, "it recovers any number of times")
    blocks: list[Block] = [placed(back, again.name, FAIL, FAIL)]
    blocks.append(replace(again, success=back.block.name, failure=FAIL))
    return Part(Recursive(name=name, blocks=tuple(blocks)))


def round_robin(at: Translator, node: TreeNode, context: Context) -> Result:
    """One child each time, in turn; the next one in the same turn if it fails, until all have."""
    if not context.again or len(node.children) == 1:
        return fallback(at, node, context)
    name = at.names.fresh(node.name or node.id)
    pieces: list[Part] = []
    for child in node.children:
        result = at.piece(child, context)
        if isinstance(result, bool):
            asked = at.choice(f"{child.name or child.id}_returns", context, "Returns at once")
            result = Part(asked, good=result, bad=result)
        pieces.append(result)
    steps = [piece.block.name for piece in pieces]
    fact = at.fact(f"{name}_next", steps, f"The child of {name} that is next")
    turn: Objective = at.turn(f"{name}_turn", context, fact, {step: step for step in steps})
    begun: list[Block] = []
    if context.halted:
        # Where a halt from outside is not told, it may begin anew.
        anew = at.setting(f"{name}_anew", context, FactChange(fact=fact, to=steps[0]), steps[0])
        routes = tuple(route for route in turn.routes if route.on == "success")
        turn, begun = replace(turn, failure=anew.name, routes=routes), [anew]
    else:
        at.memories[name] = (fact, steps[0])
    over = at.setting(f"{name}_gives_up", context, FactChange(fact=fact, to=steps[0]), FAIL)
    blocks: list[Block] = [turn, *begun]
    for place, piece in enumerate(pieces):
        following = steps[(place + 1) % len(steps)]
        change = FactChange(fact=fact, to=following, on="success")
        whole = FactRoute(when=(f"{fact}={following}",), goto=over.name, on="failure")
        with_mark = None if piece.skips else marked(piece, change)
        if with_mark is not None:
            block = placed(with_mark, SUCCEED, following)
            blocks.append(replace(block, routes=(*block.routes, whole)))
            continue
        noted = at.setting(f"{piece.block.name}_done", context, change, SUCCEED)
        block = placed(piece, noted.name, following)
        outcome = "success" if piece.bad is False and not piece.good else "failure"
        blocks += [replace(block, routes=(*block.routes, replace(whole, on=outcome))), noted]
    blocks = [replace(block, success=block.success or SUCCEED) for block in blocks]
    kind, why = Kind.EXACT, ""
    if context.halted:
        kind, why = Kind.MORE, "after a halt from outside it may go on or begin anew"
    at.note(node, name, kind, why)
    return Part(Recursive(name=name, blocks=(*blocks, over)))


def pipeline(at: Translator, node: TreeNode, context: Context) -> Result:
    """PipelineSequence: earlier children go on being ticked while later ones run."""
    name = at.names.fresh(node.name or node.id)
    result = series(at, name, _stages(at, context, name, node.children), context, stops=False)
    at.note(node, became(result), Kind.EXACT)
    return result


def _stages(at: Translator, context: Context, name: str, children: tuple[TreeNode, ...]) -> list[Result]:
    """Children of a pipeline from one on, as the results of a series."""
    first, *rest = children
    inside = replace(context, halted=True)
    if not rest:
        return [at.piece(first, inside)]
    if not at.at_once(first):
        return _going_on(at, inside, name, first, tuple(rest))
    here = at.piece(first, inside)
    behind = _stages(at, context, name, tuple(rest))
    if not isinstance(here, Part) or (here.good and here.bad) or all(at.at_once(child) for child in rest):
        return [here, *behind]  # which cannot fail when it is ticked again, or not while another runs
    wish = f"{name}_stage_fails"
    event = wish if wish in at.events else at.event(wish, f"A stage of {name} fails when it is ticked again")
    handler = Handler(event=event, goto=FAIL)
    return [here, *(_once_handled(at, result, handler) for result in behind)]


def _once_handled(at: Translator, result: Result, handler: Handler) -> Result:
    if not isinstance(result, Part) or any(h.event == handler.event for h in result.block.handlers):
        return result
    return replace(result, block=handled(result.block, [handler], at.instants))


def _going_on(
    at: Translator, context: Context, name: str, first: TreeNode, rest: tuple[TreeNode, ...]
) -> list[Result]:
    """A stage that runs: once alone, then again and again beside the later ones."""
    number = at.next_parallel()
    lane = replace(context.branch(number, 0), again=True)
    waits = WAITING.get(first.id)
    node = first.children[0] if waits else first
    made = at.piece(node, lane)
    if waits:
        at.note(first, became(made), Kind.TIME, f"again after {waits}")
    behind = series(
        at,
        at.names.fresh(f"{name}_after"),
        _stages(at, context.branch(number, 1), name, rest),
        context,
        stops=False,
    )
    if isinstance(made, bool):
        return [made, behind]
    if isinstance(behind, bool):
        return [made, behind]
    once, again = _twice(at, made, lane)
    blocks: list[Block] = []
    if waits:
        wait = at.names.fresh(f"{again.block.name}_wait")
        at.silent.add(wait)
        blocks.append(
            Objective(
                name=wait,
                activities=(at.activity("wait", lane),),
                description=f"Awaits {waits}",
                success=again.block.name,
                failure=again.block.name,
            )
        )
    blocks.append(placed(again, blocks[0].name if blocks else again.block.name, FAIL))
    loop = Recursive(name=at.names.fresh(f"{made.block.name}_loop"), blocks=tuple(blocks), nominal="endless")
    other = wrapped(behind, at.names.fresh(f"{behind.block.name}_branch")).block
    both = parallel(at.names.fresh(f"{name}_both"), (loop, other), "any", "any")
    return [once, Part(both)]


def _twice(at: Translator, piece: Part, context: Context) -> tuple[Part, Part]:
    """Two blocks for one piece: an objective written twice, or two uses of a protocol."""
    block = piece.block
    if isinstance(block, Objective) and not block.handlers and not block.routes:
        again = at.names.fresh(f"{block.name}_again")
        if block.name in at.origins:
            at.origins[again] = at.origins[block.name]
        return piece, replace(piece, block=replace(block, name=again))
    protocol = at.protocol(f" {block.name}", piece, block.name)
    one = Use(name=block.name, protocol=protocol.name)
    other = Use(name=at.names.fresh(f"{block.name}_again"), protocol=protocol.name)
    return Part(one, skips=piece.skips), Part(other, skips=piece.skips)


NAV2: dict[str, Rule] = {"RecoveryNode": recovery, "PipelineSequence": pipeline, "RoundRobin": round_robin}
"""How these nodes are translated."""
