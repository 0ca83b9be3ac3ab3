"""corerobot: how the activities of a core mission react to an event, without a net; corecheck plays it.

It reads the member ``robot`` of the entry ``core.json`` as docs/certificates.md describes it. It needs
certcheck.py beside it, and Python's standard library.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
except ImportError:  # the files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]

Json = dict[str, Any]
Names = frozenset[str]
Facts = frozenset[tuple[str, str]]
"""The value of every fact."""
Act = tuple[str, int]
"""What an activity does that is not idle, and with which of its alternatives, from 0."""
Changes = dict[str, Act | None]
"""What activities do next; nothing of those that become idle."""
Owned = frozenset[tuple[str, str]]
"""Hardware that one activity at a time may use, each with the activity that does."""

TRIES, ASKS, RUNS, REFUSED = "tries", "asks", "runs", "refused"
FIRST: Act = (TRIES, 0)
HARDWARE = {"name": str, "faulty": bool, "shared": bool, "repairable": bool}
HARDWARE |= {"out": bool, "late": bool, "crash": bool}
SOFTWARE = {"name": str, "exclusive": bool}
FACT = {"name": str, "initial": str}
EVENT = {"name": str, "changes": [[str]]}
WAY = {"name": str, "consumes": [str], "requires": [[str]]}
ACTIVITY = {"name": str, "produces": [str], "switch_back": bool, "detects": [str], "alternatives": [WAY]}
ROBOT = {"hardware": [HARDWARE], "software": [SOFTWARE], "facts": [FACT], "events": [EVENT]}
ROBOT |= {"activities": [ACTIVITY]}


class RobotMoment(NamedTuple):
    """The activities at one moment of a reaction.

    Args:
        acts: What those do that are not idle.
        begin: Objectives that are about to begin.
        known: Hardware that is known to be out of service.
        suspected: Hardware that is found to be out of service when nobody has it any more.
        told: Who has learnt that a producer is refused, and has not given up yet, with the producer.
    """

    acts: frozenset[tuple[str, Act]]
    begin: Names
    known: Names
    suspected: Names
    told: frozenset[tuple[str, str]] = frozenset()

    def but(self, changes: Changes) -> RobotMoment:
        """The same with some activities elsewhere; who goes elsewhere has given up."""
        acts = {**dict(self.acts), **changes}
        told = frozenset(pair for pair in self.told if pair[0] not in changes)
        still = ((name, act) for name, act in acts.items() if act is not None)
        return self._replace(acts=frozenset(still), told=told)


def so(when: Iterable[Iterable[str]], facts: Facts) -> bool:
    """Whether facts have the values that a condition asks for."""
    return all((fact, value) in facts for fact, value in when)


def sound(robot: Json, where: str) -> None:
    """Names differ, facts that are named are there, and what is detected or produced may be."""
    names = {key: [each["name"] for each in robot[key]] for key in ROBOT}
    changes = [each["changes"] for each in robot["events"]]
    asked = [way["requires"] for each in robot["activities"] for way in each["alternatives"]]
    said = [*((2, each) for each in asked), *((3, each) for each in changes)]
    produced = [k for each in robot["activities"] for k in each["produces"]]
    detected = {k for each in robot["activities"] for k in each["detects"]}
    wrong = ""
    if any(len(set(each)) < len(each) for each in (*names.values(), produced)):
        wrong = "a name is there twice, or something is produced twice"
    elif any(len(each) != size or each[0] not in names["facts"] for size, some in said for each in some):
        wrong = "a fact has no value, or is not there"
    elif any(len({(fact, was) for fact, was, _ in each}) < len(each) for each in changes):
        wrong = "an event changes a fact twice"
    elif any(was == to for each in changes for _, was, to in each):
        wrong = "an event changes a fact to the value that it has"
    elif {*produced, *names["software"]} & {*names["hardware"]} or detected - {*names["hardware"]}:
        wrong = "hardware is produced or named as software, or what is detected is none"
    certcheck.need(not wrong, f"{where}: {wrong}", certcheck.Malformed)


class CoreRobot:
    """What a robot has, and which activities run for which objective."""

    def __init__(self, document: Json, objectives: dict[str, list[str]]) -> None:
        where = "core.json: robot"
        certcheck.shaped(document, ROBOT, where)
        sound(document, where)
        self.objectives = objectives
        self.hardware = {each["name"]: each for each in document["hardware"]}
        self.activities = {each["name"]: each for each in document["activities"]}
        self.facts: Facts = frozenset((each["name"], each["initial"]) for each in document["facts"])
        self.changing = {
            each["name"]: {(fact, was): (fact, to) for fact, was, to in each["changes"]}
            for each in document["events"]
        }
        self.producer = {k: name for name, each in self.activities.items() for k in each["produces"]}
        self.exclusive = {name for name, each in self.hardware.items() if not each["shared"]}
        self.exclusive |= {each["name"] for each in document["software"] if each["exclusive"]}
        consumed = {name: {k for way in self.ways(name) for k in way["consumes"]} for name in self.activities}
        known = {*self.hardware, *self.producer}
        for name in {k for some in consumed.values() for k in some} - known:
            raise certcheck.Malformed(f"{where}: {name[:60]} is consumed, but neither hardware nor produced")
        for name in {a for some in objectives.values() for a in some} - self.activities.keys():
            raise certcheck.Malformed(f"{where}: no activity {name[:60]}")
        counts = Counter(k for some in consumed.values() for k in some)
        self.contended = {k for k in self.exclusive if counts[k] > 1}
        self.asked = {
            fact for name in self.activities for way in self.ways(name) for fact, _ in way["requires"]
        }
        suppliers = {
            name: {self.producer[k] for k in some if k in self.producer} for name, some in consumed.items()
        }
        self.levels = [*self.layers(suppliers)]
        self.may_use = {
            o: {k for a in certcheck.grown(own, suppliers.__getitem__) for k in consumed[a]}
            for o, own in objectives.items()
        }
        self.relevant = cache(lambda facts: frozenset(each for each in facts if each[0] in self.asked))
        self.settled_from = dict[tuple[RobotMoment, Facts], set[RobotMoment]]()

    def ways(self, name: str) -> list[Json]:
        """The alternatives of an activity, the preferred one first."""
        ways: list[Json] = self.activities[name]["alternatives"]
        return ways

    @staticmethod
    def layers(suppliers: dict[str, set[str]]) -> Iterator[Names]:
        """All activities, suppliers before consumers: each of a layer needs those of layers before alone."""
        while suppliers:
            layer = frozenset(name for name, own in suppliers.items() if own.isdisjoint(suppliers))
            certcheck.need(
                layer, "core.json: robot: activities consume each other's products", certcheck.Malformed
            )
            yield layer
            suppliers = {name: own for name, own in suppliers.items() if name not in layer}

    def having(self, acts: Iterable[tuple[str, Act]]) -> dict[str, list[str]]:
        """By activity that runs, or has asked for all that it needs, what it consumes."""
        return {name: self.ways(name)[way]["consumes"] for name, (does, way) in acts if does in (ASKS, RUNS)}

    def held(self, acts: Iterable[tuple[str, Act]]) -> set[str]:
        """What some activity has, or has asked for."""
        return {k for consumes in self.having(acts).values() for k in consumes}

    def needed(self, now: RobotMoment) -> set[str]:
        """Producers of what somebody has, or has asked for; not those that are refused to it."""
        having = self.having(now.acts).items()
        asked = {(who, self.producer[k]) for who, consumes in having for k in consumes if k in self.producer}
        return {producer for _, producer in asked - now.told}

    def needless(self, now: RobotMoment) -> Changes:
        """Producers become idle that nobody needs."""
        needed = self.needed(now)
        return {a: None for a, _ in now.acts if self.activities[a]["produces"] and a not in needed}

    def at_rest(self, now: RobotMoment) -> RobotMoment:
        """When all has stopped that nobody needs, and what only that needed."""
        while idle := self.needless(now):
            now = now.but(idle)
        return self.noticed(now)

    def noticed(self, now: RobotMoment) -> RobotMoment:
        """Suspected hardware that nobody has is known to be out of service."""
        found = now.suspected - self.held(now.acts) if now.suspected else frozenset[str]()
        return now._replace(known=now.known | found, suspected=now.suspected - found) if found else now

    def settled(self, start: RobotMoment, facts: Facts) -> set[RobotMoment]:
        """Where a reaction ends, once what nobody needs has stopped: several if who comes first counts."""
        facts = self.relevant(facts)
        if (start, facts) not in self.settled_from:
            ends, reaction, first = set[RobotMoment](), RobotReaction(self, facts), self.at_rest(start)
            met, todo = {first}, [first]
            for now in todo:  # grows while it is walked
                after = {self.noticed(each) for each in reaction.moves(now)}
                ends |= set() if after else {now}
                todo += after - met
                met |= after
            self.settled_from[start, facts] = ends
        return self.settled_from[start, facts]


class RobotReaction:
    """One reaction of a robot, in which facts stay as they are."""

    def __init__(self, robot: CoreRobot, facts: Facts) -> None:
        self.robot, self.facts = robot, facts

    def moves(self, now: RobotMoment) -> list[RobotMoment]:
        """What may happen next: one thing, several where the order is open, nothing at the end."""
        robot, acts = self.robot, dict(now.acts)
        if certain := self.evaluated(now, acts):
            return [now.but(certain)]
        taken = robot.held(now.acts) & robot.contended | now.known
        tries = ((name, way) for name, (does, way) in acts.items() if does == TRIES)
        free = ((name, way) for name, way in tries if taken.isdisjoint(robot.ways(name)[way]["consumes"]))
        takes = [now.but({name: (ASKS, way)}) for name, way in free]
        if (handled := self.handled(now, acts)) is not None:
            return [handled, *takes]
        may = [o for o in sorted(now.begin) if acts.keys().isdisjoint(robot.objectives[o])]
        wanted = Counter(a for o in now.begin for a in robot.objectives[o])
        alone = [o for o in may if all(wanted[a] == 1 for a in robot.objectives[o])]
        if alone and not takes:
            return [self.begun(now, alone[0])]
        if takes or may:
            return [*takes, *(self.begun(now, o) for o in may)]
        idle = robot.needless(now)
        return [now.but(idle)] if idle else []

    def begun(self, now: RobotMoment, objective: str) -> RobotMoment:
        """An objective has begun: its activities try their alternatives."""
        start: Changes = dict.fromkeys(self.robot.objectives[objective], FIRST)
        return now.but(start)._replace(begin=now.begin - {objective})

    def evaluated(self, now: RobotMoment, acts: dict[str, Act]) -> Changes:
        """What evaluation comes to without a part of others in it."""
        robot, held = self.robot, self.robot.held(now.acts)
        found: Changes = {p: FIRST for p in robot.needed(now) if p not in acts}
        for name, (does, way) in acts.items():
            ways = robot.ways(name)
            consumes = set(ways[way]["consumes"]) if way < len(ways) and does != REFUSED else set[str]()
            if does == TRIES and way == len(ways):
                found[name] = (REFUSED, 0)
            elif does == TRIES and (now.known & consumes - held or not self.allowed(name, way)):
                found[name] = (TRIES, way + 1)
            elif does == TRIES and not consumes & (robot.contended | now.known):
                found[name] = (ASKS, way)
            elif does == ASKS and consumes.isdisjoint(robot.producer):
                found[name] = (RUNS, way)
        return found

    def handled(self, now: RobotMoment, acts: dict[str, Act]) -> RobotMoment | None:
        """The next thing that is done about an error, or for a better alternative: suppliers first."""
        robot, having, so_far = self.robot, self.robot.having(now.acts), set[str]()
        for layer in robot.levels:
            so_far |= layer
            changes: Changes = {}
            for name in layer & acts.keys():
                does, way = acts[name]
                if name in having and self.in_error(now, name, way):
                    changes[name] = FIRST if does == RUNS else (TRIES, way + 1)
                elif does == RUNS and self.returns(name, way, now.known):
                    changes[name] = FIRST
            if changes:
                return now.but(changes)
            refused = {
                a for a in layer & acts.keys() if acts[a][0] == REFUSED and robot.activities[a]["produces"]
            }
            if refused:
                every = (
                    (who, robot.producer.get(k, "")) for who, consumes in having.items() for k in consumes
                )
                told = now.told.union(pair for pair in every if pair[1] in refused)
                return now.but(dict.fromkeys(refused))._replace(told=told)
            for name, (does, way) in acts.items():
                asked = {robot.producer[k] for k in having.get(name, ()) if k in robot.producer}
                runs = all(acts.get(p, FIRST)[0] == RUNS for p in asked)
                if does == ASKS and runs and asked & so_far and not self.in_error(now, name, way):
                    changes[name] = (RUNS, way)
            if changes:
                return now.but(changes)
        return None

    def in_error(self, now: RobotMoment, name: str, way: int) -> bool:
        """Whether an activity cannot go on with its alternative."""
        told = any(who == name for who, _ in now.told)
        lost = not now.known.isdisjoint(self.robot.ways(name)[way]["consumes"])
        return told or lost or not self.allowed(name, way)

    def allowed(self, name: str, way: int) -> bool:
        """Whether facts are as an alternative requires."""
        return so(self.robot.ways(name)[way]["requires"], self.facts)

    def returns(self, name: str, way: int, known: Names) -> bool:
        """Whether an activity changes back: a better alternative is possible again, whoever has what now."""
        back = self.robot.activities[name]["switch_back"]
        return back and any(any(True for _ in self.owning(name, i, known)) for i in range(way))

    def owning(self, name: str, way: int, known: Names) -> Iterator[Owned]:
        """Which hardware which activity would have for itself, in each way to perform an alternative."""
        robot, found = self.robot, [frozenset[tuple[str, str]]()] * self.allowed(name, way)
        for k in robot.ways(name)[way]["consumes"]:
            if k in robot.hardware:
                own = frozenset({(k, name)} if k in robot.exclusive else ())
                ways = [own] * (k not in known)
            else:
                producer = robot.producer[k]
                each = range(len(robot.ways(producer)))
                ways = [owned for i in each for owned in self.owning(producer, i, known)]
            together = {one | other for one in found for other in ways}
            found = [owned for owned in together if len(dict(owned)) == len(owned)]
        yield from found
