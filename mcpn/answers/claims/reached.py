"""Claims on what some state reaches: ends of objectives, alternatives, and what puts success out of reach."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Set
from dataclasses import replace
from functools import cached_property, partial
from typing import Generic

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.claims.claim import Claim, Makers
from mcpn.answers.claims.of_check import copies_by_name
from mcpn.answers.claims.parts import FormulaParts
from mcpn.answers.kinds.by_name import KINDS
from mcpn.answers.verdicts.unreachable import selected_and_entered
from mcpn.events import Event, What
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.run import Run

WORDS = {"success": What.SUCCESS, "failure": What.FAILURE, "timeout": What.TIMEOUT}
"""Ends of an objective, by what claims call them."""
HARDWARE = (What.OUT_OF_SERVICE, What.REPAIRED, What.DETECTED)
"""What happens to hardware whatever the mission does."""


class Reached(Generic[S]):
    """The claims of one mission.

    Args:
        prospects: The mission in a space of its alternatives graph.
    """

    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects, self.net = prospects, prospects.mission_net
        self.space: Space[S] = prospects.space

    @property
    def makers(self) -> Makers:
        """What makes them."""
        return (
            (("outcome_comes", "end_decides"), self._ends_of_objectives),
            (("selected",), self._alternatives),
            (("used",), self.hardware),
            (("event_decides",), self._deciding_events),
            (("fact_defeats",), self._facts),
            (("waits_for_hardware",), self._waits_for_hardware),
        )

    def _ends_of_objectives(self) -> Iterator[Claim]:
        """Which objectives can succeed, fail or be late, and whose end so can put success out of reach."""
        for name, copies in copies_by_name(self.net, self.prospects.sections).items():
            for word, what in WORDS.items():
                own = self.space.net.events.of(*(Event(what, copy) for copy in copies))
                if not own:
                    continue
                said = str(Event(what, name))
                yield self._claim("outcome_comes", (name, word), not self._firing.isdisjoint(own), said)
                if word != "success":
                    yield self._claim("end_decides", (name, word), self._decides(own), said)

    def _alternatives(self) -> Iterator[Claim]:
        """Which alternatives are ever selected."""
        for kind, name in self.net.by_role:
            if kind == "active":
                activity, way = name.split(".", 1)
                yield self._claim("selected", (activity, way), name in self._selected)

    def hardware(self) -> Iterator[Claim]:
        """Which hardware some alternative that runs consumes."""
        ways: dict[str, list[tuple[str, str]]] = {}
        for activity in self.net.usage.activities.values():
            for way in activity.alternatives:
                if ("active", f"{activity.name}.{way.name}") in self.net.by_role:
                    for resource in way.consumes:
                        ways.setdefault(resource, []).append((activity.name, way.name))
        for name in (h.name for h in self.net.core.declared_hardware if h.name in ways):
            runs = any(f"{a}.{w}" in self._selected for a, w in ways[name])
            some = " | ".join(f"alternative({a})={w}" for a, w in ways[name])
            formula = KINDS["used"].formula.format(name, ways=some)
            yield Claim("used", (name,), runs, formula=formula)

    def _deciding_events(self) -> Iterator[Claim]:
        """Which declared events can put success out of reach."""
        for event in self.net.core.events:
            if own := self.space.net.events.of(declared := Event(What.DECLARED, event.name)):
                claim = self._claim("event_decides", (event.name,), self._decides(own), str(declared))
                yield replace(claim, find_run=partial(self._run_to_last, own)) if claim.holds else claim

    def _facts(self) -> Iterator[Claim]:
        """Which values of facts leave no way to success as long as the mission has not succeeded."""
        for fact in self.net.core.facts:
            for value in fact.values:
                places = self.net.by_role.get(("fact", f"{fact.name}={value}"), ())
                if places:
                    there = self.space.marked(places) - self.prospects.mission.won
                    lost = bool(there and self._hopeful & self.space.initial) and not there & self._hopeful
                    claim = self._claim("fact_defeats", (fact.name, value), lost)
                    run = partial(FormulaParts(self.prospects).run_to, there)
                    yield replace(claim, find_run=run) if lost else claim

    def _waits_for_hardware(self) -> Iterator[Claim]:
        """Whether nothing but hardware may go on before the mission has ended."""
        own = {t: event for t, event in self.space.net.events.pairs if event.what not in HARDWARE}
        names = list(dict.fromkeys(map(str, own.values())))
        ended = self.space.marked(self.net.ends.values())
        stuck = self.space.everything - self.space.enabling(own) - ended
        kind, some = KINDS["waits_for_hardware"], " | ".join(f"event({name})" for name in names)
        formula = kind.formula.format(ends=" | ".join(self.net.ends), some=some)
        run = partial(FormulaParts(self.prospects).run_to, stuck) if stuck else None
        yield Claim(kind.name, (), bool(stuck), formula=formula, find_run=run)

    def _claim(self, kind: str, subject: tuple[str, ...], holds: bool, event: str = "") -> Claim:
        return Claim(kind, subject, holds, formula=KINDS[kind].formula.format(*subject, event=event))

    @cached_property
    def _hopeful(self) -> S:
        """States from which some run succeeds, whatever is repaired and helps on it."""
        return self.prospects.hopeful(self.prospects.mission, repairs=True) | self.prospects.mission.won

    def _run_to_last(self, own: Collection[int]) -> Run | None:
        """A run on which one of some events takes the last way to success."""
        lost = self.space.everything - self._hopeful
        before = self.space.before(lost, own) & self._hopeful
        return FormulaParts(self.prospects).run_through(before, own, lost)

    def _decides(self, own: Collection[int]) -> bool:
        """Whether some of these events lead from a way to success to none."""
        return not self._deciding.isdisjoint(own)

    @cached_property
    def _deciding(self) -> Set[int]:
        """Transitions that lead from a way to success to none."""
        lost = self.space.everything - self._hopeful
        return {t for t, _ in self.space.crossing(self._hopeful, lost)} if lost else set()

    @cached_property
    def _firing(self) -> Set[int]:
        """Transitions that some state has an edge of."""
        return {t for t, count in self.space.firings(self.space.everything).items() if count}

    @cached_property
    def _selected(self) -> Set[str]:
        """Alternatives that run in some state."""
        return selected_and_entered(self.net, self.space)[0]
