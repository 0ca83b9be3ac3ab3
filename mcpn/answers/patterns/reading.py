"""What the pattern of a requirement says: a formula, and a sentence in the mission's names."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple, TypeVar

from mcpn.answers.patterns import robot_patterns as robots
from mcpn.answers.patterns.catalogue import after_step, bounded, used
from mcpn.answers.patterns.english import clause
from mcpn.answers.patterns.moments import EVERY_EVENT, LASTING, OF_EVENTS, OF_STATES, At, on_states
from mcpn.errors import InputError, LimitError, Problem
from mcpn.logic.ltl.formulas import Happens, SomePath, normal
from mcpn.logic.syntax import parse
from mcpn.mission.requirement import (
    Avoidance,
    BoundedExistence,
    Patrolling,
    Pattern,
    Precedence,
    Reaction,
    Response,
    RestrictedAvoidance,
    Scoped,
    Visit,
    Wait,
    formulas_of,
)
from mcpn.sentences import enumeration
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import FALSE, TRUE, And, Formula, Not, Or

_Read = TypeVar("_Read")
_TIMES = {1: "once", 2: "twice"}
_ONE_WORD = re.compile(r"[\w.]+(\([\w.]+\)(=[\w.]+)?)?")


class PatternText(NamedTuple):
    """What a pattern says.

    Args:
        formula: As people may write it.
        sentence: In English.
    """

    formula: str
    sentence: str


def read_pattern(pattern: Pattern, names: Names) -> PatternText:
    """What a pattern says of a mission.

    Args:
        pattern: A valid one.
        names: Of the mission, or of one use of a protocol.

    Raises:
        InputError: An attribute is no formula, or names what is not there; with the pattern's line.
    """
    reader = _PatternReader(pattern, names)
    reader.understand_all()
    match pattern:
        case Visit() | Patrolling():
            text = reader.movement(pattern)
        case Avoidance() | RestrictedAvoidance() | Wait():
            text = reader.places(pattern)
        case Reaction():
            text = reader.reaction(pattern)
        case _:
            text = reader.scoped(pattern)
    return PatternText(text.formula, text.sentence[0].upper() + text.sentence[1:])


class _PatternReader:
    """Looks up what the attributes of a pattern say."""

    def __init__(self, pattern: Pattern, names: Names) -> None:
        self._pattern, self._names = pattern, names

    def understand_all(self) -> None:
        """Raises what is wrong with any attribute that is a formula."""
        wrong = list[Problem]()
        for attribute, text in formulas_of(self._pattern):
            try:
                self._read(attribute, partial(parse, text, self._names))
            except InputError as error:
                wrong += error.problems
        if wrong:
            raise InputError(wrong)

    def clause(self, attribute: str) -> str:
        """A formula of an attribute as a clause."""
        text, names = getattr(self._pattern, attribute), self._names

        def said() -> str:
            formula = parse(text, names)
            return f"“{text.strip()}”" if formula in (TRUE, FALSE) else clause(formula, names)

        return self._read(attribute, said)

    def is_event(self, attribute: str, negated: bool = False) -> bool:
        """Whether a formula of an attribute, or its negation, says that an event happens."""
        text, names = getattr(self._pattern, attribute), self._names
        if text is None:
            return False
        formula = self._read(attribute, lambda: parse(text, names))
        return _comes_about(~formula if negated else formula)

    def _on_states(self, formula: str, letters: Mapping[str, str | None], lasting: str = "") -> str:
        """A formula of letters, understood of moments where attributes are events; see :mod:`.moments`.

        Args:
            formula: As it is where all is said of states.
            letters: By letter its attribute; ``None`` for what is said of states, whatever attributes say.
            lasting: Letters that must be true all along.
        """
        events = {
            letter for letter, formula in letters.items() if formula is not None and self.is_event(formula)
        }
        if not events:
            return formula
        if "q" in events:
            formula = after_step(formula)
        kinds: dict[str, At] = {
            letter: OF_EVENTS if letter in events else LASTING if letter in lasting else OF_STATES
            for letter in letters
        }
        return on_states(formula, kinds)

    def operand(self, attribute: str) -> str:
        """A formula of an attribute as it stands inside another."""
        text: str = getattr(self._pattern, attribute).strip()
        return text if _ONE_WORD.fullmatch(text) else f"({text})"

    def locations(self, objectives: tuple[str, ...], attribute: str) -> list[str]:
        """For each of some objectives, the formula that it runs."""

        def known() -> list[str]:
            for name in objectives:
                self._names.word("objective", name)
            return [f"objective({name})" for name in objectives]

        return self._read(attribute, known)

    def _read(self, attribute: str, read: Callable[[], _Read]) -> _Read:
        """What ``read`` makes of an attribute; its errors name the attribute and the pattern's line."""
        at, where = self._pattern.source, f"{attribute} of <{self._pattern.TAG}>"
        try:
            return read()
        except InputError as error:
            raise InputError(Problem(at, f"{where}: {each.message}") for each in error.problems) from None
        except LimitError as error:
            raise InputError.at(at, f"{where}: {error}") from None

    def scoped(self, pattern: Scoped) -> PatternText:
        letters = {"q": "after", "r": "until" if pattern.until is not None else "before"}
        scope = "globally"
        match pattern.after is None, pattern.before is None, pattern.until is None:
            case True, False, _:
                scope = "before"
            case False, True, True:
                scope = "after"
            case False, False, _:
                scope = "between"
            case False, True, False:
                scope = "after_until"
        most = pattern.most if isinstance(pattern, BoundedExistence) else 2
        name, more = _kind(pattern)
        letters = {a: b for a, b in (letters | more).items() if getattr(pattern, b) is not None}
        said = {letter: self.clause(attribute) for letter, attribute in letters.items()}
        texts = {letter: self.operand(attribute) for letter, attribute in letters.items()}
        if name == "bounded_existence":
            formula = bounded(
                most, of_events=self.is_event("of"), to_event=self.is_event(letters.get("r", "before"))
            )[scope]
            formula = after_step(formula) if self.is_event("after") else formula
        else:
            formula = self._scoped_formula(used(name, scope), name, letters)
        formula = _written(formula, texts)
        sentence = (_AFTER_EVENTS if self.is_event("after") else _SCOPES)[scope]
        body = _BODIES[self._body(name)].format(**said, times=_TIMES.get(most, f"{most} times"))
        return PatternText(formula, sentence.format(body=body, **said))

    def _scoped_formula(self, formula: str, name: str, letters: dict[str, str]) -> str:
        if name != "universality" or not (self.is_event("of") or self.is_event("of", negated=True)):
            return self._on_states(formula, letters, "p" if name == "universality" else "")
        # Of each event, or of none: the states between say nothing.
        if self.is_event("after"):
            formula = after_step(formula)
        scope = {letter: OF_EVENTS if self.is_event(a) else OF_STATES for letter, a in letters.items()}
        return on_states(formula, scope | {"p": EVERY_EVENT})

    def _body(self, name: str) -> str:
        """What precedes is an event, and what it precedes a state: that begins with the reaction."""
        last = {"precedence": "by", "precedence_chain_2_1": "then"}.get(name)
        return f"{name}_event" if last and self.is_event(last) and not self.is_event("of") else name

    def movement(self, pattern: Visit | Patrolling) -> PatternText:
        places = self.locations(pattern.objectives, "in")
        kind = "visit" if isinstance(pattern, Visit) else "patrolling"
        begin = "the robot visits" if kind == "visit" else "again and again the robot visits"
        listed = enumeration(pattern.objectives)
        sentence = f"{begin} {_ORDERS[pattern.order].format(listed)}"
        return PatternText(robots.movement(kind, pattern.order, places), f"{sentence}.")

    def places(self, pattern: Avoidance | RestrictedAvoidance | Wait) -> PatternText:
        places = self.locations(pattern.objectives, "in" if isinstance(pattern, Wait) else "of")
        listed = enumeration(pattern.objectives)
        either = listed if len(places) == 1 else f"any of {listed}"
        here = places[0] if len(places) == 1 else f"({' | '.join(places)})"
        match pattern:
            case Wait():
                formula = self._placed(robots.WAIT, here, "until", lasting="p")
                return PatternText(formula, f"the robot stays in {either} until {self.clause('until')}.")
            case RestrictedAvoidance():
                said = next(a for a in ("at_most", "at_least", "exactly") if getattr(pattern, a) is not None)
                times: int = getattr(pattern, said)
                formula = " & ".join(f"({robots.entries(said, place, times)})" for place in places)
                number = f"{said.replace('_', ' ')} {_TIMES.get(times, f'{times} times')}"
                each = listed if len(places) == 1 else f"each of {listed}"
                return PatternText(formula, f"the robot enters {each} {number}.")
        if pattern.until is not None:
            formula = self._placed(robots.PAST, here, "until")
            sentence = f"at some time {self.clause('until')}, and the robot does not visit {either} before."
            return PatternText(formula, sentence)
        if pattern.after is not None:
            formula = self._placed(robots.FUTURE, here, "after")
            return PatternText(formula, f"once {self.clause('after')}, the robot never visits {either}.")
        return PatternText(robots.GLOBAL.format(each=here), f"the robot never visits {either}.")

    def _placed(self, formula: str, here: str, attribute: str, lasting: str = "") -> str:
        """The formula that the robot is, or is not, at some places, with what begins or ends this."""
        letter = {"after": "q", "until": "r"}[attribute]
        of_letters = self._on_states(
            formula.format(each="p", **{attribute: letter}), {"p": None, letter: attribute}, lasting
        )
        return _written(of_letters, {"p": here, letter: self.operand(attribute)})

    def reaction(self, pattern: Reaction) -> PatternText:
        to, gives = self.clause("to"), self.clause("gives")
        formulas, sentences = robots.REACTIONS, _REACTIONS
        if self.is_event("to") and not self.is_event("gives"):
            formulas = {**formulas, **robots.REACTIONS_TO_EVENTS}
            sentences = sentences | _REACTIONS_TO_EVENTS
        formula = formulas[pattern.when].format(to=self.operand("to"), gives=self.operand("gives"))
        return PatternText(formula, sentences[pattern.when].format(to=to, gives=gives))


