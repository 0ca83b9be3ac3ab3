"""Kinds of claims on what some state reaches, on what the text says, and on entries of sections."""

from __future__ import annotations

from mcpn.answers.kinds.kind import AT_ENTRY, EVERYWHERE, JSON, TERMINAL, ClaimKind

_ENTRIES = "it speaks of all sections of which no other claim does"


def _at_entry(does: str, goal: str) -> ClaimKind:
    """The kind on one section whose entry a loss leaves without a way to a goal."""
    return ClaimKind(
        f"loss_at_entry_{does}",
        "!E(F (({before}) & X (({inside}) & {then})))",
        f"the loss of {{0}}, not repaired, leaves no way to {goal} from the entry of {{1}} on",
        f"from the entry of {{1}} on the loss of {{0}}, not repaired, leaves a way to {goal}",
        f"whether the loss of {{0}} at the entry of {{1}} leaves a way to {goal} is not known",
        "all states at the entry",
        (TERMINAL, JSON),
        AT_ENTRY,
        joint=", or of ",
        several="{}",
        good=False,
    )


def _at_entries(spares: str, goal: str) -> ClaimKind:
    """The kind on all other sections, whose entries a loss leaves with a way to a goal."""
    return ClaimKind(
        f"loss_at_entries_spares_{spares}",
        "",
        f"the loss of {{0}}, not repaired, leaves a way to {goal} from the entry of each section of which "
        "nothing else is said",
        f"the loss of {{0}}, not repaired, leaves no way to {goal} from the entry of a section of which "
        "nothing is said",
        f"whether the loss of {{0}} at other entries leaves a way to {goal} is not known",
        "all states at the entries",
        why=_ENTRIES,
        several="{}",
        good=True,
    )


OF_REACH = (
    ClaimKind(
        "event_decides",
        "E(F (EF success & happens({event}) & X !EF success))",
        "{0} can put success out of reach, whatever is repaired",
        "{0} never puts success out of reach",
        "whether {0} puts success out of reach is not known",
        "all states in which it happens",
        EVERYWHERE,
        good=False,
    ),
    ClaimKind(
        "fact_defeats",
        "EF success & EF (fact({0})={1} & !success) & AG (fact({0})={1} & !success -> !EF success)",
        "once {0} is {1} success is out of reach",
        "while {0} is {1} success may still be reached, or the mission never comes there or never succeeds",
        "whether success is out of reach once {0} is {1} is not known",
        "all states in which it is so",
        EVERYWHERE,
        good=False,
    ),
    ClaimKind(
        "end_decides",
        "E(F (EF success & happens({event}) & X !EF success))",
        "the {1} of {0} can put success out of reach, whatever is repaired",
        "the {1} of {0} never puts success out of reach",
        "whether the {1} of {0} puts success out of reach is not known",
        "all states in which it happens",
        good=False,
    ),
    ClaimKind(
        "outcome_comes",
        "E(F happens({event}))",
        "the {1} of {0} comes on some run",
        "the {1} of {0} never comes",
        "whether the {1} of {0} ever comes is not known",
        "a state",
    ),
    ClaimKind(
        "selected",
        "EF alternative({0})={1}",
        "{0} runs as {1} in some state",
        "{0} never runs as {1}",
        "whether {0} ever runs as {1} is not known",
        "a state",
    ),
    ClaimKind(
        "waits_for_hardware",
        "EF !({ends} | {some})",
        "the mission can come to wait for hardware alone: nothing but failures and repairs is possible",
        "until the mission ends something may happen that is not only of hardware",
        "whether the mission can wait for hardware alone is not known",
        "a state",
        EVERYWHERE,
        good=False,
    ),
    ClaimKind(
        "used",
        "EF ({ways})",
        "{0} is used in some state",
        "{0} is never used, so that its loss costs nothing by itself",
        "whether {0} is ever used is not known",
        "a state",
    ),
    ClaimKind(
        "granted",
        "",
        "the mission says that {0} cannot fail, and the proof believes it",
        "the mission says that {0} can fail",
        "whether {0} can fail is not known",
        "its text",
        why="it is a word of the text: what cannot fail has no state in which it has",
    ),
    ClaimKind(
        "tree_exact",
        "",
        "the mission has the runs of the tree {0}, and no others",
        "the mission has more runs than the tree {0}, or others",
        "whether the mission has the runs of the tree {0} is not known",
        "the ledger of its translation",
        why="runs of a tree are no runs of the mission: its ledger says what became of each node",
        good=True,
    ),
    _at_entry("defeats", "success"),
    _at_entries("success", "success"),
    _at_entries("safety", "a safe end"),
    _at_entry("endangers", "a safe end"),
)
"""In the order in which they are shown."""
