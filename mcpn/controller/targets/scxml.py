"""The controller as SCXML (W3C Recommendation, 2015): states, events, and of a data model ``In`` alone.

One parallel state holds the mission and a region for each hardware resource that can fail. Every section has
a compound state: first a tree of choices by the hardware out of service, each an eventless transition with
``In``, then the states of its type's machine; so the size is the sum over sections. Actions are ``<log>`` in
their order, with labels like ``select localisation gps_localisation``; a selection with parameters has them
as its expression, a string that is JSON: by name ``value`` and ``unit``.

A handler that happens once has a region too, *open* and then *happened*: a move that asks for it has a
condition, and the region goes on with the same event in the same state of the section.

What may be true of a fact has a region, *off* and *on*: it changes with the event of a move that changes it,
in the same state of the section, or with the entry that does; with an event that changes facts whatever runs,
unless a section runs that has this event itself. So has hardware that is detected late: *on* while it is out
of service and the robot knows it; it is repaired only then.

An objective with a timeout has a region, *off* and *on*: what arms and disarms its timer raises an event, and
*on* sends the event that its time is over after a delay, and cancels that when it is left.

An event's name is its text with ``-`` in place of ``.``: a dot would make ``OBJ_a_EV_OK`` also match
``OBJ_a_EV_OK.b_EV_OK``. An event that cannot be taken is ignored, as the Recommendation wants it; a host that
must know asks first, or watches whether the configuration or the log changes.
"""

from __future__ import annotations

import json
from collections.abc import Sequence, Set

from lxml import etree

from mcpn.controller.hierarchy import Entry, Move, PlacedMachine, TableController
from mcpn.controller.machine import PlannedAction
from mcpn.controller.targets.json import laws
from mcpn.controller.targets.names import comment, identifiers
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.status import told_as_facts
from mcpn.mission.expansion.faults import noticed
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.nets.events import START, Event, What
from mcpn.runtime.tables import Laws

NAMESPACE = "http://www.w3.org/2005/07/scxml"
ENDS = {SUCCEED: "success", FAIL: "failure", ABORT: "abort"}


def write_scxml(controller: TableController, mission_net: MissionNet) -> dict[str, str]:
    """The file by name.

    Args:
        controller: The controller.
        mission_net: The mission's net.
    """
    name = identifiers([controller.mission])[controller.mission].lower()
    return {f"{name}.scxml": _Document(controller, mission_net).text()}


def event_name(event: Event | str) -> str:
    """The name of an event in SCXML."""
    return str(event).replace(".", "-")


class Regions:
    """The identifiers of states by what they stand for.

    Args:
        controller: The controller.
        mission_net: The mission's net.
    """

    def __init__(self, controller: TableController, mission_net: MissionNet) -> None:
        self.hardware = identifiers(controller.hardware, prefix="hardware_")
        said = mission_net.mission.hardware
        self.out = {h.name for h in said if h.initial == "oos"}
        self.lasting = {h.name for h in said if not h.repairable}
        crashes = mission_net.mission.crashes
        self.crashing: dict[str, list[tuple[str, str]]] = {crash.name: [] for crash in crashes}
        once = (s.names["once"].get(h, h) for s in controller.sections for h in controller.types[s.type].once)
        self.once = identifiers(dict.fromkeys(once), prefix="once_")
        told = told_as_facts(mission_net.statuses)
        self.late = {flag.text: flag.name for flag in told if flag.kind == "known"}
        every = sorted(flag.text for flag in told if flag.kind == "fact")
        self.facts = identifiers(
            [*every, *(flag.text for flag in told if flag.kind != "fact")], prefix="fact_"
        )
        timed = [s.name for s in mission_net.graph.timed]
        self.timers = identifiers(timed, prefix="timer_")
        self.ids = identifiers([s.name for s in controller.sections], prefix="section_")

    def active(
        self, section: tuple[str, int] | None, outcome: str | None, gone: Set[str], happened: Set[str]
    ) -> frozenset[str]:
        """The states that are active and have none inside, timers aside.

        Args:
            section: The section that runs, and the number of its state.
            outcome: How the mission has ended, if it has.
            gone: Hardware out of service.
            happened: Handlers that happen once and have, and what is true of facts.
        """
        found = {f"{self.ids[section[0]]}.{section[1]}" if section else outcome or "before"}
        for names, true, words in (
            (self.hardware, gone, ("ready", "out")),
            (self.once, happened, ("open", "happened")),
            (self.facts, happened, ("off", "on")),
        ):
            found |= {f"{identifier}.{words[name in true]}" for name, identifier in names.items()}
        return frozenset(found)


