"""Recoveries are written out: runs of a block, and between them copies of the sibling by which it recovers.

All stand side by side as siblings. The failure of each run but the last leads to a copy, whatever the reason
if no route names it, and the success of the copy to the next run. What the copy fails by is the failure of
the block; it has no reason (:data:`mcpn.mission.model.UNNAMED`), which only a core mission can say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from mcpn.mission.model import FAIL, UNNAMED, Block, Handler, Mission
from mcpn.mission.passes.copying import copied, handled, led
from mcpn.mission.passes.rewriting import in_series
from mcpn.mission.passes.siblings import entered, following, helping, pausing, recovering


def recovery(mission: Mission) -> Mission:
    """Blocks that recover are written out, a sibling running between their runs (`recover`)."""
    names = _first_runs(mission.blocks)
    made = in_series(mission, _written_out)
    return replace(made, handlers=handled(made.handlers, names)) if names else made


def _written_out(siblings: tuple[Block, ...], around: Sequence[Handler]) -> tuple[Block, ...]:
    helpers = recovering(siblings)
    if not helpers:
        return siblings
    after, named = following(siblings), {block.name: block for block in siblings}
    aside = helping(siblings) - entered(siblings, around) - pausing(siblings).keys()
    names = _first_runs(siblings)
    made = list[Block]()
    for block in siblings:
        if block.name in helpers and block.name in aside:
            continue  # nothing but its copies is ever entered
        block = replace(block, success=block.success or after[block.name])
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
