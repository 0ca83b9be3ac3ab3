"""The verdicts of a mission, each with the run that shows it, by any engine.

Required verdicts are those that a mission must satisfy to be flown; informative ones say more. A verdict is
``None`` where an earlier one failed in a way that leaves it unknown. Only how a space is made, and with which
errors, depends on the engine; every question is asked once, of :class:`mcpn.spaces.algebra.Space`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

from mcpn.answers.spaces_by_engine import MissionSpaces, MissionSubject, spaces_of
from mcpn.answers.verdicts.modes import Mode, functioning_modes
from mcpn.answers.verdicts.nominal import NominalRuns
from mcpn.answers.verdicts.unreachable import Ignored, Never, changing_nothing, never_happens
from mcpn.answers.verdicts.unsafe_abort import abort_by_failure, without_safe_end
from mcpn.drawing.compose import MissionNet
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, Problem, SemanticsError, UnsafeError
from mcpn.events import What
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.model import SUCCEED
from mcpn.mission.static.warnings import names_of_objectives
from mcpn.notebook import Told
from mcpn.sentences import shortened
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.engine_names import EXPLICIT, LOCAL, SYMBOLIC, Asking
from mcpn.spaces.engines import SMALL, Choice, answered
from mcpn.spaces.run import Run, run_of_fewest_events, transitions_of
from mcpn.steps import Doing, step

if TYPE_CHECKING:
    from mcpn.answers.requirements import AskedRequirement, RequirementAnswer
    from mcpn.answers.undetected_losses import LateLoss

_TRY = re.compile(r"_run[0-9]+(?=[._]|$)|_try[0-9]+(?=[.]|$)")


def skipped(mission_net: MissionNet, run: Run) -> tuple[str, ...]:
    """Objectives that begin on a run and never succeed on it, in the order in which they begin.

    All tries of an objective are one, and all runs of one that recovers.
    """
    objectives, net = mission_net.saying("objective"), mission_net.net
    begun, succeeded = dict[str, None](), set[str]()
    for t in run.firings:
        begun.update(dict.fromkeys(_untried(objectives[p]) for p, _ in net.arcs(t)[1] if p in objectives))
        if (event := net.event(t)) is not None and event.what is What.SUCCESS:
            succeeded.add(_untried(event.element))
    return tuple(name for name in begun if name not in succeeded)


def _untried(name: str) -> str:
    """The name of an objective without the numbers of its tries and runs."""
    return _TRY.sub("", name)


def no_way_to_success(graph: ObjectivesGraph) -> str:
    """Why no run succeeds, where the text alone says so."""
    if any(SUCCEED in section.routes for section in graph.sections):
        return ""
    return (
        'no route of the mission leads to succeed; a block after which all is done says success="succeed", '
        "by default success leads to the next block"
    )


NOMINAL = "nominal_success"
"""Whether every run on which nothing fails succeeds, and they leave nothing out."""
REQUIRED = (
    NOMINAL,
    "safe",
    "bounded",
    "confluent",
    "deadlock_free",
    "success_reachable",
    "can_always_finish",
)
INFORMATIVE = ("failure_reachable", "unselectable")
ENDS_SAFELY, ABORT_REACHABLE = "can_always_end_safely", "abort_reachable"
"""The further required and the further informative verdict of a mission that can abort."""
UNSAFE_ABORT = "abort_by_failure"
"""The informative verdict on an abort that the failure of a safing objective leads to."""
HANDLED = "events_handled"
"""The further required verdict of a mission with events that must be handled whatever runs."""

UNDECIDED = {
    "safe": "not decided: the net is not 1-safe, so its states cannot be explored",
    "confluent": (
        "not decided: the mission is not confluent, so composition has no single state to continue from; "
        "--engine explicit or symbolic decides it"
    ),
}
"""Why nothing else is known where one of these verdicts fails and there is no space to be asked."""


HOLDS_IF_FOUND = {
    "deadlock_free": False,
    "success_reachable": True,
    "can_always_finish": False,
    ENDS_SAFELY: False,
    "failure_reachable": True,
    ABORT_REACHABLE: True,
}
"""By verdict that a run decides, whether it holds if one is found."""


@dataclass(frozen=True)
class Verdict(Told):
    """One verdict.

    Args:
        name: One of :func:`required_of` or :func:`informative_of` a mission.
        holds: The answer, or ``None`` where it is not known.
        explanation: What was found, where a claim on it does not say it.
        runs: Witness or counterexample runs, the shortest first; two where two are needed.
        skipped: Objectives that begin on the run that shows success, and never succeed on it.
        left_out: Objectives that no run enters on which nothing fails.
        cycle: Index of the event of the run with which the part begins that goes on for ever, if it does.
        kind: The kind of claim that says it, where that is not the usual one.
        given: What it takes besides, in words.
    """

    name: str
    holds: bool | None
    explanation: str = ""
    runs: tuple[Run, ...] = ()
    skipped: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    cycle: int | None = None
    kind: str = ""
    given: tuple[str, ...] = ()

    @property
    def runs_of_events(self) -> tuple[Run, ...]:
        """The runs as a designer reads them: without internal firings, each once."""
        return tuple(dict.fromkeys(run.of_events for run in self.runs))

    @property
    def required(self) -> bool:
        """Whether a mission must satisfy it."""
        return self.name in (*REQUIRED, ENDS_SAFELY, HANDLED)


def required_of(mission_net: MissionNet) -> tuple[str, ...]:
    """The verdicts that a mission must satisfy to be flown; one more where it can abort."""
    ends_safely = () if mission_net.abort is None else (ENDS_SAFELY,)
    handled = (HANDLED,) if any(event.required for event in mission_net.core.events) else ()
    return (*REQUIRED, *ends_safely, *handled)


def informative_of(mission_net: MissionNet) -> tuple[str, ...]:
    """The informative verdicts of a mission; one more where it can abort."""
    if mission_net.abort is None:
        return INFORMATIVE
    return ("failure_reachable", ABORT_REACHABLE, UNSAFE_ABORT, "unselectable")


@dataclass(frozen=True)
class MissionCheck(Told):
    """All that one check of a mission found.

    Args:
        spaces: The mission's spaces, where the check has left those that it has built.
        verdicts: By name, required ones first.
        choice: The engine that answered.
        markings: The markings graph, where the check has made it.
        alternatives: The alternatives graph, where it exists.
        stable_sizes: Stable states and event edges of the whole mission, exact; ``None`` where not known.
        modes: Functioning modes by objective.
        unselectable: What can never be selected, entered or used, with its line.
        futile: Objectives and blocks whose success leads only to failure, with their lines.
        changing_nothing: Declared events that are ignored or answered already in some state, with what runs
            then.
        late: Hardware whose loss is noticed late, with what then can only fail.
        requirements: What the mission says that it must satisfy, and whether it does.
    """

    spaces: MissionSpaces
    verdicts: dict[str, Verdict]
    choice: Choice
    markings: Space[Any] | None = None
    alternatives: Space[Any] | None = None
    stable_sizes: tuple[int, int] | None = None
    modes: dict[str, list[Mode]] = field(default_factory=dict)
    unselectable: tuple[Problem, ...] = ()
    futile: tuple[Problem, ...] = ()
    changing_nothing: tuple[Ignored, ...] = ()
    late: tuple[LateLoss, ...] = ()
    requirements: tuple[RequirementAnswer, ...] = ()

    @property
    def mission_net(self) -> MissionNet:
        """The mission's net."""
        return self.spaces.mission

    def __repr__(self) -> str:
        verdicts = ", ".join(f"{name}: {verdict.holds}" for name, verdict in self.verdicts.items())
        return f"<check of the mission {self.mission_net.core.name}: {verdicts}>"

    @cached_property
    def marking_sizes(self) -> tuple[int, int] | None:
        """Reachable markings and firings between them, exact; ``None`` where they are not known.

        Where the check has listed stable states alone they are counted when this is asked first, unless they
        are more than may be listed; composition does not see them.
        """
        if self.markings is not None or self.choice.engine != EXPLICIT:
            return self.sizes_seen
        try:
            found = self.spaces.counted(self.choice.second_limit(SMALL), tokens=False)
        except (LimitError, UnsafeError):
            return None
        return found.states, found.edges

    @cached_property
    def sizes_seen(self) -> tuple[int, int] | None:
        """States and edges of the markings graph; ``None`` where the check has not built it."""
        if self.markings is None:
            return None
        firings = self.markings.firings(self.markings.everything)
        return self.markings.everything.count(), sum(firings.values())

    @cached_property
    def warnings(self) -> list[Problem]:
        """What is suspicious in the mission, by its text and by its states, each once."""
        problems = (*self.mission_net.warnings, *self.unselectable, *self.futile)
        return list({str(problem): problem for problem in problems}.values())

    @property
    def ignored(self) -> tuple[Ignored, ...]:
        """Declared events that are ignored in some state, with what runs then."""
        return tuple(each for each in self.changing_nothing if each.objectives)

    @property
    def failing(self) -> list[str]:
        """Required verdicts that do not hold."""
        return [name for name in required_of(self.mission_net) if self.verdicts[name].holds is False]

    @property
    def undecided(self) -> dict[str, str]:
        """By verdict that is not known, the reason."""
        return {name: v.explanation for name, v in self.verdicts.items() if v.holds is None}

    @property
    def violated(self) -> list[str]:
        """Requirements of severity ``required`` that are not met."""
        return [answer.asked.name for answer in self.requirements if answer.required and answer.met is False]

    @property
    def unanswered(self) -> list[str]:
        """Requirements of severity ``required`` of which it is not known whether they are met."""
        return [answer.asked.name for answer in self.requirements if answer.required and answer.met is None]

    @property
    def passed(self) -> bool:
        """Whether every required verdict holds, and every requirement that must be met is."""
        required = required_of(self.mission_net)
        return all(self.verdicts[name].holds for name in required) and not (self.violated or self.unanswered)


