"""The report: everything that is found of a mission, on one page."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.shared import (
    EXIT_FAILED,
    FILE,
    emit_json,
    engine_option,
    import_option,
    jobs_option,
    json_option,
    limit_option,
    mission_net_of,
    scheduler_option,
)
from mcpn.errors import InputError, McpnError, Source

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from mcpn.check.causes.prospects import Prospects
    from mcpn.check.causes.risk import Risk
    from mcpn.check.spaces import Asked
    from mcpn.check.verdicts.mission import MissionCheck
    from mcpn.mission.model import Mission
    from mcpn.net.compose import MissionNet
    from mcpn.report.page import Findings
    from mcpn.report.progress import Steps

    Told = Callable[[int, int, float], str]

MOST_ROWS = 50
"""Objectives up to which a page has the FMECA table."""

MOST_STATES = 200_000
"""Markings that are listed at most for numbers of risk."""


@click.command()
@click.argument("mission", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="The page to write, FILE.html.")
@engine_option()
@jobs_option
@scheduler_option
@limit_option
@import_option
@json_option
def report(
    mission: Path,
    output: Path,
    engine: Asked,
    jobs: int,
    scheduler: str | None,
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Write a report of MISSION as one HTML page: drawing, verdicts, causes, a controller to click through.

    The page opens from disk, needs no network, and can be printed or sent.
    """
    from mcpn.files import write_atomically
    from mcpn.report.page import page
    from mcpn.report.progress import steps_on_terminal
    from mcpn.workers import executor_of

    if output.suffix.lower() not in (".html", ".htm"):
        source = Source(str(output))
        raise InputError.at(source, f"found the suffix {output.suffix!r}, expected .html")
    with steps_on_terminal() as steps, executor_of(jobs, scheduler) as executor:
        found = findings(mission_net_of(mission, import_root), engine, max_states, steps, executor)
        steps.begin("the page")
        text = page(found)
    write_atomically(output, text)
    if as_json:
        size = len(text.encode())
        emit_json({"file": str(output), "bytes": size, "engine": found.engine, "passed": found.check.passed})
    else:
        for note in found.notes:
            click.echo(f"note: {note}", err=True)
        click.echo(str(output))
    if not found.check.passed:
        sys.exit(EXIT_FAILED)


def findings(
    mission_net: MissionNet,
    engine: Asked = "auto",
    max_states: int | None = None,
    steps: Steps | None = None,
    executor: Executor | None = None,
) -> Findings:
    """All that a report tells of a mission.

    Args:
        mission_net: The mission's net.
        engine: ``explicit``, ``symbolic``, ``local``, or ``auto``: the first of them that answers.
        max_states: Limit on states that are listed.
        steps: Told of each step and how far it is.
        executor: Where types of sections are explored; this process by default.

    Raises:
        SemanticsError: A section hands on more than the state of its hardware.
        LimitError: A limit was hit.
    """
    from mcpn.check.verdicts.mission import check
    from mcpn.mission.facts.warnings import find_warnings
    from mcpn.report.local import local_pictures
    from mcpn.report.page import Findings
    from mcpn.report.progress import Steps, counted, exploring

    steps = steps or Steps()
    seconds: dict[str, float] = {}
    notes: list[str] = []

    @contextmanager
    def timed(what: str, told: Told | None = None) -> Iterator[None]:
        steps.begin(what, told)
        started = time.perf_counter()
        yield
        seconds[what] = time.perf_counter() - started

    def tried(what: str, find: Callable[[], Any], told: Told | None = None) -> Any:
        try:
            with timed(what, told):
                return find()
        except McpnError as error:
            notes.append(f"No {what}: {error}")
            return None

    with timed("verdicts", counted if engine in ("auto", "local") else exploring):
        checked = check(
            mission_net, engine=engine, max_states=max_states, progress=steps.at, executor=executor
        )
    chosen = checked.choice.engine
    told = counted if chosen == "local" else exploring
    warnings = [*map(str, (*find_warnings(mission_net.usage), *checked.unselectable))]
    warnings += [f"{c.source}: {c}" for c in mission_net.usage.contentions]
    if not (checked.verdicts["safe"].holds and checked.verdicts["confluent"].holds):
        notes.append("No causes and no controller: the reaction to an event is not always the same.")
        return Findings(
            checked, notes=notes, warnings=list(dict.fromkeys(warnings)), engine=chosen, seconds=seconds
        )
    causes, rows = tried("causes", lambda: _causes(checked, max_states, steps, executor), told) or (
        None,
        None,
    )
    if causes is not None and rows is None:
        notes.append(f"No FMECA table of more than {MOST_ROWS} objectives: mcpn causes --fmeca writes it.")
    controller = tried("controller", lambda: _controller(checked, max_states, steps, executor), counted)
    with timed("local graphs", counted):
        local, missing = local_pictures(mission_net, steps.at)
    notes += missing
    risk = None
    if causes is not None and _has_rates(mission_net.mission):
        risk = tried("numbers of risk", lambda: _risk(causes.prospects))
    warnings = list(dict.fromkeys(warnings))
    return Findings(checked, causes, rows, controller, notes, warnings, chosen, seconds, risk, local)


def _risk(prospects: Prospects[Any]) -> Risk:
    from mcpn.check.causes.risk import risk  # an extra

    return risk(prospects, MOST_STATES)


def _has_rates(mission: Mission) -> bool:
    """Whether something of a mission happens at a rate that its files give."""
    return any(h.failure_rate for h in mission.hardware) or any(event.rate for event in mission.events)


def _causes(
    checked: MissionCheck, max_states: int | None, steps: Steps, executor: Executor | None
) -> tuple[Any, Any]:
    """Causes and, of missions that are not long, the FMECA table."""
    from mcpn.check.causes.find import find_causes
    from mcpn.check.causes.fmeca import fmeca

    causes = find_causes(
        checked.mission_net,
        engine=checked.choice.engine,
        max_states=max_states,
        progress=steps.at,
        executor=executor,
        stable=checked.alternatives,
    )
    if len(causes.objectives) > MOST_ROWS:
        return causes, None
    steps.begin("the FMECA table")
    return causes, fmeca(causes.prospects)


def _controller(
    checked: MissionCheck, max_states: int | None, steps: Steps, executor: Executor | None
) -> dict[str, Any]:
    """The controller, in one piece where sections cannot be taken apart and the mission is small."""
    from mcpn.controller.generate import generate
    from mcpn.controller.targets.json import document
    from mcpn.report.progress import exploring
    from mcpn.space.local.composite import CompositeSpace

    mission_net, known = checked.mission_net, checked.alternatives
    composite = known if isinstance(known, CompositeSpace) else None
    try:
        made = generate(
            mission_net, max_states=max_states, progress=steps.at, executor=executor, composite=composite
        )
    except McpnError:
        if checked.choice.engine == "local":
            raise
        steps.begin("controller in one piece", exploring)
        made = generate(mission_net, "flat", max_states=max_states, progress=steps.at)
    return document(made, mission_net)
