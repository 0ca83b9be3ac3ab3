"""What a reader is told unasked where it is so: by kind of claim what it answers, and its sentences."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from mcpn.answers.claims.claim import Claim, told

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
MOST_TOLD = 8
"""Sentences of one kind."""


def unasked(claims: Sequence[Claim], kinds: Collection[str]) -> Iterator[tuple[str, list[str]]]:
    """Each kind of which some claim holds, with its sentences; the last one says how many more there are."""
    for kind in kinds:
        together: dict[tuple[str, ...], list[Claim]] = {}
        for claim in claims:
            if claim.kind == kind and claim.holds:
                together.setdefault(() if kind in TOGETHER else claim.subject, []).append(claim)
        said = [told(same) for same in together.values()]
        if (more := len(said) - MOST_TOLD) > 0:
            said = [*said[:MOST_TOLD], f"And {more} more, which check --json lists."]
        if said:
            yield kind, said
