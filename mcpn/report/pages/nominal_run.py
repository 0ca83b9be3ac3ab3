"""The run without failures, as a strip of chips on a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.actions import START

if TYPE_CHECKING:
    from mcpn.findings import Findings
from mcpn.report.pages.live import MOST_CHIPS, MOST_EVENTS


def nominal_run(findings: Findings) -> list[str] | None:
    """The events of the run in which each objective succeeds and nothing fails, as the controller takes it.

    It is ``None`` where there is no controller, or such a run does not come to success.
    """
    if findings.tables is None:
        return None
    controller, events = Controller(findings.tables), [START]
    controller.handle(START)
    while controller.outcome is None and len(events) < MOST_EVENTS:
        possible = controller.possible
        ends = (f"OBJ_{name}_EV_OK" for name in controller.state.objectives)
        event = next((end for end in ends if end in possible), None)
        if event is None:
            return None
        controller.handle(event)
        events.append(event)
    return events if controller.outcome == "success" else None


def strip(findings: Findings, events: Sequence[str]) -> list[str]:
    """A run as a row of chips: each names the objectives that begin together at one event."""
    assert findings.tables is not None
    return list(_elided(list(_begun(Controller(findings.tables), events))))


def _begun(controller: Controller, events: Sequence[str]) -> Iterator[str]:
    running: tuple[str, ...] = ()
    for event in events:
        controller.handle(event)
        now = controller.state.objectives
        if begun := [name for name in now if name not in running]:
            yield _chip(begun)
        running = now
    yield controller.outcome or "…"


def _chip(names: Sequence[str]) -> str:
    """The text of a chip; a qualifier that all its objectives have (``visit.``) is written once."""
    before = {name.rpartition(".")[0] for name in names}
    if len(names) == 1 or len(before) > 1 or "" in before:
        return " ∥ ".join(names)
    return f"{before.pop()}: {' ∥ '.join(name.rpartition('.')[2] for name in names)}"


def _elided(chips: list[str]) -> list[str]:
    if len(chips) <= MOST_CHIPS:
        return chips
    first, last = MOST_CHIPS - 5, 4
    return [*chips[:first], f"… {len(chips) - first - last} more …", *chips[-last:]]
