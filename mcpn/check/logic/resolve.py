"""From formulas as they are written to the core, names looked up, and back for a reader.

>>> from mcpn.net.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> builder.transition("switch", consume=["off"], produce=["on"])
>>> resolve(Compare(Sum(0, ("on",)), ">=", Sum(1)), builder.build())
AtMost(weights=((1, -1),), bound=-1)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from difflib import get_close_matches
from itertools import islice, repeat
from typing import TYPE_CHECKING, TypeAlias

from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    MEANING,
    And,
    Compare,
    Const,
    Core,
    Derived,
    Enabled,
    Fires,
    Formula,
    Justice,
    Not,
    Sum,
    Word,
    mapped,
    negation,
    operands,
)
from mcpn.errors import InputError, LimitError
from mcpn.net.events import START, Event, What
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import AtMost

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet

MAX_CORE = 50_000
MAX_LISTED = 20
"""How many known names an error lists where none of them is near."""

Said: TypeAlias = dict[Core, Formula]
"""By meaning the words of the mission that a formula has used for it."""


def resolve(
    formula: Formula, net: PetriNet, mission_net: MissionNet | None = None, said: Said | None = None
) -> Core:
    """Looks up every name of a formula and rewrites it to the core.

    Args:
        formula: As it was written.
        net: Names places and transitions.
        mission_net: Names elements of the mission, where the net is of one.
        said: Takes in what words of the mission mean, so that :func:`written` says them again.

    Returns:
        The same in the core.

    Raises:
        InputError: A name is unknown; the message has its column and the nearest names that exist.
        LimitError: The core would have more than :data:`MAX_CORE` operators; ``<->`` and ``A[ U ]`` say what
            is in them twice there.
    """
    if _size(formula) > MAX_CORE:
        raise LimitError(f"the formula says more than {MAX_CORE} operators in full: the limit was hit")
    return _Resolver(net, mission_net, {} if said is None else said).core(formula)


_USES = {"<->": (2, 2), "AU": (1, 3)}
"""How often the meaning of a derived operator has each of its operands, where more than once."""


def _size(formula: Formula) -> int:
    """How many operators the core of a formula has."""
    uses = _USES.get(formula.operator, (1, 1)) if isinstance(formula, Derived) else repeat(1)
    return 7 + sum(use * _size(inside) for use, inside in zip(uses, operands(formula), strict=False))


class _Resolver:
    def __init__(self, net: PetriNet, mission_net: MissionNet | None, said: Said) -> None:
        self.net = net
        self.mission_net = mission_net
        self.meant = said

    def core(self, formula: Formula) -> Core:
        match formula:
            case Derived(operator, inside):
                return MEANING[operator](*map(self.core, inside))
            case Compare():
                return self.compare(formula)
            case Enabled(names, column):
                known = self.net.transition_index
                return Fires(tuple(sorted({self.known(n, known, "transition", column) for n in names})))
            case Word():
                meaning = self.word(formula)
                if not isinstance(meaning, Const):  # which other formulas mean as well
                    self.meant.setdefault(meaning, formula)
                    self.meant.setdefault(negation(meaning), Not(formula))
                return meaning
        return mapped(formula, self.core)

    def known(self, name: str, index: Collection[str], what: str, column: int | None) -> int:
        if name not in index:
            raise unknown(name, index, what, column)
        return index[name]  # type: ignore[index, no-any-return]

    def compare(self, formula: Compare) -> Core:
        left, relation, right, column = formula.left, formula.relation, formula.right, formula.column
        if relation in ("=", "!="):
            equal = And((self.at_most(left, right, 0, column), self.at_most(right, left, 0, column)))
            return equal if relation == "=" else Not(equal)
        small, large = (left, right) if relation in ("<", "<=") else (right, left)
        return self.at_most(small, large, 0 if "=" in relation else -1, column)

    def at_most(self, left: Sum, right: Sum, slack: int, column: int | None) -> Core:
        known = self.net.place_index
        weights = Counter[int]()
        for side, sign in ((left, 1), (right, -1)):
            for name in side.places:
                weights[self.known(name, known, "place", column)] += sign
        bound = right.constant - left.constant + slack
        terms = tuple(sorted((place, weight) for place, weight in weights.items() if weight))
        return AtMost(terms, bound) if terms else Const(bound >= 0)

    # --- words of the mission ---

    def word(self, word: Word) -> Core:
        mission_net = self.mission_net
        if mission_net is None:
            raise _at(word.column, f"{word.kind} is a word of missions, and this net is of none")
        name = word.argument or ""
        match word.kind:
            case "success" | "failure":
                return marked(mission_net.by_role[word.kind, mission_net.mission.name])
            case "objective" | "pending":
                graph = mission_net.graph
                objectives = [*graph.walk(), *graph.never_entered()]
                # Copies of an objective, for what comes after a handler that happens once, are the same to
                # who asks for it as it is written.
                written = {s.name: [s.name] for s in objectives}
                for section in objectives:
                    if section.name not in (named := written.setdefault(section.written, [])):
                        named.append(section.name)
                return self.said(word.kind, written[self.element(name, written, "objective", word)])
            case "oos" | "available":
                return self.resource(mission_net, word, name)
            case "event":
                texts = {str(t.event) for t in self.net.transitions if t.event}
                declared = Event(What.DECLARED, name)
                if str(declared) in texts or name in {e.name for e in mission_net.mission.events}:
                    event = declared
                else:
                    event = Event.parse(self.element(name, texts, "event", word))
                return Fires(tuple(i for i, t in enumerate(self.net.transitions) if t.event == event))
        return self.activity(word, name)

    def resource(self, mission_net: MissionNet, word: Word, name: str) -> Core:
        hardware = [h.name for h in mission_net.mission.hardware]
        producers = mission_net.usage.producer
        if word.kind == "available" and name in producers:
            return self.running("active", producers[name])
        self.element(name, hardware if word.kind == "oos" else [*hardware, *producers], "resource", word)
        oos = self.said("oos", [name])
        return oos if word.kind == "oos" else negation(oos)

    def activity(self, word: Word, name: str) -> Core:
        """What is said of an activity, or of one of its alternatives."""
        assert self.mission_net is not None
        activities = self.mission_net.usage.activities
        alternative = word.value
        if word.kind == "alternative" and alternative is None:
            name, _, alternative = name.rpartition(".")
            if not name:
                raise _at(
                    word.column, f"expected alternative(activity)=name, found no name after {alternative}"
                )
        self.element(name, activities, "activity", word)
        if word.kind == "alternative":
            known = [a.name for a in activities[name].alternatives]
            self.element(alternative or "", known, f"alternative of {name}", word)
            return self.said("active", [f"{name}.{alternative}"])
        if word.kind == "refused":
            return self.said("refused", [name])
        return self.running("wait" if word.kind == "waiting" else "active", name)

    def running(self, kind: str, activity: str) -> Core:
        assert self.mission_net is not None
        alternatives = self.mission_net.usage.activities[activity].alternatives
        return self.said(kind, [f"{activity}.{a.name}" for a in alternatives])

    def said(self, kind: str, names: list[str]) -> Core:
        """Some place that says so is marked; false where the templates have none."""
        assert self.mission_net is not None
        places = self.mission_net.saying(kind)
        return marked(tuple(place for place, name in places.items() if name in names))

    def element(self, name: str, names: Collection[str], what: str, word: Word) -> str:
        """The name in full: the use of a protocol that qualifies it may be left out where one name fits."""
        fitting = [known for known in names if known.endswith(f".{name}")]
        if name not in names and len(fitting) == 1:
            return fitting[0]
        if name not in names:
            raise unknown(name, names, what, word.column)
        return name


def marked(places: tuple[int, ...]) -> Core:
    """Some of these places holds a token."""
    return AtMost(tuple((place, -1) for place in sorted(places)), -1) if places else Const(False)


def unknown(name: str, names: Collection[str], what: str, column: int | None) -> InputError:
    """The error for a name that does not exist."""
    near = get_close_matches(name, names, n=3)
    if not near:  # the use of a protocol that qualifies a name may have been left out, or be another
        by_last = {known.rpartition(".")[2]: known for known in names}
        near = [by_last[last] for last in get_close_matches(name.rpartition(".")[2], by_last, n=3)]
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    if not near and names:
        shown = islice(names, MAX_LISTED)
        hint = f"; expected one of {', '.join(shown)}{', ...' if len(names) > MAX_LISTED else ''}"
    return _at(column, f"no {what} is named {name}{hint}")


def _at(column: int | None, message: str) -> InputError:
    return InputError.at(None, message if column is None else f"formula, column {column}: {message}")


def written(formula: Core, net: PetriNet, said: Said | None = None) -> Formula:
    """A formula of the core with names instead of indices, and with the operators that a reader knows.

    Args:
        formula: Of the core.
        net: Names places and transitions.
        said: Words of the mission that are said again, see :func:`resolve`.
    """

    def of(inside: Core) -> Formula:
        return written(inside, net, said)

    match formula:
        case AtMost() | Fires() | Not(AtMost() | Fires()) if said and formula in said:
            return said[formula]
        case AtMost(((place, -1),), -1):
            return Compare(Sum(0, (net.places[place].name,)), ">=", Sum(1))
        case AtMost(weights, bound):
            positive = tuple(net.places[p].name for p, w in weights for _ in range(w))
            negative = tuple(net.places[p].name for p, w in weights for _ in range(-w))
            return Compare(Sum(max(-bound, 0), positive), "<=", Sum(max(bound, 0), negative))
        case Fires(transitions):
            return Enabled(tuple(net.transitions[t].name for t in transitions))
        case Not(Not(a)):
            return of(a)
        case Not(EX(a)):
            return Derived("AX", (of(Not(a)),))
        case Not(EG(a)):
            return Derived("AF", (of(Not(a)),))
        case Not(EU(Const(True), a)):
            return Derived("AG", (of(Not(a)),))
        case EU(Const(True), a):
            return Derived("EF", (of(a),))
    return mapped(formula, of)


def progress(mission_net: MissionNet) -> tuple[Justice, ...]:
    """Constraints under which a mission goes on: it starts, and running objectives end some day.

    Without it ``AF`` says nothing of a mission whose hardware may fail and recover for ever. A loop of
    objectives that is run for ever is fair: each of them ends again and again.

    Args:
        mission_net: The mission's net.

    Returns:
        For the start and for each objective: again and again it is not to be awaited or not running, or the
        start, its ``OK`` or its ``FAIL`` happens.
    """
    net = mission_net.net
    starts = [i for i, t in enumerate(net.transitions) if t.event == START]
    constraints = [
        Justice(negation(marked(tuple(p for p, _ in net.transitions[i].consume))), (i,)) for i in starts
    ]
    for place, name in mission_net.saying("objective").items():
        endings = {Event(What.SUCCESS, name), Event(What.FAILURE, name)}
        taken = tuple(i for i, t in enumerate(net.transitions) if t.event in endings)
        constraints.append(Justice(negation(marked((place,))), taken))
    return tuple(constraints)
