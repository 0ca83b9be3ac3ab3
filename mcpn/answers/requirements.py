"""Requirements answered on stable states, and said: they hold, fail by a run, or hold but say nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from mcpn.answers.mission_names import MissionNames, progress
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError, LimitError, Problem
from mcpn.events import ENDING
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import is_temporal
from mcpn.logic.syntax import parse
from mcpn.logic.vacuity import idle_parts
from mcpn.logic.witness import Witness, explain
from mcpn.logic.writing import show
from mcpn.mission.requirement import BoundedExistence, Requirement
from mcpn.sentences import enumeration, ordinal
from mcpn.spaces.algebra import Space
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import Formula
from mcpn.steps import Doing, step


class AskedRequirement(NamedTuple):
    """A requirement of a mission, or of one use of a protocol, as a formula.

    Args:
        name: Qualified by the use.
        requirement: As it is written.
        text: What it says, as a formula that people may write.
        formula: The same, understood.
        names: Those that it was read with.
        sentence: What its pattern says, in English; empty where it is written as a formula.
    """

    name: str
    requirement: Requirement
    text: str
    formula: Formula
    names: Names
    sentence: str = ""

    @property
    def words(self) -> str:
        """What it says, as its author describes it, else in English, else as a formula."""
        said = self.sentence or self.text
        if self.requirement.expected == "fails":
            said = f"must not hold: {said}"
        return self.requirement.description or said

    @property
    def events(self) -> frozenset[str]:
        """The events that it names, as they are written."""
        said = self.names.said.values()
        return frozenset(about[0] for kind, *about in said if kind in ("event", "happens"))

    @property
    def said(self) -> dict[str, str | None]:
        """What it says, for programs."""
        return {
            "name": self.name,
            "formula": self.text,
            "sentence": self.sentence or None,
            "description": self.requirement.description,
            "expected": self.requirement.expected,
            "severity": self.requirement.severity,
        }


FAIR = (
    "Only runs violate it on which the mission never starts, or an objective that runs never ends; "
    'with fair="true" it is asked of the others alone, and holds.'
)


class RequirementAnswer(NamedTuple):
    """Whether a requirement is met.

    Args:
        asked: The requirement.
        holds: Whether its formula holds; ``None`` where that is not known.
        witness: A run that shows why; ``None`` where it is not known.
        reason: Why it is not known.
        vacuous: Where the formula holds and is expected to: the parts in which it is vacuous, each of which
            can be replaced by anything (:mod:`mcpn.logic.vacuity`).
        fairly: Whether it holds of fair runs, and the run that violates it goes on for ever while no
            objective ends.
    """

    asked: AskedRequirement
    holds: bool | None
    witness: Witness | None = None
    reason: str = ""
    vacuous: tuple[str, ...] = ()
    fairly: bool = False

    @property
    def advice(self) -> str:
        """What its author may mean, where it is violated by runs that no robot makes; empty elsewhere."""
        return FAIR if self.fairly else ""

    @property
    def met(self) -> bool | None:
        """Whether the formula holds or fails as the requirement expects; ``None`` where not known."""
        expected = self.asked.requirement.expected == "holds"
        return None if self.holds is None else self.holds == expected

    @property
    def says_nothing_of(self) -> str:
        """A sentence about the parts of which it says nothing; empty where there are none."""
        parts = self.vacuous
        if not parts:
            return ""
        each = "that" if len(parts) == 1 else "each of these alone"
        return f"It says nothing of {', of '.join(parts)}: it holds whatever {each} is."

    @property
    def required(self) -> bool:
        """Whether the mission may not be flown while it is violated."""
        return self.asked.requirement.severity == "required"


def asked_of(
    mission_net: MissionNet, required: Mapping[str, tuple[str, Requirement]] | None = None
) -> list[AskedRequirement]:
    """The requirements of a mission, understood before anything is explored.

    Args:
        mission_net: Its net.
        required: Others that are asked of the same net, as those of its objectives graph; those by default.

    Raises:
        InputError: Formulas cannot be read, or name what is not there; each with its requirement's line.
    """
    asked, problems = list[AskedRequirement](), dict[Problem, None]()
    required = mission_net.usage.graph.requirements if required is None else required
    for name, (within, each) in required.items():
        names = MissionNames(mission_net, within)
        try:
            asked.append(_asked(name, each, names))
        except InputError as error:
            for problem in error.problems:
                problems[Problem(problem.source or each.source, f"requirement {name}: {problem.message}")] = (
                    None
                )
        except LimitError as error:
            problems[Problem(each.source, f"requirement {name}: {error}")] = None
    if problems:
        raise InputError(list(problems))
    return asked


def _asked(name: str, requirement: Requirement, names: Names) -> AskedRequirement:
    if requirement.formula is not None:
        return AskedRequirement(
            name, requirement, requirement.formula, parse(requirement.formula, names), names
        )
    from mcpn.answers.patterns.reading import read_pattern

    pattern = read_pattern(requirement.patterns[0], names)
    formula = parse(pattern.formula, names)
    return AskedRequirement(name, requirement, pattern.formula, formula, names, pattern.sentence)


def answer_requirements(
    mission_net: MissionNet, asked: Sequence[AskedRequirement], space: Space[Any]
) -> Iterator[RequirementAnswer]:
    """Answers requirements on the stable states of a mission.

    Args:
        mission_net: The mission.
        asked: The requirements.
        space: The stable states.
    """
    plain = Evaluation(space)
    fairly = cache(lambda: Evaluation(space, progress(mission_net)))
    for each in asked:
        step(Doing.ANSWERING, question=each.name)
        evaluation = fairly() if each.requirement.fair else plain
        witness = explain(evaluation, each.formula, each.names)
        holds, parts = evaluation.holds(each.formula), tuple[str, ...]()
        if not holds:
            _say_when(each, witness, evaluation)
        if holds and each.requirement.expected == "holds":
            vacuous = idle_parts(each.formula, each.names.said, evaluation.holds)
            parts = tuple(show(part, each.names) for part in vacuous)
        idle = not holds and not each.requirement.fair and each.requirement.expected == "holds"
        idle = idle and _nothing_ends(mission_net, witness) and fairly().holds(each.formula)
        yield RequirementAnswer(each, holds, witness, vacuous=parts, fairly=idle)


def _say_when(each: AskedRequirement, witness: Witness, evaluation: Evaluation[Any]) -> None:
    """Of what comes about too often: says when it does, where the formula would be shown, which nests."""
    if not isinstance(pattern := next(iter(each.requirement.patterns), None), BoundedExistence):
        return
    counted = parse(pattern.of, each.names)
    if pattern.after or pattern.before or is_temporal(counted) or each.events:
        return
    from mcpn.answers.patterns.english import clause

    states, single = evaluation.states(counted), evaluation.space.single
    holding = [bool(single(at) & states) for at in (witness.start, *(edge.target for edge in witness.steps))]
    begins = [at for at, now in enumerate(holding) if now and not (at and holding[at - 1])]
    if len(begins) > pattern.most:
        times = [f"the {ordinal(n)} {witness.moment(at)}" for n, at in enumerate(begins, 1)]
        kept = [note for note in witness.shown if isinstance(note, str)]
        said = enumeration(["the first time " + times[0].removeprefix("the first "), *times[1:]])
        witness.shown[:] = [f"{clause(counted, each.names)} for {said}", *kept]


def _nothing_ends(mission_net: MissionNet, witness: Witness) -> bool:
    """Whether a run goes on for ever, and no objective ends in what it repeats."""
    events = (mission_net.net.transitions[t].event for t in witness.repeated)
    return bool(witness.repeated) and not any(event is not None and event.what in ENDING for event in events)
