"""Claims on what needs help or a repair, on what leads past what makes safe, and on what a loss leaves."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Set
from functools import cached_property, partial
from typing import TYPE_CHECKING, Generic

from mcpn.answers.causes.minimal_cut_sets import help_in_words
from mcpn.answers.causes.prospects import Goal
from mcpn.answers.claims.claim import Assumes, Claim, Makers
from mcpn.answers.claims.of_check import copies_by_name, plain_names
from mcpn.answers.claims.parts import FormulaParts, some
from mcpn.answers.claims.reached import WORDS
from mcpn.answers.kinds.by_name import KINDS
from mcpn.events import HELPING, Event, What
from mcpn.spaces.algebra import S

if TYPE_CHECKING:
    from mcpn.answers.verdicts.mission import MissionCheck

MOST_WAYS = 500
"""Claims on the alternatives with which objectives run."""


class Helped(Generic[S]):
    """The claims of one mission.

    Args:
        parts: The parts of its formulas.
    """

    def __init__(self, parts: FormulaParts[S]) -> None:
        self.parts, self.prospects = parts, parts.prospects
        self.space, self.net = parts.space, parts.net

    @property
    def makers(self) -> Makers:
        """What makes those that follow from its stable states."""
        needs = ("needs_help_to_succeed", "needs_help_to_end", "needs_help_to_end_safely")
        ends = ("end_always_decides", "end_leaves_repair")
        return (
            (needs, self.needs_help),
            (("leads_past",), self._past),
            (("event_always_decides", "event_leaves_repair", *ends), self._deciding),
        )

    def needs_help(self) -> Iterator[Claim]:
        """Whether success, an end and a safe end take declared events or timeouts."""
        parts, prospects, space = self.parts, self.prospects, self.space
        alone = prospects.everything - parts.helping
        unaided = parts.reaches(prospects.mission, parts.quiet)
        needs = (self._hopeful & space.initial) - parts.reaching(prospects.mission, alone)
        yield self._claim("needs_help_to_succeed", needs, prospects.mission, moment="start", unaided=unaided)
        ended = space.marked(self.net.ends.values())
        ends = Goal(self.net.core.name, space.everything - ended, ended)
        needs = parts.reaching(ends, prospects.everything) - parts.reaching(ends, alone)
        steps = " & ".join(f"!happens({event})" for event in parts.quiet) or "true"
        unaided = f"E(({steps}) U ({parts.ends}))"
        yield self._claim("needs_help_to_end", needs, ends, ends=parts.ends, unaided=unaided)
        if prospects.safety is not None:
            goal = prospects.safety
            needs = parts.reaching(goal, prospects.everything) - parts.reaching(goal, alone)
            aided, unaided = parts.reaches(goal), parts.reaches(goal, parts.quiet)
            yield self._claim("needs_help_to_end_safely", needs, goal, aided=aided, unaided=unaided)

    def _claim(self, kind: str, needs: S, goal: Goal[S], moment: str = "some", **said: str) -> Claim:
        formula = KINDS[kind].formula.format(**said) if all(said.values()) else ""
        assumes = Assumes(moment="start") if moment == "start" else Assumes()
        helpers = self._helpers(needs, goal) if needs else ()
        return Claim(kind, (), bool(needs), assumes, formula, refers_to=helpers)

    def _helpers(self, needs: S, goal: Goal[S]) -> tuple[str, ...]:
        """The events that help on a run to a goal."""
        run = self.space.run(needs.pick(), goal.won) or []
        events = (self.space.net.transitions[edge.transition].event for edge in run)
        helping = (event for event in events if event is not None and event.what in HELPING)
        # The goal may be an event itself: of these, one that helps.
        there = run[-1].target if run else needs.pick()
        enabled = (self.space.net.transitions[edge.transition].event for edge in self.space.edges(there))
        last = (e for e in enabled if e is not None and e.what in HELPING) if goal.ends_from else ()
        return tuple(dict.fromkeys(map(help_in_words, (*helping, *last))))

    def _past(self) -> Iterator[Claim]:
        shelters = self.parts.shelters
        if not shelters or self.net.abort is None:
            return
        space, aborted = self.space, self.space.marked([self.net.abort])
        safe = space.marked(self.prospects.places("objective", shelters))
        steps = frozenset(self.parts.nominal_transitions)
        past = space.reaching(aborted, space.everything - safe, steps)
        told = bool(self.parts.nominal) and self.parts.mean_one(shelters)
        for event, own in self._declared.items():
            leads = space.before(past, own) - safe - aborted
            said = {"shelters": some("objective", shelters), "as_meant": self.parts.as_meant}
            formula = KINDS["leads_past"].formula.format(event, **said) if told else ""
            others = tuple(plain_names(self.net, shelters))
            run = partial(self.parts.run_through, leads, own, past) if leads else None
            yield Claim("leads_past", (event,), bool(leads), formula=formula, refers_to=others, find_run=run)

    @cached_property
    def _declared(self) -> Mapping[str, frozenset[int]]:
        own = {e.name: self.prospects.carrying(What.DECLARED, e.name) for e in self.net.core.events}
        return {event: transitions for event, transitions in own.items() if transitions}

    def _deciding(self) -> Iterator[Claim]:
        for event, own in self._declared.items():
            yield from self._decides("event", (event,), own, event)
        for name, copies in copies_by_name(self.net, self.prospects.sections).items():
            for word in ("failure", "timeout"):
                what = WORDS[word]
                each = (self.prospects.carrying(what, copy, reason="") for copy in copies)
                if own := frozenset[int]().union(*each):
                    yield from self._decides("end", (name, word), own, str(Event(what, name)))

    def _decides(
        self, which: str, subject: tuple[str, ...], own: Collection[int], event: str
    ) -> Iterator[Claim]:
        always = not self._losing.isdisjoint(own) and self._keeping.isdisjoint(own)
        kind = f"{which}_always_decides"
        formula = KINDS[kind].formula.format(*subject, event=event)
        yield Claim(kind, subject, always, Assumes(moment="every"), formula)
        if self.parts.repairs:
            unrepaired = self.parts.reaches(self.prospects.mission, self.parts.repairs)
            kind = f"{which}_leaves_repair"
            formula = KINDS[kind].formula.format(*subject, event=event, unrepaired=unrepaired)
            yield Claim(kind, subject, not self._leaving_repair.isdisjoint(own), formula=formula)

    @cached_property
    def _losing(self) -> Set[int]:
        """Transitions that lead from a way to success to none."""
        return self._between(self._hopeful, self.space.everything - self._hopeful)

    @cached_property
    def _keeping(self) -> Set[int]:
        """Transitions that lead from a way to success to another."""
        return self._between(self._hopeful, self._hopeful)

    @cached_property
    def _leaving_repair(self) -> Set[int]:
        """Transitions behind which only a repair leads to success, as before them it need not."""
        return self._between(self._unrepaired, self._by_repair)

    def _between(self, before: S, after: S) -> Set[int]:
        return {t for t, _ in self.space.crossing(before, after)} if before and after else set()

    @cached_property
    def _hopeful(self) -> S:
        return self.parts.reaching(self.prospects.mission, self.prospects.everything)

    @cached_property
    def _unrepaired(self) -> S:
        return self.parts.reaching(self.prospects.mission, self.prospects.unrepaired)

    @cached_property
    def _by_repair(self) -> S:
        return self._hopeful - self._unrepaired

    def losses(self) -> Iterator[Claim]:
        """What the loss of each hardware resource, not repaired, always takes, and what it leaves."""
        prospects = self.prospects
        goals = [("loss_always_defeats", prospects.mission, "success")]
        if prospects.safety is not None:
            goals.append(("loss_always_endangers", prospects.safety, "success | abort"))
        hardware = [h for h in prospects.hardware if prospects.carrying(What.OUT_OF_SERVICE, h)]
        for kind, goal, ended in goals:
            for name in hardware:
                yield self._always(kind, goal, name, ended)
        for name in hardware:
            yield from self._still(name)

    def _lasting(self, hardware: str) -> tuple[frozenset[int], list[str]]:
        """What may happen while some hardware is not repaired, and its repair."""
        repairs = self.prospects.carrying(What.REPAIRED, hardware)
        return self.prospects.everything - repairs, [f"{hardware}_EV_RD"] * bool(repairs)

    def _always(self, kind: str, goal: Goal[S], hardware: str, ended: str) -> Claim:
        space, (steps, repair) = self.space, self._lasting(hardware)
        done = space.marked([place for end, place in self.net.ends.items() if end in ended])
        # As formulas say it: also where a fault has taken it.
        lost = space.marked(self._out(hardware)) & self.prospects.begun - done
        open_ = bool(lost) and not lost & self.parts.kept_reaching(goal, steps)
        unrepaired = self.parts.reaches(goal, repair)
        formula = KINDS[kind].formula.format(hardware, ended=ended, unrepaired=unrepaired)
        return Claim(kind, (hardware,), open_, Assumes(repairs="others"), formula if unrepaired else "")

    def _out(self, hardware: str) -> list[int]:
        faults = [fault.name for fault in self.net.core.common_causes if hardware in fault.affects]
        return self.prospects.places("oos", [hardware, *faults])

    def _still(self, hardware: str) -> Iterator[Claim]:
        """Where its loss alone leaves no way to success, whether other ends stay possible."""
        space, (steps, repair) = self.space, self._lasting(hardware)
        fails, goal = self.prospects.carrying(What.OUT_OF_SERVICE, hardware), self.prospects.mission
        later = self.parts.kept_reaching(goal, steps)
        sound = self.prospects.sound & self.parts.kept_reaching(goal, self.prospects.everything)
        lost = space.before(space.everything - later, fails) & sound
        if not lost:
            return
        kind, wins = "still_possible", self.parts.reaches(goal)
        for end in (end for end in ("failure", "abort") if end in self.net.ends):
            possible = space.reaching(space.marked([self.net.ends[end]]), transitions=steps)
            none_left = space.before(space.everything - later - possible, fails) & sound
            said = " & ".join(f"!happens({event})" for event in repair) or "true"
            formula = KINDS[kind].formula.format(
                hardware,
                end,
                sound=self.parts.sound,
                wins=wins,
                wins_unrepaired=self.parts.reaches(goal, repair),
                unrepaired=f"({said})",
            )
            yield Claim(kind, (hardware, end), not none_left, Assumes(repairs="others"), formula)


def claims_of_modes(check: MissionCheck) -> Iterator[Claim]:
    """With which alternatives of its own activities each objective runs."""
    net, count = check.mission_net, 0
    activities = {section.name: section.activities for section in net.graph.walk()}
    for name, every in copies_by_name(net, check.modes).items():
        copies = [copy for copy in every if copy in check.modes]
        own = {activity: None for copy in copies for activity in activities[copy]}
        found = dict.fromkeys(
            tuple((a, mode[a]) for a in own if a in mode) for copy in copies for mode in check.modes[copy]
        )
        for ways in found:
            if not ways or (count := count + 1) > MOST_WAYS:
                continue
            with_ = " and ".join(f"{activity} by {way}" for activity, way in ways)
            said = " & ".join(f"alternative({activity})={way}" for activity, way in ways)
            yield Claim(
                "runs_with", (name, with_), True, formula=KINDS["runs_with"].formula.format(name, ways=said)
            )
