"""ctlcheck: walks a controller beside the net of a certificate, in every pair of states they reach together.

``python ctlcheck.py CERTIFICATE controller.json`` needs ``certcheck.py`` beside it and nothing else of mcpn.
In each pair the same events are possible, the same hardware is out of service, the same objectives and
alternatives run, and the mission has ended alike. A model of the robot takes the actions of every event: it
only starts what is stopped, after what it consumes, only stops what runs, and releases what was held; they
lead from what ran to what runs. The page docs/certificates.md says it in full. Exit codes are those of
``certcheck``.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
except ImportError:  # alone, beside the other file
    import certcheck  # type: ignore[import-not-found, no-redef]

Json = Any
Action = tuple[str, Json]
"""In which section it stands, and the action."""
ORDER = ("disarm", "stop", "release", "select", "start", "arm")
ENDS = {"succeed": "success", "fail": "failure", "abort": "abort"}
FORMS = {
    "success": "OBJ_{}_EV_OK",
    "failure": "OBJ_{}_EV_FAIL",
    "timeout": "OBJ_{}_EV_TIMEOUT",
    "out of service": "{}_EV_OOS",
    "repaired": "{}_EV_RD",
    "detected": "{}_EV_DETECTED",
    "declared": "{}",
    "start": "MISSION_EV_START",
}
"""How the controller's document writes an event; the reason of a failure follows after ``_``."""


class ControllerState(NamedTuple):
    """A state of the controller.

    Args:
        phase: ``before``, ``running``, or how the mission has ended.
        section: The section that runs; empty where none does.
        at: The state of its type.
        gone: Hardware out of service.
        true: Facts, and handlers that have happened once.
    """

    phase: str
    section: str
    at: int
    gone: frozenset[str]
    true: frozenset[str]


class WalkedController:
    """A hierarchical controller: types of sections as machines, and sections that name their elements."""

    def __init__(self, document: Json) -> None:
        self.document = document
        self.failing = set(document["hardware"])
        self.repairable = self.failing - set(document["unrepairable"])
        self.late, self.crashing = document["late"], set(document["crashing"])
        self.sections = {section["name"]: section for section in document["sections"]}
        self.own = {name: {e: i for i, e in enumerate(s["events"])} for name, s in self.sections.items()}
        self.moves: list[list[dict[int, list[Json]]]] = []
        for each in document["types"]:
            found: list[dict[int, list[Json]]] = [{} for _ in each["states"]]
            for edge in each["edges"]:
                found[edge["from"]].setdefault(edge["event"], []).append(edge)
            self.moves.append(found)

    def first(self) -> ControllerState:
        """Before the mission starts."""
        gone = frozenset(self.document["out_of_service"])
        return ControllerState("before", "", 0, gone, frozenset(self.late[h] for h in gone if h in self.late))

    def named(self, section: str, kind: str, name: str) -> str:
        """The element of a section that its type calls so."""
        found: str = self.sections[section]["names"].get(kind, {}).get(name, name)
        return found

    def type_of(self, section: str) -> Json:
        """The type of a section."""
        return self.document["types"][self.sections[section]["type"]]

    def facts(self, section: str, item: Json, key: str) -> frozenset[str]:
        """The facts, and handlers that happen once, that an entry or an edge names."""
        once = self.type_of(section)["once"]
        names = item.get(key, ())
        return frozenset(self.named(section, "once" if n in once else "facts", n) for n in names)

    def entered(
        self, route: str, gone: frozenset[str], true: frozenset[str]
    ) -> tuple[ControllerState, list[Action]]:
        """Where a route leads: to an end, or into a section, by what is out of service and what is true."""
        if route in ENDS:
            return ControllerState(ENDS[route], "", 0, gone, true), []
        kind, number = self.type_of(route), 0
        for i, name in enumerate(kind["hardware"]):
            number |= (self.named(route, "hardware", name) in gone) << i
        for i, name in enumerate(kind["facts"][: kind["entering"]]):
            number |= (self.named(route, "facts", name) in true) << len(kind["hardware"]) + i
        entry = kind["entries"][number]
        certcheck.need(entry, f"{route} cannot be entered like this")
        true = (true | self.facts(route, entry, "gained")) - self.facts(route, entry, "lost")
        return ControllerState("running", route, entry["to"], gone, true), [
            (route, each) for each in entry["actions"]
        ]

    def onward(self, state: ControllerState) -> Iterator[tuple[str, ControllerState, list[Action]]]:
        """Each event that is possible, with the state after it and its actions."""
        own = self.own.get(state.section, {})
        for event, number in own.items():
            found = self.own_move(state, event, number)
            if found is not None:
                yield event, *found
        for name in sorted(self.failing):
            if (
                name not in state.gone
                and name not in self.crashing
                and (event := f"{name}_EV_OOS") not in own
            ):
                yield event, state._replace(gone=state.gone | {name}), []
            known = self.late.get(name)
            back = name in state.gone and name in self.repairable and (known is None or known in state.true)
            if back and (event := f"{name}_EV_RD") not in own:
                yield event, state._replace(gone=state.gone - {name}, true=state.true - {known}), []
        for event, change in self.document["changing"].items():
            true = (state.true | set(change["true"])) - set(change["false"])
            if event not in own and true != state.true:
                yield event, state._replace(true=true), []
        if state.phase == "before":
            yield "MISSION_EV_START", *self.entered(self.document["initial"], state.gone, state.true)

    def own_move(
        self, state: ControllerState, event: str, number: int
    ) -> tuple[ControllerState, list[Action]] | None:
        """What an event of the section's type does, by the first edge whose handlers allow it."""
        section = state.section
        for edge in self.moves[self.sections[section]["type"]][state.at].get(number, ()):
            opens, happened = self.facts(section, edge, "open"), self.facts(section, edge, "happened")
            if opens & state.true or not happened <= state.true:
                continue
            true = (state.true | opens | self.facts(section, edge, "gained")) - self.facts(
                section, edge, "lost"
            )
            gone = state.gone
            if event.endswith("_EV_OOS") and event[:-7] in self.failing:
                gone |= {event[:-7]}
            elif event.endswith("_EV_RD"):
                gone -= {event[:-6]}
            actions = [(section, each) for each in edge["actions"]]
            if isinstance(edge["to"], int):
                return ControllerState("running", section, edge["to"], gone, true), actions
            after, more = self.entered(self.sections[section]["routes"][edge["to"]], gone, true)
            return after, actions + more
        return None

    def shown(self, state: ControllerState) -> tuple[set[str], dict[str, str]]:
        """The objectives that run, and the alternative of each activity that runs."""
        if not state.section:
            return set(), {}
        row = self.type_of(state.section)["states"][state.at]
        modes = (self.named(state.section, "alternatives", f"{a}.{way}") for a, way in row["mode"].items())
        running = {self.named(state.section, "objectives", name) for name in row["objectives"]}
        return running, dict(mode.split(".", 1) for mode in modes)


