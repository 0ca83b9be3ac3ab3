"""Formulas as certificates hold them: nested lists, whose atoms name roles of places and events."""

from __future__ import annotations

from typing import Any

from mcpn.certificates.net_entry import event_entry
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.events import Event
from mcpn.logic.formulas import EG, EU, EX
from mcpn.logic.ltl.formulas import Happens, Next, Release, SomePath, Until
from mcpn.spaces.search.goal import And, AtMost, Deadlock, Fires, Formula, Not, Or, Stable

OPERATORS: dict[type[Formula], str] = {
    Not: "not",
    And: "and",
    Or: "or",
    EX: "EX",
    EG: "EG",
    EU: "EU",
    SomePath: "E",
    Next: "X",
    Until: "U",
    Release: "R",
    Deadlock: "deadlock",
}


def formula_entry(formula: Formula, mission_net: MissionNet) -> list[Any]:
    """A formula on the stable states of a mission.

    Raises:
        InputError: It names single transitions, which the certificate's formulas cannot.
    """
    match formula:
        case Stable():
            return ["and"]
        case AtMost(weights, bound):
            places = {place for place, _ in weights}
            said = {role for place in places if (role := mission_net.roles.get(place)) is not None}
            named = {place for role in said for place in mission_net.by_role[role]}
            if bound == 0 and named == places and all(weight > 0 for _, weight in weights):
                return ["not", ["or", *(["says", *role] for role in sorted(said))]]
            if bound == -1 and named == places and all(weight < 0 for _, weight in weights):
                says = [["says", *role] for role in sorted(said)]
                return says[0] if len(says) == 1 else ["or", *says]
            return ["at most", bound, [[*pair] for pair in weights]]
        case Fires(transitions) | Happens(transitions):
            word = "fires" if isinstance(formula, Fires) else "happens"
            return [word, *_events(transitions, mission_net)]
    return [OPERATORS[type(formula)], *(formula_entry(each, mission_net) for each in formula.operands)]


def _events(transitions: tuple[int, ...], mission_net: MissionNet) -> list[list[str]]:
    carried = mission_net.net.events.carried
    events = {carried[t] for t in transitions if t in carried}
    if set(mission_net.net.events.of(*events)) != set(transitions):
        raise InputError.at(None, "the formula names single transitions, not events")
    return [event_entry(event) for event in sorted(events, key=Event.__str__)]