def check(
    subject: MissionSubject,
    **asked: Unpack[Asking],
) -> MissionCheck:
    """Checks a mission: every verdict, with its runs.

    Args:
        subject: The mission's spaces, or its net.
        **asked: Who is asked, and within what limit.

    Raises:
        InputError: A requirement is no formula, or names what is not there, with its line.
        PremiseError: Composition cannot answer, since a section hands on more than the state of its hardware.
        LimitError: A limit was hit.

    Examples:
        >>> from mcpn.drawing.compose import compose
        >>> from mcpn.mission.model import Objective
        >>> from mcpn.testing.by_hand import activity, hw, mission, robot
        >>> film = activity("film", ("camera",))
        >>> small = mission(robot(hw("camera"), film), Objective(name="see", activities=("film",)))
        >>> found = check(compose(small))
        >>> found.passed, found.verdicts["failure_reachable"].holds
        (True, True)
    """
    spaces = spaces_of(subject, **asked)
    requirements: list[AskedRequirement] = []
    if spaces.mission.graph.requirements:  # understood before anything is explored
        from mcpn.answers.requirements import asked_of

        requirements = asked_of(spaces.mission)

    def by(choice: Choice) -> MissionCheck:
        markings: Space[Any] | None = None
        alternatives: Space[Any] | None = None
        try:
            if choice.engine == LOCAL:
                alternatives = spaces.composite()
                proof = "each type of section, and each way from one to the next, proved on its own net"
            elif choice.engine == SYMBOLIC or not spaces.net.priorities:
                # Without priorities no marking is stable.
                every = choice._replace(max_states=choice.second_limit(SMALL))
                markings = spaces.markings(every, tokens=False)
                alternatives, proof = spaces.reduced(every)
            else:
                alternatives, proof = spaces.stable(choice)
            decided = Verdict("confluent", True, proof)
        except (UnsafeError, ConfluenceError, DivergenceError) as error:
            fault: SemanticsError = error
            if choice.engine == EXPLICIT:
                markings, fault = _markings_instead(spaces, choice, error)
            decided = _broken(spaces.mission, fault)
        found = _verdicts(spaces, choice, decided, markings, alternatives)
        return replace(found, requirements=_requirements(spaces.mission, requirements, alternatives))

    return answered(by, spaces.choices("alternatives"))[0]