class RobotModel:
    """What activities do while a controller's actions are taken, one after the other.

    Args:
        controller: The controller.
        running: The alternative of each activity that runs.
    """

    def __init__(self, controller: WalkedController, running: dict[str, str]) -> None:
        self.controller, self.activities = controller, controller.document["activities"]
        self.running, self.chosen = dict(running), dict(running)
        self.left, self.released = set[str](), list[str]()
        self.software = {x for each in self.activities.values() for x in each["produces"]}

    def held(self, activity: str, way: str) -> set[str]:
        """The hardware that an alternative of an activity uses."""
        return {*self.activities[activity]["alternatives"][way]["consumes"]} - self.software

    def take(self, section: str, action: Json) -> None:
        """Takes an action, or refutes that it may be taken."""
        named, do = self.controller.named, action["do"]
        activity = named(section, "activities", action.get("activity", ""))
        if do == "stop":
            certcheck.need(activity in self.running, f"{activity} is stopped, and does not run")
            self.left |= self.held(activity, self.running.pop(activity))
        elif do == "release":
            self.released.append(named(section, "hardware", action["hardware"]))
        elif do == "select":
            way = named(section, "alternatives", f"{action['activity']}.{action['alternative']}").split(
                ".", 1
            )[1]
            self.chosen[activity] = way
            if activity in self.running:
                self.left |= self.held(activity, self.running[activity])
                self.running[activity] = way
        elif do == "start":
            certcheck.need(activity not in self.running, f"{activity} is started, and runs")
            certcheck.need(activity in self.chosen, f"{activity} is started in no alternative")
            self.running[activity] = self.chosen[activity]
            made = {x for each in self.running for x in self.activities[each]["produces"]}
            for x in self.activities[activity]["alternatives"][self.chosen[activity]]["consumes"]:
                certcheck.need(
                    x not in self.software or x in made, f"{activity} is started before {x} is there"
                )


