"""Recoveries are written out: runs of a block, and between them copies of the sibling by which it recovers.

All stand side by side as siblings. The failure of each run but the last leads to a copy, whatever the reason
if no route names it, and the success of the copy to the next run. What the copy fails by is the failure of
the block; it has no reason (:data:`mcpn.mission.model.UNNAMED`), which only a core mission can say.

So the copies count the recoveries since the block was entered. No route may lead back to the block, so it is
entered at most once in a run of the block around it: the same number is the count that ``times`` limits.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from mcpn.errors import Problem
from mcpn.mission.model import FAIL, UNNAMED, Block, Handler, Mission
from mcpn.mission.rewriting.blocks import in_series
from mcpn.mission.rewriting.copying import copied, handled, led
from mcpn.mission.rewriting.siblings import entered, helping, pausing, recovering, routes_among


def recovery(mission: Mission) -> Mission:
    """Blocks that recover are written out, a sibling running between their runs (`recover`)."""
    names = _first_runs(mission.blocks)
    made = in_series(mission, _written_out)
    return replace(made, handlers=handled(made.handlers, names)) if names else made


def _written_out(siblings: tuple[Block, ...], around: Sequence[Handler]) -> tuple[Block, ...]:
    helpers = recovering(siblings)
    if not helpers:
        return siblings
    named = {block.name: block for block in siblings}
    aside = helping(siblings) - entered(siblings, around) - pausing(siblings).keys()
    names = _first_runs(siblings)
    made = list[Block]()
    for block in siblings:
        if block.name in helpers and block.name in aside:
            continue  # nothing but its copies is ever entered
        if block.recover is None:
            made.append(replace(block, **led(block, names)))
        else:
            by = named[block.recover]
            made += (replace(each, **led(each, names)) for each in _runs(block, by))
    return tuple(made)


def _first_runs(siblings: Sequence[Block]) -> dict[str, str]:
    return {block.name: _name(block, 1) for block in siblings if block.recover is not None}


def _name(block: Block, number: int) -> str:
    return f"{block.own}_run{number}"


def _runs(block: Block, by: Block) -> Iterator[Block]:
    """The runs of a block and, between them, the copies of the sibling by which it recovers."""
    on_failure = [route for route in block.routes if route.on == "failure" and route.reason is None]
    kept = tuple(route for route in block.routes if route not in on_failure)
    unnamed = {FAIL: UNNAMED}
    left = tuple(replace(route, goto=unnamed.get(route.goto, route.goto)) for route in on_failure)
    failure, guards = block.failure or FAIL, block.guards
    last = _name(block, block.times + 1)
    pausing = tuple(replace(each, fails_as=last) if each.pause else each for each in block.handlers)
    once = replace(block, recover=None, times=1)
    for number in range(1, block.times + 1):
        helper = copied(by, f"{block.written}{number}")
        yield copied(once, f"run{number}", failure=helper.name, routes=kept, guards=guards, handlers=pausing)
        guards = ()
        back = _name(block, number + 1)
        yield replace(helper, success=back, failure=unnamed.get(failure, failure), routes=left)
    yield copied(once, f"run{block.times + 1}", guards=guards)


def recovery_problems(siblings: Sequence[Block], around: Sequence[Handler]) -> Iterator[Problem]:
    """What is wrong with the recoveries among siblings that stand under some handlers."""
    named = {block.name: block for block in siblings}
    pausing_at_last = _pausing_at_last(siblings)
    for number, block in enumerate(siblings):
        yield from _last_runs(block, number, pausing_at_last)
        if block.recover is None:
            if block.times != 1:
                yield Problem(block.source, f"{block.name} has times, though it has no recover")
            continue
        by = named.get(block.recover)
        if by is None or by is block:
            others = ", ".join(name for name in named if name != block.name)
            expected = f"expected one of {others}" if others else "expected a sibling, of which there is none"
            yield Problem(block.source, f"recover of {block.name} names {block.recover}; {expected}")
        elif by.recover is not None:
            message = f"{block.name} recovers by {by.name}, which itself recovers by {by.recover}"
            yield Problem(block.source, f"{message}: only one of them can")
        elif any(handler.pause is not None for handler in by.handlers):
            message = f"{block.name} recovers by {by.name}, which itself pauses"
            yield Problem(block.source, f"{message}: only one of them can")
        elif block.name in _behind(block.name, routes_among(siblings), around):
            message = f"{block.name} recovers by {by.name}, and a route leads back to {block.name}"
            remedy = "put it into an objective of its own, whose runs are counted one by one"
            yield Problem(block.source, f"{message}: {remedy}")


def _pausing_at_last(siblings: Sequence[Block]) -> dict[tuple[str, str], int]:
    """By stem and name, the positions of runs whose pauses do not fail as a further run of the same."""
    return {
        (block.stem, block.name): number
        for number, block in enumerate(siblings)
        if any(h.pause and not h.fails_as for h in block.handlers)
    }


def _last_runs(
    block: Block, number: int, pausing_at_last: Mapping[tuple[str, str], int]
) -> Iterator[Problem]:
    """Pauses of a run, as core missions say them, that fail as a block which is no last run of the same."""
    for handler in block.handlers:
        if handler.fails_as is None:
            continue
        last = pausing_at_last.get((block.stem, handler.fails_as), number)
        if handler.pause is None or last <= number:
            expected = "expected, with pause, a later run of the block that pauses and has none"
            yield Problem(handler.source, f"fails_as of {block.name} names {handler.fails_as}; {expected}")


def _behind(name: str, routes: Mapping[str, Sequence[str]], around: Sequence[Handler]) -> Collection[str]:
    """The siblings that routes lead to from the sibling of this name, directly or not, its recovery aside."""
    stack = [*routes[name], *(target for handler in around for target in handler.targets)]
    seen = set[str]()
    while stack:
        if (at := stack.pop()) in routes and at not in seen:
            seen.add(at)
            stack.extend(routes[at])
    return seen
