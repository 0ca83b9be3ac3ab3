"""Names of elements: where texts refer to them, which are there twice, in a circle, or new after an edit.

One declaration for all that follows names: what a datatype refers to is said beside the datatype, what words
of formulas and conditions refer to is said here. What a name means, where that depends on what is declared
(``oos(x)`` may be of hardware or of an activity that crashes), is left to the reader.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from mcpn.errors import Problem, Source
from mcpn.mission.language.forms import form_of
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.robot import Element

EXITS = (SUCCEED, FAIL, ABORT)
"""Routes that name no block."""

WORDS = {
    **dict.fromkeys(("objective", "pending", "done"), "objective"),
    "block": "block path",
    **dict.fromkeys(("activity", "waiting", "refused", "alternative"), "activity"),
    **dict.fromkeys(("oos", "available"), "loss"),
    **dict.fromkeys(("event", "happens"), "happening"),
    "fact": "fact",
}
"""By word of formulas about an element, what it names: a kind of element, or

- ``objective``: an elementary objective, or copies of it, which blocks around may qualify,
- ``block path``: the same of any block,
- ``loss``: a resource, or an activity or alternative that crashes,
- ``happening``: an event, declared or of an element.
"""
VALUED = {"alternative": "alternative", "waiting": "alternative", "fact": "value"}
"""By word of formulas that a value may follow, what the value is."""

_NAME = re.compile(r"[A-Za-z_]\w*")
_REASON = re.compile(r"(?<![\w.=+-])[A-Za-z_]\w*")
"""One that a probability may follow, in which a letter is no name: ``no_path=2e-4``."""
_PATH = re.compile(r"[A-Za-z_][\w.]*")
_SAID = re.compile(
    r"(?<![\w.\"])(?P<word>" + "|".join(WORDS) + r")\s*\(\s*\"?(?P<name>[A-Za-z_][\w.]*)\"?\s*\)"
    r"(?:\s*=\s*\"?(?P<value>\w+))?"
)
_ENDING = re.compile(r"OBJ_(?P<name>[\w.]+)_EV_(?P<how>OK|FAIL(?:_(?P<reason>[A-Za-z_]\w*))?|TIMEOUT)")
_CHANGING = re.compile(r"(?P<name>[\w.]+)_EV_(?:OOS|RD|DEATH|DETECTED)")


class Reference(NamedTuple):
    """A name in a text.

    Args:
        kind: What it names: a kind of element, or one of those of :data:`WORDS`.
        name: The name.
        place: Where it begins in the text.
        owner: The activity of an alternative, or the fact of a value.
    """

    kind: str
    name: str
    place: int
    owner: str = ""


def references(refers: str, text: str) -> Iterator[Reference]:
    """The names in the text of an attribute.

    Args:
        refers: What its datatype refers to: a kind of element, ``condition``, ``formula`` or ``objective``.
        text: The text.

    Examples:
        >>> [(each.kind, each.name) for each in references("condition", "!holding done(survey) door=open")]
        [('fact', 'holding'), ('objective', 'survey'), ('fact', 'door'), ('value', 'open')]
        >>> [(each.kind, each.name, each.owner) for each in references("formula", "AG !alternative(a)=b")]
        [('activity', 'a', ''), ('alternative', 'b', 'a')]
    """
    if refers == "formula":
        yield from _in_formula(text)
    elif refers == "condition":
        yield from _in_condition(text)
    elif refers:
        for word in {"objective": _PATH, "reason": _REASON}.get(refers, _NAME).finditer(text):
            if refers != "block" or word[0] not in EXITS:
                yield Reference(refers, word[0], word.start())


def _in_formula(text: str) -> Iterator[Reference]:
    for said in _SAID.finditer(text):
        word, name, begin = said["word"], said["name"], said.start("name")
        kind, owner = WORDS[word], ""
        if word == "alternative" and said["value"] is None and "." in name:
            owner, _, name = name.rpartition(".")
            yield Reference("activity", owner, begin)
            kind, begin = "alternative", begin + len(owner) + 1
        yield Reference(kind, name, begin, owner)
        if said["value"] is not None and word in VALUED:
            yield Reference(VALUED[word], said["value"], said.start("value"), name)


def _in_condition(text: str) -> Iterator[Reference]:
    for said in re.finditer(
        r"!?(?:done\((?P<done>[^()\s]*)\)|(?P<fact>[^\s=!()]+))(?:=(?P<value>\w+))?", text
    ):
        if said["done"]:
            yield Reference("objective", said["done"], said.start("done"))
        elif said["fact"]:
            yield Reference("fact", said["fact"], said.start("fact"))
            if said["value"]:
                yield Reference("value", said["value"], said.start("value"), said["fact"])


def reason_in(name: str) -> Reference | None:
    """The reason that an event has which is a failure for one.

    Examples:
        >>> reason_in("OBJ_dive_EV_FAIL_too_deep")
        Reference(kind='reason', name='too_deep', place=17, owner='')
    """
    ending = _ENDING.fullmatch(name)
    if ending is None or ending["reason"] is None:
        return None
    return Reference("reason", ending["reason"], ending.start("reason"))


def happening(name: str) -> Reference:
    """What an event is of that nobody declares by its name: an objective that ends, a loss; else an event.

    The time of any block may be over.

    Examples:
        >>> happening("OBJ_dive_EV_OK")
        Reference(kind='objective', name='dive', place=4, owner='')
        >>> happening("sonar_EV_OOS").kind, happening("leak").kind
        ('loss', 'event')
    """
    if (ending := _ENDING.fullmatch(name)) is not None:
        kind = "block path" if ending["how"] == "TIMEOUT" else "objective"
        return Reference(kind, ending["name"], ending.start("name"))
    if (changing := _CHANGING.fullmatch(name)) is not None:
        return Reference("loss", changing["name"], 0)
    return Reference("event", name, 0)


def unseen(mission: Element, before: Element | None = None) -> Iterator[Element]:
    """The named elements of a mission that ``before`` does not have, itself first, in document order.

    Args:
        mission: The mission.
        before: What it was before an edit; elements of it that were kept are passed over.
    """
    stack: list[tuple[Any, Any]] = [(mission, before)]
    while stack:
        element, old = stack.pop()
        if isinstance(element, Element):
            yield element
        for content in reversed([*form_of(type(element)).held()]):
            members, others = getattr(element, content.name), getattr(old, content.name, ())
            known = set(map(id, others))
            alike = others if len(others) == len(members) else (None,) * len(members)
            pairs = zip(reversed(members), reversed(alike), strict=True)
            stack.extend(pair for pair in pairs if id(pair[0]) not in known)


def duplicates(kind: str, elements: Iterable[Element]) -> Iterator[Problem]:
    """Elements of one kind that have the name of an earlier one."""
    first: dict[str, Element] = {}
    for element in elements:
        earlier = first.get(element.name)
        if earlier is not None:
            where = f", first declared at {earlier.source}" if earlier.source else ""
            yield Problem(element.source, f"{kind} {element.name} is declared twice{where}")
        first.setdefault(element.name, element)


def repeats(source: Source | None, what: str, names: tuple[str, ...]) -> Iterator[Problem]:
    """Names that an attribute says more than once."""
    for name, count in Counter(names).items():
        if count > 1:
            yield Problem(source, f"{what} names {name} {count} times")


def cycles(
    what: str, elements: Mapping[str, Element], after: Callable[[str], list[str]]
) -> Iterator[Problem]:
    """One problem for each edge that closes a cycle in a depth-first walk of the references ``after``."""
    finished: set[str] = set()
    for start in elements:
        path: dict[str, None] = {}
        stack = [(start, iter(after(start)))] if start not in finished else []
        if stack:
            path[start] = None
        while stack:
            name, left = stack[-1]
            following = next(left, None)
            if following is None:
                finished.add(name)
                stack.pop()
                del path[name]
            elif following in path:
                names = list(path)
                cycle = [*names[names.index(following) :], following]
                yield Problem(elements[following].source, f"{what}: {' -> '.join(cycle)}")
            elif following in elements and following not in finished:
                path[following] = None
                stack.append((following, iter(after(following))))
