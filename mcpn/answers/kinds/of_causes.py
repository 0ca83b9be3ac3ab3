"""Kinds of claims on what losses cost an objective, how many are survived, and which events decide."""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.answers.kinds.kind import AT_ENTRY, EVERYWHERE, JSON, TERMINAL, ClaimKind

_ENTRY = "no word of formulas names the moment at which a section is entered"
_SETS = "it counts sets of hardware, which no formula does"
_NUMBERS = "formulas have no probabilities: dense solves judge them"
_SAFE_ENDS = "where an abort may come by the failure of a safing objective, safe ends are events"
_COMMANDS = (TERMINAL, JSON)
_HAPPENING = (("event", "{0}"), ("end", "the {1} of {0}"))
"""What may happen: by the first word of a name of a kind, how sentences say it."""


def _of_goal(verb: str, goal: str, noun: str) -> Iterator[ClaimKind]:
    """The kinds on one goal of the mission.

    Args:
        verb: What losses of it do to a mission: ``defeat``, ``endanger``.
        goal: What it is, for a sentence.
        noun: What it is, within a name.
    """
    yield ClaimKind(
        f"any_lost_{verb}",
        "",
        f"the loss of some {{others}} by {{0}}, not repaired, leaves no way to {goal}",
        f"any {{others}} may be lost by {{0}}, not repaired, and {goal} stays possible",
        "whether any {others} may be lost by {0} is not known",
        "all sets of losses",
        _COMMANDS,
        _SETS,
        several="{}",
        good=False,
    )
    yield ClaimKind(
        f"most_lost_spare_{noun}",
        "",
        f"no loss of more than {{others}} by {{0}}, not repaired, leaves a way to {goal}; "
        "some loss of {others} does",
        f"some loss of more than {{others}} by {{0}}, not repaired, leaves a way to {goal}",
        f"how many may be lost by {{0}} so that {goal} stays possible is not known",
        "all sets of losses",
        _COMMANDS,
        _SETS,
        several="{}",
    )
    yield ClaimKind(
        f"no_way_from_entry_to_{noun}",
        "!E(F (({before}) & X (({inside}) & {then})))",
        f"from the entry of {{0}} on {goal} is out of reach, whatever is repaired",
        f"from the entry of {{0}} on {goal} is possible",
        f"whether {goal} is out of reach from the entry of {{0}} on is not known",
        "all states at the entry",
        _COMMANDS,
        AT_ENTRY,
        several="{}",
        good=False,
    )
    yield ClaimKind(
        f"more_losses_spare_{noun}",
        "",
        f"with {{0}} lost {goal} may be out of reach, but not with {{1}} lost",
        f"with more losses {goal} is never nearer",
        f"whether {goal} may be nearer with more losses is not known",
        "all sets of losses",
        _COMMANDS,
        _SETS,
    )
    for kind, subject in _HAPPENING:
        yield ClaimKind(
            f"{kind}_may_{verb}",
            "EF ({hopeful} & {during} & E(happens({event}) & X !{hopeful}))",
            f"{subject} can leave no way to {goal} without a repair{{moments}}",
            f"{subject} never takes the last way to {goal} without a repair",
            f"whether {subject} takes the last way to {goal} is not known",
            "all states in which it happens",
            _COMMANDS,
            _SAFE_ENDS if verb == "endanger" else "",
            good=False,
        )


OF_CAUSES = (
    ClaimKind(
        "loss_before_loses_objective",
        "",
        "the loss of {0} beforehand, not repaired, leaves {1} no way to succeed",
        "the loss of {0} beforehand, not repaired, leaves {1} a way to succeed",
        "whether {1} can succeed after the loss of {0} is not known",
        "all states at its entry",
        _COMMANDS,
        _ENTRY,
        joint=", or of ",
        several="{}",
        good=False,
    ),
    ClaimKind(
        "losses_lose_objective",
        "",
        "some loss of hardware beforehand, not repaired, leaves {0} no way to succeed",
        "whatever hardware is lost beforehand, {0} can succeed",
        "whether {0} can succeed whatever hardware is lost is not known",
        "all states at its entry",
        _COMMANDS,
        _ENTRY,
        several="{}",
        good=False,
    ),
    ClaimKind(
        "can_end_safely",
        "EF (success | abort)",
        "the mission can end safely",
        "the mission can never end safely",
        "whether the mission can end safely is not known",
        "a run",
        _COMMANDS,
        _SAFE_ENDS,
        good=True,
    ),
    *_of_goal("defeat", "success", "success"),
    *_of_goal("endanger", "a safe end", "safety"),
    *(
        ClaimKind(
            f"{kind}_endangers",
            "E(F (EF (success | abort) & happens({event}) & X !EF (success | abort)))",
            f"{subject} can put every safe end out of reach, whatever is repaired",
            f"{subject} never puts every safe end out of reach",
            f"whether {subject} puts every safe end out of reach is not known",
            "all states in which it happens",
            _COMMANDS,
            _SAFE_ENDS,
            good=False,
        )
        for kind, subject in _HAPPENING
    ),
    ClaimKind(
        "chance",
        "",
        "with the given rates the mission ends in {0} with probability {others}",
        "with the given rates the mission does not end in {0} with probability {others}",
        "how probable {0} is is not known",
        "a chain of all states",
        EVERYWHERE,
        _NUMBERS,
        several="each of {}",
    ),
    *(
        ClaimKind(
            kind,
            "",
            f"{end} is more probable by {{others}} if {{0}} never fails than if it is lost before the start "
            "and not repaired, whether it has a rate or not",
            f"{end} is not more probable by {{others}} if {{0}} never fails",
            f"the importance of {{0}}{of} is not known",
            "chains of all states",
            EVERYWHERE,
            _NUMBERS,
        )
        for kind, end, of in (
            ("importance", "success", ""),
            ("safe_importance", "success or an abort", " for an end without failure"),
        )
    ),
    ClaimKind(
        "unrated",
        "",
        "{0} has no rate, and never happens in these numbers",
        "{0} has a rate",
        "whether {0} has a rate is not known",
        "its text",
        EVERYWHERE,
        "it is a question to the text",
        several="each of {}",
    ),
)
"""In the order in which they are shown."""
