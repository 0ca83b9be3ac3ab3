"""Failure modes, effects and criticality: a row for each hardware resource and objective that it touches.

Every entry is read from a space of states: all edges at which the resource goes out of service while the
objective runs, however the mission has come there, also after repairs and after objectives that failed by
themselves. A row says the worst that the failure does when all other hardware is in service, and with which
other hardware out of service it does worse.

Source: the columns are those of IEC 60812 (FMEA and FMECA), reduced to what a mission says.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress, islice
from typing import Generic, NamedTuple, TypeAlias

from mcpn.answers.causes.effects import (
    Case,
    Cell,
    Column,
    Loss,
    Severity,
    Told,
    changes,
    each_once,
    in_words,
    local_effect,
    worth_telling,
)
from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.answers.verdicts.modes import Situation, said_by
from mcpn.drawing.templates import Role
from mcpn.events import What
from mcpn.mission.core.objectives_graph import Branch, ElementarySection, ParallelSection
from mcpn.mission.core.routes import GO_ON
from mcpn.spaces.algebra import Alike, S, Space
from mcpn.spaces.projections import ImageStore
from mcpn.steps import Doing, step

Others: TypeAlias = tuple[str, ...]
"""Other hardware that is out of service already, sorted."""


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Args:
        hardware: What fails.
        objective: The elementary objective that runs.
        section: The section of the mission's graph that it belongs to: itself, or its parallel block.
        columns: By column the claims in its cell.
        severity: The worst with all other hardware in service, however the mission has come there.
        with_others: Worse severities, each with the minimal sets of other hardware that must be out already.
    """

    hardware: str
    objective: str
    section: str
    columns: Mapping[str, Column]
    severity: Severity
    with_others: tuple[tuple[Severity, tuple[Others, ...]], ...]

    @property
    def cells(self) -> Iterator[Cell]:
        """The claims in all cells, each once."""
        columns = self.columns.values()
        return iter(dict.fromkeys(cell for column in columns for told in column for cell in told))

    @property
    def local_effect(self) -> str:
        """What changes in the functioning mode."""
        return in_words(self.columns["local_effect"])

    @property
    def objective_effect(self) -> str:
        """What it means for the objective."""
        return in_words(self.columns["objective_effect"])

    @property
    def mission_effect(self) -> str:
        """What it means for the mission."""
        return in_words(self.columns["mission_effect"])

    @property
    def detection(self) -> str:
        """Where the failure is seen."""
        return in_words(self.columns["detection"])

    @property
    def compensation(self) -> str:
        """What replaces it, or where the objective's failure leads."""
        return in_words(self.columns["compensation"])

    @property
    def recovery(self) -> str:
        """What happens when the resource is ready again while the objective still runs."""
        return in_words(self.columns["recovery"])

    @property
    def worst(self) -> Severity:
        """The severity in the worst company."""
        return max((self.severity, *(severity for severity, _ in self.with_others)))


def fmeca(prospects: Prospects[S], objectives: Collection[str] | None = None) -> list[Row]:
    """The table of a mission.

    Args:
        prospects: The mission in a space of its alternatives graph.
        objectives: Those to look at; all by default.

    Returns:
        A row for each resource that may fail and each objective that may run, in the mission's order of
        hardware, then of objectives; also where the failure has no effect, so that no pair is missing.

    Raises:
        LimitError: An event may end a block and enter it again, or lead to the beginning of a branch in it.
    """
    return list(_Table(prospects).rows(objectives))


class _Facts(NamedTuple):
    """What a failure does while an objective runs, before it is put in words.

    Args:
        cases: What it does when all other hardware is in service, the worst first.
        severity: The worst of it.
        with_others: Worse severities, each with the minimal sets of other hardware that must be out already.
    """

    cases: Sequence[Case]
    severity: Severity
    with_others: tuple[tuple[Severity, tuple[Others, ...]], ...]

    def named(self, names: Mapping[str, str]) -> _Facts:
        """A copy with other names of objectives."""
        cases = [
            replace(case, elsewhere=tuple((names[name], told) for name, told in case.elsewhere))
            if case.elsewhere
            else case
            for case in self.cases
        ]
        return self._replace(cases=cases)


