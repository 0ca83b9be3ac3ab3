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
from collections.abc import Mapping, Sequence, Set
from typing import Any, TypeAlias

from lxml import etree

from mcpn.events import START, Event, What
from mcpn.robot.runtime.controller_tables import Laws
from mcpn.robot.runtime.documents import ENDS
from mcpn.robot.targets.identifiers import comment, identifiers

NAMESPACE = "http://www.w3.org/2005/07/scxml"
Row: TypeAlias = Mapping[str, Any]
"""A JSON object of the document."""


def write_scxml(document: Row) -> dict[str, str]:
    """The file by name.

    Args:
        document: The controller's.
    """
    name = identifiers([document["mission"]])[document["mission"]].lower()
    return {f"{name}.scxml": _Document(document).text()}


def event_name(event: Event | str) -> str:
    """The name of an event in SCXML."""
    return str(event).replace(".", "-")


class Regions:
    """The identifiers of states by what they stand for.

    Args:
        document: The controller's.
    """

    def __init__(self, document: Row) -> None:
        self.hardware = identifiers(document["hardware"], prefix="hardware_")
        self.out = frozenset[str](document["out_of_service"])
        self.lasting = frozenset[str](document["unrepairable"])
        self.crashing: dict[str, list[tuple[str, str]]] = {name: [] for name in document["crashing"]}
        sections, types = document["sections"], document["types"]
        once = (own_name(s, "once", h) for s in sections for h in types[s["type"]]["once"])
        self.once = identifiers(dict.fromkeys(once), prefix="once_")
        self.late = {flag: name for name, flag in document["late"].items()}
        facts = document["facts"].values()
        of_facts = {flag for values in facts for true in values.values() for flag in true}
        self.facts = identifiers([*sorted(of_facts), *self.late], prefix="fact_")
        self.laws = Laws(document)
        self.timers = identifiers(self.laws.timeouts, prefix="timer_")
        self.ids = identifiers([s["name"] for s in sections], prefix="section_")

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
    def __init__(self, document: Row) -> None:
        super().__init__(document)
        self.document = document
        self.crashes = {str(Event(What.OUT_OF_SERVICE, name)): name for name in self.crashing}
        self.happening: dict[str, list[tuple[str, str]]] = {handler: [] for handler in self.once}
        self.turning: dict[tuple[str, str], list[dict[str, str]]] = {}

    def text(self) -> str:
        said = self.document
        root = etree.fromstring(f'<scxml xmlns="{NAMESPACE}"/>')
        for key, value in (("version", "1.0"), ("datamodel", "ecmascript"), ("initial", "controller")):
            root.set(key, value)
        root.set("name", identifiers([said["mission"]])[said["mission"]])
        controller = f"Controller of the mission {said['mission']}, {said['form']}: {said['size']}."
        root.addprevious(_comment(controller))
        root.addprevious(_comment("Generated by mcpn; do not edit."))
        whole = _add(root, "parallel", id="controller")
        mission = _add(whole, "state", id="mission", initial="before")
        before = _add(mission, "state", id="before")
        _add(before, "transition", event=event_name(START), target=self.ids[said["initial"]])
        for section in said["sections"]:
            self.section(mission, section)
        reached = {"succeed", "fail", *(route for s in said["sections"] for route in s["routes"].values())}
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
                        guarded["cond"] = f"In('{self.facts[said['late'][name]]}.on')"
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
            for declared, changes in self.document["changing"].items():
                if name in changes["true" if other == "on" else "false"]:
                    sections = self.document["sections"]
                    inside = (self.ids[s["name"]] for s in sections if declared in s["events"])
                    condition = " && ".join(f"In('{each}') === false" for each in inside)
                    guarded = {"cond": condition} if condition else {}
                    target = f"{identifier}.{other}"
                    _add(status, "transition", event=event_name(declared), **guarded, target=target)

    def turn(self, section: Row, step: Row, **when: str) -> None:
        """Notes what a move or an entry changes of facts, and when."""
        for other, changed in (("on", step["gained"]), ("off", step["lost"])):
            for flag in changed:
                self.turning.setdefault((own_name(section, "facts", flag), other), []).append(when)

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

    def section(self, parent: etree._Element, section: Row) -> None:
        machine = self.document["types"][section["type"]]
        own = self.ids[section["name"]]
        whole = _add(parent, "state", id=own, initial=f"{own}.enter")
        whole.append(_comment(f"section {section['name']}"))
        asked = [f"{self.hardware[own_name(section, 'hardware', h)]}.out" for h in machine["hardware"]]
        entering = machine["facts"][: machine["entering"]]
        asked += [f"{self.facts[own_name(section, 'facts', f)]}.on" for f in entering]
        self.choice(whole, section, f"{own}.enter", asked, machine["entries"])
        moves = iter(machine["edges"])
        move = next(moves, None)
        for number, state in enumerate(machine["states"]):
            mode = (f"{a}.{w}" for a, w in state["mode"].items())
            runs = ", ".join(own_name(section, "alternatives", pair) for pair in mode)
            objectives = ", ".join(own_name(section, "objectives", o) for o in state["objectives"])
            inside = _add(whole, "state", id=f"{own}.{number}")
            inside.append(_comment(f"objectives: {objectives}; mode: {runs}"))
            while move is not None and move["from"] == number:
                self.move(inside, section, move, f"{own}.{number}")
                move = next(moves, None)

    def move(self, inside: etree._Element, section: Row, move: Row, here: str) -> None:
        """A transition of a state, and what regions do with its event there."""
        text, to = section["events"][move["event"]], move["to"]
        event = event_name(text)
        target = f"{self.ids[section['name']]}.{to}" if isinstance(to, int) else self.route(section, to)
        condition = self.condition(section, move)
        guarded = {"cond": condition} if condition else {}
        drawn = _add(inside, "transition", event=event, **guarded, target=target)
        self.order(drawn, section, move["actions"])
        when = " && ".join(filter(None, (f"In('{here}')", condition)))
        self.turn(section, move, event=event, cond=when)
        if crashed := self.crashes.get(text):
            self.crashing[crashed].append((event, when))
        for handler in move["open"]:
            self.happening[own_name(section, "once", handler)].append((event, when))

    def condition(self, section: Row, move: Row) -> str:
        """What a move asks of handlers that happen once."""
        asked = ((part, h) for part in ("open", "happened") for h in move[part])
        return " && ".join(f"In('{self.once[own_name(section, 'once', h)]}.{part}')" for part, h in asked)

    def route(self, section: Row, outcome: str) -> str:
        """Where an outcome of a section leads."""
        target = section["routes"][outcome]
        return ENDS.get(target) or self.ids[target]

    def choice(
        self,
        parent: etree._Element,
        section: Row,
        identifier: str,
        asked: Sequence[str],
        entries: Sequence[Row | None],
    ) -> None:
        """States that lead to the entry by the states that regions are in, the last one asked first."""
        known = [entry for entry in entries if entry is not None]
        state = _add(parent, "state", id=identifier)
        if not known:  # the mission cannot come here
            return
        if all(entry == known[0] for entry in entries):
            own = f"{self.ids[section['name']]}.{known[0]['to']}"
            self.order(_add(state, "transition", target=own), section, known[0]["actions"])
            self.turn(section, known[0], cond=f"In('{identifier}')")
            return
        half = len(entries) // 2
        _add(state, "transition", cond=f"In('{asked[-1]}')", target=f"{identifier}1")
        _add(state, "transition", target=f"{identifier}0")
        self.choice(parent, section, f"{identifier}0", asked[:-1], entries[:half])
        self.choice(parent, section, f"{identifier}1", asked[:-1], entries[half:])

    def order(self, transition: etree._Element, section: Row, actions: Sequence[Row]) -> None:
        """Logs the actions of a transition."""
        for action in actions:
            log = _add(transition, "log", label=_label(action, section))
            if said := self.parameters(action, section):
                log.set("expr", said)
            if action["do"] in ("arm", "disarm"):
                name = own_name(section, "objectives", action["objective"])
                _add(transition, "raise", event=f"{action['do']}-{self.timers[name]}")

    def parameters(self, action: Row, section: Row) -> str:
        """Those in force for a selection, as a string of ECMAScript."""
        if "alternative" not in action:
            return ""
        pair = own_name(section, "alternatives", f"{action['activity']}.{action['alternative']}")
        objective = action.get("objective") and own_name(section, "objectives", action["objective"])
        activity, alternative = pair.split(".", 1)
        found = self.laws.of(activity, alternative, objective)
        if not found:
            return ""
        return json.dumps(json.dumps({p.name: {"value": p.value, "unit": p.unit} for p in found}))


def own_name(section: Row, kind: str, name: str) -> str:
    """A section's own name of what its type calls so."""
    own: str = section["names"].get(kind, {}).get(name, name)
    return own


def _add(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
    element = etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    for key, value in attributes.items():  # as keyword arguments they would be sorted
        element.set(key, value)
    return element


def _label(action: Row, section: Row) -> str:
    """An action in the section's own names."""
    verb = action["do"]
    if "hardware" in action:
        return f"{verb} {own_name(section, 'hardware', action['hardware'])}"
    if "activity" not in action:
        return f"{verb} {own_name(section, 'objectives', action['objective'])}"
    activity = action["activity"]
    own = own_name(section, "activities", activity)
    if "alternative" not in action:
        return f"{verb} {own}"
    pair = own_name(section, "alternatives", f"{activity}.{action['alternative']}")
    return f"{verb} {own} {pair.split('.', 1)[1]}"


def _comment(text: str) -> etree._Comment:
    """A comment with a blank at both ends, which may hold no two hyphens in a row."""
    return etree.Comment(f" {comment(text).replace('--', '- -').rstrip('-')} ")