def _written(formula: str, texts: Mapping[str, str]) -> str:
    """A formula of letters with what stands for each."""
    return re.sub(r"\b[pqrstz]\b", lambda match: texts[match[0]], formula)


def _comes_about(formula: Formula) -> bool:
    """Whether a formula holds only where some event happens."""
    match formula:
        case Happens():
            return True
        case Not((SomePath((path,)),)):
            return _comes_about(normal(path, wanted=False))
        case And(operands):
            return any(map(_comes_about, operands))
        case Or(operands):
            return all(map(_comes_about, operands))
    return False


def _kind(pattern: Scoped) -> tuple[str, dict[str, str]]:
    """The name of a pattern in the catalogue, and by letter of its formula the attribute that is meant."""
    match pattern:
        case Precedence() if pattern.then is not None:
            return "precedence_chain_2_1", {"p": "of", "s": "by", "t": "then"}
        case Precedence() if pattern.followed_by is not None:
            return "precedence_chain_1_2", {"p": "by", "s": "of", "t": "followed_by"}
        case Precedence():
            return "precedence", {"p": "of", "s": "by"}
        case Response() if pattern.without is not None:
            return "constrained_chain", {"p": "to", "s": "gives", "t": "then", "z": "without"}
        case Response() if pattern.then is not None:
            return "response_chain_1_2", {"p": "to", "s": "gives", "t": "then"}
        case Response() if pattern.followed_by is not None:
            return "response_chain_2_1", {"p": "gives", "s": "to", "t": "followed_by"}
        case Response():
            return "response", {"p": "to", "s": "gives"}
    return pattern.TAG, {"p": "of"}