class _Table(Generic[S]):
    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects = prospects
        self.space: Space[S] = prospects.space
        self.net = prospects.mission_net
        goals = [goal for goal in (prospects.mission, prospects.safety) if goal is not None]
        # As the fields of Loss: of success, then of safety where the mission can abort.
        self.lost = [prospects.losing(g, repairs=r) for g in goals for r in (False, True)]
        self.oos = prospects.places("oos", prospects.hardware)
        self.some_out = self.space.marked(self.oos)
        self.images = ImageStore(len(self.oos))
        self.around: dict[str, list[tuple[ParallelSection, Branch]]] = {n: [] for n in prospects.sections}
        self.sections = dict(prospects.sections)
        for block in self.net.graph.all_sections():
            if isinstance(block, ParallelSection):
                for branch in block.branches:
                    for inner in branch.graph.walk():
                        self.around[inner.name].append((block, branch))
                for pause_graph in block.pause_graphs:
                    pause_exits = {GO_ON: block.name, **dict(block.pause_exits)}
                    for here in pause_graph.graph.sections:
                        if isinstance(here, ElementarySection):
                            to = pause_exits.get(here.failure, here.failure)
                            reasons = tuple((why, pause_exits.get(at, at)) for why, at in here.reasons)
                            self.sections[here.name] = replace(here, failure=to, reasons=reasons)
        self._modes: dict[str, dict[int, S]] = {}
        self._facts: Alike[_Facts | None] = Alike()
        self._lost_by_section = [
            {prospects.ending_in(piece): piece.kind for piece in self.space.pieces(region)}
            for region in self.lost
        ]

    def rows(self, objectives: Collection[str] | None) -> Iterator[Row]:
        for hardware in self.prospects.hardware:
            for name, goal in self.prospects.objectives.items():
                if goal.running and (objectives is None or name in objectives):
                    step(Doing.FINDING_EFFECTS, hardware=hardware, objective=name)
                    facts = self.facts(hardware, goal)
                    if facts is not None:
                        yield self.row(hardware, goal, facts)

    def facts(self, hardware: str, goal: Goal[S]) -> _Facts | None:
        """What a failure does while an objective runs; found once for rounds that are equal.

        Two objectives have equal facts if their sections have one type and the mission is lost in the same
        states of both: a failure of hardware leaves no section, so that no other section matters.
        """
        alike = self.prospects.alike(goal)
        if alike is None:
            return self.facts_of(hardware, goal)
        kind, own = alike
        key = hardware, kind, *(lost.get(own) for lost in self._lost_by_section)
        found, names = self._facts.known(key, own, lambda: self.facts_of(hardware, goal))
        return None if found is None else found.named(names)

    def facts_of(self, hardware: str, goal: Goal[S]) -> _Facts | None:
        transitions = sorted(self.prospects.carrying(What.OUT_OF_SERVICE, hardware))
        edges = {t: self.severities(t, goal) for t in transitions}
        if not any(edges.values()):
            return None
        # Other hardware may have been repaired by now: cases with all of it in service are always possible.
        cases = worth_telling([case for t in edges for case in self.cases(t, edges[t], hardware, goal)])
        severity = max((case.severity for case in cases), default=Severity.NO_EFFECT)
        return _Facts(cases, severity, tuple(self.with_others(list(edges.values()), severity)))

    def row(self, hardware: str, goal: Goal[S], facts: _Facts) -> Row:
        cases = facts.cases
        section, around = self.sections[goal.name], self.around[goal.name]
        return Row(
            hardware,
            goal.name,
            around[0][0].name if around else goal.name,
            {
                "local_effect": local_effect(cases),
                "objective_effect": each_once(case.objective_effect() for case in cases),
                "mission_effect": each_once(case.mission_effect() for case in cases),
                "detection": each_once(case.detection(self.net.usage, hardware) for case in cases),
                "compensation": each_once(case.compensation(section, around) for case in cases),
                "recovery": each_once(case.recovery(self.net.usage, hardware) for case in cases),
            },
            facts.severity,
            facts.with_others,
        )

    def severities(self, transition: int, goal: Goal[S]) -> dict[Severity, S]:
        """The states before the failure, by severity: that of the worst losing region that it enters."""
        found: dict[Severity, S] = {}
        left = self.space.enabling([transition]) & goal.running
        regions = [self.prospects.losing(goal, repairs=False), *self.lost]
        for number, region in reversed(list(enumerate(regions))):
            severity = Severity(Severity.OBJECTIVE_LOST + number)
            if left and region:
                found[severity] = (self.leading(region, [transition]) & left) - region
                left = left - found[severity]
        changed = self.space.nothing
        for states in self.modes(goal).values() if left else ():
            changed = changed | self.changing(states, transition, left)
        found |= {Severity.DEGRADED: changed, Severity.NO_EFFECT: left - changed}
        return {severity: states for severity, states in found.items() if states}

    def leading(self, states: S, *steps: Collection[int]) -> S:
        """The preimage of some states under steps, each an edge of some transitions."""
        for transitions in reversed(steps):
            states = self.space.before(states, transitions) if states else states
        return states

    def changing(self, states: S, transition: int, before: S) -> S:
        """The states of ``before`` from which an edge leads into or out of ``states``."""
        kept = self.leading(states, [transition])
        return ((states - kept) | (kept - states)) & before

    def modes(self, goal: Goal[S]) -> dict[int, S]:
        """The mode of an objective: by place of an activity that serves it, the states in which it serves.

        An activity serves an objective that starts it, or that another serves by an alternative which
        consumes what this one produces. A branch beside the objective may keep it running without that.
        """
        if goal.name not in self._modes:
            self._modes[goal.name] = self._mode_of(goal)
        return self._modes[goal.name]

    def _mode_of(self, goal: Goal[S]) -> dict[int, S]:
        space, by_role, usage = self.space, self.net.by_role, self.net.usage
        activities, varying = self.prospects.sections[goal.name].activities, set(space.varying(goal.running))
        serves = {a: space.nothing for started in activities for a in usage.closure(started)}
        serves |= dict.fromkeys(activities, goal.running)
        found: dict[int, S] = {}
        for name in filter(serves.__contains__, reversed(list(usage.suppliers_first()))):
            states = serves[name]
            roles: list[tuple[Role, tuple[str, ...]]] = [(("refused", name), ())]
            for way in usage.activities[name].alternatives:
                started_as = f"{name}.{way.name}"
                roles += [(("active", started_as), way.consumes), (("wait", started_as), way.consumes)]
                roles.append((("want", started_as), ()))  # it holds nothing yet
            for role, consumes in roles:
                for place in varying.intersection(by_role.get(role, ())):
                    marked = space.restricted(states, [place], ()) if states else states
                    if marked:
                        found[place] = marked
                        for producer in {producing for r in consumes if (producing := usage.producer.get(r))}:
                            serves[producer] = serves[producer] | marked
        return dict(sorted(found.items()))

    def with_others(
        self, edges: Sequence[Mapping[Severity, S]], alone: Severity
    ) -> Iterator[tuple[Severity, tuple[Others, ...]]]:
        """Severities beyond the one alone, with the minimal sets of hardware that bring them about.

        A set with which one of two severities may come is listed with the worse alone.
        """
        found, worse = list[tuple[Severity, tuple[Others, ...]]](), self.images.nothing
        for severity in reversed(range(alone + 1, len(Severity))):
            family = self.images.nothing
            for states in (
                by_severity[Severity(severity)] for by_severity in edges if severity in by_severity
            ):
                family |= self.space.image(states, self.oos, self.images)
            only = set(self.images.minimal(family - worse))
            least = only.intersection(self.images.minimal(family))
            worse |= family
            if least:
                names = [tuple(sorted(self.prospects.hardware[h] for h in s)) for s in least]
                found.append((Severity(severity), tuple(sorted(names, key=lambda n: (len(n), n)))))
        return reversed(found)

    def cases(
        self, transition: int, severities: Mapping[Severity, S], hardware: str, goal: Goal[S]
    ) -> Iterator[Case]:
        """The different things that a failure does when all other hardware is in service."""
        for severity in sorted(severities, reverse=True):
            states = severities[severity] - self.some_out
            if states and severity:
                yield from self.distinct(severity, states, transition, hardware, goal)
            elif states:
                yield replace(
                    self.without_effect(states, goal), found=self.found(states, transition, hardware)
                )

    def found(self, states: S, transition: int, hardware: str) -> bool:
        """Whether the late detection of a failure may be the next event after it."""
        finding = self.prospects.carrying(What.DETECTED, hardware)
        return bool(finding) and bool(states & self.leading(self.space.enabling(finding), [transition]))

    def without_effect(self, states: S, goal: Goal[S]) -> Case:
        """That nothing changes, as seen in the states with the best prospects."""
        idle, hopeful = Situation(), states - self.prospects.losing(goal, repairs=False)
        best = hopeful or states
        for region in self.lost:
            best = best - region or best
        loss = Loss(*(not best - region for region in self.lost))
        return Case(Severity.NO_EFFECT, idle, idle, idle, not hopeful, not hopeful, loss)

    def distinct(
        self, severity: Severity, states: S, transition: int, hardware: str, goal: Goal[S]
    ) -> Iterator[Case]:
        """The cases of a failure: states before it by how it changes the objective's mode and prospects."""
        lost, modes = self.prospects.losing(goal, repairs=False), self.modes(goal)
        fails, repairs = [transition], self.prospects.carrying(What.REPAIRED, hardware)
        repaired = self.leading(self.space.enabling(repairs), fails) if repairs else self.space.nothing
        changed = [p for p, marked in modes.items() if self.changing(marked, transition, states)]
        ways: tuple[tuple[Collection[int], ...], ...] = (), (fails,), (fails, repairs)
        asked = [
            lost,
            repaired,
            *(self.leading(region, fails) for region in (lost, *self.lost)),
            *(self.leading(region, fails, repairs) for region in (lost, *self.lost[::2])),
            *(self.leading(modes[p], *steps) for steps in ways for p in changed),
        ]
        for said, those in _atoms(states, asked):
            answers = iter(said)  # in the order of what is asked
            already, comes_back = next(answers), next(answers)
            gone, loss = next(answers), Loss(*islice(answers, len(self.lost)))
            still_gone, still = next(answers), list(islice(answers, len(self.lost[::2])))
            before, after, back = (
                said_by(self.net, compress(changed, list(islice(answers, len(changed))))) for _ in ways
            )
            mission, *safety = (bool(was) and not now for was, now in zip(loss[::2], still, strict=False))
            # Where no repair is possible the preimage of each region is empty: nothing is regained there.
            objective = comes_back and gone and not still_gone
            mission, safe = comes_back and mission, comes_back and any(safety)
            elsewhere = self.elsewhere(those, transition, goal.name) if before == after else ()
            found = self.found(those, transition, hardware)
            prospects = already, gone, loss, objective, mission, safe
            yield Case(severity, before, after, back, *prospects, elsewhere, found, comes_back)

    def elsewhere(self, states: S, transition: int, name: str) -> tuple[tuple[str, Told], ...]:
        """By objective in another branch of the blocks around, what a failure changes in its mode."""
        found = dict[tuple[str, Told], None]()
        branches = (b for block, branch in self.around[name] for b in block.branches if b != branch)
        for other in (inner.name for branch in branches for inner in branch.graph.walk()):
            goal = self.prospects.objectives[other]
            there = states & goal.running
            modes = self.modes(goal) if there else {}
            changed = [p for p, marked in modes.items() if self.changing(marked, transition, there)]
            asked = [modes[p] for p in changed]
            asked += [self.leading(modes[p], [transition]) for p in changed]
            for answers, _ in _atoms(there, asked):
                if changed and (after := answers[len(changed) :]) != answers[: len(changed)]:
                    was, now = compress(changed, answers), compress(changed, after)
                    found[other, changes(said_by(self.net, was), said_by(self.net, now))] = None
        return tuple(found)


def _atoms(states: S, asked: Sequence[S]) -> Iterator[tuple[tuple[bool, ...], S]]:
    """Partitions states by membership in some sets: the atoms of these, each with its memberships."""
    if not asked:
        yield (), states
        return
    *before, last = asked
    for answers, those in _atoms(states, before):
        for inside, half in ((True, those & last), (False, those - last)):
            if half:
                yield (*answers, inside), half