class _Document(Regions):
    def __init__(self, controller: TableController, mission_net: MissionNet) -> None:
        super().__init__(controller, mission_net)
        self.controller = controller
        self.laws = Laws(laws(mission_net))
        self.happening: dict[str, list[tuple[str, str]]] = {handler: [] for handler in self.once}
        self.world = mission_net.usage.world
        self.turning: dict[tuple[str, str], list[dict[str, str]]] = {}

    def text(self) -> str:
        c = self.controller
        root = etree.fromstring(f'<scxml xmlns="{NAMESPACE}"/>')
        for key, value in (("version", "1.0"), ("datamodel", "ecmascript"), ("initial", "controller")):
            root.set(key, value)
        root.set("name", identifiers([c.mission])[c.mission])
        root.addprevious(_comment(f"Controller of the mission {c.mission}, {c.form}: {c.size}."))
        root.addprevious(_comment("Generated by mcpn; do not edit."))
        whole = _add(root, "parallel", id="controller")
        mission = _add(whole, "state", id="mission", initial="before")
        before = _add(mission, "state", id="before")
        _add(before, "transition", event=event_name(START), target=self.ids[c.initial])
        for section in c.sections:
            self.section(mission, section)
        reached = {SUCCEED, FAIL, *(route for s in c.sections for route in s.routes.values())}
        for end in (word for route, word in ENDS.items() if route in reached):
            _add(mission, "final", id=end)
        for name, identifier in self.hardware.items():
            first = "out" if name in self.out else "ready"
            region = _add(whole, "state", id=identifier, initial=f"{identifier}.{first}")
            for state, what, other in (
                ("ready", What.OUT_OF_SERVICE, "out"),
                ("out", What.REPAIRED, "ready"),
            ):
                status = _add(region, "state", id=f"{identifier}.{state}")
                if state == "ready" and name in self.crashing:
                    for event, here in self.crashing[name]:
                        _add(status, "transition", event=event, cond=here, target=f"{identifier}.{other}")
                elif state == "ready" or name not in self.lasting:
                    event, guarded = event_name(Event(what, name)), dict[str, str]()
                    if state == "out" and name in self.late.values():
                        guarded["cond"] = f"In('{self.facts[noticed(name)]}.on')"
                    _add(status, "transition", event=event, **guarded, target=f"{identifier}.{other}")
        for name, identifier in self.once.items():
            region = _add(whole, "state", id=identifier, initial=f"{identifier}.open")
            region.append(_comment(f"handler {name}"))
            status = _add(region, "state", id=f"{identifier}.open")
            for event, condition in self.happening[name]:
                _add(status, "transition", event=event, cond=condition, target=f"{identifier}.happened")
            _add(region, "state", id=f"{identifier}.happened")
        for name, identifier in self.facts.items():
            self.fact(whole, name, identifier)
        for name, identifier in self.timers.items():
            self.timer(whole, name, identifier)
        written = etree.tostring(
            root.getroottree(), pretty_print=True, xml_declaration=True, encoding="UTF-8"
        )
        return written.decode()

    def fact(self, whole: etree._Element, name: str, identifier: str) -> None:
        """The region of what may be true of a fact, or of hardware that is detected late."""
        first = "on" if self.late.get(name) in self.out else "off"
        region = _add(whole, "state", id=identifier, initial=f"{identifier}.{first}")
        region.append(_comment(name))
        for state, other in (("off", "on"), ("on", "off")):
            status = _add(region, "state", id=f"{identifier}.{state}")
            if name in self.late and state == "on":
                if self.late[name] not in self.lasting:
                    repaired = event_name(Event(What.REPAIRED, self.late[name]))
                    _add(status, "transition", event=repaired, target=f"{identifier}.{other}")
                continue
            for said in self.turning.get((name, other), ()):
                _add(status, "transition", **said, target=f"{identifier}.{other}")
            for event, (true, false) in self.world.turning.items():
                if name in (true if other == "on" else false):
                    declared = Event(What.DECLARED, event)
                    inside = (self.ids[s.name] for s in self.controller.sections if declared in s.events)
                    condition = " && ".join(f"In('{each}') === false" for each in inside)
                    guarded = {"cond": condition} if condition else {}
                    target = f"{identifier}.{other}"
                    _add(status, "transition", event=event_name(declared), **guarded, target=target)

    def turn(self, section: PlacedMachine, step: Entry | Move, **when: str) -> None:
        """Notes what a move or an entry changes of facts, and when."""
        names = section.names["facts"]
        for other, changed in (("on", step.gained), ("off", step.lost)):
            for flag in changed:
                self.turning.setdefault((names.get(flag, flag), other), []).append(when)

    def timer(self, whole: etree._Element, name: str, identifier: str) -> None:
        """The region of an objective's timer."""
        region = _add(whole, "state", id=identifier, initial=f"{identifier}.off")
        region.append(_comment(f"timer of {name}"))
        off, on = (_add(region, "state", id=f"{identifier}.{state}") for state in ("off", "on"))
        _add(off, "transition", event=f"arm-{identifier}", target=f"{identifier}.on")
        late, delay = event_name(Event(What.TIMEOUT, name)), f"{round(1000 * self.laws.timeouts[name])}ms"
        _add(_add(on, "onentry"), "send", event=late, id=f"{identifier}.late", delay=delay)
        _add(_add(on, "onexit"), "cancel", sendid=f"{identifier}.late")
        _add(on, "transition", event=f"disarm-{identifier}", target=f"{identifier}.off")

    def section(self, parent: etree._Element, section: PlacedMachine) -> None:
        machine = self.controller.types[section.type]
        own = self.ids[section.name]
        names = section.names
        whole = _add(parent, "state", id=own, initial=f"{own}.enter")
        whole.append(_comment(f"section {section.name}"))
        asked = [f"{self.hardware[names['hardware'].get(h, h)]}.out" for h in machine.hardware]
        asked += [f"{self.facts[names['facts'].get(f, f)]}.on" for f in machine.facts[: machine.entering]]
        self.choice(whole, section, f"{own}.enter", asked, machine.entries)
        moves = iter(machine.moves)
        move = next(moves, None)
        for number, state in enumerate(machine.states):
            mode = (f"{a}.{w}" for a, w in state.mode.items())
            runs = ", ".join(names["alternatives"].get(pair, pair) for pair in mode)
            objectives = ", ".join(names["objectives"].get(o, o) for o in state.objectives)
            inside = _add(whole, "state", id=f"{own}.{number}")
            inside.append(_comment(f"objectives: {objectives}; mode: {runs}"))
            while move is not None and move.source == number:
                event = event_name(section.events[move.event])
                target = (
                    f"{own}.{move.target}"
                    if isinstance(move.target, int)
                    else self.route(section, move.target)
                )
                condition = self.condition(section, move)
                guarded = {"cond": condition} if condition else {}
                drawn = _add(inside, "transition", event=event, **guarded, target=target)
                self.order(drawn, section, move.actions)
                here = " && ".join(filter(None, (f"In('{own}.{number}')", condition)))
                self.turn(section, move, event=event, cond=here)
                happens = section.events[move.event]
                if happens.what is What.OUT_OF_SERVICE and happens.element in self.crashing:
                    self.crashing[happens.element].append((event, here))
                for handler in move.guard.open:
                    self.happening[names["once"].get(handler, handler)].append((event, here))
                move = next(moves, None)

    def condition(self, section: PlacedMachine, move: Move) -> str:
        """What a move asks of handlers that happen once."""
        asked = ((part, h) for part in ("open", "happened") for h in getattr(move.guard, part))
        own = section.names["once"]
        return " && ".join(f"In('{self.once[own.get(h, h)]}.{part}')" for part, h in asked)

    def route(self, section: PlacedMachine, outcome: str) -> str:
        target = section.routes[outcome]
        return ENDS.get(target) or self.ids[target]

    def choice(
        self,
        parent: etree._Element,
        section: PlacedMachine,
        identifier: str,
        asked: Sequence[str],
        entries: Sequence[Entry | None],
    ) -> None:
        """States that lead to the entry by the states that regions are in, the last one asked first."""
        known = [entry for entry in entries if entry is not None]
        state = _add(parent, "state", id=identifier)
        if not known:  # the mission cannot come here
            return
        if all(entry == known[0] for entry in entries):
            own = f"{self.ids[section.name]}.{known[0].target}"
            self.order(_add(state, "transition", target=own), section, known[0].actions)
            self.turn(section, known[0], cond=f"In('{identifier}')")
            return
        half = len(entries) // 2
        _add(state, "transition", cond=f"In('{asked[-1]}')", target=f"{identifier}1")
        _add(state, "transition", target=f"{identifier}0")
        self.choice(parent, section, f"{identifier}0", asked[:-1], entries[:half])
        self.choice(parent, section, f"{identifier}1", asked[:-1], entries[half:])

    def order(
        self, transition: etree._Element, section: PlacedMachine, actions: Sequence[PlannedAction]
    ) -> None:
        """Logs the actions of a transition."""
        for action in actions:
            log = _add(transition, "log", label=_label(action, section))
            if said := self.parameters(action, section):
                log.set("expr", said)
            if action.verb in ("arm", "disarm"):
                name = section.names["objectives"].get(action.objective or "", action.objective or "")
                _add(transition, "raise", event=f"{action.verb}-{self.timers[name]}")

    def parameters(self, action: PlannedAction, section: PlacedMachine) -> str:
        """Those in force for a selection, as a string of ECMAScript."""
        if action.alternative is None:
            return ""
        names = section.names
        pair = f"{action.activity}.{action.alternative}"
        activity, alternative = names["alternatives"].get(pair, pair).split(".", 1)
        objective = action.objective and names["objectives"].get(action.objective, action.objective)
        found = self.laws.of(activity, alternative, objective)
        if not found:
            return ""
        return json.dumps(json.dumps({p.name: {"value": p.value, "unit": p.unit} for p in found}))


def _add(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
    element = etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    for key, value in attributes.items():  # as keyword arguments they would be sorted
        element.set(key, value)
    return element


def _label(action: PlannedAction, section: PlacedMachine) -> str:
    """An action in the section's own names."""
    names = section.names
    if action.hardware is not None:
        return f"{action.verb} {names['hardware'].get(action.hardware, action.hardware)}"
    if action.activity is None:
        return f"{action.verb} {names['objectives'].get(action.objective or '', action.objective)}"
    activity = action.activity
    own = names["activities"].get(activity, activity)
    if action.alternative is None:
        return f"{action.verb} {own}"
    pair = f"{activity}.{action.alternative}"
    return f"{action.verb} {own} {names['alternatives'].get(pair, pair).split('.', 1)[1]}"


def _comment(text: str) -> etree._Comment:
    """A comment with a blank at both ends, which may hold no two hyphens in a row."""
    return etree.Comment(f" {comment(text).replace('--', '- -').rstrip('-')} ")
