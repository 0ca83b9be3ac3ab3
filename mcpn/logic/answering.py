"""Ways to answer formulas and examinations take turns: which goes first, and by which slices of turns.py.

Formulas are simplified, by invariants and by the initial marking; what asks for one reachable marking goes to
a search, once where several formulas ask for the same; others are asked of few markings, as they are needed
(:mod:`mcpn.logic.on_the_fly`). What is left is asked of the space, built once. All questions share it:
cheap ones first, each with a time slice that grows round by round, so that one hard question does not cost
the easy ones. A typed formula comes with a run that shows its value, so that a technique without runs decides
it only where no single run would show it, or where there is no space.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain
from math import inf
from typing import TYPE_CHECKING, Any

from mcpn.errors import InputError, LimitError, McpnError
from mcpn.logic.evaluate import largest
from mcpn.logic.formulas import EG, EU, EX, OPERATORS, on_one_path, says_paths
from mcpn.logic.implications import LIVE, ONE_SAFE, Meaning
from mcpn.logic.implied import bounds_of, conditions
from mcpn.logic.initial_state import parts_at_first
from mcpn.logic.open_questions import REWRITING, ContestAnswer, OpenQuestions, effort
from mcpn.logic.session import Answer, Session
from mcpn.logic.without_space import SOME_DEADLOCK
from mcpn.logic.witness import NoRun, Witness, explain
from mcpn.nets.petri import PetriNet
from mcpn.spaces import engine_names
from mcpn.spaces.diagrams.slices import within_seconds
from mcpn.spaces.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.spaces.engine_names import Asked
from mcpn.spaces.engines import Choice, NoSpace
from mcpn.spaces.search import EXPLICIT, HOME, INITIAL_STATE, RANDOM_WALK, STATE_EQUATION
from mcpn.spaces.search.goal import FALSE, TRUE, And, AtMost, Formula
from mcpn.steps import Doing, step
from mcpn.turns import in_turns

if TYPE_CHECKING:
    from mcpn._kernel import Store
    from mcpn.logic.contest import Property
    from mcpn.logic.ltl.parts import PathParts
    from mcpn.logic.on_the_fly import LocalChecks
    from mcpn.spaces.algebra import Space
    from mcpn.spaces.search.facts import Facts
    from mcpn.spaces.search.portfolio import Round
    from mcpn.spaces.search.searches import Searches

# What searches is loaded when something is searched.

DIAGRAMS, COMPOSITION = "DECISION_DIAGRAMS", "COMPOSITION"
FIRST_STEPS, MOST_STEPS = 600_000, 2**60
"""Of the race for the space, within which it is there at once, and where it goes on to its end."""
SECONDS_OF_SOLVER = 0.1
"""That it takes to load what solves linear programs."""
FIRST_SLICE = 0.02
"""Seconds of first turns: what is easy for some way is soon answered, whichever it is."""
SLICE_OF_PROOF = 0.5
"""Seconds of first turns where one deadlock is asked for: to load the solver takes a tenth."""
RESTS = 4
"""How many times as long as formulas have been rewritten they are not, although more is known."""
FIRST_SLICE_OF_QUESTION, SLICE_FACTOR = 0.4, 3.0
WALK_STEPS = 50_000
LOCAL_STEPS = (20_000, 200_000, 1_000_000, 5_000_000, 25_000_000, 125_000_000)
"""For each part of a formula, in rounds."""
PACED, FEWEST_STEPS = 1_000, 2_000
"""Places and transitions of a net up to which steps are not made fewer, and the fewest of each round."""


def answer_all(
    questions: Session, properties: Iterable[Property] = (), examinations: Iterable[str] = ()
) -> Iterator[ContestAnswer]:
    """Answers properties, of one file or several, and examinations, on one space.

    Args:
        questions: About the net.
        properties: What is asked.
        examinations: Names of :data:`mcpn.logic.behaviour.EXAMINATIONS`.

    Returns:
        The answers in the order in which they are found. Taking them raises UnboundedError, UnsafeError (of
        nets with priorities) or LimitError where what is left needs the space.

    Raises:
        InputError: Two properties have one name; this is found before anything is answered.
    """
    meant: dict[str, Meaning] = {}
    for name in examinations:
        searched = name == "ReachabilityDeadlock" and questions.searchable
        meaning: Meaning = SOME_DEADLOCK if searched else name
        if name == ONE_SAFE and questions.net.complements:
            meaning = _safe_beside(questions.net)
        meant[examination(questions, name)] = meaning
    for asked in properties:
        if asked.name in meant:
            raise InputError.at(asked.source, f"found {asked.name} a second time, expected a name of its own")
        meant[asked.name] = asked.meaning
    return _Answers(questions, meant).all()


def _safe_beside(net: PetriNet) -> Formula:
    """That no place holds two tokens but those that stand for inhibitor arcs."""
    own = (place for place in range(len(net.places)) if place not in net.complements)
    return OPERATORS["AG"](And(*(AtMost(((place, 1),), 1) for place in own)))


def examination(questions: Session, name: str) -> str:
    """What the answer to an examination of a net is called."""
    return f"{questions.net.name}-{name}"


def answer_typed(questions: Session, texts: Sequence[str]) -> list[Answer]:
    """Answers formulas as people type them, each with a run that shows why.

    Args:
        questions: About the net or the mission.
        texts: The formulas.

    Returns:
        The answers, in the order of the formulas.

    Raises:
        InputError: A text is no formula; this is found before anything is answered.
        SemanticsError: The space that is needed does not exist.
        LimitError: A limit was hit.
    """
    formulas = questions.formulas(texts)
    answers, given = _Answers(questions, dict(formulas), typed=True), dict[str, Answer]()
    for verdict in answers.all():
        holds = verdict.value == str(True).upper()
        witness, choice = answers.shown(formulas[verdict.name], holds, verdict.techniques)
        given[verdict.name] = Answer(verdict.name, holds, witness, choice, verdict.techniques)
    return [given[text] for text in texts]


class _Answers(OpenQuestions):
    """Gives answers: each technique removes the questions that it decides from those that wait.

    Args:
        questions: About the net.
        waiting: What is asked, by name; of a formula, what is left to ask in the initial marking.
        typed: Whether a run is to show each answer.
    """

    def __init__(self, questions: Session, waiting: dict[str, Meaning], *, typed: bool = False) -> None:
        super().__init__(questions.net, waiting, settled=questions.on == "alternatives")
        self.questions, self.typed = questions, typed
        self.local: LocalChecks | None = None
        self.paths: PathParts | None = None
        self.facts: Facts | None = None
        self._weighed: set[Formula] = set()
        self.rounds = self.path_rounds = 0
        self.late: dict[Iterator[ContestAnswer | None], float] = {}
        self.failed: McpnError | None = None
        """Why there is no space."""

    def all(self) -> Iterator[ContestAnswer]:
        """Asks all ways by turns; of typed formulas, whose runs are to be the same each time, one by one."""
        self.tell_open()
        space = self.by_space()
        ways = self.ways_to_go([] if self.questions.engine == "search" else [space])
        if self.typed:
            first = inf
        elif [*self.waiting.values()] == [SOME_DEADLOCK]:
            first = SLICE_OF_PROOF
        else:
            first = FIRST_SLICE
        turns = in_turns(
            ways,
            lambda: not self.waiting,
            first=first,
            whole=space,
            near=lambda: self.questions.made,
            late=self.late,
        )
        for told in turns:
            if told is not None:
                yield told
                self.tell_open()
        if self.waiting:
            raise self.failed or LimitError(f"engine search leaves open: {', '.join(self.waiting)}")

    def ways_to_go(self, space: list[Iterator[ContestAnswer | None]]) -> list[Iterator[ContestAnswer | None]]:
        """The ways to answer that there are, the space among them, in the order of their first turns."""
        questions = self.questions
        if not questions.searchable:
            return [self.one_safe_at_sight(), *space]
        if not self.typed:
            at_sight: Iterator[ContestAnswer | None] = chain(self.one_safe_at_sight(), self.rewritten())
            structure, equation, search = self.by_structure(), self.by_equation(), self.by_search()
            need, paths = self.by_need(), self.by_paths()
            if self.searched:  # often a walk is enough, and the invariants take longer
                equation = chain(structure, equation)
            self.late[equation] = SECONDS_OF_SOLVER
            if self.searched:
                return [at_sight, search, *space, structure, need, paths, equation]
            return [chain(at_sight, structure), *space, need, paths, search, equation]
        # The space of a mission is not far, once a search has found nothing; in a small one it has the
        # shortest runs.
        ways = [self.one_safe_at_sight(), self.rewritten(), self.by_need(LOCAL_STEPS[:1])]
        if not questions.small or not space:
            ways.append(self.by_search(short=self.net.priorities))
        ways += [self.by_need(LOCAL_STEPS[1:2]), *space]
        if self.net.priorities:
            ways.append(self.by_search())
        return [*ways, self.by_need(LOCAL_STEPS[2:], runs=True), self.by_paths(LOCAL_STEPS[2:4], enrich=True)]

    def shown(self, formula: Formula, holds: bool, ways: Sequence[str]) -> tuple[Witness, Choice | NoSpace]:
        """The run that shows the value of a formula, and who has answered."""
        questions = self.questions
        parts = parts_at_first(self.known.simple(formula)) if self.known.paths else []
        if not questions.made or any(part in self.known.paths for part in parts):
            listed = ", ".join(way.lower().replace("_", " ") for way in ways)
            choice = NoSpace(f"no space was needed ({listed})")
            try:
                return self.known.explain(formula, holds, questions.names), choice
            except NoRun:
                pass
            try:
                _ = questions.space
            except McpnError as error:
                witness = self.known.beginning(questions.names)
                witness.shown.append(f"no run is shown, since it needs the space: {error}")
                return witness, choice
        return explain(questions.evaluation, formula, questions.names), questions.choice

    @cached_property
    def searches(self) -> Searches:
        """Walks and searches on the net, which all ways share."""
        from mcpn.spaces.search.searches import Searches

        return Searches(self.net)

    @cached_property
    def searched(self) -> bool:
        """Whether a search may answer all that is asked, so that it begins: often it is over at once."""
        goals = (self.known.goal(part) is not None for part in self.parts())
        return all(isinstance(asked, Formula) for asked in self.waiting.values()) and all(goals)

    def paced(self, steps: int) -> int:
        """Fewer steps where each takes longer, since the net is large."""
        size = len(self.net.places) + len(self.net.transitions)
        return max(FEWEST_STEPS, steps * PACED // max(size, PACED))

    def affordable(self, rounds: Sequence[int]) -> list[int]:
        """Rounds of steps of which none lists more states than may be listed."""
        most = self.questions.max_states
        return list(rounds) if most is None else sorted({min(steps, most) for steps in rounds})

    def one_safe_at_sight(self) -> Iterator[ContestAnswer]:
        """Answers whether the net is 1-safe, where the initial marking or a walk shows that it is not."""
        if ONE_SAFE not in self.waiting.values():
            return
        searches = self.searches
        if max(self.net.initial, default=0) > 1:
            yield from self.learn(ONE_SAFE, False, INITIAL_STATE)
        elif self.questions.engine == "auto" and searches.fits and searches.walk_unsafe(steps=WALK_STEPS):
            yield from self.learn(ONE_SAFE, False, RANDOM_WALK)

    def one_safe(self) -> Iterator[ContestAnswer]:
        """Answers whether the net is 1-safe; if it is, the space is then there for all that is asked."""
        if ONE_SAFE in self.waiting.values():
            safe = self.questions.one_safe()
            engine = self.questions.choice.engine if safe else self.questions.engine
            yield from self.learn(ONE_SAFE, safe, _technique(engine))

    def by_structure(self) -> Iterator[ContestAnswer | None]:
        """Bounds places by invariants, and simplifies by them."""
        if self.net.priorities:
            return
        from mcpn.nets.structure import bounding

        self.known.bounds = yield from bounding(self.net)
        if self.facts:
            self.facts.bounded_by(self.known.bounds)
        self.known.forget()
        yield from self.rewritten()

    def by_space(self) -> Iterator[ContestAnswer | None]:
        """Asks the space, once the race for it is over."""
        questions, at_once = self.questions, False
        try:
            if questions.searchable and not (self.typed or self.net.priorities):
                at_once = questions.made or (yield from questions.spaces.going_on(FIRST_STEPS))
                if not at_once:
                    yield from questions.spaces.going_on(MOST_STEPS)
            yield from self.one_safe()
            space = questions.space if self.waiting else None
            self.tell_open()
        except McpnError as error:
            self.failed = error
            return
        yield from self.asking(space, at_once=at_once)

    def asking(self, space: Space[Any] | None, *, at_once: bool) -> Iterator[ContestAnswer | None]:
        """Asks a space in rounds; of a small one, that is there at once, few markings decide much before."""
        store = space.encoding.store if isinstance(space, DiagramMarkings | DiagramAlternatives) else None
        tried: Counter[str] = Counter()
        if at_once:
            yield from self.asked_of(store, tried, lambda asked: not isinstance(asked, Formula))
            yield from self.by_need(LOCAL_STEPS[:1])
            yield from self.by_paths(LOCAL_STEPS[:1])
        while self.waiting:
            yield from self.asked_of(store, tried, lambda asked: True)

    def asked_of(
        self, store: Store | None, tried: Counter[str], which: Callable[[Meaning], bool]
    ) -> Iterator[ContestAnswer | None]:
        """Asks the space each question once that has been tried least often."""
        least = min(map(tried.__getitem__, self.waiting), default=0)
        names = [name for name, asked in self.waiting.items() if tried[name] == least and which(asked)]
        for name in sorted(names, key=lambda name: effort(self.waiting[name])):
            if name not in self.waiting:  # what was answered before it has implied its answer
                continue
            value = None
            with within_seconds(store, FIRST_SLICE_OF_QUESTION * SLICE_FACTOR**least):
                value = self.value(name)
            tried[name] += 1
            if value is not None:
                yield from self.answer(name, value, _technique(self.questions.choice.engine))
            yield None

    def bounded(self) -> Iterator[ContestAnswer]:
        """Finds weaker and stronger parts that speak of one operator: what is not so weakly is not so."""
        for part in [] if self.typed or self.net.priorities else self.parts():
            if self.known.goal(part) is None and part not in self._weighed and not says_paths(part):
                self._weighed.add(part)
                for bound, when in zip(bounds_of(part), (False, True), strict=True):
                    simple = self.known.rest(bound)
                    if simple in (TRUE, FALSE):
                        if (simple == TRUE) == when:
                            yield from self.learn(part, when, REWRITING)
                            break
                    elif isinstance(simple, EU | EG | EX) and simple != part:
                        self.bounding.setdefault(simple, []).append((part, when))
        formulas = [asked for asked in self.waiting.values() if isinstance(asked, Formula)]
        inside = list(chain.from_iterable(map(self.known.nested, formulas)))
        for part in inside:
            if part not in self.known.values:
                self.nested.add(part)
                self.bounding.setdefault(part, [])
        if any(part in self.known.values for part in inside):
            self.known.forget()
            yield from self.rewritten(HOME)

    def by_equation(self) -> Iterator[ContestAnswer | None]:
        """Answers bounds and examinations by the state equation and by walks that come to what it allows."""
        if self.net.priorities:
            return
        from mcpn.spaces.search.facts import Facts

        self.facts = Facts(self.net, self.known.bounds, self.searches)
        ways = self.sums_by_equation(), self.examined_by_equation(), self.simplified_by_equation()
        yield from in_turns(ways, lambda: not self.waiting)

    def sums_by_equation(self) -> Iterator[ContestAnswer | None]:
        """Answers bounds of sums of tokens."""
        assert self.facts is not None
        sums = [asked for asked in dict.fromkeys(self.waiting.values()) if isinstance(asked, tuple)]
        for found in self.facts.sums(asked for asked in sums if asked in self.waiting.values()):
            if found is None:
                yield None
            else:
                places, bound, ways = found
                yield from self.learn(places, bound, *ways)

    def examined_by_equation(self) -> Iterator[ContestAnswer | None]:
        """Answers examinations."""
        assert self.facts is not None
        asked = [name for name in self.facts.examinations if name in self.waiting.values()]
        yield from in_turns(map(self.examining, asked), lambda: not self.waiting)

    def examining(self, name: str) -> Iterator[ContestAnswer | None]:
        """Answers one examination."""
        assert self.facts is not None
        value, ways = yield from self.facts.examinations[name]()
        if value is not None and name in self.waiting.values():
            yield from self.learn(name, value, *ways)

    def simplified_by_equation(self) -> Iterator[ContestAnswer | None]:
        """Simplifies formulas by what always holds, or may always hold again."""
        facts = self.facts
        assert facts is not None
        formulas = [asked for asked in self.waiting.values() if isinstance(asked, Formula)]
        asked = chain.from_iterable(map(conditions, map(self.known.simple, formulas)))
        self.known.believe(facts)
        known, rested = 0, 0.0
        for _ in facts.knowing(asked):
            yield None
            begun = time.process_time()
            if facts.constants > known and begun >= rested:
                known = facts.constants
                self.known.forget()
                yield from self.rewritten(STATE_EQUATION)
                now = time.process_time()
                rested = now + RESTS * (now - begun)
        self.known.forget()
        yield from self.rewritten(STATE_EQUATION)
        if LIVE in self.waiting.values() or any(self.known.goal(part) is None for part in self.parts()):
            self.known.home = home = yield from facts.going_home()
            if home:
                dead = not self.net.enabled(home.marking)
                yield from self.learn(SOME_DEADLOCK, dead, HOME, STATE_EQUATION)
                self.known.forget()
                yield from self.rewritten(STATE_EQUATION)

    def by_search(self, *, short: bool = False) -> Iterator[ContestAnswer | None]:
        """Answers what asks for reachable markings by search.

        Args:
            short: Whether there is no more than one search, for a short run.
        """
        if short is False and self.net.priorities and self.typed and not isinstance(self.failed, LimitError):
            return
        from mcpn.spaces.search.portfolio import ROUNDS, SHORT, Portfolio

        budgets = [self.limited(budget) for budget in ([SHORT] if short else ROUNDS)]
        portfolio, had = Portfolio(self.net, self.searches), Counter[Formula]()
        while True:  # what is learnt brings up other parts, which begin
            yield from self.bounded()
            goals = {part: goal for part in self.sought() if (goal := self.known.goal(part)) is not None}
            number = min(map(had.__getitem__, goals), default=len(budgets))
            if number == len(budgets):
                return
            portfolio.keep(goals.values())
            searched = [part for part in goals if had[part] == number]
            had.update(searched)

            def asked(index: int, among: Sequence[Formula] = searched) -> bool:
                return among[index] in self.sought()

            for told in portfolio.going_on(
                [goals[part] for part in searched], budgets[number], number, asked
            ):
                if told is None:
                    yield None
                    continue
                index, found = told
                if found.run is not None:
                    self.known.runs[searched[index]] = found.run
                yield from self.learn(searched[index], found.reachable, *found.techniques)

    def limited(self, budget: Round) -> Round:
        """A budget within the user's limit on markings that are listed."""
        most = self.questions.max_states
        return budget if most is None else replace(budget, states=min(budget.states, most))

    def by_need(
        self, rounds: Sequence[int] = LOCAL_STEPS, *, runs: bool = False
    ) -> Iterator[ContestAnswer | None]:
        """Asks markings as they are needed; each part has its turn in each round.

        Args:
            rounds: Steps for each part, in rounds.
            runs: Whether a part that holds is answered although no run is known that shows it.
        """
        if self.net.priorities or not self.searches.fits:  # whose atoms are no conditions on tokens alone
            return
        for steps in self.affordable(rounds):
            # What a search looks for is its own: it needs fewer markings.
            searched = self.typed and steps > LOCAL_STEPS[1]
            asked = [part for part in (*self.parts(), *self.nested) if not says_paths(part)]
            parts = [part for part in asked if searched or self.known.goal(part) is None]
            if not parts:
                continue
            if self.local is None:
                from mcpn.logic.on_the_fly import LocalChecks

                self.local = LocalChecks(self.net, self.searches)
            seed, self.rounds = self.rounds, self.rounds + 1
            for part in parts:
                if part in self.known.values:
                    continue
                self.local.ask(asked)
                value = yield from self.local.deciding(part, self.paced(steps), seed)
                # EX is shown by one step; other parts that hold need a run, which is not known.
                if value is False or (value and (runs or not self.typed or isinstance(part, EX))):
                    yield from self.learn(part, value, EXPLICIT)
                yield None

    def by_paths(
        self, rounds: Sequence[int] = LOCAL_STEPS, *, enrich: bool = False
    ) -> Iterator[ContestAnswer | None]:
        """Looks for paths that parts ask for, marking by marking; each part has its turn in each round.

        Args:
            rounds: Steps for each part, in rounds.
            enrich: Whether to ask in the first round, too, what holds always, or never.
        """
        if self.net.priorities:
            return
        for steps in self.affordable(rounds):
            yield from self.bounded()
            enrich = enrich or steps > rounds[0]
            # Others are asked marking by marking as well, and the space is quicker, once it is there.
            every = enrich and steps <= LOCAL_STEPS[1] and not (self.typed or self.questions.made)
            parts = [part for part in self.parts() if every or says_paths(part)]
            parts += () if self.questions.made else self.bounding
            if self.paths is None:
                from mcpn.logic.ltl.parts import PathParts

                self.paths = PathParts(self.net, self.searches)
            self.path_rounds += 1
            for part in parts:
                path = on_one_path(part, self.net)
                if path is None or part in self.known.values or self.known.goal(part) is not None:
                    continue
                found = yield from self.paths.deciding(
                    path, self.paced(steps), self.path_rounds, enrich=enrich
                )
                if found is not None and found.outcome in ("found", "none"):
                    if found.outcome == "found":
                        self.known.paths[part] = found
                    yield from self.learn(part, found.outcome == "found", EXPLICIT)
                yield None

    def value(self, name: str) -> int:
        """The answer by the space: a truth value or a number."""
        # A typed formula is asked as it was written: so is the run that shows it.
        meaning, questions = (self.asked if self.typed else self.waiting)[name], self.questions
        if self.typed:
            step(Doing.ANSWERING, question=name)
        if isinstance(meaning, tuple):
            return largest(questions.space, Counter(meaning))
        if isinstance(meaning, str):
            from mcpn.logic.behaviour import EXAMINATIONS, Behaviour

            return EXAMINATIONS[meaning](Behaviour(questions.space))
        return questions.evaluation.holds(meaning)


def _technique(engine: Asked) -> str:
    return {engine_names.EXPLICIT: EXPLICIT, engine_names.LOCAL: COMPOSITION}.get(engine, DIAGRAMS)
