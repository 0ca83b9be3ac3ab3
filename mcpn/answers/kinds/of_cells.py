"""Kinds of claims in cells of the FMECA table: what a failure changes, who notices it, what replaces it.

Each is of the failure of a resource while all other hardware is in service and an objective runs: ``{0}`` and
``{1}``. It holds where that is so in some state.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.answers.kinds.kind import FMECA, JSON, PAGE, SAFE_ENDS, ClaimKind

_OF_TEXT = "its text"
_TEXT = "it is a question to the text"
_SERVES = "no word of formulas says for which objective an activity runs"
_ABSENT = "it says that nothing else is so, which the other cells say"
_COLUMNS = "the cells on the mission say what is lost"


def _cell(
    name: str, cell: str, said: str = "", after: str = "", before: str = "", why: str = ""
) -> ClaimKind:
    """A kind that holds in some state.

    Args:
        name: Its name.
        cell: What the cell says.
        said: What is so, in a sentence; the cell's words by default.
        after: What a formula says of the state after the failure; empty where none says it.
        before: What it says of the state before.
        why: Why there is none.
    """
    when, said = "when {0} alone fails during {1}", said or cell
    formula = f"E(F ({{sound}} & objective({{1}}){before} & happens({{0}}_EV_OOS) & X ({after})))"
    return ClaimKind(
        name,
        formula if after else "",
        f"{when}, it may be that {said}",
        f"{when}, it is never so that {said}",
        f"whether {said} {when} is not known",
        _OF_TEXT if why == _TEXT else "all failures of it while the objective runs",
        (FMECA, PAGE, JSON),
        why,
        cell=cell,
    )


def _change(
    name: str, cell: str, said: str, after: str, before: str = "", why: str = ""
) -> Iterator[ClaimKind]:
    """What changes in the mode of the objective, and of another one beside it."""
    yield _cell(name, cell, said, after, before, why)
    # The other objective is named last.
    last = max(int(each) for each in "234" if f"{{{each}}}" in cell) + 1
    elsewhere = f"{before} & objective({{{last}}})"
    yield _cell(f"{name}_elsewhere", f"in {{{last}}}, {cell}", f"{said} in {{{last}}}", after, elsewhere, why)


def _prospect(name: str, cell: str, after: str, lost: str, why: str = "") -> Iterator[ClaimKind]:
    """What the mission can reach after the failure; where it has lost nothing by it, as before.

    Args:
        name: The kind's name.
        cell: What the cell says.
        after: What is so after the failure.
        lost: What of it was so before, where that has not changed.
        why: Why some have no formula.
    """
    yield _cell(name, cell, f"the mission {cell}", after, why=why)
    if lost:
        so = f"{cell}, as before it"
        yield _cell(f"{name}_before", so, f"the mission {so}", after, f" & {lost}", why)


OF_CELLS = (
    # What changes in the mode.
    *_change(
        "changes_alternative",
        "{2}: {3} -> {4}",
        "{2} changes from {3} to {4}",
        "alternative({2})={4}",
        " & alternative({2})={3}",
    ),
    *_change("has_no_alternative", "{2} has no possible alternative", "", "refused({2})"),
    *_change("comes_to_wait", "{2} waits", "", "waiting({2})"),
    *_change("comes_to_run", "{2} runs", "", "activity({2})"),
    *_change("comes_to_stop", "{2} stops", "", "", why=_SERVES),
    _cell("changes_nothing", "none", "nothing changes", why=_ABSENT),
    _cell("changes_nothing_here", "none here", "nothing changes in {1}", why=_ABSENT),
    _cell("needed_later", "needed later", "nothing changes, and {0} is needed later", why=_COLUMNS),
    _cell(
        "lost_unseen",
        "none at once; the objective cannot succeed any more",
        "nothing changes at once, and {1} can no longer succeed",
        "objective({1}) & !{open}",
        " & {open}",
        "where an event ends an objective and begins it again, no word of formulas tells its runs apart",
    ),
    # What that means for the objective.
    _cell(
        "objective_lost",
        "cannot succeed any more",
        "the present run of {1} can no longer succeed without a repair",
        "objective({1}) & !{open}",
        " & {open}",
        "where an event ends an objective and begins it again, no word of formulas tells its runs apart",
    ),
    _cell(
        "objective_lost_before",
        "cannot succeed any more, as before it",
        "the present run of {1} can no longer succeed without a repair, as before it",
        "objective({1}) & !{open}",
        " & !{open}",
        "where an event ends an objective and begins it again, no word of formulas tells its runs apart",
    ),
    _cell("goes_on_otherwise", "goes on in another mode", "{1} goes on in another mode", why=_ABSENT),
    _cell("objective_unchanged", "none", "nothing changes for {1}", why=_ABSENT),
    # What that means for the mission.
    *_prospect("spared", "can still succeed", "{unrepaired}", ""),
    *_prospect("by_repair", "can succeed only if repaired", "!{unrepaired} & {wins}", "!{unrepaired}"),
    *_prospect("mission_lost", "cannot succeed any more", "!{wins}", "!{wins}"),
    *_prospect("robot_lost", "can no longer end safely", "!{safe}", "!{safe}", SAFE_ENDS),
    *_prospect(
        "safe_by_repair",
        "can end safely only if repaired",
        "!{safe_unrepaired} & {safe} & {wins}",
        "!{safe_unrepaired}",
        SAFE_ENDS,
    ),
    *_prospect(
        "safe_by_repair_alone",
        "can end safely only if repaired, and no longer succeed",
        "!{safe_unrepaired} & {safe} & !{wins}",
        "!{safe_unrepaired} & !{wins}",
        SAFE_ENDS,
    ),
    *_prospect(
        "safe_alone",
        "can end safely, but no longer succeed",
        "{safe_unrepaired} & !{wins}",
        "!{wins}",
        SAFE_ENDS,
    ),
    *_prospect(
        "by_repair_or_safe",
        "can succeed only if repaired, or end safely",
        "{safe_unrepaired} & {wins} & !{unrepaired}",
        "!{unrepaired}",
        SAFE_ENDS,
    ),
    # Who notices it.
    _cell("seen_as_crash", "at once: {2} has crashed", "it is seen at once, for {2} has crashed", why=_TEXT),
    _cell("found_next", "by {2}, which runs", "{2}, which runs, notices it next", "event({0}_EV_DETECTED)"),
    _cell(
        "found_by",
        "late, by {2} when it runs, or as an objective fails that uses it",
        "it is noticed late: by {2} when it runs, or as an objective fails that uses it",
        why=_TEXT,
    ),
    _cell(
        "found_late",
        "late, or as an objective fails that uses it",
        "it is noticed late, or as an objective fails that uses it",
        why=_TEXT,
    ),
    _cell(
        "seen_by_error",
        "at once, by the error to {2}",
        "it is noticed at once, by the error to {2}",
        "true",
        " & {ways}",
    ),
    _cell(
        "seen_by_event",
        "by its event alone: not in use here",
        "nothing in {1} uses it, so that its event alone tells of it",
        why=_SERVES,
    ),
    # What makes up for it.
    _cell("replaced", "{2} instead", "{2} takes its place", "{ways}"),
    _cell("not_replaced", "none", "nothing takes its place", why=_ABSENT),
    _cell("no_need_to_replace", "none needed", "nothing need take its place", why=_ABSENT),
    *(
        _cell(
            name, f"the objective's failure {said}{{given}}", f"the failure of {{1}} {said}{{given}}", why=why
        )
        for name, said, why in (
            ("failure_tries_again", "leads to its next try", _TEXT),
            ("failure_leads", "leads to {2}", _TEXT),
            ("failure_ends", "ends the mission in {2}", _TEXT),
            ("failure_aborts", "aborts {2}", _TEXT),
            ("failure_counts_as_success", "is a success of {2}", _TEXT),
            ("failure_fails_early", "fails {2} while another child runs", _TEXT),
            ("failure_fails", "fails {2}", _TEXT),
        )
    ),
    _cell("block_needs", "{2} needs {3} of {4}{given}", why=_TEXT),
    _cell("block_allows", "{3} failures fail {2}{given}", why=_TEXT),
    _cell("block_allows_early", "{3} failures fail {2} while another child runs{given}", why=_TEXT),
    _cell("block_does_without", "{2} does not need it{given}", why=_TEXT),
    # What its return does.
    _cell("never_repaired", "none: it is not repaired", "it is not repaired", "!{repair}"),
    _cell(
        "repaired_once_found",
        "none before its loss is noticed",
        "it is repaired only when its loss has been noticed",
        "!{repair}",
    ),
    _cell(
        "objective_regained",
        "the objective can succeed again",
        "{1} can succeed again as {0} is ready",
        "objective({1}) & !{open} & happens({0}_EV_RD) & X {open}",
        why="where an event ends an objective and begins it again, no word of formulas tells its runs apart",
    ),
    _cell(
        "objective_not_regained",
        "none before the objective has failed",
        "{1} cannot succeed though {0} is ready again",
        "objective({1}) & !{open} & happens({0}_EV_RD) & X !{open}",
        why="where an event ends an objective and begins it again, no word of formulas tells its runs apart",
    ),
    *(
        _cell(
            f"{name}{kind}",
            cell.format(goal),
            f"the mission can {goal} again as {{0}} is ready",
            f"!{way} & happens({{0}}_EV_RD) & X {way}",
            why=why,
        )
        for name, goal, way, why in (
            ("success_regained", "succeed", "{unrepaired}", ""),
            ("safety_regained", "end safely", "{safe_unrepaired}", SAFE_ENDS),
        )
        for kind, cell in (("", "the mission can {} again"), ("_then", "then the mission can {}"))
    ),
    _cell("nothing_regained", "none", "its return changes nothing", why=_ABSENT),
    _cell("no_return_needed", "none needed", "its return is not needed", why=_ABSENT),
    _cell(
        "returns_at_next_start",
        "at the next start of the activity",
        "it is used again when its activity next starts",
        why=_ABSENT,
    ),
    _cell(
        "former_mode",
        "the former mode",
        "{1} goes on as before when {0} is ready",
        "!({ways}) & happens({0}_EV_RD) & X ({ways})",
        " & {ways}",
        "where an activity has stopped, no word of formulas says for which objective it runs again",
    ),
    _cell("other_mode", "another mode", "{1} goes on in a third mode when {0} is ready", why=_ABSENT),
)
"""In the order of the table's columns."""
