"""Numbers of risk of a mission: what they suppose, and which chain they are read off.

The model, all durations exponential and independent, hours the unit of time:

- the mission starts at time 0 with all hardware in service but for that declared out of service;
- the loss of hardware that is detected late is found out at the ``detection_rate`` of the activity that
  detects it, as long as this runs; nobody repairs it before it is known. An objective goes on that uses it
  though it is lost: where it would succeed but for that it ends at rate ``1/d`` in failure;
- hardware in service fails at its ``failure_rate``, hardware out of service is repaired at its
  ``repair_rate``; a rate that is not given is 0; what may crash fails only while it runs;
- hardware fails with its ``demand_probability`` at once when an alternative that consumes it starts
  (:mod:`mcpn.answers.causes.demands`);
- an objective of mean duration ``d`` ends at rate ``1/d`` while its success is possible: with its
  ``failure_probability`` in failure, else in success; of these failures each reason has the part that the
  mission gives it (``failures``), all others are for no reason, as are those of the next kinds;
- a declared event happens at its ``rate`` wherever something handles it; one without a rate never happens;
- an objective whose *present run* cannot succeed any more fails at once (the activity's error to the
  controller, paper 6.2); one that only waits for a resource waits. Of several that fail at once, each is as
  likely to be the first. A declared event that stops an objective ends its run, also where it leads back
  into it.

By composition each type of section is one chain (:mod:`mcpn.answers.causes.chain`), and they are put together
at the status of the hardware (:mod:`mcpn.answers.causes.section_chains`). Otherwise the whole mission is one
section. Both give the same numbers but for rounding.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from mcpn.answers.causes.chain import ListedChain
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.section_chains import ChainSection, Outlook, Sections
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.section_type import SectionType
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.permanent_loss import entered_otherwise
from mcpn.drawing.sections import LocalPart
from mcpn.drawing.status import Element
from mcpn.errors import InputError, LimitError
from mcpn.events import Event, What
from mcpn.mission.fact_conditions import all_flags
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.static.warnings import of_objectives
from mcpn.spaces.arrays import ArraySet, ArraySpace
from mcpn.spaces.stable.written_out import written_out
from mcpn.steps import Doing, step

MOST_STATES = 50_000
"""States of one chain whose numbers are computed, unless another limit is given; the system of one of so many
states is solved in seconds, for each resource again."""


@dataclass(frozen=True)
class Risk:
    """Numbers of one mission.

    Args:
        success: Probability of mission success.
        failure: Probability of mission failure; the ends make less than 1 where the mission need not end.
        degraded_modes: Expected number of times that the robot comes into a degraded functioning mode: one in
            which some activity runs in another alternative than its first. Infinite where it may go on so for
            ever.
        importance: Birnbaum importance by hardware: how much more probable success is if the resource never
            fails than if it is out of service from the start and never repaired.
        unrated: Declared events that interrupt something, and detections, that have no rate: in the numbers
            they never happen.
        abort: Probability of mission abort; ``None`` of a mission that cannot abort.
        safety_importance: The same importance for success or abort; ``None`` of a mission that cannot abort.
    """

    success: float
    failure: float
    degraded_modes: float
    importance: Mapping[str, float]
    unrated: tuple[str, ...] = ()
    abort: float | None = None
    safety_importance: Mapping[str, float] | None = None


def risk(prospects: Prospects[Any]) -> Risk:
    """The numbers of a mission whose file gives rates and durations.

    Args:
        prospects: The mission on its alternatives graph. A probability is one number for each state: of a
            decision diagram the states are listed, of a composite those of each type of section: no more
            than :data:`MOST_STATES`, unless it says another limit.

    Returns:
        The ends, degraded modes and importance.

    Raises:
        InputError: An objective that may run has no duration.
        LimitError: A chain has too many states, which is found before they are listed, or there is too much
            hardware to be remembered; or an event may end a block and enter it again, or lead to the
            beginning of a branch in it.
    """
    refuse_unknown(prospects)
    step(Doing.COMPUTING_RISK)
    limit = MOST_STATES if prospects.max_states is None else prospects.max_states
    model = _sections(prospects, limit)
    hardware = {h.name: h for h in prospects.mission_net.core.hardware}
    rates: dict[Element, tuple[float, float]] = {}
    if isinstance(prospects.space, CompositeSpace):
        rates |= _rates_of_facts(prospects.mission_net)
    failing = {
        ("hardware", h): (hardware[h].failure_rate or 0.0, hardware[h].repair_rate or 0.0)
        for h in prospects.hardware
    }
    rates |= failing
    demands: dict[Element, float] = {("hardware", h): p for h, p in _demands(prospects.mission_net).items()}
    outlook = Outlook(model, rates, demands)
    ends, aborts = outlook.ends(), prospects.mission_net.abort is not None
    importance, safely = dict[str, float](), dict[str, float]()
    for resource in failing:
        frozen = Outlook(model, {**rates, resource: (0.0, 0.0)}, {**demands, resource: 0.0}, outlook)
        best, worst = frozen.ends(kept=resource), frozen.ends(resource)
        importance[resource[1]] = _gain(best, worst, (SUCCEED,))
        safely[resource[1]] = _gain(best, worst, (SUCCEED, ABORT))
    return Risk(
        ends[SUCCEED],
        ends[FAIL],
        outlook.degraded_modes(),
        importance,
        tuple(_unrated(prospects.mission_net)),
        ends[ABORT] if aborts else None,
        safely if aborts else None,
    )


def _gain(best: Mapping[str, float], worst: Mapping[str, float], wanted: Collection[str]) -> float:
    """How much more probable some ends are; by the less probable side, of them or all others.

    Where success is nearly certain with and without a resource, the failures make the difference.
    """
    won, lost = ([end for end in best if (end in wanted) == side] for side in (True, False))
    if sum(best[end] + worst[end] for end in won) <= 1.0:
        return sum(best[end] - worst[end] for end in won)
    return sum(worst[end] - best[end] for end in lost)


def _demands(mission_net: MissionNet) -> dict[str, float]:
    """How probable it is that hardware fails on demand, of what may."""
    return {h.name: h.demand_probability for h in mission_net.core.hardware if h.demand_probability}


def _rates_of_facts(mission_net: MissionNet) -> dict[Element, tuple[float, float]]:
    """How often events make facts other than they were at the start, and bring them back.

    Raises:
        LimitError: An event with a rate changes several facts, or one of more than two values: a section that
            does not know them would not know how they change together.
    """
    world, rates = mission_net.usage.world, dict[Element, tuple[float, float]]()
    for event in mission_net.core.events:
        changes = world.changing.get(event.name, {})
        if not changes or not event.rate:
            continue
        (name, to), *others = changes.items()
        fact = world.facts[name]
        if others or len(fact.values) > 2:
            what = "several facts" if others else f"a fact of {len(fact.values)} values"
            raise LimitError(
                f"the event {event.name} changes {what}: numbers of risk know events with a rate that change "
                "one fact of two values"
            )
        (flag,) = all_flags(fact)
        away, back = rates.get(("fact", flag), (0.0, 0.0))
        for was, now in to.items():
            if was != now and was == fact.start:
                away += event.rate
            elif was != now:
                back += event.rate
        rates["fact", flag] = away, back
    return rates


def _unrated(mission_net: MissionNet) -> Iterator[str]:
    handled = {i.event for section in mission_net.graph.all_sections() for i in section.interruptions}
    handled |= mission_net.usage.world.changing.keys()
    for event in mission_net.core.events:
        if event.name in handled and event.rate is None:
            yield event.name
    for name in mission_net.usage.started:
        activity = mission_net.usage.activities[name]
        if activity.detection_rate is None:
            yield from (str(Event(What.DETECTED, hardware)) for hardware in activity.detects)


def refuse_unknown(prospects: Prospects[Any]) -> None:
    """Raises an InputError that names each objective that may run and has no duration."""
    needed = "no duration, which numbers of risk need: its mean in hours"
    running = (s for name, s in prospects.sections.items() if prospects.objectives[name].running)
    unknown = (section for section in running if section.duration is None)
    problems = list(of_objectives(prospects.mission_net.usage, unknown, f"has {needed}", f"have {needed}"))
    if problems:
        raise InputError(problems)


def _sections(prospects: Prospects[Any], max_states: int) -> Sections:
    """The sections of a composite; of any other space the whole mission as one, listed."""
    space, net = prospects.space, prospects.mission_net
    every = tuple(flag.element for status in net.statuses for flag in status.flags if flag.kind != "dead")
    out = [flag for status in net.statuses for flag in status.values[status.initial]]
    demands = _demands(net)

    def demanded(*each: Sequence[Element]) -> tuple[int, ...]:
        """The positions of hardware that fails on demand in at least one of some alike sections."""
        return tuple(
            i
            for i, elements in enumerate(zip(*each, strict=True))
            if any(kind == "hardware" and name in demands for kind, name in elements)
        )

    if not isinstance(space, CompositeSpace):
        if (size := space.everything.count()) > max_states:
            raise LimitError(f"{size:,} states, the limit is {max_states:,} (--max-chain)")
        # Before the start events may change facts, as hardware may fail: what is so at the start has a
        # status. What happens once has not happened then.
        status = tuple(flag for flag in every if flag[0] != "once")
        if net.core.crashes:  # importance asks what it means that they had crashed before the start
            net = entered_otherwise(net, [What.OUT_OF_SERVICE])
            prospects = Prospects(net, spaces_of(net).unproved(max_states))
        elif not isinstance(space, ArraySpace):
            prospects = Prospects(net, ArraySpace(written_out(space, "risk", max_states)))
        routes = {"success": SUCCEED, "failure": FAIL, "abort": ABORT}
        whole = ChainSection(
            ListedChain(prospects, status, (), demanded(status)),
            status,
            tuple(prospects.sections.values()),
            routes,
        )
        return Sections({"": whole}, "", status, out)
    known: dict[SectionType, Prospects[ArraySet]] = {}
    listed = cache(ListedChain)
    sections = {}
    # An event without a rate never happens, and so nothing that it makes happen once has happened.
    rated = {event.name for event in net.core.events if event.rate}

    def carried(part: LocalPart) -> tuple[Element, ...]:
        kept = {("once", name) for name in part.once_on(rated)}
        return tuple(element for element in part.carried if element[0] != "once" or element in kept)

    entered = {
        name: placed
        for name, placed in space.sections.items()
        # Importance asks what it means that something had crashed before the start, when others are entered.
        if net.core.crashes or name in space.everything.parts
    }
    alike: dict[SectionType, list[tuple[Element, ...]]] = {}
    for placed in entered.values():
        alike.setdefault(placed.type, []).append(carried(placed.part))
    asked = {kind: demanded(*each) for kind, each in alike.items()}
    for name, placed in entered.items():
        kind = placed.type
        if kind not in known:
            kind.refuse_list(name, max_states, "numbers of risk list every state", "--max-chain")
            kept = kind.part.once_on(rated)
            known[kind] = Prospects(kind.forgetful(kept)[0], ArraySpace(kind.listed(kept, max_states)))
        again = tuple(exit_ for exit_, route in placed.routes.items() if route == name)
        objectives = tuple(placed.part.graph.walk())
        sections[name] = ChainSection(
            listed(known[kind], carried(kind.part), again, asked[kind]),
            carried(placed.part),
            objectives,
            placed.routes,
        )
    idle = [("hardware", crash.name) for crash in net.core.crashes]
    return Sections(sections, net.graph.entry, every, out, idle)
