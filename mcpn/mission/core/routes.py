"""How sections of the objectives graph are left: by their ends, by events that interrupt them, by facts.

Which routes facts choose is in :mod:`mcpn.mission.core.destinations`; facts and ``<route>`` are declared in
:mod:`mcpn.mission.robot` and :mod:`mcpn.mission.model`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from typing import NamedTuple

from mcpn.errors import Source
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.fact_conditions import Condition
from mcpn.records import record

GO_ON = "go on"
"""The exit of what runs while a parallel block pauses, after which it goes on: no block is called so."""


class Setting(NamedTuple):
    """A fact that an objective changes.

    Args:
        fact: Its name.
        value: The value that it has then.
        on: When: ``success``, ``failure`` or ``start``.
    """

    fact: str
    value: str
    on: str


@record(frozen=True, slots=True)
class Interruption:
    """A handler as a section has it: when the declared event happens, the section is stopped and left.

    Args:
        event: The event's name.
        target: The next section, or one of the graph's own exits.
        once: Where the handler is written if it happens once: protocol, block and event, as far as they are
            there (``go_home.leak``), the same for all copies; ``None`` if it may happen again and again.
        source: Its line.
        cases: Where it leads instead if facts are so; the first that fits counts.
        pauses: The number of what runs meanwhile, from 0, where a parallel block pauses and goes on; it leads
            nowhere then.
    """

    event: str
    target: str
    once: str | None = None
    source: Source | None = field(default=None, compare=False)
    cases: tuple[FactCase, ...] = ()
    pauses: int | None = None

    @property
    def routes(self) -> tuple[str, ...]:
        """Where it may lead."""
        return () if self.pauses is not None else (self.target, *(case.target for case in self.cases))

    def led(self, to: Callable[[str], str]) -> Interruption:
        """The same, with other targets."""
        cases = tuple(case._replace(target=to(case.target)) for case in self.cases)
        return replace(self, target=to(self.target), cases=cases)


@record(frozen=True, slots=True)
class Becoming:
    """That a section is stopped and left when, while it runs, facts become so.

    Args:
        when: What they must all be; that they are so as it is entered does not count.
        target: The next section, or one of the graph's own exits.
        source: Its line.
    """

    when: Condition
    target: str
    source: Source | None = field(default=None, compare=False)

    @property
    def words(self) -> str:
        """What facts must become, as missions say it."""
        return FactCase(self.when, self.target).words


def left_by(number: int) -> str:
    """The outcome of a section that is left as facts become so, by the number of what they become."""
    return f"when {number}"


class Interrupted:
    """What events interrupt."""

    __slots__ = ()
    interruptions: tuple[Interruption, ...]

    @property
    def every_interruption(self) -> tuple[Interruption, ...]:
        """All of its interruptions."""
        return self.interruptions

    def handlers(self, event: str) -> Iterator[tuple[Interruption | None, tuple[str, ...]]]:
        """What interrupts the section on an event: each handler, with those that must have happened before.

        The last is ``None`` where all of them happen once: after these the section goes on.
        """
        happened: tuple[str, ...] = ()
        for interruption in self.interruptions:
            if interruption.event == event:
                yield interruption, happened
                if interruption.once is None:
                    return
                happened = (*happened, interruption.once)
        yield None, happened

    @property
    def numbered(self) -> Iterator[tuple[int, Interruption]]:
        """Interruptions, each with its number among those by the same event, from 1."""
        counts: dict[str, int] = {}
        for interruption in self.interruptions:
            number = counts[interruption.event] = counts.get(interruption.event, 0) + 1
            yield number, interruption


class Routes(Interrupted):
    """How sections are left."""

    __slots__ = ()
    success: str
    failure: str
    cases: tuple[tuple[str, FactCase], ...]
    becomes: tuple[Becoming, ...]

    @property
    def becoming(self) -> tuple[tuple[str, Becoming], ...]:
        """The outcomes by which it is left as facts become so; the first that counts does."""
        becomes = self.becomes
        return tuple((left_by(number), each) for number, each in enumerate(becomes, 1)) if becomes else ()

    @property
    def routes(self) -> tuple[str, ...]:
        """Where the section may lead: by its outcomes, then on each event that interrupts it."""
        outcomes = self.outcomes
        ends = [route for outcome, _ in outcomes for route in self._led(outcomes, outcome)]
        return *ends, *[route for i in self.interruptions for route in i.routes]

    def led(self, outcome: str) -> tuple[str, ...]:
        """Where an outcome may lead, the default first."""
        return self._led(self.outcomes, outcome)

    def _led(self, outcomes: Sequence[tuple[str, str]], outcome: str) -> tuple[str, ...]:
        default = [route for said, route in outcomes if said == outcome]
        if not self.cases or not default:
            return tuple(default)
        return *default, *(case.target for case in self.cases_of(outcome))

    def cases_of(self, outcome: str) -> tuple[FactCase, ...]:
        """Where an outcome leads instead if facts are so."""
        return tuple([case for said, case in self.cases if said == outcome]) if self.cases else ()

    @property
    def all_cases(self) -> Iterator[FactCase]:
        """The cases, with their conditions on facts, of all outcomes and all interruptions."""
        for outcome, _ in self.outcomes:
            yield from self.cases_of(outcome)
        for each in self.becomes:
            yield FactCase(each.when, each.target)
        for interruption in self.every_interruption:
            yield from interruption.cases

    @property
    def outcomes(self) -> tuple[tuple[str, str], ...]:
        """How the section may end by itself, each with where that leads."""
        raise NotImplementedError


def exits_on(section: Routes) -> Iterator[tuple[str, Interruption]]:
    """Names of the exits of a part that events lead to, each with its handler; no section has such a name."""
    for number, interruption in section.numbered:
        yield f"on {interruption.event}" + (f" {number}" if number > 1 else ""), interruption


def exits_by_facts(exit_: str, cases: Sequence[FactCase]) -> Iterator[tuple[str, FactCase]]:
    """Names of the exits that facts lead to instead of the given exit, each with its case."""
    for number, case in enumerate(cases, 1):
        yield f"{exit_} case {number}", case


def routes_of(section: Routes) -> dict[str, str]:
    """Where the exits of a section lead that stands alone: outcomes, events, and what facts decide."""
    routes = dict(section.outcomes)
    for outcome, _ in section.outcomes:
        routes |= {exit_: case.target for exit_, case in exits_by_facts(outcome, section.cases_of(outcome))}
    for on, interruption in exits_on(section):
        if interruption.pauses is None:
            routes[on] = interruption.target
        routes |= {exit_: case.target for exit_, case in exits_by_facts(on, interruption.cases)}
    return routes
