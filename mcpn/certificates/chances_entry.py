"""Claims on how probable the ends of a mission are, of the entry ``further.json``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from types import MappingProxyType
from typing import Any

import numpy as np

from mcpn.answers.causes.find import Causes
from mcpn.answers.causes.interval_bounds import proved_values
from mcpn.answers.causes.sparse import Floats
from mcpn.answers.causes.whole_chain import WholeChain, whole_chain
from mcpn.certificates.entries import Claimed, EvidenceError, Trusted, entry, supported
from mcpn.certificates.furthercheck import DECIMAL, UNIT
from mcpn.certificates.moments_entry import REENTERED, MomentClaims
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import What
from mcpn.mission.static.interval_rates import interval_rates
from mcpn.spaces.markings.graph import Ints
from mcpn.spaces.stable.alternatives import AlternativesGraph

ON_DEMAND = "the states of a certificate do not say what fails on demand"
UNNOTICED = "what an objective does with hardware that is lost unnoticed is not stated"
CRASHES = "how often an activity crashes is not stated"
SENTENCE = "The mission ends in {} with a probability from {} to {}."
WITHIN = "Whatever the rates are in their intervals, the mission ends in {} with a probability from {} to {}."
SLACK = 1e-9
"""How far a number may lie outside of its interval, for solvers round; JSON prints digits beyond it, too."""
IMPORTANCE = "What resources are worth, and how often a mode is degraded.", "no kind of claim states it"


def chance_claims(
    causes: Causes,
    graph: AlternativesGraph,
    stopped: MomentClaims,
    printed: Mapping[str, float | None] = MappingProxyType({}),
) -> Iterator[Claimed | Trusted]:
    """Each as the certificate holds it, or why it is only trusted.

    Args:
        causes: What makes the mission fail.
        graph: Its listed states.
        stopped: What says which events end runs of objectives.
        printed: By end the probability that is told beside the certificate, if any.

    Raises:
        EvidenceError: One that is told lies outside of what is proved, by more than :data:`SLACK`.
        InputError: An objective that may run has no duration.
    """
    mission_net = causes.mission_net
    rounds: list[tuple[str, str, Callable[[Any], float], Callable[[Any], float]]]
    rounds = [("chance", SENTENCE, float, float)]
    if interval_rates(mission_net.core):
        rounds.append(("bounds", WITHIN, lambda rate: _side(rate, "low"), lambda rate: _side(rate, "high")))
    yield Trusted("importance", *IMPORTANCE)
    why = _unsaid(mission_net, stopped)
    ends = [end for end in ("success", "failure", "abort") if end in mission_net.ends]
    if why:
        for key, _, _, _ in rounds:
            yield from (Trusted(f"{key}: {end}", f"How probable {end} is.", why) for end in ends)
        return
    place_of = {graph.marking(state): state for state in range(graph.states)}
    for key, sentence, lower, upper in rounds:
        # Edges that no rate gives are the same in both, as an interval begins above 0.
        low, high = (whole_chain(causes.prospects.within(graph.states), number) for number in (lower, upper))
        with supported("The states of the Markov chain are those of the net."):
            states = np.array([place_of[low.markings(state)] for state in range(low.states)], np.int64)
        said = _model(mission_net, lower, upper)
        said["stopped"] = stopped.stopped(stopped.objectives)
        if not _decimal(said):
            yield from (
                Trusted(f"{key}: {end}", f"How probable {end} is.", "too many digits") for end in ends
            )
            continue
        for end in low.ends:
            try:
                vectors = _vectors(low, high, end, states, graph.states)
            except LimitError as error:
                yield Trusted(f"{key}: {end}", f"How probable {end} is.", str(error))
                continue
            first = int(states[0])
            least, most = (_parts(vectors[side][first]) for side in ("below", "above"))
            stated = {"end": end, "low": least, "high": most, **said}
            words = sentence.format(end, least, most)
            told = printed.get(end)
            if told is not None and not float(least) - SLACK <= told <= float(most) + SLACK:
                raise EvidenceError(words, f"it has computed {told:.9g}")
            yield entry(f"{key}: {end}", "chance", (end,), True, words, stated, vectors)


def _side(rate: Any, side: str) -> float:
    return float(getattr(rate, side, rate))


def _unsaid(mission_net: MissionNet, stopped: MomentClaims) -> str:
    """Why no statement gives the model of a mission; empty where one does."""
    mission = mission_net.core
    if mission.crashes:
        return CRASHES
    if any(hardware.demand_probability for hardware in mission.hardware):
        return ON_DEMAND
    if mission_net.saying("fine"):
        return UNNOTICED
    return REENTERED if any(goal.refused for goal in stopped.objectives.values()) else ""


def _vectors(low: WholeChain, high: WholeChain, end: str, states: Ints, every: int) -> dict[str, list[int]]:
    """Numbers of all listed states above and below the probability of an end, in whole parts."""
    found = dict[str, list[int]]()
    for side in ("above", "below"):
        values: Floats = proved_values(low, high, low.ends[end], up=side == "above", parts=UNIT)
        rounded = np.ceil(values * UNIT) if side == "above" else np.floor(values * UNIT)
        whole = np.zeros(every, np.int64)
        whole[states] = np.maximum(rounded, 0).astype(np.int64)
        found[side] = whole.tolist()
    return found


def _model(
    mission_net: MissionNet, lower: Callable[[Any], float], upper: Callable[[Any], float]
) -> dict[str, Any]:
    """How often what happens, as a statement says it."""
    mission, known = mission_net.core, mission_net.net.events

    def rate(value: Any) -> list[str]:
        return [_text(side(value or 0.0)) for side in (lower, upper)]

    rated = [(What.DECLARED, event.name, event.rate) for event in mission.events]
    rated += [(What.DETECTED, k, a.detection_rate) for a in mission.activities for k in a.detects]
    ending = {event.element for event in known if event.what in (What.SUCCESS, What.FAILURE)}
    return {
        "hardware": [
            {"name": h.name, "fails": rate(h.failure_rate), "repaired": rate(h.repair_rate)}
            for h in mission.hardware
            if ("oos", h.name) in mission_net.by_role
        ],
        "objectives": [
            {"name": o.name, "duration": _text(o.duration or 0.0), "failures": _failures(o.shares, o.reasons)}
            for o in mission_net.graph.walk()
            if o.name in ending
        ],
        "events": [
            {"event": [what.value, name], "rate": rate(value)}
            for (what, name), value in {(what, name): value for what, name, value in rated}.items()
            if value
        ],
    }


def _failures(shares: tuple[float, ...], reasons: tuple[tuple[str, str], ...]) -> list[list[str]]:
    names = ("", *(reason for reason, _ in reasons))
    return [[name, _text(share)] for name, share in zip(names, shares, strict=True) if share]


def _text(value: float) -> str:
    """A number as the decimal that the file says."""
    return f"{Decimal(repr(float(value))):f}"


def _parts(value: int) -> str:
    return f"{Decimal(value).scaleb(-len(str(UNIT)) + 1):f}"


def _decimal(said: Mapping[str, Any]) -> bool:
    """Whether all numbers of a model are as short as a certificate allows."""
    rates = [text for each in said["hardware"] for text in (*each["fails"], *each["repaired"])]
    rates += [text for each in said["events"] for text in each["rate"]]
    rates += [each["duration"] for each in said["objectives"]]
    rates += [share for each in said["objectives"] for _, share in each["failures"]]
    return all(DECIMAL.fullmatch(text) for text in rates)
