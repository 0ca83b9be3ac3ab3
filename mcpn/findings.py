"""Computes all that a report says of a mission: verdicts, causes, controller and more, with their times."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

from mcpn.answers.causes.find import Causes, find_causes
from mcpn.answers.causes.fmeca import Row, fmeca
from mcpn.answers.claims import Claim, all_claims, claims_of
from mcpn.answers.claims.of_risk import claims_of_risk
from mcpn.answers.spaces_by_engine import MissionSpaces, MissionSubject, spaces_of
from mcpn.answers.verdicts.mission import MissionCheck, check
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.errors import LimitError, McpnError, SemanticsError
from mcpn.mission.static.interval_rates import at_their_means
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.spaces.engine_names import LOCAL
from mcpn.steps import Doing, step

if TYPE_CHECKING:
    from mcpn.answers.causes.prospects import Prospects
    from mcpn.answers.causes.risk import Risk
    from mcpn.controller.generate import Form
    from mcpn.drawing.compose import MissionNet
    from mcpn.mission.model import Mission
    from mcpn.spaces.engine_names import Asking
    from mcpn.spaces.stable.alternatives import AlternativesGraph

MOST_ROWS = 50
"""Objectives up to which a page has the FMECA table."""

MOST_LOCAL_STATES, MOST_LOCAL = 20_000, 24
"""States up to which a local graph is listed, and local graphs of one mission."""


@dataclass(frozen=True)
class LocalGraph:
    """The local graph of a type of section.

    Args:
        section: The section that it is listed for.
        alike: Other sections of the same type.
        net: The section's net.
        graph: Its stable states.
    """

    section: str
    alike: tuple[str, ...]
    net: MissionNet
    graph: AlternativesGraph


@dataclass(frozen=True)
class Findings:
    """The contents of a report; what could not be computed is ``None``, and a note says why.

    Args:
        check: The mission's verdicts.
        causes: Its causes of failure.
        fmeca: The FMECA table.
        controller: The controller, of rules where it can be, as the JSON object of
            :mod:`mcpn.controller.document`.
        notes: Why something is missing.
        warnings: What reading the mission found suspicious.
        engine: The engine that was used.
        seconds: Time by what took it.
        risk: Numbers of risk, where the mission's files give rates.
        local: Local graphs, one for each type of section.
        unlisted: Why some local graphs are missing.
        claims: All that is said of the mission, each with what shows it.
    """

    check: MissionCheck
    causes: Causes | None = None
    fmeca: Sequence[Row] | None = None
    controller: Mapping[str, Any] | None = None
    notes: Sequence[str] = ()
    warnings: Sequence[str] = ()
    engine: str = ""
    seconds: Mapping[str, float] = field(default_factory=dict)
    risk: Risk | None = None
    local: Sequence[LocalGraph] = ()
    unlisted: Sequence[str] = ()
    claims: Sequence[Claim] = ()

    def held(self, kind: str) -> list[Claim]:
        """The claims of a kind that hold."""
        return [claim for claim in self.claims if claim.kind == kind and claim.holds]

    @cached_property
    def tables(self) -> Tables | None:
        """Those of the controller, which whatever runs it shares."""
        return None if self.controller is None else Tables(self.controller)


def findings(
    subject: MissionSubject,
    **asked: Unpack[Asking],
) -> Findings:
    """All that a report says of a mission.

    Args:
        subject: The mission's spaces, or its net.
        **asked: Who is asked, and within what limit.

    Raises:
        SemanticsError: A section hands on more than the state of its hardware.
        LimitError: A limit was hit.
    """
    spaces = spaces_of(subject, **asked)
    mission_net = spaces.mission
    seconds: dict[str, float] = {}
    notes: list[str] = []

    @contextmanager
    def timed(what: str) -> Iterator[None]:
        step(Doing.PREPARING, question=what)
        started = time.perf_counter()
        yield
        seconds[what] = time.perf_counter() - started

    def tried(what: str, find: Callable[[], Any]) -> Any:
        try:
            with timed(what):
                return find()
        except McpnError as error:
            notes.append(f"No {what}: {error}")
            return None

    with timed("verdicts"):
        checked = check(spaces)
    chosen = checked.choice.engine
    warnings = list(map(str, checked.warnings))
    if not (checked.verdicts["safe"].holds and checked.verdicts["confluent"].holds):
        notes.append("No causes and no controller: the reaction to an event is not always the same.")
        claims = claims_of(checked)
        return Findings(
            checked, notes=notes, warnings=warnings, engine=chosen, seconds=seconds, claims=claims
        )
    causes, rows = tried("causes", lambda: _causes(checked)) or (None, None)
    if causes is not None and rows is None:
        notes.append(f"No FMECA table of more than {MOST_ROWS} objectives: mcpn causes --fmeca writes it.")
    controller = tried("controller", lambda: _controller(checked))
    with timed("local graphs"):
        local, unlisted = _local_graphs(spaces)
    risk = None
    if causes is not None and _has_rates(mission_net.core):
        risk = tried("numbers of risk", lambda: _risk(causes.prospects))
        if risk is not None and (means := at_their_means(mission_net.core)):
            notes.append(f"Numbers of risk are {means}; mcpn causes --rates tells bounds.")
    with timed("claims"):
        claims = all_claims(checked, causes, rows or ())
        claims += [] if risk is None else claims_of_risk(risk)
    return Findings(
        check=checked,
        causes=causes,
        fmeca=rows,
        controller=controller,
        notes=notes,
        warnings=warnings,
        engine=chosen,
        seconds=seconds,
        risk=risk,
        local=local,
        unlisted=unlisted,
        claims=claims,
    )


def _local_graphs(spaces: MissionSpaces) -> tuple[list[LocalGraph], list[str]]:
    """The local graph of each type of section as far as it can be listed, and why others cannot."""
    alike: dict[Hashable, list[str]] = {}
    alone = spaces.mission.section_parts.alone
    for section in spaces.mission.graph.sections:
        alike.setdefault(alone(section).type, []).append(section.name)
    found, notes = list[LocalGraph](), list[str]()
    for number, (first, *others) in enumerate(alike.values(), 1):
        step(Doing.LISTING_SECTION, section=first, number=number, total=min(len(alike), MOST_LOCAL))
        if len(found) == MOST_LOCAL:
            notes.append(f"No more than {MOST_LOCAL} local graphs, of {len(alike)} types of sections.")
            break
        try:
            found.append(LocalGraph(first, tuple(others), *spaces.local(first, MOST_LOCAL_STATES)))
        except (LimitError, SemanticsError) as error:
            notes.append(f"No local graph of {first}: {error}")
    return found, notes


def _risk(prospects: Prospects[Any]) -> Risk:
    from mcpn.answers.causes.risk import risk  # loads numpy

    return risk(prospects.within(None))


def _has_rates(mission: Mission) -> bool:
    """Whether something of a mission happens at a rate that its files give."""
    return any(h.failure_rate for h in mission.hardware) or any(event.rate for event in mission.events)


def _causes(checked: MissionCheck) -> tuple[Any, Any]:
    """Causes and, of missions that are not long, the FMECA table."""
    causes = find_causes(checked.spaces, engine=checked.choice.engine)
    if len(causes.objectives) > MOST_ROWS:
        return causes, None
    step(Doing.PREPARING, question="the FMECA table")
    return causes, fmeca(causes.prospects)


def _controller(checked: MissionCheck) -> dict[str, Any]:
    """The controller as rules: its size is a sum over activities, so that a page can hold it.

    Where a section has no rules the controller is one of tables; where a small mission cannot be divided into
    sections it is flat.
    """
    forms: tuple[Form, ...] = ("modular", "hierarchical")
    if checked.choice.engine != LOCAL:
        forms = (*forms, "flat")
    for number, form in enumerate(forms, 1):
        if form == "flat":
            step(Doing.PREPARING, question="the controller in one piece")
        try:
            made = generate(checked.spaces, form)
        except McpnError:
            if number == len(forms):
                raise
        else:
            return document(made, checked.mission_net)
    raise AssertionError("the last form has answered, or has raised")
