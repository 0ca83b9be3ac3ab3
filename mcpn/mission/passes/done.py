"""What objectives have done becomes a fact like others: ``done(x)`` is declared, and set as ``x`` succeeds.

It is one fact for all objectives of that name, whichever copies they are of: that any of them has succeeded.
Only core missions can declare a fact of such a name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from mcpn.mission.fact_conditions import facts_of, objective_done
from mcpn.mission.model import Block, Mission, Objective
from mcpn.mission.rewriting.blocks import everywhere
from mcpn.mission.robot import BOOLEAN_VALUES, FactChange


def done(mission: Mission) -> Mission:
    """What objectives have done is a fact that they set (`done()`)."""
    declared = {fact.name for fact in mission.every_fact}
    asked = {name: fact for name, fact in facts_of(mission).items() if name not in declared}
    if not asked:
        return mission
    told = partial(_telling, {objective_done(name): name for name in asked})
    *robots, last = mission.robots
    return replace(
        mission,
        robots=(*robots, replace(last, facts=(*last.facts, *asked.values()))),
        blocks=everywhere(mission.blocks, told),
        protocols=tuple(replace(each, blocks=everywhere(each.blocks, told)) for each in mission.protocols),
    )


def _telling(asked: Mapping[str | None, str], block: Block) -> Block:
    """An objective that sets what is asked of it, after what it sets by itself."""
    if not isinstance(block, Objective) or block.written not in asked:
        return block
    change = FactChange(fact=asked[block.written], to=BOOLEAN_VALUES[True], source=block.source)
    return replace(block, sets=(*block.sets, change))
