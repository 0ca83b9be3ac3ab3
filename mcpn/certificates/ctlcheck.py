"""ctlcheck: walks a controller beside the net of a certificate, in every pair of states they reach together.

``python ctlcheck.py CERTIFICATE controller.json`` needs ``ctlforms.py`` and ``certcheck.py`` beside it, and
nothing else of mcpn. In each pair the same events are possible, and both say the same of hardware,
objectives, activities, facts and how the mission has ended. A model of the robot takes the actions of every
event: it only starts what is stopped, after what it consumes, only stops what runs, and releases what was
held; they lead from what ran to what runs. Hierarchical, minimised and flat controllers have tables of
states, modular ones rules on bits. The page docs/certificates.md says it in full. Exit codes are those of
``certcheck``.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Set
from typing import Any

try:
    from mcpn.certificates import certcheck, ctlforms
except ImportError:  # alone, beside the other files
    import certcheck  # type: ignore[import-not-found, no-redef]
    import ctlforms  # type: ignore[import-not-found, no-redef]

Json = Any
ASKED = {
    "disarm": {"do"},
    "stop": {"do", "activity"},
    "release": {"do", "hardware"},
    "select": {"do", "activity", "alternative"},
    "start": {"do", "activity"},
    "arm": {"do"},
}
"""By what an action does the keys that it has, but ``objective``."""
ORDER = tuple(ASKED)
ENDING = ("success", "failure", "timeout")
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
READS_OTHERWISE = re.compile(
    r"(MISSION_EV_START|.+(_EV_OOS|_EV_RD|_EV_DETECTED|_EV_DEATH|_EARLIER)|OBJ_.+_EV_(OK|FAIL|TIMEOUT)"
    r"|OBJ_.+_EV_FAIL_[A-Za-z_][A-Za-z0-9_]*)(_EV)*"
)
"""Names of declared events that are written with ``_EV`` behind them."""


class RobotModel:
    """What activities and timers do while the actions of an event are taken, one after the other.

    Args:
        controller: The controller.
        state: Where the event happens.
    """

    def __init__(self, controller: ctlforms.WalkedController, state: ctlforms.ControllerState) -> None:
        self.controller, self.activities = controller, controller.document["activities"]
        self.running, self.timed = controller.running(state), controller.timed(state)
        self.chosen = dict[str, str]()
        self.left, self.released = set[str](), list[str]()
        self.disarmed, self.named = set[str](), list[tuple[str, str | None]]()
        document = controller.document
        self.robots = {*document["all_hardware"]} - {*document["crashing"], *document["common_causes"]}
        self.stopped = set[str]()

    def held(self, activity: str, way: str) -> set[str]:
        """The hardware that an alternative uses; what stands for crashes and common causes is none."""
        return {*self.activities[activity]["alternatives"][way]["consumes"]} & self.robots

    def made(self, activities: Iterable[str]) -> set[str]:
        """What some activities produce."""
        return {x for each in activities for x in self.activities[each]["produces"]}

    def take(self, type_: ctlforms.PlacedType, action: Json) -> None:
        """Takes an action, or refutes that it may be taken."""
        do, whole = action["do"], set(action)
        certcheck.need(whole - {"objective"} == ASKED[do], f"{do} has other keys than it needs")
        activity = type_.named("activities", action.get("activity", ""))
        objective = action.get("objective") and type_.named("objectives", action["objective"])
        if do in ("arm", "disarm"):
            certcheck.need(
                (objective in self.timed) == (do == "disarm"), f"{do} {objective}: it is so already"
            )
            self.timed ^= {objective}
            self.disarmed |= {objective} if do == "disarm" else set()
        elif do == "stop":
            certcheck.need(activity in self.running, f"{activity} is stopped, and does not run")
            way = self.running.pop(activity)
            fine = self.made(self.stopped).isdisjoint(
                self.activities[activity]["alternatives"][way]["consumes"]
            )
            certcheck.need(fine, f"{activity} is stopped after what it consumes")
            self.stopped.add(activity)
            self.left |= self.held(activity, way)
        elif do == "release":
            self.released.append(type_.named("hardware", action["hardware"]))
        elif do == "select":
            certcheck.need(activity not in self.chosen, f"{activity} is selected twice")
            own = type_.named("alternatives", f"{action['activity']}.{action['alternative']}")
            self.chosen[activity] = own.split(".", 1)[1]
            if activity in self.running:
                self.left |= self.held(activity, self.running[activity])
                self.running[activity] = self.chosen[activity]
        elif do == "start":
            certcheck.need(activity not in self.running, f"{activity} is started, and runs")
            certcheck.need(activity in self.chosen, f"{activity} is started in no alternative")
            way = self.chosen[activity]
            consumed = self.activities[activity]["alternatives"][way]["consumes"]
            needed = {x for x in consumed if self.controller.producers.get(x, set()) - {activity}}
            certcheck.need(
                needed <= self.made(self.running), f"{activity} is started before what it consumes"
            )
            self.running[activity] = way
        if do in ("select", "start"):
            self.named.append((activity, objective))

    def led_to(self, then: ctlforms.ControllerState, ended: str | None) -> None:
        """Refutes the actions unless they have led to a state.

        Args:
            then: The state.
            ended: The objective or block that the event has ended; empty of events that may end any, ``None``
                of those of hardware, which end none.
        """
        controller, objectives = self.controller, self.controller.document["objectives"]
        certcheck.need(self.running == controller.running(then), "other activities run after it")
        certcheck.need(sorted(self.released) == sorted(self.left), "not what was held is released")
        certcheck.need(self.timed == controller.timed(then), "other timers run after it")
        if ended is None:
            certcheck.need(not self.disarmed, "a timer ends, though only hardware changes")
        elif self.times(ended):
            certcheck.need(ended in self.disarmed, f"the timer of {ended} goes on")
        idle = self.chosen.keys() - self.running.keys()
        certcheck.need(not idle, f"{sorted(idle)} are selected, and do not run")
        for activity, objective in self.named:
            naming = {
                o for o in controller.shown(then)["objectives"] if activity in objectives[o]["activities"]
            }
            fine = objective in naming if naming else objective is None
            certcheck.need(fine, f"{activity} is not of the objective {objective}")

    def times(self, name: str) -> bool:
        """Whether an objective or block has a timer."""
        document = self.controller.document
        each = document["objectives"].get(name) or document.get("blocks", {}).get(name)
        return each is not None and each["timeout"] is not None


def same(what: str, net: set[str], controller: Set[str]) -> None:
    """Refutes the controller unless both say the same."""
    certcheck.need(net == controller, f"other {what}: {sorted(net ^ controller)}")


def text_of(event: tuple[str, ...]) -> str:
    """How the controller's document writes an event."""
    what, element, *reason = event
    text = "_".join([FORMS[what].format(element), *reason])
    return f"{text}_EV" if what == "declared" and READS_OTHERWISE.fullmatch(text) else text


