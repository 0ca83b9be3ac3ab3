"""The verdicts of a mission on decision diagrams: no marking is ever listed."""

from __future__ import annotations

from mcpn._kernel import Zdd
from mcpn.check.logic.evaluate import Evaluation
from mcpn.check.logic.formulas import EU, And, Const, Core, Deadlock, Or, negation
from mcpn.check.logic.resolve import marked
from mcpn.check.logic.witness import explain
from mcpn.check.modes import diagram_modes
from mcpn.check.properties import (
    INFORMATIVE,
    REQUIRED,
    Happened,
    MissionCheck,
    Verdict,
    explain_error,
    find_unselectable,
    told,
    verdict_of,
)
from mcpn.check.runs import Step, replay
from mcpn.errors import ConfluenceError, DivergenceError, UnsafeError
from mcpn.net.compose import MissionNet
from mcpn.space.confluence import prove_confluent
from mcpn.space.diagrams import DiagramAlternatives, DiagramMarkings
from mcpn.space.symbolic import reach


def check_by_diagrams(mission_net: MissionNet, *, max_states: int | None = None) -> MissionCheck:
    """Checks a mission symbolically: the verdicts are those of :func:`mcpn.check.properties.check_mission`.

    Args:
        mission_net: The mission's net.
        max_states: Limit on stable states where confluence must be decided edge by edge.

    Returns:
        Every verdict with its runs.

    Raises:
        LimitError: A limit was hit.
    """
    verdicts = {name: Verdict(name, None, "not known") for name in (*REQUIRED, *INFORMATIVE)}
    try:
        space = reach(mission_net.net)
    except UnsafeError as error:
        verdicts["safe"] = Verdict("safe", False, str(error), told(mission_net, error))
        return MissionCheck(mission_net, verdicts)
    verdicts["safe"] = Verdict("safe", True, "no firing puts a second token in a place")
    verdicts["bounded"] = Verdict("bounded", True, "a 1-safe net is bounded")
    graph: DiagramMarkings | DiagramAlternatives = DiagramMarkings(space)
    try:
        limits = {} if max_states is None else {"max_states": max_states}
        proof = prove_confluent(mission_net.net, space=space, **limits)
        verdicts["confluent"] = Verdict("confluent", True, proof)
        graph = DiagramAlternatives(space)
    except (ConfluenceError, DivergenceError) as error:
        found = explain_error(mission_net, error)
        verdicts["confluent"] = Verdict("confluent", False, found, told(mission_net, error))
    for verdict in _reachability(mission_net, Evaluation(graph)):
        verdicts[verdict.name] = verdict
    unselectable = find_unselectable(mission_net.usage, _happened(mission_net, graph))
    text = f"{len(unselectable)} found" if unselectable else "nothing found"
    verdicts["unselectable"] = Verdict("unselectable", bool(unselectable), text)
    modes = diagram_modes(mission_net, space.encoding, graph.everything)
    return MissionCheck(mission_net, verdicts, modes=modes, unselectable=unselectable, space=space)


def _reachability(mission_net: MissionNet, evaluation: Evaluation[Zdd]) -> list[Verdict]:
    success, failure = marked((mission_net.success,)), marked((mission_net.failure,))
    finished = Or((success, failure))
    goals: dict[str, Core] = {
        "deadlock_free": And((Deadlock(), negation(finished))),
        "success_reachable": success,
        "can_always_finish": negation(EU(Const(True), finished)),
        "failure_reachable": failure,
    }
    return [verdict_of(name, _run_to(mission_net, evaluation, goal)) for name, goal in goals.items()]


def _run_to(mission_net: MissionNet, evaluation: Evaluation[Zdd], goal: Core) -> list[Step] | None:
    formula = EU(Const(True), goal)
    if not evaluation.holds(formula):
        return None
    names = [mission_net.net.transitions[t].name for t in explain(evaluation, formula).firings]
    return replay(mission_net, names)


def _happened(mission_net: MissionNet, graph: DiagramMarkings | DiagramAlternatives) -> Happened:
    condition = graph.space.encoding.condition
    events = {mission_net.net.transitions[t].event for t, count in graph.space.fired.items() if count}
    selected, entered = (
        frozenset(
            name
            for place, name in mission_net.saying(kind).items()
            if (wanted := condition([place])) is not None and graph.everything.first([wanted]) >= 0
        )
        for kind in ("active", "objective")
    )
    return Happened(selected, entered, frozenset(event for event in events if event))
