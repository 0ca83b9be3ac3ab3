"""Which claims on failure causes are shown, and how they are folded; numbers of risk with their names.

A mission that can abort has claims on two goals: that it is accomplished (success), and that it ends
safely (success or abort).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.causes.find import Causes, Survival
from mcpn.answers.claims.claim import Claim, sentences, told
from mcpn.answers.claims.entries import GOALS, claims_of_survival
from mcpn.answers.claims.of_check import plain_names
from mcpn.answers.claims.of_objectives import BEFOREHAND, claims_of_objective
from mcpn.answers.claims.of_risk import ROUNDING
from mcpn.answers.kinds.by_name import KINDS
from mcpn.report.words import folded
from mcpn.sentences import counted, enumeration

if TYPE_CHECKING:
    from mcpn.answers.causes.find import GoalCauses
    from mcpn.answers.causes.minimal_cut_sets import CutSet
    from mcpn.answers.causes.risk import Risk


IMPORTANCE = f"importance: {KINDS['importance'].holds.format('a resource', others='so much')}"
NO_HARDWARE = "No hardware that may fail is used."
MOST_TOLD = 8
"""Sets of losses, or names, of one sentence; tables and JSON have all."""
NEVER = {"defeat": "can_succeed", "endanger": "can_end_safely"}
"""By what losses of a goal do the kind of claim that it can be reached."""


def held(claims: Sequence[Claim], kind: str) -> list[Claim]:
    """The claims of a kind that hold."""
    return [claim for claim in claims if claim.kind == kind and claim.holds]


def losses(claims: Sequence[Claim], verb: str, most: int = MOST_TOLD) -> list[str]:
    """The losses that defeat a mission or endanger the robot: before the start, later, and without help.

    What needs a worse moment, or lacks help, is said where nothing less does the same harm.

    Args:
        claims: On losses.
        verb: What the losses do: ``defeat``, ``endanger``.
        most: Names of one sentence.
    """
    before = held(claims, f"loss_before_{verb}s")
    aided, unaided = ([c for c in before if c.assumes.help == help_] for help_ in ("declared", "none"))
    known_alone = {claim.subject for claim in before}
    missing, several = held(claims, f"missing_{verb}s"), held(claims, f"losses_{verb}")
    known_alone |= {claim.subject for claim in missing}
    later, worse = held(claims, f"loss_{verb}s"), at_worst(claims, verb)
    alone = [c for c in later if c.refers_to and c.subject not in known_alone]
    never = [c for c in claims if c.kind == NEVER[verb] and c.holds is False]
    needed = never or held(claims, f"without_repair_{verb}ed")
    return sentences([*needed, *aided, *missing, *worse, *several, *unaided, *alone], most)


def at_worst(claims: Sequence[Claim], verb: str) -> list[Claim]:
    """Losses, each alone, that do harm at a worse moment than before the start."""
    before = held(claims, f"loss_before_{verb}s")
    known = {claim.subject for claim in before if claim.assumes.help == "declared"}
    known |= {claim.subject for claim in held(claims, f"missing_{verb}s")}
    later = held(claims, f"loss_{verb}s")
    return [c for c in later if c.assumes.help == "declared" and c.subject not in known]


def kept(claims: Sequence[Claim], verb: str, unused: Collection[str], most: int = MOST_TOLD) -> list[str]:
    """The losses, each alone, that are survived whenever they come, and without help.

    Args:
        claims: On losses.
        verb: What other losses do: ``defeat``, ``endanger``.
        unused: Hardware that nothing uses.
        most: Names of one sentence.
    """
    alone = [claim for claim in claims if claim.kind == f"loss_{verb}s"]
    lost = {claim.subject for claim in alone if claim.holds is not False}
    aided = [c for c in alone if c.assumes.help == "declared" and c.subject not in lost]
    return sentences((claim for claim in aided if not {*claim.subject} & {*unused}), most)


def spared(causes: Causes, verb: str = "defeat") -> list[str]:
    """What is said of a goal that no losses take away: that none may come, or that a way is left.

    Args:
        causes: Of a mission.
        verb: What losses would do: ``defeat``, ``endanger``.
    """
    if {*causes.prospects.hardware} <= {*causes.unused}:
        return [NO_HARDWARE]
    if verb == "endanger" or causes.mission.cut_sets:
        return []  # hardware is used, and of each resource it is said that it may be lost
    return sentences([Claim("losses_lose_objective", ("the mission",), False, BEFOREHAND)])


def headlines(causes: Causes, claims: Sequence[Claim]) -> Iterator[str]:
    """What keeps the mission from success, and from a safe end if it can abort, and what does not."""
    yield from sentences(held(claims, "needs_help_to_succeed"))
    for verb in ("defeat", "endanger")[: 1 + (causes.safety is not None)]:
        said = (*losses(claims, verb, most=len(claims)), *kept(claims, verb, causes.unused))
        yield from said or (spared(causes) if verb == "defeat" else ())
    unsaid = [claim for claim in claims if claim.kind == "says_what_is_safe" and not claim.holds]
    yield from sentences([*unsaid, *held(claims, "abort_after")])


def of_objectives(causes: Causes) -> Iterator[str]:
    """What losses cost the objectives, those with equal causes together."""
    shared: dict[tuple[CutSet, ...], list[str]] = {}
    for name, goal in causes.objectives.items():
        shared.setdefault(tuple(goal.cut_sets), []).append(name)
    for names in shared.values():
        same = enumeration(folded(causes.mission_net, names))
        yield from conditions(causes.objectives[names[0]], same)


def conditions(goal: GoalCauses, name: str) -> list[str]:
    """What losses cost an objective, or several with the same causes."""
    claims = [*claims_of_objective(goal, name)]
    return sentences(claims, most=len(claims))


def survived(causes: Causes) -> Iterator[tuple[str, list[str]]]:
    """What is survived from each moment on: moments of which the same is so, and what is so there."""
    shared: dict[tuple[str, ...], list[Survival]] = {}
    for found in causes.survival[1:]:
        shared.setdefault(tuple(_from(found, *_entry("each of these"))), []).append(found)
    yield "from the start", _from(causes.survival[0], "", "the start")
    every = [section.name for section in causes.mission_net.graph.sections]
    for same in shared.values():
        names = causes.mission_net.graph.copies.told([str(found.section) for found in same], every)
        if len(names) == 1 or len(shared) == 1:
            one = names[0] if len(names) == 1 else "any section"
            yield f"from {one} on", _from(same[0], *_entry(one))
        else:
            yield ", ".join(names), _from(same[0], *_entry("each of these"))


def _entry(section: str) -> tuple[str, str]:
    """A section, or several in words, and the moment of their entry."""
    return section, f"the entry of {section}"


def _from(found: Survival, section: str, moment: str) -> list[str]:
    """What is survived from one moment on; that not any loss is, the sets of losses say."""
    claims = [
        claim
        for claim in claims_of_survival(found, section, moment)
        if not (claim.kind.startswith("any_lost") and claim.holds)
    ]
    claims = [c for c in claims if c.refers_to != (counted(0, "resource"),)]
    for verb, noun in GOALS:  # what any so many losses leave says how many may be lost at most
        any_ = [c.refers_to for c in claims if c.kind == f"any_lost_{verb}"]
        claims = [c for c in claims if c.kind != f"most_lost_spare_{noun}" or c.refers_to not in any_]
    return sentences(claims, most=len(claims))


def critical(causes: Causes, claims: Sequence[Claim], verb: str) -> Iterator[str]:
    """The events that take the last way to a goal, those that do so at the same moments together."""
    every = [*plain_names(causes.mission_net, causes.prospects.sections), ""]
    for kind in ("event", "end"):
        unrepaired = held(claims, f"{kind}_may_{verb}")
        shared: dict[tuple[tuple[str, ...], tuple[str, ...]], list[Claim]] = {}
        for claim in unrepaired:
            shared.setdefault((claim.subject[1:], claim.during), []).append(claim)
        for (_, during), same in shared.items():
            yield told(same, len(same), moments(during, every))
        known = {claim.subject for claim in unrepaired}
        for_good = held(claims, f"{kind}_{'decides' if verb == 'defeat' else 'endangers'}")
        yield from sentences((claim for claim in for_good if claim.subject in known), len(for_good))


def moments(during: Sequence[str], every: Sequence[str]) -> str:
    """While what runs, or but for what, whichever is shorter; nothing runs before the start.

    >>> moments(["dive", "climb"], ["dive", "climb", "wait", "call", ""])
    'while one of dive and climb runs'
    >>> moments(["dive", "climb", "wait", ""], ["dive", "climb", "wait", "call", ""])
    'at any moment, but not while call runs'
    """
    if not during:
        return ""

    def running(names: Sequence[str]) -> str:
        some = [name for name in names if name]
        while_ = [f"while {'one of ' * (len(some) > 1)}{enumeration(some)} runs"] * bool(some)
        return ", or ".join([*while_, *["before the start"] * ("" in names)])

    then = {*during}
    within, without = running(during), running([name for name in every if name not in then])
    if not without:
        return "at any moment"
    return within if len(within) <= len(without) else f"at any moment, but not {without}"


def risk_counts(numbers: Risk) -> Iterator[tuple[str, float]]:
    """Probabilities, degraded modes and importances, each with its name, in the order people read them.

    Importances are differences of probabilities: one within rounding errors of 0 is given as 0.
    """
    yield "success", numbers.success
    if numbers.abort is not None:
        yield "abort", numbers.abort
    yield "failure", numbers.failure
    yield "degraded modes", numbers.degraded_modes
    for found, end in ((numbers.importance, ""), (numbers.safety_importance or {}, " for a safe end")):
        for hardware, value in sorted(found.items(), key=lambda pair: -pair[1]):
            yield f"importance of {hardware}{end}", value if abs(value) > ROUNDING else 0.0


def ranked(values: Mapping[str, float]) -> list[str]:
    """Hardware by falling values; of values that differ by rounding alone the first comes first."""

    def size(name: str) -> float:
        return float(f"{values[name]:.9g}") if abs(values[name]) > ROUNDING else 0.0

    return sorted(values, key=size, reverse=True)
