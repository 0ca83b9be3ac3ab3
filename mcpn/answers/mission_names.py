"""What words in formulas mean of a mission: objectives, activities, resources, facts, events, progress."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from itertools import chain
from typing import NoReturn, cast

from mcpn.answers.verdicts.modes import WAITING
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.events import ENDING, START, Event, What
from mcpn.logic.formulas import Justice
from mcpn.logic.ltl.formulas import Happens
from mcpn.mission.core.copies import Copies, grouped
from mcpn.mission.fact_conditions import is_boolean, objective_done
from mcpn.mission.model import Mission, Objective, walk
from mcpn.mission.robot import BOOLEAN_VALUES
from mcpn.nets.petri import PetriNet
from mcpn.spaces.formula_names import ENDINGS, Names, known, unknown
from mcpn.spaces.search.goal import FALSE, TRUE, Fires, Formula, marked

ROLES = {
    "objective": ("objective",),
    "block": ("objective",),
    "pending": ("pending",),
    "activity": ("active",),
    "alternative": ("active",),
    "waiting": WAITING,
    "refused": ("refused",),
    "oos": ("oos",),
    "available": ("oos",),
    "fact": ("fact",),
    "done": ("fact",),
}
"""By word about an element of the mission the roles of the places that it stands for."""


class MissionNames(Names):
    """Looks names up in a mission and its net; an unknown one is an InputError that lists what is near.

    Args:
        mission_net: Names elements of the mission, places and transitions.
        within: The prefix of names in the formula's text, where that is of one use of a protocol.
        net: The net whose transitions events stand for, where it is not the mission's own.
    """

    endings = ENDINGS
    _also_places = ENDINGS

    def __init__(self, mission_net: MissionNet, within: str = "", *, net: PetriNet | None = None) -> None:
        super().__init__(mission_net.net if net is None else net)
        self.within = within
        self.mission_net = mission_net

    @cached_property
    def declared(self) -> tuple[str, ...]:
        """The events that the mission declares."""
        return tuple(event.name for event in self.mission_net.core.events)

    def place(self, name: str) -> int:
        """The index of a place; of an element of the mission the error says by which word it is named."""
        if name not in self.net.place_index:
            expected(name, self.mission_net.mission, (*self._also_places, *self.net.place_index))
        return super().place(name)

    def word(self, *said: str) -> Formula:
        """What a word about the mission means; see :meth:`mcpn.spaces.formula_names.Names.word`."""
        meaning = self._meaning(*said)
        if meaning not in (TRUE, FALSE):  # which other formulas mean as well
            self.said.setdefault(meaning, said)
        return meaning

    def _meaning(self, kind: str, name: str = "", value: str | None = None) -> Formula:
        mission_net = self.mission_net
        if value is not None and kind not in ("alternative", "waiting", "fact"):
            raise InputError.at(None, f"expected {kind}({name}) alone, found ={value} after it")
        match kind:
            case "success" | "failure" | "abort":
                about = [mission_net.core.name]
            case "objective" | "pending":
                about = self._copies.meant(name, self.within)
                if not about and self._copies.inside(name, self.within):
                    message = f"{name} holds blocks: expected block({name}), found {kind}({name})"
                    raise InputError.at(None, message)
                about = about or self._unknown(name, self._copies.objectives, "objective")
            case "block":
                about = self._copies.inside(name, self.within) or self._unknown(
                    name, self._copies.held, "block"
                )
            case "fact" | "done":
                about = [self._fact(kind, name, value)]
            case "available" if name in mission_net.usage.producer:
                return self._meaning("activity", mission_net.usage.producer[name])
            case "oos" | "available":
                software = mission_net.usage.producer if kind == "available" else ()
                known = [*(h.name for h in mission_net.core.hardware), *software]
                resource = self._element(name, known, "resource")
                about = [resource, *(f.name for f in mission_net.core.common_causes if resource in f.affects)]
            case "event":
                events = self._events(name)
                return Fires(tuple(sorted(self.net.events.of(*events))))
            case "happens":
                may = self._meaning("event", name)
                assert isinstance(may, Fires)
                return Happens(may.transitions)
            case "alternative" if value is None:
                activity, _, value = name.rpartition(".")
                if not activity:
                    message = f"expected alternative(activity)=name, found no name after {value}"
                    raise InputError.at(None, message)
                return self._meaning(kind, activity, value)
            case _:
                activity = self._element(name, mission_net.usage.activities, "activity")
                ways = [a.name for a in mission_net.usage.activities[activity].alternatives]
                if value is not None:
                    ways = [self._element(value, ways, f"alternative of {activity}")]
                about = [activity] if kind == "refused" else [f"{activity}.{way}" for way in ways]
        roles = ROLES.get(kind, (kind,))
        by_role = cast("Mapping[tuple[str, str], tuple[int, ...]]", mission_net.by_role)
        said = ((role, element) for role in roles for element in about)
        places = sorted({place for each in said for place in by_role.get(each, ())})
        return ~marked(*places) if kind == "available" else marked(*places)

    def _events(self, name: str) -> set[Event]:
        """The events that a name says: one, or that of all copies of an objective or a block."""
        known = self.net.events
        plain = name
        if name.endswith("_EV"):  # so declared events were once called
            from mcpn.robot.runtime.actions import spelled

            plain = spelled(name, self.declared)
        declared, said = Event(What.DECLARED, plain), Event.parse(name)
        if declared in known or declared.element in self.declared:
            return {declared}
        if said.what not in ENDING:
            return {
                said if said in known else Event.parse(self._element(name, sorted(map(str, known)), "event"))
            }
        objectives = self._copies.meant(said.element, self.within)
        about = objectives or self._copies.blocks(said.element, self.within)  # whose time may be over
        found = {event for each in about if (event := said.of(each)) in known}
        if objectives and said.what in (What.SUCCESS, What.FAILURE) and not said.reason:
            return found  # none of an objective that never runs
        return found or self._unknown(name, sorted(map(str, known)), "event")

    def _fact(self, kind: str, name: str, value: str | None) -> str:
        """A fact with its value, as the role of a place says it."""
        facts = self.mission_net.usage.world.facts
        if kind == "done":
            kept = [objective for fact in facts if (objective := objective_done(fact))]
            if name not in kept:
                mission = self.mission_net.mission
                texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
                every = (block for blocks in texts for block in walk(blocks))
                objectives = [block.name for block in every if isinstance(block, Objective)]
                done = known(name, dict.fromkeys([*kept, *objectives]), "objective")
                message = (
                    f"done({done}) is not kept: no route, condition or requirement of the mission reads it; "
                    f"write the formula as a requirement of the mission, or ask of happens(OBJ_{done}_EV_OK)"
                )
                raise InputError.at(None, message)
            return f"done({name})={BOOLEAN_VALUES[True]}"
        fact = facts[known(name, [known for known in facts if objective_done(known) is None], "fact")]
        if value is None and not is_boolean(fact):
            values = " or ".join(f"fact({name})={value}" for value in fact.values)
            raise InputError.at(None, f"expected {values}, found fact({name}) alone")
        said = BOOLEAN_VALUES[True] if value is None else known(value, fact.values, f"value of {name}")
        return f"{name}={said}"

    def folded(self, names: Collection[str]) -> dict[str, list[str]]:
        """Names, those of all copies of one together under the one name that means all of them."""

        def plain(name: str) -> str:
            event = Event.parse(name)
            if event.what in ENDING:
                return str(event.of(self._copies.plain(event.element)))
            return self._copies.plain(name)

        return grouped(names, plain)

    @property
    def _copies(self) -> Copies:
        return self.mission_net.graph.copies

    def _unknown(self, name: str, names: Collection[str], what: str) -> NoReturn:
        """Says which known name is near, all copies of one by one name."""
        declared = self.declared if what == "event" else ()
        unknown(name, names, what, [*dict.fromkeys([*declared, *self.folded(names)])])

    def _element(self, name: str, names: Collection[str], what: str) -> str:
        """The name of what is no block in full: what qualifies it may be left out where one name fits."""
        fitting = [known for known in names if known.endswith(f".{name}")]
        if name not in names and len(fitting) == 1:
            return fitting[0]
        if name not in names:
            self._unknown(name, names, what)
        return name


def words_of(mission: Mission) -> Iterator[tuple[str, str]]:
    """The elements of a mission by name, as declared or written, each with the word that says it.

    Args:
        mission: A mission, valid or not.
    """
    texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
    for block in (block for blocks in texts for block in walk(blocks)):
        yield block.name, f"{'objective' if isinstance(block, Objective) else 'block'}({block.name})"
    for robot in mission.robots:
        yield from ((activity.name, f"activity({activity.name})") for activity in robot.activities)
        yield from ((hardware.name, f"oos({hardware.name})") for hardware in robot.hardware)
        yield from ((software.name, f"available({software.name})") for software in robot.software)
        for fact in robot.facts:
            value = "" if is_boolean(fact) else f"={fact.values[0]}"
            yield fact.name, f"fact({fact.name}){value}"
        yield from ((event.name, f"happens({event.name})") for event in robot.events)


def expected(name: str, mission: Mission, also: Collection[str] = ()) -> NoReturn:
    """Says what is written in a formula instead of a name that stands alone there.

    Args:
        name: The name.
        mission: The mission, valid or not.
        also: What may stand alone.
    """
    by_name: dict[str, list[str]] = {}
    for element, word in words_of(mission):
        by_name.setdefault(element, []).append(word)
    words = list(dict.fromkeys(by_name.get(name.rpartition(".")[2], ())))
    if not words and Event.parse(name).what is not What.DECLARED:
        words = [f"happens({name})"]
    if words:
        said = " or ".join(word.replace(f"({name.rpartition('.')[2]})", f"({name})") for word in words)
        raise InputError.at(None, f"{name} alone says nothing: expected {said}")
    from difflib import get_close_matches

    near = next(
        (found for known in (ENDINGS, by_name, also) if (found := get_close_matches(name, known, n=1))), []
    )
    near = [word for each in near for word in by_name.get(each, [each])]
    hint = f"did you mean {' or '.join(dict.fromkeys(near))}?" if near else EXPECTED
    raise InputError.at(None, f"no word is named {name}; {hint}")


EXPECTED = "expected success, failure, abort, or a word about an element, as objective(x) or happens(x)"
"""What may stand where a name alone says nothing."""


def progress(mission_net: MissionNet) -> tuple[Justice, ...]:
    """Constraints under which a mission goes on: it starts, and running objectives end some day.

    Without it ``AF`` says nothing of a mission whose hardware may fail and recover for ever. A loop of
    objectives that is run for ever is fair: each of them ends again and again.

    Returns:
        For the start: infinitely often the mission has begun, or the start happens. For each objective:
        infinitely often it does not run, or its ``OK``, ``TIMEOUT`` or a ``FAIL`` happens.
    """
    events = mission_net.net.events
    waits = {mission_net.beginning: events.of(START)}
    for place, name in mission_net.saying("objective").items():
        waits[place] = tuple(chain.from_iterable(events.of_element(what, name) for what in ENDING))
    return tuple(Justice(~marked(place), tuple(sorted(ends))) for place, ends in waits.items())
