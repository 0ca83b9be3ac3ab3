"""The robot's activities: which alternatives run, what waits, what is refused, and how they react.

Made from the language page alone. A *reaction* runs until nothing moves. First, who evaluates passes over
alternatives that need hardware out of service and takes what it alone can want, producers that are needed
begin, who has all that it needs runs. Then who is in error gives its alternative up, suppliers before
consumers: a producer without a possible alternative tells all who have asked, and is idle. At any time
those who evaluate may take something that several may want, in any order: where two orders end differently
the outcome is not determined. Last, producers that nobody needs stop.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache

from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Alternative


class Acting(StrEnum):
    """What an activity does that is not idle."""

    TRIES = "tries"
    """It evaluates an alternative; in a stable state it waits until something that it needs is free."""
    ASKS = "asks"
    """It has what the alternative needs for itself, and waits until its producers run."""
    RUNS = "runs"
    REFUSED = "refused"


At = tuple[Acting, int]
"""What an activity does, and with which alternative, by its rank; a refused one has none, by rank -1."""
Facts = frozenset[tuple[str, str]]
"""The value of every fact."""
REFUSED: At = (Acting.REFUSED, -1)
FROM_THE_FIRST: At = (Acting.TRIES, 0)


@dataclass(frozen=True)
class Activities:
    """All activities at one moment.

    Args:
        at: Those that are not idle.
        wanted: Activities that objectives have yet to start, by objective.
        out: Hardware out of service.
        facts: The value of every fact.
        suspected: Hardware that is found to be out of service when who has it lets it go.
        told: Who has been told that a producer is refused, with the producer, and has not given up yet.
    """

    at: Mapping[str, At]
    wanted: Mapping[str, tuple[str, ...]]
    out: frozenset[str]
    facts: Facts = frozenset()
    suspected: frozenset[str] = frozenset()
    told: frozenset[tuple[str, str]] = frozenset()

    def but(self, changes: Mapping[str, At | None]) -> Activities:
        """The same with some activities elsewhere; ``None`` for idle."""
        at = {**self.at, **changes}
        told = frozenset(pair for pair in self.told if pair[0] not in changes)
        return replace(self, at={name: where for name, where in at.items() if where is not None}, told=told)

    def key(self) -> tuple[object, ...]:
        """What tells two moments apart."""
        at, wanted = frozenset(self.at.items()), frozenset(self.wanted)
        return at, wanted, self.out, self.facts, self.suspected, self.told


def so(facts: Facts, words: Iterable[str]) -> bool:
    """Whether facts are as some words say, all of them."""
    for word in words:
        name, sign, value = word.lstrip("!").partition("=")
        if (name, value if sign else "false" if word.startswith("!") else "true") not in facts:
            return False
    return True


class Reactions:
    """What the robot's engineer has declared, and how it reacts.

    Args:
        mission: The mission.
    """

    def __init__(self, mission: Mission) -> None:
        declared = [activity for robot in mission.robots for activity in robot.activities]
        self.activities = {activity.name: activity for activity in declared}
        self.hardware = {h.name: h for robot in mission.robots for h in (*robot.hardware, *robot.crashes)}
        self.written_crashes = {crash.name for robot in mission.robots for crash in robot.crashes}
        self.faults = {f.name: frozenset(f.affects) for robot in mission.robots for f in robot.faults}
        self.producer = {s: a.name for a in declared for s in a.produces}
        self.exclusive = {h.name for h in self.hardware.values() if not h.shared}
        self.exclusive |= {s.name for s in mission.software if s.exclusive}
        self.consumers = Counter(
            k for a in declared for k in {k for way in a.alternatives for k in way.consumes}
        )
        self.possible = cache(self._possible)
        self.levels = [*self._levels()]

    def _levels(self) -> Iterator[frozenset[str]]:
        """All activities, suppliers before consumers: each of a level consumes of those before alone."""
        under: dict[str, set[str]] = {name: set() for name in self.activities}
        for name, activity in self.activities.items():
            consumed = {k for way in activity.alternatives for k in way.consumes}
            under[name] = {self.producer[k] for k in consumed if k in self.producer}
        while under:
            level = frozenset(name for name, suppliers in under.items() if suppliers.isdisjoint(under))
            yield level
            under = {name: suppliers for name, suppliers in under.items() if name not in level}

    def way(self, name: str, at: At) -> Alternative:
        """The alternative that an activity tries, asks for or runs."""
        return self.activities[name].alternatives[at[1]]

    def settled(self, start: Activities) -> list[Activities]:
        """Where a reaction may end: one moment, or several where the outcome is not determined."""
        ends: dict[object, Activities] = {}
        seen, stack = {start.key()}, [start]
        while stack and len(ends) < 2:
            now = stack.pop()
            after = [self.noticed(one) for one in self.move(now)]
            if not after:
                ends[now.key()] = now
            for one in after:
                if one.key() not in seen:
                    seen.add(one.key())
                    stack.append(one)
        return list(ends.values())

    def noticed(self, now: Activities) -> Activities:
        """What is suspected and nobody has any more is out of service, and known to be."""
        held = {k for _, consumes in self.holding(now) for k in consumes} if now.suspected else set()
        found = now.suspected - held
        return replace(now, out=now.out | found, suspected=now.suspected - found) if found else now

    def stopped(self, now: Activities) -> Activities:
        """Every producer stopped that nobody needs, and those that only these needed."""
        while idle := self.needless(now):
            now = now.but(dict.fromkeys(idle))
        return now

    def move(self, now: Activities) -> list[Activities]:
        """What may happen next: one thing, several where the order is open, none at the end."""
        if certain := self.evaluation(now):
            return [now.but(certain)]
        chosen = [*self.takes(now)]
        if (handled := self.handled(now)) is not None:
            return [handled, *chosen]
        if alone := None if chosen else self.alone(now):
            return [alone]
        if chosen := [*chosen, *self.begins(now)]:
            return chosen
        idle = self.needless(now)
        return [now.but(dict.fromkeys(idle))] if idle else []

    def handled(self, now: Activities) -> Activities | None:
        """The next thing that is done about an error, or for the sake of a better alternative."""
        decided = frozenset[str]()
        for level in self.levels:
            decided |= level
            if certain := {**self.returns(now, level), **self.errors(now, level)}:
                return now.but(certain)
            if refused := [n for n in level if now.at.get(n) == REFUSED and self.activities[n].produces]:
                return self.tells(now, refused)
            if certain := self.answers(now, decided):
                return now.but(certain)
        return None

    def errors(self, now: Activities, level: frozenset[str]) -> dict[str, At | None]:
        """Who runs and loses a resource tries all again; who still asks tries the next alternative."""
        found: dict[str, At | None] = {}
        for name, consumes in self.holding(now):
            if name in level and self.in_error(now, name, consumes):
                doing, rank = now.at[name]
                found[name] = FROM_THE_FIRST if doing is Acting.RUNS else (Acting.TRIES, rank + 1)
        return found

    def in_error(self, now: Activities, name: str, consumes: Iterable[str]) -> bool:
        """Whether an activity cannot go on in its alternative."""
        if any(told == name for told, _ in now.told) or not self.unusable(now.out).isdisjoint(consumes):
            return True
        return not self.allowed(name, now.at[name][1], now.facts, now.out)

    def tells(self, now: Activities, refused: Collection[str]) -> Activities:
        """Producers that are refused tell all who have asked, or have what they produce, and are idle."""
        every = {(who, self.producer.get(k, "")) for who, consumes in self.holding(now) for k in consumes}
        now = now.but(dict.fromkeys(refused))
        return replace(now, told=now.told | {pair for pair in every if pair[1] in refused})

    def allowed(self, name: str, rank: int, facts: Facts, out: frozenset[str] = frozenset()) -> bool:
        """Whether facts are as an alternative requires, and it has not crashed."""
        activity = self.activities[name]
        works = out.isdisjoint(self.crashes(name, rank))
        return works and so(facts, (*activity.requires, *activity.alternatives[rank].requires))

    def crashes(self, name: str, rank: int) -> Iterator[str]:
        """What may crash while an activity runs in an alternative."""
        activity = self.activities[name]
        if activity.faulty:
            yield name
        if (way := activity.alternatives[rank]).faulty:
            yield f"{name}.{way.name}"
        yield from self.written_crashes.intersection(way.consumes)

    def unusable(self, out: frozenset[str]) -> frozenset[str]:
        """Hardware that is out of service, by itself or by a fault."""
        return out.union(*(affected for fault, affected in self.faults.items() if fault in out))

    def evaluation(self, now: Activities) -> dict[str, At | None]:
        """The steps of evaluation that no other activity has a part in."""
        found: dict[str, At | None] = {p: FROM_THE_FIRST for p in self.needed(now) if p not in now.at}
        held = {k for _, consumes in self.holding(now) for k in consumes}  # known to be out when given up
        for name, (doing, rank) in now.at.items():
            activity = self.activities[name]
            if doing is Acting.TRIES and rank == len(activity.alternatives):
                found[name] = REFUSED
            elif doing is Acting.TRIES:
                consumes = activity.alternatives[rank].consumes
                lost = self.unusable(now.out).intersection(consumes)
                if lost - held or not self.allowed(name, rank, now.facts, now.out):
                    found[name] = (Acting.TRIES, rank + 1)
                elif not lost and not any(map(self.contended, consumes)):
                    found[name] = (Acting.ASKS, rank)
            elif doing is Acting.ASKS and not self.asked(name, rank):
                found[name] = (Acting.RUNS, rank)
        return found

    def answers(self, now: Activities, level: frozenset[str]) -> dict[str, At | None]:
        """Who asks runs when all producers do that it asks, of whom some are of a level."""
        found: dict[str, At | None] = {}
        for name, (doing, rank) in now.at.items():
            asked = self.asked(name, rank) if doing is Acting.ASKS else set[str]()
            runs = all(now.at.get(p, REFUSED)[0] is Acting.RUNS for p in asked)
            if runs and asked & level and not self.in_error(now, name, self.way(name, now.at[name]).consumes):
                found[name] = (Acting.RUNS, rank)
        return found

    def asked(self, name: str, rank: int) -> set[str]:
        """The producers of what an alternative consumes."""
        consumes = self.activities[name].alternatives[rank].consumes
        return {self.producer[k] for k in consumes if k in self.producer}

    def returns(self, now: Activities, level: frozenset[str]) -> dict[str, At | None]:
        """Who switches back and has a better alternative that is possible again."""
        return {
            name: FROM_THE_FIRST
            for name, (doing, rank) in now.at.items()
            if name in level and doing is Acting.RUNS and self.activities[name].switch_back
            if any(self.possible(name, better, now.out, now.facts) for better in range(rank))
        }

    def alone(self, now: Activities) -> Activities | None:
        """An objective begins whose activities no other is about to start."""
        starts = Counter(name for activities in now.wanted.values() for name in activities)
        return next(
            (after for o, after in self.beginning(now) if all(starts[a] == 1 for a in now.wanted[o])), None
        )

    def takes(self, now: Activities) -> Iterator[Activities]:
        """One of those that evaluate takes what several may want and nobody has."""
        held = {k for _, consumes in self.holding(now) for k in consumes if self.contended(k)}
        held |= self.unusable(now.out)
        for name, at in now.at.items():
            if at[0] is Acting.TRIES and held.isdisjoint(self.way(name, at).consumes):
                yield now.but({name: (Acting.ASKS, at[1])})

    def begins(self, now: Activities) -> Iterator[Activities]:
        """One of the objectives that wait begins."""
        return (after for _, after in self.beginning(now))

    def beginning(self, now: Activities) -> Iterator[tuple[str, Activities]]:
        """Objectives whose activities no other has started, and the moment when one of them has begun."""
        for objective, activities in now.wanted.items():
            if not any(name in now.at for name in activities):
                left = {o: those for o, those in now.wanted.items() if o != objective}
                yield objective, replace(now.but(dict.fromkeys(activities, FROM_THE_FIRST)), wanted=left)

    def contended(self, resource: str) -> bool:
        """Whether one activity at a time has the resource, and several may want it."""
        return resource in self.exclusive and self.consumers[resource] > 1

    def holding(self, now: Activities) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Who has which resources, or has asked their producers."""
        for name, at in now.at.items():
            if at[0] in (Acting.ASKS, Acting.RUNS):
                yield name, self.way(name, at).consumes

    def needed(self, now: Activities) -> set[str]:
        """Producers of what somebody has or asks for."""
        every = {
            (who, self.producer[k])
            for who, consumes in self.holding(now)
            for k in consumes
            if k in self.producer
        }
        return {producer for _, producer in every - now.told}

    def needless(self, now: Activities) -> list[str]:
        """Producers that are not idle though nobody needs what they produce."""
        needed = self.needed(now)
        return [name for name in now.at if self.activities[name].produces and name not in needed]

    def _possible(self, name: str, rank: int, out: frozenset[str], facts: Facts) -> bool:
        """Whether hardware in service and facts allow an alternative, whoever has the hardware now."""
        return any(True for _ in self._ways(self.activities[name], rank, out, facts))

    def _ways(
        self, activity: Activity, rank: int, out: frozenset[str], facts: Facts
    ) -> Iterator[frozenset[tuple[str, str]]]:
        """Which hardware which activity would have for itself, in each way to perform an alternative."""
        if not self.allowed(activity.name, rank, facts, out):
            return
        found: list[frozenset[tuple[str, str]]] = [frozenset()]
        for k in activity.alternatives[rank].consumes:
            found = [
                way
                for one in found
                for other in self._ways_to(k, activity.name, out, facts)
                for way in _both(one, other)
            ]
        yield from found

    def _ways_to(
        self, resource: str, who: str, out: frozenset[str], facts: Facts
    ) -> Iterator[frozenset[tuple[str, str]]]:
        if resource in self.hardware:
            if resource not in self.unusable(out):
                yield frozenset({(resource, who)} if resource in self.exclusive else ())
            return
        producer = self.activities[self.producer[resource]]
        for rank in range(len(producer.alternatives)):
            yield from self._ways(producer, rank, out, facts)


def _both(
    one: frozenset[tuple[str, str]], other: frozenset[tuple[str, str]]
) -> Iterable[frozenset[tuple[str, str]]]:
    """Both together, unless two activities would have one hardware resource."""
    together = one | other
    if len({hardware for hardware, _ in together}) == len(together):
        yield together
