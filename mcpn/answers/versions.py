"""Two missions, mostly versions of one: what the second loses or gains, claim by claim.

Claims have keys that are the same in all versions of a mission, and their kinds say whether a mission is
better where they hold. So a *gain* is a good claim that holds in the second alone, or a bad one that holds in
the first alone. A claim that only one of them has is about something that the other does not have.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from mcpn.answers.causes.find import Causes, find_causes
from mcpn.answers.causes.minimal_cut_sets import CutSet, Moment
from mcpn.answers.claims import Claim, claims_of, claims_of_causes
from mcpn.answers.verdicts.mission import MissionCheck, check
from mcpn.errors import InputError, LimitError, SemanticsError

if TYPE_CHECKING:
    from mcpn.answers.requirements import AskedRequirement
    from mcpn.answers.spaces_by_engine import MissionSpaces

MOST_ROWS = 50
"""Objectives up to which single failures during each of them are compared."""

T = TypeVar("T", bound=Hashable)


class Apart(NamedTuple, Generic[T]):
    """What only one of two missions has."""

    first: Sequence[T]
    second: Sequence[T]


class Changed(NamedTuple):
    """A claim that does not hold alike in two missions."""

    before: Claim
    after: Claim


@dataclass(frozen=True)
class VersionDifference:
    """How the second of two missions differs from the first.

    Args:
        gained: Claims of which the second has the better answer.
        lost: Claims of which it has the worse one.
        changed: Claims that are neither good nor bad, or whose answer is not known of one of them.
        claims: Claims that only one of them has.
        verdicts: Verdicts with different answers, by name: of the first, of the second; ``None`` where not
            known.
        cut_sets: By what they defeat, minimal cut sets that only one of them has.
        modes: By objective of both, functioning modes that only one of them has, in words.
        requirements: By name, requirements of both that do not ask the same: what each asks.
        notes: What could not be compared, and why.
    """

    gained: Sequence[Changed] = ()
    lost: Sequence[Changed] = ()
    changed: Sequence[Changed] = ()
    claims: Apart[Claim] = field(default_factory=lambda: Apart((), ()))
    verdicts: Mapping[str, tuple[bool | None, bool | None]] = field(default_factory=dict)
    cut_sets: Mapping[str, Apart[CutSet]] = field(default_factory=dict)
    modes: Mapping[str, Apart[str]] = field(default_factory=dict)
    requirements: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    notes: Sequence[str] = ()

    @property
    def same(self) -> bool:
        """Whether nothing differs of what was compared."""
        claims = (self.gained, self.lost, self.changed, *self.claims)
        return not any((*claims, self.verdicts, self.cut_sets, self.modes, self.requirements))


class _Version(NamedTuple):
    """What is known of one mission."""

    check: MissionCheck
    claims: Mapping[str, Claim]
    causes: Causes | None
    note: str


def compared(first: MissionSpaces, second: MissionSpaces) -> VersionDifference:
    """What the second mission loses or gains.

    Args:
        first: A mission.
        second: Another one, with some objectives or hardware of the same names.

    Raises:
        InputError: They have no objective and no hardware in common.
        LimitError: A limit was hit.
    """
    _match(first, second)
    before, after = _known(first), _known(second)
    changed = _changed(before.claims, after.claims)
    both = changed.pop(True), changed.pop(False), changed.pop(None)
    cut_sets = dict(_cut_sets(before.causes, after.causes)) if before.causes and after.causes else {}
    return VersionDifference(
        *both,
        Apart(*_alone(before.claims, after.claims)),
        dict(_verdicts(before.check, after.check)),
        cut_sets,
        dict(_modes(before.check, after.check)),
        dict(_requirements(before.check, after.check)),
        tuple(dict.fromkeys(note for note in (before.note, after.note) if note)),
    )


def _match(first: MissionSpaces, second: MissionSpaces) -> None:
    """Refuses missions that say nothing of each other."""
    names = []
    for spaces in (first, second):
        mission, graph = spaces.mission.core, spaces.mission.graph
        objectives = {graph.copies.plain(section.name) for section in graph.walk()}
        names.append(
            {("objective", n) for n in objectives} | {("hardware", h.name) for h in mission.hardware}
        )
    if names[0].isdisjoint(names[1]):
        here, there = (spaces.mission.core for spaces in (first, second))
        raise InputError.at(
            there.source,
            f"found the mission {there.name}, which has no objective and no hardware in common with "
            f"{here.name}; expected another version of it",
        )


def _known(spaces: MissionSpaces) -> _Version:
    checked, mission = check(spaces), spaces.mission.core
    name, claims = (mission.source and mission.source.file) or mission.name, claims_of(checked)
    try:
        causes = find_causes(spaces)
    except SemanticsError as error:
        return _Version(checked, _by_key(claims), None, f"{name}: losses are not compared: {error}")
    rows, note = [], ""
    if len(causes.objectives) <= MOST_ROWS:
        from mcpn.answers.causes.fmeca import fmeca

        try:
            rows = fmeca(causes.prospects)
        except LimitError as error:
            note = f"{name}: failures during objectives are not compared: {error}"
    else:
        note = f"{name}: failures during objectives are not compared: it has more than {MOST_ROWS} of them"
    return _Version(checked, _by_key([*claims, *claims_of_causes(causes, rows)]), causes, note)


def _by_key(claims: Iterable[Claim]) -> dict[str, Claim]:
    return {claim.key: claim for claim in claims}


def _changed(before: Mapping[str, Claim], after: Mapping[str, Claim]) -> dict[bool | None, list[Changed]]:
    """Claims of both with different answers, by whether that is better."""
    found: dict[bool | None, list[Changed]] = {True: [], False: [], None: []}
    for key, was in before.items():
        now = after.get(key)
        if now is not None and now.holds != was.holds:
            known = None not in (was.holds, now.holds, now.of.good)
            found[now.holds == now.of.good if known else None].append(Changed(was, now))
    return found


def _alone(before: Mapping[str, Claim], after: Mapping[str, Claim]) -> Iterator[list[Claim]]:
    """The claims that only the first has, then those that only the second has."""
    for own, other in ((before, after), (after, before)):
        yield [claim for key, claim in own.items() if key not in other]


def _verdicts(
    before: MissionCheck, after: MissionCheck
) -> Iterator[tuple[str, tuple[bool | None, bool | None]]]:
    for name in dict.fromkeys([*before.verdicts, *after.verdicts]):
        was, now = (check.verdicts.get(name) for check in (before, after))
        if was is not None and now is not None and was.holds != now.holds:
            yield name, (was.holds, now.holds)


def _cut_sets(before: Causes, after: Causes) -> Iterator[tuple[str, Apart[CutSet]]]:
    """Minimal cut sets of the goals that both have, lost before the start and at the worst moment."""
    goals = {"success": (before.mission, after.mission)}
    if before.safety is not None and after.safety is not None:
        goals["a safe end"] = before.safety, after.safety
    moments = {Moment.START: "before the start", Moment.SOMETIME: "at the worst moment"}
    for goal, both in goals.items():
        for moment, words in moments.items():
            was, now = (each.moments[moment.value] for each in both)
            yield from _apart(f"{goal}, lost {words}", was, now)


def _modes(before: MissionCheck, after: MissionCheck) -> Iterator[tuple[str, Apart[str]]]:
    for name in before.modes:
        if name in after.modes:
            was, now = (
                [", ".join(f"{a}: {way}" for a, way in mode.items()) for mode in check.modes[name]]
                for check in (before, after)
            )
            yield from _apart(name, was, now)


def _requirements(before: MissionCheck, after: MissionCheck) -> Iterator[tuple[str, tuple[str, str]]]:
    """What requirements of one name ask, where that is not the same: each may be met while it asks less."""
    earlier = {answer.asked.name: answer.asked for answer in before.requirements}
    for answer in after.requirements:
        now = answer.asked
        was = earlier.get(now.name)
        if was is not None and (said := _asks(was)) != (says := _asks(now)):
            yield now.name, (said, says)


def _asks(asked: AskedRequirement) -> str:
    """What a requirement asks, as a formula, and how."""
    requirement = asked.requirement
    how = (
        "must not hold" * (requirement.expected == "fails"),
        "of fair runs alone" * requirement.fair,
        requirement.severity * (requirement.severity != "required"),
    )
    said = ", ".join(each for each in how if each)
    return f"{asked.text} ({said})" if said else asked.text


def _apart(name: str, was: Sequence[Any], now: Sequence[Any]) -> Iterator[tuple[str, Apart[Any]]]:
    """What only one of two lists has, where one has something."""
    only = Apart([each for each in was if each not in now], [each for each in now if each not in was])
    if any(only):
        yield name, only