def ended_by(event: tuple[str, ...]) -> str | None:
    """The objective or block that an event ends; empty where it may end any, ``None`` of hardware."""
    what, element, *_ = event
    return None if what in ("out of service", "repaired", "detected") else element if what in ENDING else ""


def followed(
    controller: ctlforms.WalkedController,
    state: ctlforms.ControllerState,
    then: ctlforms.ControllerState,
    actions: list[ctlforms.Action],
    ended: str | None,
) -> None:
    """Lets the model of the robot take the actions of an event, in order."""
    robot, at, last = RobotModel(controller, state), "", 0
    for section, action in actions:
        verb = ORDER.index(action["do"])
        last, at = last if at == section else 0, section
        certcheck.need(verb >= last, f"{action['do']} comes too late")
        robot.take(controller.types[section], action)
        last = verb
    robot.led_to(then, ended)


class PairedWalk:
    """Net and controller, walked together.

    Args:
        graph: The states of the net.
        controller: The controller.
    """

    def __init__(self, graph: certcheck.Listing, controller: ctlforms.WalkedController) -> None:
        self.graph, self.controller, net = graph, controller, graph.net
        self.texts, self.ended = dict[int, str](), dict[str, str | None]()
        for t in net.events:
            text = self.texts[t] = text_of(net.event[t])
            self.ended[text] = ended_by(net.event[t])
        self.roles: dict[str, dict[str, int]] = {
            role: {of: places for (said, of), places in net.roles.items() if said == role}
            for role in (
                "oos",
                "known",
                "fact",
                *(role for _, those in ctlforms.SHOWN.values() for role in those),
            )
        }
        self.phases = {
            "before": graph.saying("begin"),
            **{end: graph.saying(end) for end in ctlforms.ENDS.values()},
        }

    def marked(self, number: int, role: str) -> set[str]:
        """The elements of marked places of a role."""
        marking = self.graph.stable[number]
        return {of for of, places in self.roles[role].items() if marking & places}

    def alike(self, number: int, state: ctlforms.ControllerState) -> None:
        """Refutes the controller unless the two states of a pair say the same."""
        controller = self.controller
        for phase, states in self.phases.items():
            certcheck.need((number in states) == (state.phase == phase), f"only one of both is {phase}")
        same("hardware is out of service", self.marked(number, "oos"), state.gone)
        known = {name for name in state.gone if controller.late.get(name) in state.true}
        same("hardware is known to be out of service", self.marked(number, "known"), known)
        same("facts", self.marked(number, "fact"), controller.facts(state))
        for key, names in controller.shown(state).items():
            roles = ctlforms.SHOWN[key][1]
            there = {of for role in roles for of in self.roles[role]}
            there |= names if key == "mode" else set()  # the robot runs what is running
            same(key, {of for role in roles for of in self.marked(number, role)}, names & there)

    def onward(
        self, number: int, state: ctlforms.ControllerState
    ) -> Iterator[tuple[int, ctlforms.ControllerState]]:
        """The pairs after a pair, by every event; refuted unless both have the same ones."""
        after = dict[str, int]()
        for t, target in self.graph.edges[number]:
            text = self.texts[t]
            certcheck.need(after.setdefault(text, target) == target, f"{text} has two outcomes")
        moves = {event: (then, actions) for event, then, actions in self.controller.onward(state)}
        same("events", set(after), moves.keys())
        for event, (then, actions) in moves.items():
            try:
                followed(self.controller, state, then, actions, self.ended[event])
            except certcheck.Refuted as error:
                raise certcheck.Refuted(f"{event}: {error}") from None
            yield after[event], then