def _markings_instead(
    spaces: MissionSpaces, choice: Choice, error: SemanticsError
) -> tuple[Space[Any] | None, SemanticsError]:
    """The markings graph of a mission that has no alternatives graph, and the error to report.

    Returns:
        The markings graph, for the verdicts that need no outcome of events; ``None`` where there is none. The
        error: where a firing is unsafe, that of the markings graph, which has a shortest run to the firing.

    Raises:
        LimitError: There are more markings than may be listed, and another engine may be asked.
    """
    listed = choice._replace(max_states=choice.second_limit(SMALL))
    try:
        markings = spaces.markings(listed, tokens=False)
    except UnsafeError as unsafe:
        return None, unsafe
    except LimitError:
        if choice.why is not None:
            raise
        return None, error
    return markings, error


def _broken(mission_net: MissionNet, error: SemanticsError) -> Verdict:
    """The verdict that an error decides, with its runs, internal firings after the last event included."""
    name = "safe"
    if not isinstance(error, UnsafeError):
        name = "confluent"
        step(Doing.EXPLAINING)
        if isinstance(error, ConfluenceError):
            from mcpn.composite.clash_sentences import explained

            error = explained(mission_net, error)
    net, index = mission_net.net, mission_net.net.transition_index
    runs = (names for names in error.runs if all(name in index for name in names))
    shown = tuple(Run(net, tuple(index[name] for name in names), detailed=True) for names in runs)
    return Verdict(name, False, str(error), shown)