_SCOPES = {
    "globally": "{body}.",
    "before": "up to the first moment at which {r}, if there is one: {body}.",
    "after": "from the first moment on at which {q}: {body}.",
    "between": "whenever {q}, up to the next moment at which {r}, if there is one: {body}.",
    "after_until": "whenever {q}, up to the next moment at which {r}, or for ever: {body}.",
}
_AFTER_EVENTS = {
    "after": "after the first moment at which {q}, from the reaction on: {body}.",
    "between": "whenever {q}, from the reaction up to the next moment at which {r}, if there is one: {body}.",
    "after_until": "whenever {q}, from the reaction up to the next moment at which {r}, or for ever: {body}.",
}
"""The same where an event begins the scope."""
_BODIES = {
    "absence": "it is never the case that {p}",
    "existence": "at some moment {p}",
    "bounded_existence": "at most {times} it becomes true that {p}",
    "universality": "it is always the case that {p}",
    "precedence": "{p} only when {s}, or after that",
    "precedence_event": "{p} only after {s}",
    "response": "whenever {p}, then or later {s}",
    "precedence_chain_2_1_event": "{p} only after {t}, and before that {s}",
    "precedence_chain_2_1": "{p} only when {t}, or after that, and before that {s}",
    "precedence_chain_1_2": "{s} and later {t} only when first {p}",
    "response_chain_2_1": "whenever {s} and later {t}, then or later {p}",
    "response_chain_1_2": "whenever {p}, then or later {s}, and after that {t}",
    "constrained_chain": "whenever {p}, then or later {s}, and after that {t}, and in between never {z}",
}
_ORDERS = {
    "any": "{0}",
    "sequenced": "{0}, each after the one before it",
    "ordered": "{0}, none before the one before it",
    "strict": "{0}, none before the one before it, and enters none twice before the next one",
    "fair": "{0}, and does not enter one again before it has visited the next one in turn",
}
_REACTIONS = {
    "instantaneous": "whenever {to}, at that moment {gives}.",
    "prompt": "whenever {to}, after the next event {gives}.",
    "delayed": "whenever {to}, then or later {gives}.",
    "bound": "whenever {to}, and only then, {gives}.",
    "bound_delay": "whenever {to}, and only then, after the next event {gives}.",
}
_REACTIONS_TO_EVENTS = {
    "instantaneous": "whenever {to}, in the reaction {gives}.",
    "bound": "in the reaction to it whenever {to}, and only then, {gives}.",
}
"""The sentences of patterns, made of clauses."""
