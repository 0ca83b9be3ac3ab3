"""Reasons that activities name stand on the objectives that run them: those of activities before their own.

An objective of the core mission says all reasons for which it may fail. Where that leads is found as the
objectives graph is made, for it depends on all blocks that the failure leaves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from mcpn.mission.model import Block, Mission, Objective
from mcpn.mission.reasons import reason, reasons_of
from mcpn.mission.rewriting.blocks import everywhere
from mcpn.mission.robot import Activity


def reasons(mission: Mission) -> Mission:
    """Reasons of activities stand on the objectives that run them (`failures`)."""
    activities = {activity.name: activity for activity in mission.activities if activity.failures}
    if not activities:
        return mission
    all_named = partial(_named, activities)
    # Protocols that nothing uses are kept, and checked as they are read again.
    protocols = (replace(each, blocks=everywhere(each.blocks, all_named)) for each in mission.protocols)
    robots = (
        replace(robot, activities=tuple(replace(activity, failures=()) for activity in robot.activities))
        for robot in mission.robots
    )
    blocks = everywhere(mission.blocks, all_named)
    return replace(mission, blocks=blocks, protocols=tuple(protocols), robots=tuple(robots))


def _named(activities: Mapping[str, Activity], block: Block) -> Block:
    if not isinstance(block, Objective) or activities.keys().isdisjoint(block.activities):
        return block
    own = {reason(text).name: text for text in block.failures}
    return replace(block, failures=tuple(own.get(r.name, r.name) for r in reasons_of(block, activities)))