def walked(graph: certcheck.Listing, controller: WalkedController) -> tuple[int, int]:
    """Walks net and controller together; the numbers of pairs and of events taken, or Refuted."""
    net = graph.net
    texts = {
        t: FORMS[net.event[t][0]].format(net.event[t][1]) + "".join(f"_{r}" for r in net.event[t][2:])
        for t in net.events
    }
    roles = {
        role: {of: places for (said, of), places in net.roles.items() if said == role}
        for role in ("objective", "active", "oos")
    }
    phases = {"before": graph.saying("begin"), **{end: graph.saying(end) for end in ENDS.values()}}
    pairs, taken = {(0, controller.first())}, 0
    todo = list(pairs)
    while todo:
        number, state = todo.pop()
        marking, here = (
            graph.stable[number],
            f"state {number} beside {state.phase} {state.section} {state.at}",
        )
        marked = {
            role: {of for of, places in known.items() if marking & places} for role, known in roles.items()
        }
        for phase, states in phases.items():
            certcheck.need((number in states) == (state.phase == phase), f"{here}: {phase}")
        running, modes = controller.shown(state)
        certcheck.need(
            marked["oos"] & controller.failing == state.gone, f"{here}: other hardware is out of service"
        )
        certcheck.need(
            marked["objective"] == running & set(roles["objective"]), f"{here}: other objectives run"
        )
        real = {f"{activity}.{way}" for activity, way in modes.items()}
        certcheck.need(marked["active"] == real & set(roles["active"]), f"{here}: other alternatives run")
        after = dict[str, int]()
        for t, target in graph.edges[number]:
            certcheck.need(
                after.setdefault(texts[t], target) == target, f"{here}: {texts[t]} has two outcomes"
            )
        moves = {event: (then, actions) for event, then, actions in controller.onward(state)}
        certcheck.need(
            moves.keys() == after.keys(), f"{here}: other events: {sorted(moves.keys() ^ after.keys())}"
        )
        for event, (then, actions) in moves.items():
            robot, last, taken = RobotModel(controller, modes), 0, taken + 1
            for section, action in actions:
                robot.take(section, action)
                several = len({section for section, _ in actions}) > 1
                certcheck.need(
                    several or ORDER.index(action["do"]) >= last, f"{here}: {event}: order of actions"
                )
                last = ORDER.index(action["do"])
            certcheck.need(
                robot.running == controller.shown(then)[1], f"{here}: {event}: other activities run after it"
            )
            certcheck.need(
                sorted(robot.released) == sorted(robot.left),
                f"{here}: {event}: not what was held is released",
            )
            pair = (after[event], then)
            if pair not in pairs:
                pairs.add(pair)
                todo.append(pair)
        graph.within(len(pairs))
    return len(pairs), taken


def main(arguments: list[str] | None = None) -> int:
    """Checks the controller that the command line names against the net of a certificate."""
    parser = argparse.ArgumentParser(
        "ctlcheck", description="Checks a controller against a certificate's net."
    )
    parser.add_argument("certificate")
    parser.add_argument("controller", help="controller.json, hierarchical or flat")
    parser.add_argument("--max-states", type=int, default=2_000_000, help="markings to keep at most")
    parser.add_argument("--seconds", type=float, default=600.0, help="time after which to give up")
    asked = parser.parse_args(arguments)
    until, code = time.monotonic() + asked.seconds, 2
    try:
        net = certcheck.Net(certcheck.parsed(certcheck.unpacked(asked.certificate), "net.json"))
        with open(asked.controller, "rb") as file:
            document = certcheck.parsed({"controller": file.read(certcheck.MOST_BYTES)}, "controller")
        if not isinstance(document, dict) or document.get("form") not in ("hierarchical", "flat"):
            raise certcheck.Malformed("expected a hierarchical or flat controller of mcpn")
        pairs, taken = walked(certcheck.Listing(net, asked.max_states, until), WalkedController(document))
        code, said = 0, f"proved       controller: {pairs} pairs of states, {taken} events between them"
    except certcheck.Refuted as error:
        code, said = 1, f"refuted      controller: {error}"
    except (certcheck.Malformed, certcheck.Limit, OSError) as error:
        said = f"not checked  controller: {error}"
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError) as error:
        said = f"not checked  controller: its document is not as mcpn writes it: {error!r}"
    sys.stdout.write(said.encode("ascii", "backslashreplace").decode().replace("\n", " ") + "\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
