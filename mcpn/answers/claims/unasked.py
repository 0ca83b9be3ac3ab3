"""What a reader is told unasked where it is so: by kind of claim what it answers, and its sentences."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from mcpn.answers.claims.claim import Claim, told
from mcpn.events import Event

DEFEATING = {"event_decides": "What defeats it?", "fact_defeats": "What defeats it?"}
"""By kind of claim on what defeats a mission beside hardware, what it answers."""
UNASKED = {
    "needs_help_to_succeed": "What does it need?",
    "needs_help_to_end": "What does it need?",
    "needs_help_to_end_safely": "What does it need?",
    "leads_past": "What leads past a shelter?",
    "succeeds_without": "What may success leave out?",
    "interrupts_answer": "What interrupts an answer?",
    "ends_at_once": "What ends it at once?",
    "alternate_for_ever": "What may go on for ever?",
    "waits_for_hardware": "Where may it stand still?",
    "met_as_ignored": "Of what do requirements not speak?",
}
"""By other kinds."""
TOGETHER = ("succeeds_without", "event_decides")
"""Kinds of which all claims make one sentence."""
MOST_EVENTS = 8
"""Events of a run in one line."""
MOST_TOLD = 8
"""Sentences of one kind."""


class ClaimRun(NamedTuple):
    """A run that shows a claim.

    Args:
        claim: The claim.
        events: Its events.
        repeats: How many of them come before those that go on for ever; ``None`` where it ends.
    """

    claim: Claim
    events: Sequence[Event]
    repeats: int | None = None

    @property
    def words(self) -> str:
        """The run in one line, its events by the names that formulas have for them."""
        first = self.events if self.repeats is None else self.events[: self.repeats]
        again = [] if self.repeats is None else [f"then for ever {_listed(self.events[self.repeats :])}"]
        return ", ".join([*([_listed(first)] if first else []), *again])


def unasked(claims: Sequence[Claim], kinds: Collection[str]) -> Iterator[tuple[str, list[str]]]:
    """Each kind of which some claim holds, with its sentences; the last one says how many more there are."""
    for kind, together in _together(claims, kinds):
        said = [told(same) for same in together[:MOST_TOLD]]
        if (more := len(together) - MOST_TOLD) > 0:
            said.append(f"And {more} more, which check --json lists.")
        yield kind, said


def runs_of_unasked(claims: Sequence[Claim], kinds: Collection[str]) -> Mapping[str, ClaimRun]:
    """By sentence that a reader is told unasked the run that shows the first of its claims."""
    found = dict[str, ClaimRun]()
    for _, together in _together(claims, kinds):
        for same in together[:MOST_TOLD]:
            if (shown := run_of(same[0])) is not None:
                found[told(same)] = shown
    return found


def run_of(claim: Claim) -> ClaimRun | None:
    """A run that shows a claim, looked for now."""
    if claim.find_lasso is not None and (lasso := claim.find_lasso()) is not None:
        return ClaimRun(claim, lasso[0].events, lasso[1])
    run = claim.find_run() if claim.find_run is not None else None
    return None if run is None else ClaimRun(claim, run.events)


def _together(claims: Sequence[Claim], kinds: Collection[str]) -> Iterator[tuple[str, list[list[Claim]]]]:
    """By kind the claims that hold, those of one sentence together."""
    for kind in kinds:
        together: dict[tuple[str, ...], list[Claim]] = {}
        for claim in claims:
            if claim.kind == kind and claim.holds:
                together.setdefault(() if kind in TOGETHER else claim.subject, []).append(claim)
        if together:
            yield kind, [*together.values()]


def _listed(events: Sequence[Event]) -> str:
    """Events by their names; of many the first ones and the last ones."""
    names = [*map(str, events)]
    if (more := len(names) - MOST_EVENTS) > 0:
        half = MOST_EVENTS // 2
        names = [*names[:half], f"{more} more", *names[-half:]]
    return ", ".join(names)
