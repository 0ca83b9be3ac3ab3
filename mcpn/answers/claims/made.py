"""Makes the claims of a mission: what its check has found, what its states say, what its FMECA has."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, Literal

from mcpn.answers.causes.minimal_cut_sets import help_in_words
from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.answers.claims.asked import with_formulas
from mcpn.answers.claims.claim import Assumes, Claim, Makers, made_by
from mcpn.answers.claims.helped import Helped, claims_of_modes
from mcpn.answers.claims.of_check import claims_found, copies_by_name, led_to
from mcpn.answers.claims.of_text import claims_of_text
from mcpn.answers.claims.parts import FormulaParts
from mcpn.answers.claims.reached import Reached
from mcpn.answers.kinds.by_name import KINDS
from mcpn.answers.verdicts.nominal import meant_to_be_entered
from mcpn.events import HELPING, What
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.run import Run, transitions_of

if TYPE_CHECKING:
    from mcpn.answers.causes.fmeca import Row
    from mcpn.answers.verdicts.mission import MissionCheck


def claims_of(check: MissionCheck, kinds: Collection[str] = KINDS) -> list[Claim]:
    """The claims that follow from a check of a mission, in the order of their kinds.

    Args:
        check: What was found.
        kinds: Kinds of claims; what others need is not computed.
    """
    found = [*claims_found(check), *claims_of_text(check.mission_net.core)]
    if check.alternatives is not None:
        made = _Made(Prospects(check.mission_net, check.alternatives))
        found = [*with_formulas(found, check, made.parts, kinds)]
        makers: Makers = (
            (("runs_with",), partial(claims_of_modes, check)),
            *made.makers,
            *Reached(made.prospects).makers,
            *Helped(made.parts).makers,
        )
        found += made_by(makers, kinds)
    return in_order(claim for claim in found if claim.kind in kinds)


def claims_of_losses(prospects: Prospects[Any], rows: Sequence[Row] = ()) -> list[Claim]:
    """The claims on losses of hardware, in the order of their kinds.

    Args:
        prospects: The mission in a space of its alternatives graph.
        rows: Its FMECA table, where there is one.
    """
    made = _Made(prospects)
    return in_order([*made.losses(), *made.failures(rows), *Helped(made.parts).losses()])


def in_order(found: Iterable[Claim]) -> list[Claim]:
    """Claims in the order of their kinds."""
    order = {name: number for number, name in enumerate(KINDS)}
    return sorted(found, key=lambda claim: order[claim.kind])


class _Made(Generic[S]):
    """The claims that are asked of stable states."""

    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects, self.net = prospects, prospects.mission_net
        self.space: Space[S] = prospects.space
        self.parts = FormulaParts(prospects)
        self.led = led_to(self.net)
        self.declared = {
            name: self.prospects.carrying(What.DECLARED, name)
            for name in (e.name for e in self.net.core.events if not e.changes_facts)
            if self.prospects.carrying(What.DECLARED, name)
        }

    @property
    def makers(self) -> Makers:
        """What makes the claims that follow from stable states."""
        return (
            (("succeeds_without",), self.without),
            (("interrupts_answer", "ends_at_once", "alternate_for_ever"), self.events),
        )

    def running(self, name: str) -> S:
        """States in which some copy of an objective runs."""
        copies = self.net.graph.copies.meant(name)
        return self.space.marked(self.prospects.places("objective", copies))

    def without(self) -> Iterator[Claim]:
        """Which objectives success needs, of those that are meant to be entered."""
        carrying, needed = self.prospects.carrying, dict[str, frozenset[int]]()
        for name, copies in copies_by_name(self.net, meant_to_be_entered(self.net)).items():
            own = frozenset[int]().union(*(carrying(What.SUCCESS, copy) for copy in copies))
            needed |= {name: own} if own else {}
        reached = self.space.reaches_without(self.prospects.mission.won, list(needed.values()))
        for name, holds in zip(needed, reached, strict=True):
            formula = KINDS["succeeds_without"].formula.format(name)
            run = partial(self._run_without, needed[name]) if holds else None
            yield Claim("succeeds_without", (name,), holds, Assumes(moment="start"), formula, find_run=run)

    def _run_without(self, left_out: frozenset[int]) -> Run | None:
        """A run to success without some transitions."""
        return self.parts.run_to(self.prospects.mission.won, self.prospects.everything - left_out)

    def events(self) -> Iterator[Claim]:
        """What declared events interrupt and end, and whether they go on for ever."""
        for event, own in self.declared.items():
            for other, led in self.led.items():
                for name in led if other != event else ():
                    yield self._interrupts(event, own, name, other)
            for end in ("abort", "failure"):
                if end in self.net.ends:
                    yield self._ends(event, own, end)
        if self.declared:
            yield self._alternate()

    def _interrupts(self, event: str, own: Collection[int], name: str, other: str) -> Claim:
        running = self.running(name)
        outside = self.space.everything - running
        left = self.space.before(outside, own, among=running) & running
        kind = "interrupts_answer"
        formula = KINDS[kind].formula.format(event, name)
        run = partial(self.parts.run_through, left, own, outside) if left else None
        return Claim(kind, (event, name, other), bool(left), formula=formula, find_run=run)

    def _ends(self, event: str, own: Collection[int], end: str) -> Claim:
        ended = self.space.marked([self.net.ends[end]])
        at_once = self.space.before(ended, own) - ended
        formula = KINDS["ends_at_once"].formula.format(event, end)
        run = partial(self.parts.run_through, at_once, own, ended) if at_once else None
        return Claim("ends_at_once", (event, end), bool(at_once), formula=formula, find_run=run)

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
        lasso = partial(self._circling, circling, every) if circling else None
        others = tuple(events)
        return Claim(
            "alternate_for_ever", (), bool(circling), formula=formula, refers_to=others, find_lasso=lasso
        )

    def _circling(self, circling: S, every: Collection[int]) -> tuple[Run, int] | None:
        """A run on which declared events go on for ever, and how many events come before those that do."""
        space, begin = self.space, self.space.initial.pick()
        edges = space.run(begin, circling)
        if edges is None:
            return None
        there, before = edges[-1].target if edges else begin, len(edges)
        seen = []  # members of a space need not be hashable: of diagrams they are lists
        while there not in seen:
            seen.append(there)
            edges.append(
                next(
                    edge
                    for edge in space.edges(there)
                    if edge.transition in every and space.run(edge.target, circling) == []
                )
            )
            there = edges[-1].target
        return Run(space.net, transitions_of(edges), settles=True), before + seen.index(there)

    def losses(self) -> Iterator[Claim]:
        """What the loss of each hardware resource alone, for good, leaves, with help and without.

        That a goal stays possible is said only where it is possible from the start.
        """
        prospects = self.prospects
        goals = [("loss_defeats", prospects.mission)]
        if prospects.safety is not None:
            goals.append(("loss_endangers", prospects.safety))
        helping = self.parts.helping
        for kind, goal in goals:
            possible = self._possible(goal, frozenset())
            unaided = helping and self._possible(goal, helping)
            for hardware in filter(self._can_fail, prospects.hardware):
                aided = self._loss(kind, goal, hardware, frozenset())
                if helping:
                    alone = self._loss(kind, goal, hardware, helping)
                    helpers = (
                        self._helpers(goal, hardware, helping) if alone.holds and not aided.holds else ()
                    )
                    if alone.holds or unaided:
                        yield replace(alone, refers_to=helpers)
                if aided.holds or possible:
                    yield aided

    def _possible(self, goal: Goal[S], helping: frozenset[int]) -> bool:
        """Whether a goal is in reach without some events, from the start and from a state without losses."""
        space, prospects = self.space, self.prospects
        hopeful = self.parts.kept_reaching(goal, prospects.everything - helping)
        return bool(hopeful & space.initial) and bool(hopeful & prospects.sound)

    def _can_fail(self, hardware: str) -> bool:
        """Whether some event takes it out of service: a crash of what nothing starts has none."""
        return bool(self.prospects.carrying(What.OUT_OF_SERVICE, hardware))

    def _loss(self, kind: str, goal: Goal[S], hardware: str, helping: frozenset[int]) -> Claim:
        prospects = self.prospects
        repair = [f"{hardware}_EV_RD"] * bool(prospects.carrying(What.REPAIRED, hardware))
        lost = self._losing(goal, hardware, helping)
        quiet = self.parts.quiet if helping else []
        wins, unrepaired = self.parts.reaches(goal, quiet), self.parts.reaches(goal, quiet + repair)
        said = {"sound": self.parts.sound, "wins": wins, "wins_unrepaired": unrepaired}
        formula = KINDS[kind].formula.format(hardware, **said) if wins else ""
        aid: Literal["none", "declared"] = "none" if helping else "declared"
        run = partial(self._run_to_loss, lost, hardware) if lost else None
        return Claim(kind, (hardware,), bool(lost), Assumes(aid, "others"), formula, find_run=run)

    def _losing(self, goal: Goal[S], hardware: str, helping: frozenset[int]) -> S:
        """States with all hardware in service in which a loss for good takes the last way to a goal."""
        space, prospects = self.space, self.prospects
        allowed = prospects.everything - helping
        later = self.parts.kept_reaching(goal, allowed - prospects.carrying(What.REPAIRED, hardware))
        fails = prospects.carrying(What.OUT_OF_SERVICE, hardware)
        return (
            space.before(space.everything - later, fails)
            & prospects.sound
            & self.parts.kept_reaching(goal, allowed)
        )

    def _helpers(self, goal: Goal[S], hardware: str, helping: frozenset[int]) -> tuple[str, ...]:
        """The events that help on a run to a goal after a loss that takes the last way without them."""
        space, prospects = self.space, self.prospects
        lost = self._losing(goal, hardware, helping)
        after = space.after(lost, prospects.carrying(What.OUT_OF_SERVICE, hardware))
        repairs = prospects.carrying(What.REPAIRED, hardware)
        after = after - self.parts.kept_reaching(goal, prospects.everything - helping - repairs)
        steps = prospects.everything - repairs
        run = space.run(after.pick(), goal.won, transitions=steps) if after else None
        events = [space.net.transitions[edge.transition].event for edge in run or ()]
        told = (help_in_words(event) for event in events if event is not None and event.what in HELPING)
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

    def failures(self, rows: Sequence[Row]) -> Iterator[Claim]:
        """What each failure of hardware costs while each objective runs, as the FMECA says."""
        from mcpn.answers.causes.effects import Severity

        safety = self.prospects.safety
        wins = self.parts.reaches(self.prospects.mission if safety is None else safety)
        for row in rows:
            kind, lost = "failure_loses_mission", row.severity is Severity.MISSION_LOST
            if safety is not None:
                kind, lost = "failure_loses_robot", row.severity is Severity.ROBOT_LOST
            if not self._can_fail(row.hardware):
                continue
            said = {"sound": self.parts.sound, "wins": wins}
            formula = KINDS[kind].formula.format(row.hardware, row.objective, **said) if wins else ""
            yield Claim(kind, (row.hardware, row.objective), lost, formula=formula)


def some_run(left_out: Sequence[str], goal: str) -> str:
    """That some run reaches a goal without some events."""
    steps = " & ".join(f"!happens({event})" for event in left_out) or "true"
    return f"E(({steps}) U {goal})"