def walked(graph: certcheck.Listing, controller: ctlforms.WalkedController) -> tuple[int, int]:
    """Walks net and controller together; the numbers of pairs and of events taken, or Refuted."""
    walk, pairs, taken = PairedWalk(graph, controller), {(0, controller.first())}, 0
    todo = list(pairs)
    while todo:
        number, state = todo.pop()
        try:
            walk.alike(number, state)
            for pair in walk.onward(number, state):
                taken += 1
                if pair not in pairs:
                    pairs.add(pair)
                    todo.append(pair)
        except certcheck.Refuted as error:
            here = f"{state.phase} {state.section}".strip()
            raise certcheck.Refuted(f"state {number} beside {here} {state.at}: {error}") from None
        graph.within(len(pairs))
    return len(pairs), taken


def timers_are_the_missions(net: certcheck.Net, document: Json) -> None:
    """Refutes the controller unless what has a timer in it is what the net has a timeout of."""
    of_net = {net.event[t][1] for t in net.carrying("timeout")}
    each = {**document["objectives"], **document.get("blocks", {})}
    same("timers", of_net, {name for name, one in each.items() if one["timeout"] is not None})


def use_in_core(activity: Json) -> tuple[dict[str, list[str]], list[str]]:
    """What the alternatives of an activity of a core mission consume, and what it produces."""
    ways = {way["name"]: sorted(way["consumes"]) for way in activity["alternatives"]}
    return ways, sorted(activity["produces"])


def same_use(name: str, in_core: tuple[dict[str, list[str]], list[str]], activity: Json) -> None:
    """Refutes the controller unless an activity in it uses and produces what it does in the core mission."""
    ways = {way: sorted(one["consumes"]) for way, one in activity["alternatives"].items()}
    fine = (ways, sorted(activity["produces"])) == in_core
    certcheck.need(fine, f"the activity {name} uses or produces something else")


def robot_is_the_missions(core: Json, document: Json) -> None:
    """Refutes the controller unless what its activities use and make is what the core mission says."""
    try:
        hardware, activities = core["robot"]["hardware"], core["robot"]["activities"]
        crash = {each["name"] for each in hardware if each["crash"] and each["faulty"]}
        used = {each["name"]: use_in_core(each) for each in activities}
    except (LookupError, TypeError, AttributeError) as error:
        raise certcheck.Malformed(f"core.json: no core mission: {error!r}") from error
    same("hardware fails only as it is used", crash, set(document["crashing"]))
    for name in document["activities"].keys() & used.keys():  # no other one ever runs
        same_use(name, used[name], document["activities"][name])


def document_at(path: str) -> Json:
    """A controller's document; unlike in certificates times may have fractions."""
    try:
        with open(path, "rb") as file:
            text = file.read(certcheck.MOST_BYTES + 1)
    except OSError as error:
        raise certcheck.Malformed(str(error)) from error
    certcheck.need(len(text) <= certcheck.MOST_BYTES, f"{path} is too long", certcheck.Limit)
    document = certcheck.parsed({"controller": text}, "controller", float)
    if not isinstance(document, dict) or document.get("form") not in ("hierarchical", "flat", "modular"):
        raise certcheck.Malformed("expected a controller of mcpn")
    return document


def reported(controller: str, walk: Callable[[Json], str]) -> certcheck.Report:
    """What a walk of the document at a path shows; raises Malformed where mcpn would not write it so."""
    document = document_at(controller)
    try:
        return [("proved", "controller", walk(document))]
    except certcheck.Refuted as error:
        return [("refuted", "controller", str(error))]
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise certcheck.Malformed(
            f"{controller}: the document is not as mcpn writes it: {error!r}"
        ) from error


def checked(
    certificate: str, controller: str, *, most: int = 2_000_000, seconds: float = 600
) -> certcheck.Report:
    """Checks a controller against the net of a certificate; raises Malformed and Limit as certcheck does."""
    until = time.monotonic() + seconds
    entries = certcheck.unpacked(certificate)
    net = certcheck.Net(certcheck.parsed(entries, "net.json"))
    core = certcheck.parsed(entries, "core.json") if "core.json" in entries else None

    def walk(document: Json) -> str:
        read = ctlforms.WalkedController(document)
        timers_are_the_missions(net, document)
        if core is not None:
            robot_is_the_missions(core, document)
        pairs, taken = walked(certcheck.Listing(net, most, until), read)
        return f"{pairs} pairs of states, {taken} events between them"

    return reported(controller, walk)


def main(arguments: list[str] | None = None) -> int:
    """Checks the controller that the command line names against the net of a certificate."""
    words = "Checks a controller of any form against a certificate's net."
    return certcheck.ran(checked, words, arguments, "certificate", "controller")


if __name__ == "__main__":
    sys.exit(main())
