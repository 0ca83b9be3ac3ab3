"""Drawn robots: resources, activities and their alternatives."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TypedDict

from hypothesis import strategies as st

from mcpn.mission.robot import Activity, Alternative, Fault, Hardware, Software
from mcpn.testing.drawn_facts import WorldDrawing
from mcpn.testing.shape import REASONS, Shape


@dataclass
class Island:
    """A part of the robot that shares no resource with another; without disjoint branches, all of it.

    Args:
        number: Its rank.
        below: Its resources, each with all that its producer may need, itself included.
        groups: Its resources, each with those that the same activity produces.
        startable: Its activities that objectives may start.
    """

    number: int
    below: dict[str, frozenset[str]] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    startable: list[str] = field(default_factory=list)


class Crashing(TypedDict, total=False):
    """What an activity or an alternative says of its crashes."""

    faulty: bool
    recovers: bool
    failure_rate: float | None
    repair_rate: float | None


class RobotDrawing(WorldDrawing):
    """Draws the robot of a mission."""

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        super().__init__(draw, shape)
        self.islands: list[Island] = []
        self.activities: list[Activity] = []
        # Hardware that one activity may use at a time; who uses it, where no other may at all.
        self.exclusive_hardware: set[str] = set()
        self.users: dict[str, str] = {}
        # Hardware detected late that no activity detects so far.
        self.undetected: list[str] = []

    def island(self) -> Island:
        """One of the islands."""
        return self.islands[self.number(0, len(self.islands) - 1)]

    def resources(self) -> tuple[tuple[Hardware, ...], tuple[Software, ...]]:
        """Hardware, software and the activities that produce it."""
        hardware = tuple(self.hardware(f"h{i}") for i in range(self.number(1, self.shape.hardware)))
        self.exclusive_hardware = {h.name for h in hardware if not h.shared}
        islands = self.number(1, len(hardware)) if self.shape.disjoint_branches else 1
        self.islands = [Island(i) for i in range(islands)]
        for i, h in enumerate(hardware):
            island = self.islands[i] if i < islands else self.island()
            island.below[h.name] = frozenset({h.name})
            island.groups[h.name] = (h.name,)
        software: list[Software] = []
        for i in range(self.number(0, self.shape.producers)):
            produced = tuple(f"s{i}{letter}" for letter in "abcd"[: self.number(1, self.shape.outputs)])
            island = self.island()
            producer = self.activity(f"producer{i}", island, produced)
            self.activities.append(producer)
            software += [
                Software(name=s, description=self.description(), exclusive=self.exclusive()) for s in produced
            ]
            needs = [island.below[k] for a in producer.alternatives for k in a.consumes]
            for s in produced:
                island.below[s] = frozenset(produced).union(*needs)
                island.groups[s] = produced
        return hardware, tuple(software)

    def faults(self, hardware: tuple[Hardware, ...]) -> tuple[Fault, ...]:
        """Common causes, each of some hardware; nothing is drawn where there are none."""
        if not self.shape.faults:
            return ()
        some = st.lists(st.sampled_from([h.name for h in hardware]), min_size=1, max_size=3, unique=True)
        return tuple(
            Fault(
                name=f"f{i}",
                affects=tuple(self.draw(some)),
                description=self.description(),
                repairable=repairable,
                failure_rate=self.value(0, 1e6),
                repair_rate=self.value(0, 1e6) if repairable else None,
            )
            for i in range(self.number(0, self.shape.faults))
            for repairable in [not self.lasting()]
        )

    def exclusive(self) -> bool:
        """Whether software is exclusive."""
        return not self.shape.own_hardware and self.number(0, 3) == 0

    def hardware(self, name: str) -> Hardware:
        """A hardware resource."""
        faulty = self.number(0, 4) > 0
        repairable = not (faulty and self.lasting())
        out = faulty and repairable and self.lasting()
        shared = self.number(0, 1 if self.shape.own_hardware else 3) == 0
        late = self.shape.late and faulty and not shared and self.number(0, 2) > 0
        if late:
            self.undetected.append(name)
        fails = self.value(0, 1e6) if faulty else None
        back = self.value(0, 1e6) if faulty and repairable else None
        return Hardware(
            name=name,
            faulty=faulty,
            repairable=repairable,
            initial="oos" if out else "service",
            shared=shared,
            detected="late" if late else "at_once",
            description=self.description(),
            failure_rate=fails,
            repair_rate=back,
            demand_probability=self.value(0, 1) if faulty and self.shape.lasting else None,
        )

    def lasting(self) -> bool:
        """Whether hardware stays out of service, or is so at first; nothing is drawn where none may."""
        return self.shape.lasting and self.number(0, 2) == 0

    def startable(self, island: Island) -> None:
        """Adds an activity that objectives may start."""
        name = f"activity{len(self.activities)}"
        self.activities.append(self.activity(name, island, ()))
        island.startable.append(name)

    def activity(self, name: str, island: Island, produces: tuple[str, ...]) -> Activity:
        """An activity with its alternatives."""
        ways: list[Alternative] = []
        for i in range(self.number(1, self.shape.alternatives)):
            # Fallbacks mostly use something else than what has failed.
            before = {k for way in ways for k in way.consumes}
            consumes = self.consumed(name, island, before, before if self.number(0, 3) else set())
            way = Alternative(name=f"{name}_way{i}", consumes=consumes, parameters=self.parameters())
            ways.append(replace(way, requires=self.required(), **self.crashing()))
        if len(ways) == 1 and self.chance():
            ways = [Alternative(name=name, consumes=ways[0].consumes)]  # the short form
        detects = self.detected()
        return Activity(
            name=name,
            produces=produces,
            switch_back=len(ways) > 1 and self.number(0, 3) == 0,
            alternatives=tuple(ways),
            parameters=self.parameters(),
            description=self.description(),
            detects=detects,
            detection_rate=self.value(0, 1e6) if detects else None,
            failures=() if produces else self.reasons(),
            **self.crashing(),
        )

    def reasons(self, *, shares: bool = False) -> tuple[str, ...]:
        """Reasons for failures, none or a few, with shares of one half and less where numbers are drawn."""
        if not self.rarely(self.shape.reasons):
            return ()
        drawn = self.draw(st.permutations(REASONS))[: self.number(1, 2)]
        if not shares or not self.shape.numbers:
            return tuple(drawn)
        return tuple(f"{name}={self.number(0, 4) / 16}" if self.chance() else name for name in drawn)

    def detected(self) -> tuple[str, ...]:
        """Hardware whose loss an activity finds out, that no other does."""
        if not self.undetected or not self.chance():
            return ()
        return (self.undetected.pop(),)

    def crashing(self) -> Crashing:
        """Whether an activity, or an alternative, may crash, and how often; mostly not."""
        if not self.shape.crashes or self.number(0, 2):
            return {}
        recovers = self.number(0, 2) > 0
        back = self.value(0, 1e6) if recovers else None
        return {
            "faulty": True,
            "recovers": recovers,
            "failure_rate": self.value(0, 1e6),
            "repair_rate": back,
        }

    def required(self) -> tuple[str, ...]:
        """What facts must be for an alternative, mostly nothing."""
        return self.condition() if self.facts and self.number(0, 3) == 0 else ()

    def consumed(self, activity: str, island: Island, before: set[str], avoided: set[str]) -> tuple[str, ...]:
        """What an alternative consumes, after others of the activity that consume some resources."""
        chosen: list[str] = []
        for _ in range(self.draw(st.sampled_from([0, 1, 1, 1, 2, 2]))):
            left = [
                k
                for k in island.below
                if self.may_join(island, k, chosen) and self.may_follow(island, k, before)
            ]
            if self.shape.own_hardware:
                left = [k for k in left if self.users.get(k, activity) == activity]
            left = [k for k in left if k not in avoided] or left
            # What a supplier of this very alternative may take too, itself or through others.
            under = frozenset[str]().union(*(island.below[k] for k in chosen))
            near = [k for k in left if any(not under.isdisjoint(island.below[j]) for j in island.groups[k])]
            if near and self.chance():
                left = near
            # Chains of activities come of software alone.
            made = [k for k in left if k.startswith("s")]
            if made and self.chance():
                left = made
            if left:
                chosen.append(self.draw(st.sampled_from(left)))
        self.users |= {k: activity for k in chosen if k in self.exclusive_hardware}
        return tuple(chosen)

    def may_join(self, island: Island, resource: str, chosen: list[str]) -> bool:
        """Whether a resource may be consumed beside the chosen ones: disjoint below, or of one producer."""
        if not self.shape.disjoint_branches:
            return resource not in chosen
        return resource not in chosen and all(
            resource in island.groups[k] or island.below[resource].isdisjoint(island.below[k]) for k in chosen
        )

    def may_follow(self, island: Island, resource: str, before: set[str]) -> bool:
        """Whether a resource may be consumed after other alternatives, whose producers may be ending yet."""
        if not self.shape.disjoint_branches:
            return True
        return all(
            (resource == k and len(island.below[k]) == 1)
            or island.below[resource].isdisjoint(island.below[k])
            for k in before
        )
