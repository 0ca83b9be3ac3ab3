"""Control nodes of Nav2: recovery that is bounded, pipelines, taking turns."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import FAIL, SUCCEED, Block, FactRoute, Handler, Objective, Recursive, Use
from mcpn.mission.robot import FactChange
from mcpn.trees.controls import became, series
from mcpn.trees.decorators import AWAITED, COPIES, failing_itself
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.pieces import Part, Result, handled, marked, placed, tidied, wrapped
from mcpn.trees.translator import Context, Rule, Translator, called, parallel


def recovery(at: Translator, node: TreeNode, context: Context) -> Result:
    """The first child; when it fails the second is run, then the first again, so many times."""
    name = at.names.fresh(called(node))
    text = at.forest.choice.value(node, "number_of_retries")
    count = int(text) if text.strip().lstrip("+").isdecimal() else None
    inside = replace(context, again=True)
    main = at.piece(node.children[0], inside if count != 0 else context)
    back = at.piece(node.children[1], inside)
    if main is False and isinstance(back, Part) and count != 0:
        return _vainly(at, node, context, name, back, count)
    if isinstance(main, bool) or back is False or count == 0:
        at.note(node, became(main), Kind.EXACT)
        return main
    if count is None or count > COPIES:
        again = back.block.name if isinstance(back, Part) else main.block.name
        blocks: list[Block] = [placed(main, SUCCEED, again)]
        blocks += [placed(back, main.block.name, FAIL, FAIL)] if isinstance(back, Part) else []
        at.note(node, name, Kind.MORE, f"it recovers any number of times, not {text}")
        return Part(Recursive(name=name, blocks=tidied(blocks)), skips=main.skips)
    main = wrapped(main, at.names.fresh(f"{main.block.name}_main"))
    if isinstance(back, Part) and back.skips and context.again:
        why = "that it goes on counting after its second child was skipped is not modelled"
        at.note(node, name, Kind.LEFT_OUT, why)
    else:
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
    """One child each time, in turn; the next one in the same turn if it fails, until all have.

    Since Nav2 1.5 it fails, unless it wraps around, once its last child has ended, by success as well.
    """
    wraps = wrapping(at, node)
    name = at.names.fresh(called(node))
    results = [at.piece(child, context) for child in node.children]
    skips = any(isinstance(result, Part) and result.skips for result in results)
    if skips:
        at.note(node, name, Kind.LEFT_OUT, "how it counts children that are skipped is not modelled")
    if not context.again or len(node.children) == 1:
        result = series(at, name, _last_in_turn(at, name, results, context, wraps), context, stops=True)
        at.note(node, became(result), Kind.EXACT)
        return result
    pieces: list[Part] = []
    for child, result in zip(node.children, results, strict=True):
        pieces.append(at.returning(called(child), context, result) if isinstance(result, bool) else result)
    made = _Turns(at, name, pieces, context, wraps).made()
    why = "after a halt from outside it may go on or begin anew" if context.halted else ""
    at.note(node, name, Kind.MORE if context.halted else Kind.EXACT, why)
    return made


def wrapping(at: Translator, node: TreeNode) -> frozenset[bool]:
    """Whether RoundRobin goes on with its first child after its last; both where the version is not known."""
    found = set[bool]()
    for row in at.forest.choice.rows(node):
        if row.rule == "round_robin":
            found.add(True)
            continue
        said = at.forest.choice.value(node, "wrap_around").strip().lower()
        found |= {True, False} if said.startswith("{") else {said in ("true", "1")}
    return frozenset(found)


def _last_in_turn(
    at: Translator, name: str, results: list[Result], context: Context, wraps: frozenset[bool]
) -> list[Result]:
    """The children of a RoundRobin that is entered once, as those of a fallback."""
    *before, last = results
    if wraps == {True} or last is False:
        return results
    if isinstance(last, Part) and wraps == {False}:
        return [*before, replace(last, good=False, bad=False)]
    if wraps == {False}:
        return [*before, False]
    counts = at.choice(f"{name}_counts", context, "Whether the success of the last child is one: by version")
    if not isinstance(last, Part):
        return [*before, Part(counts)]
    around = at.names.fresh(f"{last.block.name}_last")
    blocks = [placed(last, counts.name, FAIL), replace(counts, success=SUCCEED, failure=FAIL)]
    return [*before, Part(Recursive(name=around, blocks=tidied(blocks)), skips=last.skips)]


class _Turns:
    """A RoundRobin that is entered again and again: a fact says which child is next.

    Args:
        at: The translation.
        name: What it is called.
        pieces: Its children.
        context: Where it stands.
        wraps: Whether it goes on with its first child after its last; both where that is not known.
    """

    def __init__(
        self, at: Translator, name: str, pieces: list[Part], context: Context, wraps: frozenset[bool]
    ) -> None:
        self.at, self.name, self.pieces, self.context, self.wraps = at, name, pieces, context, wraps
        self.steps = [piece.block.name for piece in pieces]
        self.fact = at.fact(f"{name}_next", self.steps, f"The child of {name} that is next")
        self.may_fail = False in wraps or all(False in at.answers(piece) for piece in pieces)

    def made(self) -> Part:
        """The block."""
        at, name, steps = self.at, self.name, self.steps
        turn = at.turn(f"{name}_turn", self.context, self.fact, {step: step for step in steps})
        begun: list[Block] = []
        if self.context.halted:
            # Where a halt from outside is not told, it may begin anew.
            anew = self.setting(f"{name}_anew", steps[0], steps[0])
            routes = tuple(route for route in turn.routes if route.on == "success")
            turn, begun = replace(turn, failure=anew.name, routes=routes), [anew]
        else:
            at.memories[name] = (self.fact, steps[0])
        over = self.setting(f"{name}_gives_up", steps[0], FAIL)
        blocks: list[Block] = [turn, *begun]
        for place, piece in enumerate(self.pieces):
            last = place + 1 == len(steps)
            blocks += (
                self.last(piece, over) if last and False in self.wraps else self.child(place, piece, over)
            )
        blocks = [replace(block, success=block.success or SUCCEED) for block in blocks]
        return Part(Recursive(name=name, blocks=(*blocks, *([over] if self.may_fail else []))))

    def setting(self, wish: str, to: str, goto: str) -> Objective:
        return self.at.setting(wish, self.context, FactChange(fact=self.fact, to=to), goto)

    def child(self, place: int, piece: Part, over: Objective) -> list[Block]:
        """A child after which the next one is asked."""
        following = self.steps[(place + 1) % len(self.steps)]
        whole = FactRoute(when=(f"{self.fact}={following}",), goto=over.name, on="failure")
        routes: tuple[FactRoute, ...] = (whole,) if True in self.wraps and self.may_fail else ()
        change = FactChange(fact=self.fact, to=following, on="success")
        with_mark = None if piece.skips else marked(piece, change)
        if with_mark is not None:
            block = placed(with_mark, SUCCEED, following)
            return [replace(block, routes=(*block.routes, *routes))]
        noted = self.setting(f"{piece.block.name}_done", following, SUCCEED)
        block = placed(piece, noted.name, following)
        fails = [end for end, good in (("success", piece.good), ("failure", piece.bad)) if not good]
        routes = tuple(replace(route, on=end) for route in routes for end in fails)
        return [replace(block, routes=(*block.routes, *routes)), noted]

    def last(self, piece: Part, over: Objective) -> list[Block]:
        """The last child, with which it is over; or perhaps is, where the version is not known."""
        if self.wraps == {False}:
            return [placed(piece, over.name, over.name)]
        at, named = self.at, piece.block.name
        counts = at.choice(
            f"{named}_counts", self.context, "Whether its success is one of the node: by version"
        )
        begins = self.setting(f"{named}_done", self.steps[0], SUCCEED)
        goes_on = at.choice(f"{named}_goes_on", self.context, "Whether the first child is next: by version")
        whole = FactRoute(when=(f"{self.fact}={self.steps[0]}",), goto=over.name, on="success")
        return [
            placed(piece, counts.name, goes_on.name),
            replace(counts, success=begins.name, failure=over.name),
            begins,
            replace(goes_on, success=self.steps[0], failure=over.name, routes=(whole,)),
        ]


def pipeline(at: Translator, node: TreeNode, context: Context) -> Result:
    """PipelineSequence: earlier children go on being ticked while later ones run."""
    name = at.names.fresh(called(node))
    stages = _stages(at, context, name, node.children)
    result = series(at, name, stages, context, stops=False)
    if any(isinstance(stage, Part) and stage.skips for stage in stages):
        at.note(
            node, became(result), Kind.LEFT_OUT, "what it does with children that are skipped is not modelled"
        )
    else:
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
    if not isinstance(here, Part) or len(at.answers(here)) < 2 or all(at.at_once(child) for child in rest):
        return [here, *behind]  # which answers the same when it is ticked again, or not while another runs
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
    context = replace(context, piped=True)
    lane = replace(context.branch(number, 0), again=True)
    waits = AWAITED.get(at.forest.rule(first))
    node = first.children[0] if waits else first
    made = at.piece(node, lane)
    if waits:
        made = failing_itself(at, first, made, lane)
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


NAV2: dict[str, Rule] = {
    "recovery": recovery,
    "pipeline": pipeline,
    "round_robin": round_robin,
    "round_robin_wraps_or_not": round_robin,
}
"""How these nodes are translated, by the rule that the table of nodes names."""
