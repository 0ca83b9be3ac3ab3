"""Kinds of claims on events: handled or ignored, aborting, interrupting, going on for ever."""

from __future__ import annotations

from mcpn.answers.kinds.kind import EVERYWHERE, ClaimKind

HANDLED = (
    ClaimKind(
        "abort_after",
        "E(F (!abort & ({fails}) & X abort)) & {shelters}",
        "the mission is aborted by the failure of {0}, a safing objective: that is no safe end, but in "
        "probabilities it counts as an abort",
        "the mission is not aborted by the failure of {0}, or {0} is no safing objective",
        "whether the mission is aborted by the failure of {0} is not known",
        "all states in which it aborts",
        EVERYWHERE,
        "of more than 40 objectives, and of those whose copies have one name",
        several="any one of {}",
        good=False,
    ),
    ClaimKind(
        "says_what_is_safe",
        "",
        "the mission says by its aborts which ends are safe besides success",
        "the mission has no abort, so that nothing says which of its failures are safe",
        "whether the mission has an abort is not known",
        "its text",
        EVERYWHERE,
        "it is a question to the text",
        good=True,
    ),
    ClaimKind(
        "handled_always",
        "AG (({running}) -> event({0}))",
        "whatever runs, the mission handles {0}",
        "while some objectives run, {0} changes nothing",
        "whether {0} is always handled is not known",
        "all states",
        good=True,
        several="{}",
    ),
    ClaimKind(
        "ignored",
        "EF (objective({1}) & !event({0}){not_led})",
        "{0} is ignored during {1}",
        "{0} is never ignored during {1}",
        "whether {0} is ignored during {1} is not known",
        "a state",
        EVERYWHERE,
        several="{}",
        good=False,
    ),
    ClaimKind(
        "handled_else",
        "AG (({running}) -> event({0}))",
        "{0} is handled during each objective of which nothing else is said",
        "{0} is ignored during an objective of which nothing is said",
        "whether {0} is handled elsewhere is not known",
        "all states",
        good=True,
        several="{}",
    ),
    ClaimKind(
        "answered_already",
        "EF (objective({1}) & !event({0}))",
        "{0} changes nothing during {1}, where it leads",
        "{0} is handled during {1}",
        "whether {0} is handled during {1} is not known",
        "a state",
        EVERYWHERE,
        several="{}",
    ),
)
"""On what handles an event, and where it is ignored."""

INTERRUPTING = (
    ClaimKind(
        "interrupts_answer",
        "E(F (objective({1}) & happens({0}) & X !objective({1})))",
        "{0} interrupts {1}, to which {2} leads",
        "{0} never interrupts {1}, to which {2} leads",
        "whether {0} interrupts {1} is not known",
        "a run",
        shown=EVERYWHERE,
        good=False,
    ),
    ClaimKind(
        "ends_at_once",
        "E(F (!{1} & happens({0}) & X {1}))",
        "{0} may end the mission in {1} at once: nothing runs after it",
        "{0} never ends the mission in {1} at once",
        "whether {0} ends the mission in {1} at once is not known",
        "a run",
        shown=EVERYWHERE,
    ),
    ClaimKind(
        "alternate_for_ever",
        "E(F G ({events}))",
        "{others} may go on for ever, and nothing else happens",
        "declared events alone never go on for ever",
        "whether declared events alone may go on for ever is not known",
        "a run that repeats",
        shown=EVERYWHERE,
        good=False,
    ),
)
"""On what events end, and which may go on for ever."""
