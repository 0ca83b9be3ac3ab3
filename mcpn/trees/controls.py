"""Control nodes of BehaviorTree.CPP that are not reactive: series, parallel blocks, choices."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from mcpn.errors import Problem
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Block, Handler, Objective, Recursive
from mcpn.mission.robot import FactChange
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.forest import tree_of
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.pieces import Part, Result, marked, placed, tidied, wrapped
from mcpn.trees.translator import Context, Rule, Translator, called, parallel


def _series(
    at: Translator, node: TreeNode, context: Context, *, stops: bool, returns: bool = False
) -> Result:
    """Children one after the other, up to the first that returns ``stops``.

    Args:
        at: What is translated.
        node: The node.
        context: Around it.
        stops: Which result ends it.
        returns: Whether it returns between its children.
    """
    name = at.names.fresh(called(node))
    results = [at.piece(child, context) for child in node.children]
    if returns:
        return _between(at, node, name, results, context, stops=stops)
    result = series(at, name, results, context, stops=stops)
    at.note(node, became(result), Kind.EXACT)
    return result


sequence: Rule = partial(_series, stops=False)
"""Children one after the other, up to the first that fails."""
fallback: Rule = partial(_series, stops=True)
"""Children one after the other, up to the first that succeeds."""
async_sequence: Rule = partial(_series, stops=False, returns=True)
"""A sequence that returns between its children."""
async_fallback: Rule = partial(_series, stops=True, returns=True)
"""A fallback that returns between its children."""


def series(at: Translator, name: str, results: list[Result], context: Context, *, stops: bool) -> Result:
    """What a sequence of results becomes, or a fallback of them, where ``stops`` is true."""
    pieces: list[Part] = []
    end, answered = not stops, False
    for result in results:
        if isinstance(result, Part):
            pieces.append(result)
        elif result == stops:
            end = stops
            break
        else:
            answered = True  # so that it is not skipped, whatever its other children are
    if not pieces:
        return end
    if len(pieces) == 1 and end != stops and not (answered and pieces[0].skips):
        return pieces[0]
    after = SUCCEED if end else FAIL
    out = SUCCEED if stops else FAIL
    unknown = end != stops and not answered and all(piece.skips for piece in pieces)
    blocks: list[Block] = []
    last = (
        replace(
            at.choice(f"{name}_skipped", context, "Whether all of it was skipped"),
            success=after,
            failure=ABORT,
        )
        if unknown
        else None
    )
    for place, piece in enumerate(pieces):
        behind = place + 1 == len(pieces)
        following = after if behind else pieces[place + 1].block.name
        skipped = last.name if behind and last else following
        good, bad = (out, following) if stops else (following, out)
        blocks.append(placed(piece, good, bad, skipped))
    return Part(Recursive(name=name, blocks=tidied([*blocks, *([last] if last else [])])), skips=unknown)


def ended(blocks: tuple[Block, ...]) -> tuple[Block, ...]:
    """A series that does not lead on to what is put behind it."""
    *first, last = blocks
    return (*first, replace(last, success=last.success or SUCCEED))


def became(result: Result) -> str:
    """What a node became, in words."""
    if isinstance(result, bool):
        return "succeeds at once" if result else "fails at once"
    return result.block.name


def with_memory(at: Translator, node: TreeNode, context: Context) -> Result:
    """A sequence that goes on with the child that failed or was halted, when it is entered again."""
    name = at.names.fresh(called(node))
    results = [at.piece(child, context) for child in node.children]
    if not context.again or len(node.children) == 1:
        return _between(at, node, name, results, context, stops=False)
    if results[0] is False:
        at.note(node, became(False), Kind.EXACT)
        return False
    made, moments = _steps(at, node, name, results, context)
    if len(made) < 2:
        at.note(node, became(made[0] if made else True), Kind.EXACT)
        return made[0] if made else True
    steps = [piece.block.name for piece in made]
    fact = at.fact(f"{name}_at", steps, f"Where {name} goes on")
    turn = at.turn(f"{name}_turn", context, fact, {step: step for step in steps})
    kind, why = seen_between(context, bool(moments))
    beginning: list[Block] = []
    if any(row.rule == "with_memory_unhalted" for row in at.forest.choice.rows(node)):
        # A halt from outside is not told: it may begin anew whenever it is entered again.
        anew = at.setting(f"{name}_anew", context, FactChange(fact=fact, to=steps[0]), steps[0])
        routes = tuple(route for route in turn.routes if route.on == "success")
        turn, beginning = replace(turn, failure=anew.name, routes=routes), [anew]
        kind, why = Kind.MORE, "after a halt it begins anew, after a failure it goes on: either is free"
    if all(piece.skips for piece in made):
        kind, why = Kind.LEFT_OUT, "that it is skipped where all its children are is not modelled"
    blocks: list[Block] = [turn, *beginning]
    for place, piece in enumerate(made):
        behind = place + 1 == len(made)
        following = SUCCEED if behind else steps[place + 1]
        change = FactChange(fact=fact, to=steps[0] if behind else following, on="success")
        if moment := moments.get(following):
            # Halted in it, the node goes on behind it.
            moment = replace(moment, success=following, failure=following)
            following = moment.name
        with_mark = marked(piece, change)
        if with_mark is not None and not piece.skips:
            blocks.append(placed(with_mark, following, FAIL))
        else:
            noted = at.setting(f"{piece.block.name}_done", context, change, following)
            blocks += [placed(piece, noted.name, FAIL, noted.name), noted]
        blocks += [moment] if moment else []
    at.note(node, name, kind, why)
    return Part(Recursive(name=name, blocks=tidied(blocks)))


def _between(
    at: Translator, node: TreeNode, name: str, results: list[Result], context: Context, *, stops: bool
) -> Result:
    """A series that remembers nothing, with moments between its children."""
    end = next((place for place, result in enumerate(results) if result is stops), len(results))
    moments = False
    for place, result in enumerate(results[: end + 1]):
        if place and isinstance(result, bool):
            # It ends at once, but after a moment in which what runs beside it may end, or time be over.
            results[place] = at.later(f"{name}_between", context, result)
            moments = moments or context.seen
    made = series(at, name, results[: end + 1], context, stops=stops)
    at.note(node, became(made), *seen_between(context, moments))
    return made


def _steps(
    at: Translator, node: TreeNode, name: str, results: list[Result], context: Context
) -> tuple[list[Part], dict[str, Objective]]:
    """The children of a sequence with memory, and by child that answers at once the moment before it."""
    made: list[Part] = []
    moments: dict[str, Objective] = {}
    for child, result in zip(node.children, results, strict=True):
        if isinstance(result, Part):
            made.append(result)
            continue
        if result and not context.seen:
            continue
        answer = at.returning(called(child), context, result)
        made.append(answer)
        if context.seen and child is not node.children[0]:
            moment = at.constant(f"{name}_between", context, True, "at a later tick").block
            assert isinstance(moment, Objective)
            moments[answer.block.name] = moment
    return made, moments


def seen_between(context: Context, moments: bool) -> tuple[Kind, str]:
    """How faithful a node is that returns between its children, or rounds.

    It does only behind a child that has answered in its first tick, and then what runs beside has as well.
    """
    if context.lane and moments:
        return Kind.MORE, "how long it returns between its children, while others run, is free"
    return Kind.EXACT, ""


def if_then_else(at: Translator, node: TreeNode, context: Context) -> Result:
    """A condition that is asked once, and what follows from it."""
    name = at.names.fresh(called(node))
    results = [at.piece(child, context) for child in node.children]
    asked, then = results[:2]
    other = results[2] if len(results) == 3 else False
    if isinstance(asked, bool):
        result: Result = then if asked else other
        at.note(node, became(result), Kind.EXACT)
        return result
    made = branching(name, asked, then, other)
    kind, why = skipped_condition(asked)
    first = node.children[0]
    if len(results) == 2 and context.again and not first.children and not at.at_once(first):
        # The library returns from a condition that has failed without resetting it.
        kind, why = (
            Kind.LEFT_OUT,
            "a condition that has run and failed keeps its answer when it is asked again",
        )
    at.note(node, name, kind, why)
    return made


def skipped_condition(asked: Part) -> tuple[Kind, str]:
    """How faithful a choice is whose condition may be skipped: the library throws then."""
    return (Kind.LEFT_OUT, "it throws where its condition is skipped") if asked.skips else (Kind.EXACT, "")


def branching(name: str, asked: Part, then: Result, other: Result) -> Part:
    """A piece that is asked, and what is done as it succeeds, or fails."""

    def target(result: Result) -> str:
        return result.block.name if isinstance(result, Part) else SUCCEED if result else FAIL

    blocks = [placed(asked, target(then), target(other))]
    blocks += [placed(each, SUCCEED, FAIL) for each in (then, other) if isinstance(each, Part)]
    skips = any(isinstance(each, Part) and each.skips for each in (asked, then, other))
    return Part(Recursive(name=name, blocks=tidied(blocks)), skips=skips)


def try_catch(at: Translator, node: TreeNode, context: Context) -> Result:
    """A sequence; when it fails the last child is run, and then it has failed."""
    name = at.names.fresh(called(node))
    *tried, caught = [at.piece(child, context) for child in node.children]
    result = series(at, f"{name}_try", list(tried), context, stops=False)
    if isinstance(result, bool):
        if not result and isinstance(caught, Part):
            result = replace(caught, good=False, bad=False)
            if caught.skips:
                block = placed(caught, FAIL, FAIL, FAIL)
                result = Part(Recursive(name=f"{name}_caught", blocks=tidied([block])))
    elif isinstance(caught, Part):
        blocks = [placed(result, SUCCEED, caught.block.name), placed(caught, FAIL, FAIL, FAIL)]
        result = Part(Recursive(name=name, blocks=tidied(blocks)), skips=result.skips)
    halted = at.forest.choice.value(node, "catch_on_halt").lower() not in ("false", "0")
    kind = Kind.LEFT_OUT if halted and context.halted else Kind.EXACT
    at.note(
        node,
        became(result),
        kind,
        "its last child is not run when it is halted" if kind is not Kind.EXACT else "",
    )
    return result


def parallel_node(at: Translator, node: TreeNode, context: Context) -> Result:
    """Children at the same time, up to so many successes or failures."""
    count = len(node.children)
    wanted, allowed = counts(at, node)
    if wanted is None or allowed is None:
        return _unclear(at, node, context, "how many must succeed or fail is data")
    if wanted > count or allowed > count:
        at.problems.append(Problem(node.source, f"{node.title}: more successes or failures than children"))
        return True
    row = at.forest.row(node)
    if row is not None and "success_count" not in (row.ports or {}) and 0 in (wanted, allowed):
        said = f"{node.title}: a threshold of 0 is never met in {row.where}, expected 1 to {count}"
        at.problems.append(Problem(node.source, said))
        return True
    name = at.names.fresh(called(node))
    number = at.next_parallel()
    early = wanted < count or allowed > 0
    inside = replace(context, halted=context.halted or early)
    results = [at.piece(child, inside.branch(number, i)) for i, child in enumerate(node.children)]
    losing = count - wanted + 1
    if allowed or results[0] is not False:  # failures are compared for equality: the first one passes by 0
        losing = min(allowed, losing)
    if allowed == 0 < wanted and isinstance(results[0], Part):
        why = "it fails unless its first child has answered to the first tick, which is free"
        return free(at, node, name, [one for one in results if isinstance(one, Part)], context, why)
    late = False  # a child with one answer is counted behind others, which may end in the same tick
    for place, result in enumerate(results):
        if result is True:
            wanted -= 1
        elif result is False:
            losing -= 1
        ticked = [piece for piece in results[: place + 1] if isinstance(piece, Part)]
        if wanted <= 0 or losing <= 0:  # children behind it are never ticked, it and those before it are once
            if ticked:
                why = "what its first children answer to the one tick that they get is free"
                return free(at, node, name, ticked, context, why)
            at.note(node, became(wanted <= 0), Kind.EXACT)
            return wanted <= 0
        late = late or (isinstance(result, bool) and len(ticked) > 1)
    pieces = [result for result in results if isinstance(result, Part)]
    if late and min(wanted, losing) < len(pieces):
        why = "which children answer to the first tick, before one that always answers the same, is free"
        return free(at, node, name, pieces, context, why)
    branches = in_parallel(at, pieces)
    kind, why = Kind.EXACT, ""
    if any(piece.skips for piece in pieces):
        kind, why = _skipping(at, node, results)
    if context.piped and at.asks(node):
        kind = Kind.LEFT_OUT
        why = "that conditions end it in each tick, before its other children run on, is not modelled"
    success = "all" if wanted == len(branches) else str(wanted) if wanted > 1 else "any"
    if len(branches) == 1:
        made = _alone(at, branches[0])
    else:
        failure = "any" if losing == 1 else str(losing) if losing < len(branches) else "all"
        made = parallel(name, branches, success, failure)
    at.note(node, made.name, kind, why)
    return Part(made)


def _skipping(at: Translator, node: TreeNode, results: list[Result]) -> tuple[Kind, str]:
    """How faithful a parallel node is of which a child may be skipped."""
    if any(_skips_later(at, child) for child, r in zip(node.children, results, strict=True) if _skips(r)):
        return Kind.LEFT_OUT, "a child that is skipped after a part of it has run begins anew: not modelled"
    every = at.forest.rule(node) == "parallel_all"
    if every and all(_skips(result) for result in results):
        return Kind.LEFT_OUT, "that it is skipped where all its children are is not modelled"
    if every or at.forest.choice.value(node, "success_count").startswith("-"):
        return Kind.MORE, "a child that is skipped counts as one that has succeeded, and is asked again"
    return Kind.LEFT_OUT, "with a count it stays running beside a child that is skipped: not modelled"


def _alone(at: Translator, branch: Block) -> Block:
    """The only branch, with what it says of its abort: that holds inside of a block of its own."""
    if branch.abort is None:
        return branch
    return Recursive(name=at.names.fresh(f"{branch.name}_alone"), blocks=(branch,))


def _skips(result: Result) -> bool:
    return isinstance(result, Part) and result.skips


def _skips_later(at: Translator, node: TreeNode) -> bool:
    """Whether a node may be skipped by anything but its own ``_skipIf``, which is asked before it begins."""
    if "_while" in node.rules or "_skipIf" not in node.rules:
        return True
    tree = tree_of(at.forest, node)
    inside = [*node.children, *([tree.root] if tree else [])]
    below = [node, *(each for child in inside for each in child.walk())]
    return any(_may_skip(at, each) or each.category == "SubTree" for each in below[1:]) or _decides(at, node)


def _may_skip(at: Translator, node: TreeNode) -> bool:
    return "_while" in node.rules or "_skipIf" in node.rules or _decides(at, node)


def _decides(at: Translator, node: TreeNode) -> bool:
    """Whether a decorator is skipped as it likes."""
    return at.forest.rule(node) in ("once", "precondition", "skip_unless_updated", "loop")


def in_parallel(at: Translator, pieces: list[Part]) -> list[Block]:
    """The branches of a parallel block; one that is skipped has succeeded."""
    branches = []
    for piece in pieces:
        block = wrapped(piece, at.names.fresh(f"{piece.block.name}_branch")).block
        branches.append(replace(block, abort=SUCCEED) if piece.skips else block)
    return branches


def parallel_all(at: Translator, node: TreeNode, context: Context) -> Result:
    """Children at the same time, all of them to their end."""
    count = len(node.children)
    allowed = threshold(at.forest.choice.value(node, "max_failures"), count)
    if allowed is None:
        return _unclear(at, node, context, "how many may fail is data")
    if allowed > count:
        at.problems.append(Problem(node.source, f"{node.title}: more failures than children"))
        return True
    name = at.names.fresh(called(node))
    number = at.next_parallel()
    results = [at.piece(child, context.branch(number, i)) for i, child in enumerate(node.children)]
    failed = sum(1 for result in results if result is False)
    pieces = [result for result in results if isinstance(result, Part)]
    branches = in_parallel(at, pieces)
    if not branches:
        at.note(node, became(failed < allowed), Kind.EXACT)
        return failed < allowed
    kind, skipped = Kind.EXACT, ""
    if any(piece.skips for piece in pieces):
        kind, skipped = _skipping(at, node, results)
    if allowed - failed == 1:
        block: Block = _alone(at, branches[0]) if len(branches) == 1 else parallel(name, branches)
        at.note(node, block.name, kind, skipped)
        return Part(block)
    if allowed - failed <= 0 or allowed - failed > len(branches):
        well = allowed - failed > len(branches)
        block = parallel(name, branches) if len(branches) > 1 else _alone(at, branches[0])
        at.note(node, name, kind, skipped)
        return Part(block, good=well, bad=well)
    inner = parallel(at.names.fresh(f"{name}_all"), branches)
    verdict = at.choice(f"{name}_verdict", context, f"Whether fewer than {allowed} have failed")
    free = f"whether fewer than {allowed} have failed is free"
    at.note(node, name, Kind.LEFT_OUT if kind is Kind.LEFT_OUT else Kind.MORE, skipped or free)
    inner = replace(inner, success=SUCCEED, failure=verdict.name)
    return Part(Recursive(name=name, blocks=(inner, verdict)))


def counts(at: Translator, node: TreeNode) -> tuple[int | None, int | None]:
    """How many children of a parallel node must succeed, and how many must fail; ``None``: it is data."""
    row = at.forest.row(node)
    names = tuple(row.ports or ()) if row is not None else ()
    numbers = [threshold(at.forest.choice.value(node, name), len(node.children)) for name in names]
    if len(numbers) == 1:  # of version 3: it fails where so many successes are out of reach
        return numbers[0], len(node.children)
    return numbers[0], numbers[1]


def threshold(text: str, count: int) -> int | None:
    """A number of children; negative ones count from their number. ``None``: it is data."""
    try:
        number = int(text)
    except ValueError:
        return None
    return max(count + number + 1, 0) if number < 0 else number


def _unclear(at: Translator, node: TreeNode, context: Context, why: str) -> Part:
    """A parallel node that may end at any moment, either way."""
    name = at.names.fresh(called(node))
    number = at.next_parallel()
    inside = replace(context, halted=True)
    results = [at.piece(child, inside.branch(number, i)) for i, child in enumerate(node.children)]
    return free(at, node, name, [result for result in results if isinstance(result, Part)], context, why)


def free(at: Translator, node: TreeNode, name: str, pieces: list[Part], context: Context, why: str) -> Part:
    """Children at the same time, which may be over at any moment, either way."""
    branches = in_parallel(at, pieces)
    verdict = at.choice(f"{name}_verdict", context, why)
    over = at.event(f"{name}_over", f"{name} ends: {why}")
    at.note(node, name, Kind.MORE, why)
    if not branches:
        return Part(verdict)
    inner = parallel(at.names.fresh(f"{name}_children"), branches) if len(branches) > 1 else branches[0]
    inner = replace(inner, failure=verdict.name, handlers=(Handler(event=over, goto=verdict.name),))
    return Part(Recursive(name=name, blocks=(inner, verdict)))


def switch(at: Translator, node: TreeNode, context: Context) -> Result:
    """One child by the value of a variable, which is free; the last if none fits."""
    name = at.names.fresh(called(node))
    inside = replace(context, again=True, halted=True)
    results = [at.piece(child, inside) for child in node.children]
    changes = at.event(f"{name}_changes", f"{node.ports.get('variable', 'the variable')} changes")
    cases = [node.ports.get(f"case_{i + 1}", str(i + 1)) for i in range(len(results) - 1)]
    asked = [
        at.choice(f"{name}_is_{case}", context, f"Whether {node.ports.get('variable', 'it')} is {case}")
        for case in cases
    ]
    blocks: list[Block] = []
    for place, one in enumerate(asked):
        other = asked[place + 1].name if place + 1 < len(asked) else _target(results[-1])
        blocks.append(replace(one, success=_target(results[place]), failure=other))
    for result in results:
        if isinstance(result, Part):
            block = placed(result, SUCCEED, FAIL)
            blocks.append(
                replace(block, handlers=(Handler(event=changes, goto=asked[0].name), *block.handlers))
            )
    at.note(node, name, Kind.MORE, f"the value of {node.ports.get('variable', 'its variable')} is free")
    return Part(
        Recursive(name=name, blocks=tidied(blocks)),
        skips=any(isinstance(result, Part) and result.skips for result in results),
    )


def _target(result: Result) -> str:
    return result.block.name if isinstance(result, Part) else SUCCEED if result else FAIL


CONTROLS: dict[str, Rule] = {
    "sequence": sequence,
    "fallback": fallback,
    "async_sequence": async_sequence,
    "async_fallback": async_fallback,
    "with_memory": with_memory,
    "with_memory_unhalted": with_memory,
    "if_then_else": if_then_else,
    "try_catch": try_catch,
    "parallel": parallel_node,
    "parallel_all": parallel_all,
    "switch": switch,
}
"""How they are translated, by the rule that the table of nodes names."""
