"""What questions about one net or mission share: names, limits, the engine, the space once it is made."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

from mcpn.errors import InputError, LimitError, Problem, UnboundedError, UnsafeError
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import Justice
from mcpn.logic.syntax import parse
from mcpn.notebook import Told
from mcpn.sentences import quoted
from mcpn.spaces.algebra import Space
from mcpn.spaces.diagrams.base import Diagrams
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.engine_names import EXPLICIT, SYMBOLIC, Asking, On
from mcpn.spaces.engines import Choice, NoSpace, answered, refuse_unknown
from mcpn.spaces.formula_names import PROGRESS
from mcpn.spaces.registry import Subject, spaces_of
from mcpn.spaces.search.goal import Formula

if TYPE_CHECKING:
    from mcpn.logic.witness import Witness


@dataclass(frozen=True)
class Answer(Told):
    """The answer to a formula.

    Args:
        formula: As it was written.
        holds: Whether the initial state satisfies it.
        witness: A run that shows why.
        choice: The engine that answered.
        techniques: How, in words of the Model Checking Contest.
    """

    formula: str
    holds: bool
    witness: Witness
    choice: Choice | NoSpace
    techniques: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<{self.formula} {'holds' if self.holds else 'fails'}>"


class Session:
    """What questions about one net share: how they are meant, and the space, built when it is first needed.

    Args:
        subject: The spaces of a mission or of a net, or what they are to be built of.
        on: The graph that formulas speak of; by default a mission's stable states, or a net's markings.
        fair: ``progress`` or formulas that hold again and again on the infinite paths that count.
        **asked: Who makes the space, and within what limit: arrays, diagrams, composition, or ``auto``, see
            :mod:`mcpn.spaces.engines`, with a search before it where one may do; ``search``: nobody.

    Raises:
        InputError: A constraint is no formula, or the words do not fit the net.
    """

    def __init__(
        self,
        subject: Subject,
        *,
        on: On | None = None,
        fair: Sequence[str] = (),
        **asked: Unpack[Asking],
    ) -> None:
        refuse_unknown(on=on)
        self.spaces = spaces_of(subject, **asked)
        self.net = net = self.spaces.net
        on = on or self.spaces.asked_on
        if on == "alternatives" and not net.priorities:
            raise InputError.at(None, "the alternatives graph is of missions: this net has no priorities")
        self.on: On = on
        self.engine, self.max_states = self.spaces.engine, self.spaces.max_states
        self.names = self.spaces.names()
        self.fair: tuple[Justice, ...] = ()  # a constraint speaks of all paths itself
        self.fair = tuple(
            constraint
            for text in fair
            for constraint in (
                [Justice(*each) for each in self.spaces.progress()]
                if text == PROGRESS
                else [Justice(self.formula(text))]
            )
        )

    def formula(self, text: str) -> Formula:
        """The formula of a text; it raises what :func:`mcpn.logic.syntax.parse` does."""
        return parse(text, self.names, fair=bool(self.fair))

    def formulas(self, texts: Sequence[str]) -> dict[str, Formula]:
        """The formulas of several texts; errors of all of them say which they are about.

        Raises:
            InputError: As :meth:`formula`, of one of several with its number and text.
            LimitError: As :meth:`formula`.
        """
        if len(texts) == 1:
            return {texts[0]: self.formula(texts[0])}
        read, problems = dict[str, Formula](), list[Problem]()
        for number, text in enumerate(texts, 1):
            which = f"formula {number}, {quoted(text, 40)}"
            try:
                read[text] = self.formula(text)
            except InputError as error:
                for source, message in error.problems:
                    problems.append(Problem(source, f"{which}: {re.sub('^formula[:,] ', '', message)}"))
            except LimitError as error:
                raise LimitError(f"{which}: {error}") from error
        if problems:
            raise InputError(problems)
        return read

    @property
    def searchable(self) -> bool:
        """Whether reachability of a state may be asked of a search: no engine by name, all paths count.

        A run from one stable state to the next is one of the alternatives graph where each event has one
        outcome. Where activities contend, that is for the space to prove.
        """
        exact = self.on == "markings" or self.spaces.one_outcome
        return self.engine in ("auto", "search") and not self.fair and exact

    @property
    def small(self) -> bool:
        """Whether the space is of a mission and soon listed."""
        return self.spaces.few()

    @property
    def made(self) -> bool:
        """Whether the space has been built."""
        return "_chosen" in self.__dict__

    @property
    def space(self) -> Space[Any]:
        """The space that formulas speak of; it raises what :meth:`mcpn.spaces.registry.Spaces.space` does."""
        return self._chosen[0]

    @property
    def choice(self) -> Choice:
        """Who has made the space."""
        return self._chosen[1]

    @cached_property
    def _chosen(self) -> tuple[Space[Any], Choice]:
        return self._made()

    def _made(self, *, tokens: bool = True) -> tuple[Space[Any], Choice]:
        def by(choice: Choice) -> Space[Any]:
            return self.spaces.space(choice, self.on, tokens=tokens)

        space, choice = answered(by, self.spaces.choices(self.on))
        if choice.engine == SYMBOLIC and not isinstance(space, Diagrams):
            choice = Choice(EXPLICIT, "its markings were listed before a diagram held them")
        return space, choice

    def one_safe(self) -> bool:
        """Whether no place ever holds two tokens; where none does, the space has then been built.

        Raises:
            LimitError: A limit was hit.
        """
        try:
            if not self.made and (self.net.priorities or not self.searchable):
                self._chosen = self._made(tokens=False)
                return True
            space = self.space
        except (UnsafeError, UnboundedError):
            return False
        if isinstance(space, DiagramMarkings):
            return space.space.max_tokens_in_place <= 1
        # The space of a net with priorities is there only if it is 1-safe.
        places = () if self.net.priorities else range(len(self.net.places))
        return not any(space.everything - space.at_most({place: 1}, 1) for place in places)

    @cached_property
    def evaluation(self) -> Evaluation[Any]:
        """Evaluates formulas on the space, under the constraints."""
        return Evaluation(self.space, self.fair)