def _verdicts(
    spaces: MissionSpaces,
    choice: Choice,
    decided: Verdict,
    markings: Space[Any] | None,
    alternatives: Space[Any] | None,
) -> MissionCheck:
    """Every verdict; where one fails, the others as far as there is a space to be asked."""
    mission_net, space = spaces.mission, alternatives or markings
    known, reason = [decided], "" if space else UNDECIDED[decided.name]
    never = Never()
    firings: Mapping[int, int] = {}
    idle: tuple[Ignored, ...] = ()
    if space is not None:
        known.append(Verdict("safe", True, "no firing puts a second token in a place"))
        known.append(Verdict("bounded", True, "a 1-safe net is bounded"))
        known += _reachability(mission_net, space, settles=alternatives is not None)
        step(Doing.COUNTING)
        firings = space.firings(space.everything)
        never = never_happens(mission_net, space, firings)
        found = f"{len(never.unselectable)} found" if never.unselectable else "nothing found"
        known.append(Verdict("unselectable", bool(never.unselectable), found))
        idle = tuple(changing_nothing(mission_net, space))
        known.append(Verdict(HANDLED, not any(each.required and each.objectives for each in idle)))
        step(Doing.FINDING_MODES)
    by_name = {verdict.name: verdict for verdict in known}
    names = (*required_of(mission_net), *informative_of(mission_net))
    sizes = None if alternatives is None else (alternatives.everything.count(), sum(firings.values()))
    return MissionCheck(
        spaces=spaces,
        verdicts={name: by_name.get(name, Verdict(name, None, reason)) for name in names},
        choice=choice,
        markings=markings,
        alternatives=alternatives,
        stable_sizes=sizes,
        modes={} if space is None else functioning_modes(mission_net, space),
        unselectable=never.unselectable,
        futile=never.futile,
        changing_nothing=idle,
        late=_late(mission_net, alternatives),
    )


def _late(mission_net: MissionNet, alternatives: Space[Any] | None) -> tuple[LateLoss, ...]:
    """What losses that are noticed late cost, where some are."""
    if alternatives is None or not mission_net.core.late:
        return ()
    from mcpn.answers.undetected_losses import late_losses

    return tuple(late_losses(mission_net, alternatives))


