"""Makes the claims of a mission: from its check, from its states, and from its FMECA."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial, reduce
from operator import or_
from typing import TYPE_CHECKING, Any, Generic, Literal

from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.kinds import KINDS
from mcpn.answers.verdicts.nominal import meant_to_be_entered
from mcpn.answers.verdicts.unreachable import targets
from mcpn.nets.events import Event, What
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.run import Run, transitions_of

if TYPE_CHECKING:
    from mcpn.answers.causes.fmeca import Row
    from mcpn.answers.requirements import RequirementAnswer
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.answers.verdicts.unreachable import Ignored
    from mcpn.drawing.compose import MissionNet

VERDICTS = {
    "can_succeed": "success_reachable",
    "can_fail": "failure_reachable",
    "can_be_aborted": "abort_reachable",
    "can_always_end": "can_always_finish",
    "can_always_end_safely": "can_always_end_safely",
    "can_always_go_on": "deadlock_free",
    "nominal_success": "nominal_success",
}
"""By kind the verdict that answers it."""

HELP = (What.DECLARED, What.TIMEOUT)
"""Events that may help, and need not happen."""
MOST_RUNNING = 60
"""Objectives up to which a formula names all that may run."""


def claims_of(check: MissionCheck) -> list[Claim]:
    """The claims that follow from a check of a mission, in the order of their kinds."""
    found = [*_of_verdicts(check), *_of_requirements(check)]
    if check.alternatives is not None:
        made = _Made(Prospects(check.mission_net, check.alternatives))
        found += made.without()
        found += made.events(check.changing_nothing)
    return _in_order(found)


def claims_of_losses(prospects: Prospects[Any], rows: Sequence[Row] = ()) -> list[Claim]:
    """The claims on losses of hardware, in the order of their kinds.

    Args:
        prospects: The mission in a space of its alternatives graph.
        rows: Its FMECA table, where there is one.
    """
    made = _Made(prospects)
    return _in_order([*made.losses(), *made.failures(rows)])


def _in_order(found: Iterable[Claim]) -> list[Claim]:
    order = {name: number for number, name in enumerate(KINDS)}
    return sorted(found, key=lambda claim: order[claim.kind])


def _of_verdicts(check: MissionCheck) -> Iterator[Claim]:
    ends = " | ".join(check.mission_net.ends)
    for kind, name in VERDICTS.items():
        if (verdict := check.verdicts.get(name)) is not None:
            reason = verdict.explanation if verdict.holds is None else ""
            formula = KINDS[kind].formula.format(ends=ends)
            if kind == "can_always_end_safely" and check.verdicts["abort_by_failure"].holds:
                formula = ""
            moment: Literal["every", "some"] = "every" if kind.startswith("can_always") else "some"
            yield Claim(kind, (), verdict.holds, Assumes(moment=moment), formula, reason)


def _of_requirements(check: MissionCheck) -> Iterator[Claim]:
    for answer in check.requirements:
        name, formula = answer.asked.name, _asked(answer)
        yield Claim("requirement", (name,), answer.met, Assumes(moment="start"), formula, answer.reason)
        for each in check.changing_nothing:
            if each.event in answer.asked.events and each.objectives:
                running = _some("objective", _plain(check.mission_net, each.objectives))
                idle = KINDS["met_as_ignored"].formula.format(
                    name, each.event, formula=formula, running=running
                )
                holds = answer.met
                yield Claim("met_as_ignored", (name, each.event), holds, formula=idle if formula else "")


def _asked(answer: RequirementAnswer) -> str:
    """What a requirement asks, as a formula of the whole mission; empty where its names are others."""
    asked = answer.asked
    if asked.requirement.fair or "." in asked.name:
        return ""
    # Of a formula on paths: not every run satisfies it. That no run does would be more.
    return asked.text if asked.requirement.expected == "holds" else f"!A({asked.text})"


def _some(word: str, names: Iterable[str]) -> str:
    return f"({' | '.join(f'{word}({name})' for name in names)})"


def _plain(mission_net: MissionNet, objectives: Iterable[str]) -> list[str]:
    """Objectives by the names that mean all copies of each."""
    copies = mission_net.graph.copies
    return list(dict.fromkeys(copies.plain(name) for name in objectives))


class _Made(Generic[S]):
    """The claims that are asked of stable states."""

    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects, self.net = prospects, prospects.mission_net
        self.space: Space[S] = prospects.space
        self.objectives = _plain(self.net, prospects.sections)
        answers = targets(self.net.mission)
        self.declared = {
            name: self.prospects.carrying(What.DECLARED, name)
            for name in (e.name for e in self.net.mission.events if not e.changes_facts)
            if self.prospects.carrying(What.DECLARED, name)
        }
        copies = self.net.graph.copies
        self.led = {
            event: _plain(self.net, (n for n in copies.objectives if blocks & set(copies.around(n))))
            for event, blocks in answers.items()
        }

    def running(self, name: str) -> S:
        """States in which some copy of an objective runs."""
        copies = self.net.graph.copies.meant(name)
        return self.space.marked(self.prospects.places("objective", copies))

    def without(self) -> Iterator[Claim]:
        """Which objectives success needs, of those that are meant to be entered."""
        space, prospects = self.space, self.prospects
        for name in _plain(self.net, meant_to_be_entered(self.net)):
            copies = self.net.graph.copies.meant(name)
            needed = frozenset[int]().union(*(prospects.carrying(What.SUCCESS, copy) for copy in copies))
            if not needed:
                continue
            hopeful = space.reaching(prospects.mission.won, transitions=prospects.everything - needed)
            formula = KINDS["succeeds_without"].formula.format(name)
            yield Claim(
                "succeeds_without", (name,), bool(hopeful & space.initial), Assumes(moment="start"), formula
            )

    # --- events ---

    def events(self, changing_nothing: Sequence[Ignored]) -> Iterator[Claim]:
        """What becomes of declared events that interrupt."""
        yield from self._changing_nothing(changing_nothing)
        for event, own in self.declared.items():
            for other, led in self.led.items():
                for name in led if other != event else ():
                    yield self._interrupts(event, own, name, other)
            for end in ("abort", "failure"):
                if end in self.net.ends:
                    yield self._ends(event, own, end)
        if self.declared:
            yield self._alternate()

    def _changing_nothing(self, found: Sequence[Ignored]) -> Iterator[Claim]:
        """Of each event where it is handled, where it leads already, and where nothing handles it."""
        idle = {each.event: each for each in found}
        few = len(self.objectives) <= MOST_RUNNING
        for event in (e.name for e in self.net.mission.events if not e.changes_facts):
            each, led = idle.get(event), self.led.get(event, ())
            if few:
                running = _some("objective", self.objectives)
                formula = KINDS["handled_always"].formula.format(event, running=running)
                yield Claim("handled_always", (event,), each is None, Assumes(moment="every"), formula)
            not_led = "".join(f" & !objective({name})" for name in led)
            ignored, answering = ((), ()) if each is None else (each.objectives, each.answering)
            for kind, names, asked in (
                ("ignored", ignored, self.objectives),
                ("answered_already", answering, led),
            ):
                so = _plain(self.net, names)
                for name in asked if few else so:
                    formula = KINDS[kind].formula.format(event, name, not_led=not_led)
                    yield Claim(kind, (event, name), name in so, formula=formula)

    def _interrupts(self, event: str, own: Collection[int], name: str, other: str) -> Claim:
        running = self.running(name)
        left = self.space.before(self.space.everything - running, own) & running
        kind = "interrupts_answer"
        return Claim(kind, (event, name, other), bool(left), formula=KINDS[kind].formula.format(event, name))

    def _ends(self, event: str, own: Collection[int], end: str) -> Claim:
        ended = self.space.marked([self.net.ends[end]])
        at_once = self.space.before(ended, own) - ended
        formula = KINDS["ends_at_once"].formula.format(event, end)
        return Claim("ends_at_once", (event, end), bool(at_once), formula=formula)

    def _alternate(self) -> Claim:
        """Whether declared events alone go on for ever, and which."""
        space, every = self.space, frozenset[int]().union(*self.declared.values())
        along = space.enabling(every)
        circling = space.staying(along, transitions=every)
        events = []
        if circling:
            events = [e for e, own in self.declared.items() if space.before(circling, own) & circling]
        formula = KINDS["alternate_for_ever"].formula.format(
            events=" | ".join(f"happens({event})" for event in self.declared)
        )
        return Claim("alternate_for_ever", (), bool(circling), formula=formula, refers_to=tuple(events))

    # --- losses ---

    def losses(self) -> Iterator[Claim]:
        """What the loss of each hardware resource alone, for good, leaves, with help and without."""
        prospects = self.prospects
        goals = [("loss_defeats", prospects.mission, "success")]
        if prospects.safety is not None:
            goals.append(("loss_endangers", prospects.safety, "(success | abort)"))
        transitions = enumerate(self.space.net.transitions)
        helping = frozenset(t for t, each in transitions if each.event and each.event.what in HELP)
        for kind, goal, words in goals:
            for hardware in filter(self._can_fail, prospects.hardware):
                aided = self._loss(kind, goal, words, hardware, frozenset())
                if helping:
                    alone = self._loss(kind, goal, words, hardware, helping)
                    helpers = (
                        self._helpers(goal, hardware, helping) if alone.holds and not aided.holds else ()
                    )
                    yield replace(alone, refers_to=helpers)
                yield aided

    def _can_fail(self, hardware: str) -> bool:
        """Whether some event takes it out of service: a crash of what nothing starts has none."""
        return bool(self.prospects.carrying(What.OUT_OF_SERVICE, hardware))

    def _loss(self, kind: str, goal: Goal[S], words: str, hardware: str, helping: frozenset[int]) -> Claim:
        space, prospects = self.space, self.prospects
        repairs = prospects.carrying(What.REPAIRED, hardware)
        lost = self._losing(goal, hardware, helping)
        formula = ""
        if not goal.ends_from:
            quiet = sorted({str(space.net.transitions[t].event) for t in helping})
            formula = KINDS[kind].formula.format(
                hardware,
                sound=self._sound(),
                wins=_wins(quiet, words),
                wins_unrepaired=_wins(quiet + [f"{hardware}_EV_RD"] * bool(repairs), words),
            )
        aid: Literal["none", "declared"] = "none" if helping else "declared"
        run = partial(self._run_to_loss, lost, hardware) if lost else None
        return Claim(kind, (hardware,), bool(lost), Assumes(aid, "others"), formula, find_run=run)

    def _losing(self, goal: Goal[S], hardware: str, helping: frozenset[int]) -> S:
        """States with all hardware in service in which a loss for good takes the last way to a goal."""
        space, prospects = self.space, self.prospects
        allowed = prospects.everything - helping
        sound = space.restricted(space.everything, (), prospects.places("oos", prospects.hardware))
        later = self._hopeful(goal, allowed - prospects.carrying(What.REPAIRED, hardware))
        fails = prospects.carrying(What.OUT_OF_SERVICE, hardware)
        return space.before(space.everything - later, fails) & sound & self._hopeful(goal, allowed)

    def _helpers(self, goal: Goal[S], hardware: str, helping: frozenset[int]) -> tuple[str, ...]:
        """The events that help on a run to a goal after a loss that takes the last way without them."""
        space, prospects = self.space, self.prospects
        lost = self._losing(goal, hardware, helping)
        after = space.after(lost, prospects.carrying(What.OUT_OF_SERVICE, hardware))
        after = after - self._hopeful(goal, prospects.everything - helping)
        steps = prospects.everything - prospects.carrying(What.REPAIRED, hardware)
        run = space.run(after.pick(), goal.won, transitions=steps) if after else None
        events = [space.net.transitions[edge.transition].event for edge in run or ()]
        told = (_event_in_words(event) for event in events if event is not None and event.what in HELP)
        return tuple(dict.fromkeys(told))

    def _run_to_loss(self, lost: S, hardware: str) -> Run | None:
        """A short run to a loss that takes the last way to a goal."""
        space, begin = self.space, self.space.initial.pick()
        edges = space.run(begin, lost)
        if edges is None:
            return None
        fails = self.prospects.carrying(What.OUT_OF_SERVICE, hardware)
        last = next(e for e in space.edges(edges[-1].target if edges else begin) if e.transition in fails)
        return Run(space.net, transitions_of([*edges, last]), settles=True)

    def _hopeful(self, goal: Goal[S], steps: frozenset[int]) -> S:
        """States from which a run of some events reaches a goal of the mission."""
        space = self.space
        if not goal.ends_from:
            return space.reaching(goal.won, transitions=steps)
        # Where some aborts are no safe ends, the others are events from the states in which they happen.
        well = {t: states for t, states in goal.ends_from.items() if t in steps}
        won = reduce(or_, well.values(), self.prospects.mission.won)
        guards = {t: space.everything - states for t, states in well.items()}
        return space.reaching(won, goal.running, steps, guards or None)

    def _sound(self) -> str:
        """That no hardware is out of service."""
        return " & ".join(f"!oos({name})" for name in self.prospects.hardware)

    def failures(self, rows: Sequence[Row]) -> Iterator[Claim]:
        """What each failure of hardware costs while each objective runs, as the FMECA says."""
        from mcpn.answers.causes.effects import Severity

        safety = self.prospects.safety
        for row in rows:
            kind, lost = "failure_loses_mission", row.severity is Severity.MISSION_LOST
            if safety is not None:
                kind, lost = "failure_loses_robot", row.severity is Severity.ROBOT_LOST
            known = safety is None or not safety.ends_from
            if not self._can_fail(row.hardware):
                continue
            formula = KINDS[kind].formula.format(row.hardware, row.objective, sound=self._sound())
            yield Claim(kind, (row.hardware, row.objective), lost, formula=formula if known else "")


def _event_in_words(event: Event) -> str:
    return event.element if event.what is What.DECLARED else f"the end of the time of {event.element}"


def _wins(left_out: Sequence[str], goal: str) -> str:
    """That some run reaches a goal without some events."""
    steps = " & ".join(f"!happens({event})" for event in left_out) or "true"
    return f"E(({steps}) U {goal})"
