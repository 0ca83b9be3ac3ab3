"""Mistakes in the formulas of a mission that is not valid yet: they are reported with the others.

What formulas name is looked up among what the mission declares and writes, since there is no net. So all
that is reported here is wrong however it is mended, unless what a formula names is still to be added.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.answers.mission_names import expected, words_of
from mcpn.errors import InputError, LimitError, Problem, Source
from mcpn.events import ENDING, Event, What
from mcpn.logic.syntax import parse_open
from mcpn.mission.model import Mission
from mcpn.mission.requirement import Requirement, formulas_of
from mcpn.mission.xml import InvalidMission, in_place
from mcpn.nets.petri import NetBuilder
from mcpn.robot.runtime.actions import spelled
from mcpn.spaces.formula_names import ENDINGS, Names, unknown
from mcpn.spaces.search.goal import Formula, marked


def with_formulas(error: InputError) -> InputError:
    """An error that a mission is not valid, with the mistakes in its formulas."""
    if not isinstance(error, InvalidMission) or error.mission is None:
        return error
    problems = {*error.problems, *mistakes(error.mission)}
    return InvalidMission(sorted(problems, key=in_place), error.mission)


def mistakes(mission: Mission) -> Iterator[Problem]:
    """What is wrong with the formulas of a mission, valid or not, as far as no net is needed to know it."""
    names = _DraftNames(mission)
    for requirement in mission.all_requirements:
        for source, where, text in _formulas(requirement):
            try:
                parse_open(text, names)
            except InputError as error:
                for problem in error.problems:
                    yield Problem(source, f"requirement {requirement.name}: {where}{problem.message}")
            except LimitError as error:
                yield Problem(source, f"requirement {requirement.name}: {where}{error}")


def _formulas(requirement: Requirement) -> Iterator[tuple[Source | None, str, str]]:
    if requirement.formula is not None:
        yield requirement.source, "", requirement.formula
    for pattern in requirement.patterns:
        for attribute, text in formulas_of(pattern):
            yield pattern.source, f"{attribute} of <{pattern.TAG}>: ", text


class _DraftNames(Names):
    """Looks up names among what a mission declares and writes; of copies their blocks must be there."""

    endings = ENDINGS

    def __init__(self, mission: Mission) -> None:
        builder = NetBuilder(mission.name)
        builder.place("anything")
        super().__init__(builder.build())
        self._mission = mission
        self._by_word: dict[str, dict[str, None]] = {}
        self._named: set[str] = set()
        for name, word in words_of(mission):
            self._named.add(name)
            self._by_word.setdefault(word.partition("(")[0], {})[name] = None

    def place(self, name: str) -> int:
        if name in self._named or not any(element in name for element in ("MISSION", *self._named)):
            expected(name, self._mission)
        return 0  # places of the net are called after elements

    def transition(self, name: str) -> int:
        return 0

    def word(self, *said: str) -> Formula:
        kind, *about = said
        if about:
            self._look_up(kind, about[0])
        return marked(0)

    def _look_up(self, kind: str, name: str) -> None:
        match kind:
            case "objective" | "pending" | "done":
                if kind != "done" and self._is(name, "block") and not self._is(name, "objective"):
                    message = f"{name} holds blocks: expected block({name}), found {kind}({name})"
                    raise InputError.at(None, message)
                self._known(name, "objective", "objective")
            case "block":
                self._known(name, "block", "block", "objective")
            case "activity" | "waiting" | "refused":
                self._known(name, "activity", "activity")
            case "oos" | "available" if not self._is(name.partition(".")[0], "activity"):
                self._known(name, "resource", "oos", *(["available"] if kind == "available" else []))
            case "fact":
                self._known(name, "fact", "fact")
            case "event" | "happens":
                self._event(name)

    def _event(self, name: str) -> None:
        event = Event.parse(name)
        if self._is(name, "happens") or event.what in (What.START, What.DETECTED):
            return
        if event.what in ENDING and (
            self._is(event.element, "objective") or self._is(event.element, "block")
        ):
            return
        if event.what in (What.OUT_OF_SERVICE, What.REPAIRED) and not self._is(event.element, "objective"):
            return  # of hardware, or of a fault or a crash
        if not self._is(spelled(name, self._by_word.get("happens", ())), "happens"):
            unknown(name, [*self._by_word.get("happens", ())], "event")

    def _is(self, name: str, *words: str) -> bool:
        """Whether something is named so, or the copies of a block begin with its name."""
        last = name.rpartition(".")[2]
        return any(
            last == one or last.startswith(f"{one}_") for word in words for one in self._by_word.get(word, ())
        )

    def _known(self, name: str, what: str, *words: str) -> None:
        if not self._is(name, *words):
            unknown(name, [one for word in words for one in self._by_word.get(word, ())], what)