def _requirements(
    mission_net: MissionNet, asked: Sequence[AskedRequirement], space: Space[Any] | None
) -> tuple[RequirementAnswer, ...]:
    """The answers to requirements, where there are stable states to ask."""
    if not asked:
        return ()
    from mcpn.answers.requirements import RequirementAnswer, answer_requirements

    if space is None:
        reason = "not decided: some event has several outcomes, so there are no stable states to ask"
        return tuple(RequirementAnswer(each, None, reason=reason) for each in asked)
    return tuple(answer_requirements(mission_net, asked, space))


def _reachability(mission_net: MissionNet, space: Space[S], *, settles: bool) -> Iterator[Verdict]:
    """Verdicts that a run to some states decides."""
    success, failure = space.marked([mission_net.success]), space.marked([mission_net.failure])
    finished = success | failure
    if mission_net.abort is not None:
        abort = space.marked([mission_net.abort])
        finished |= abort
    step(Doing.DECIDING, question=NOMINAL)
    nominal_runs = NominalRuns(mission_net, space, settles=settles)
    nominal = nominal_runs.decided()
    nominal_run = () if nominal.run is None else (nominal.run,)
    yield Verdict(
        NOMINAL,
        nominal.holds,
        nominal.explanation,
        nominal_run,
        left_out=nominal.left_out,
        cycle=nominal.cycle,
        kind=nominal.kind,
        given=nominal.given,
    )
    step(Doing.FINDING_STUCK)
    goals = {
        "deadlock_free": space.dead - finished,
        "success_reachable": success,
        "can_always_finish": space.everything - space.reaching(finished),
        "failure_reachable": failure,
    }
    if mission_net.abort is not None:
        goals[ENDS_SAFELY] = without_safe_end(mission_net, space)
        goals[ABORT_REACHABLE] = abort
        yield _unsafe_abort(mission_net, space, settles=settles)
    for name, goal in goals.items():
        step(Doing.DECIDING, question=name)
        if name == "success_reachable":
            yield _success(nominal_runs, goal)
            continue
        run = None
        if goal:
            run = space.run(space.initial.pick(), goal) if settles else run_of_fewest_events(space, goal)
        if run is None:
            yield Verdict(name, not HOLDS_IF_FOUND[name])
        else:
            shown = Run(space.net, transitions_of(run), settles=settles)
            yield Verdict(name, HOLDS_IF_FOUND[name], runs=(shown,))


def _unsafe_abort(mission_net: MissionNet, space: Space[S], *, settles: bool) -> Verdict:
    """Whether the mission aborts by the failure of a safing objective."""
    step(Doing.DECIDING, question=UNSAFE_ABORT)
    names, run = abort_by_failure(mission_net, space, settles=settles)
    if run is None:
        return Verdict(UNSAFE_ABORT, False, "what ends in abort by its success does not by its failure")
    told = shortened(mission_net.graph.copies.told(names, names_of_objectives(mission_net.graph)))
    return Verdict(UNSAFE_ABORT, True, f"safing objectives by whose failure it aborts: {told}", (run,))


def _success(nominal_runs: NominalRuns[S], goal: S) -> Verdict:
    """Whether the mission can succeed; nothing fails on the run that shows it if such a run succeeds."""
    mission_net, space, settles = nominal_runs.mission_net, nominal_runs.space, nominal_runs.settles
    if not goal:
        return Verdict("success_reachable", False, no_way_to_success(mission_net.graph))
    shown = nominal_runs.succeeding(goal)
    if shown is None:
        run = space.run(space.initial.pick(), goal) if settles else run_of_fewest_events(space, goal)
        assert run is not None, "the goal is reachable"
        shown = Run(space.net, transitions_of(run), settles=settles)
    return Verdict("success_reachable", True, runs=(shown,), skipped=skipped(mission_net, shown))
