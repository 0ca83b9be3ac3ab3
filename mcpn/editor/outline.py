"""The outline of a mission's text: its named elements, each in that around it."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcpn.editor.scan import TOKEN, ScannedElement
from mcpn.mission.language.forms import language
from mcpn.mission.robot import Described, Element


@dataclass
class Outlined:
    """A named element in the outline of a text.

    Args:
        element: The element.
        end: Behind its end tag.
        inside: Named elements inside.
    """

    element: ScannedElement
    end: int
    inside: list[Outlined] = field(default_factory=list)


def outline(text: str, elements: list[ScannedElement]) -> list[Outlined]:
    """The named elements of a text, each in that around it, also where the text is no XML yet.

    Args:
        text: The text.
        elements: What was scanned of it.
    """
    ends, roots = _ends(text, elements), list[Outlined]()
    shown = dict[int, Outlined]()
    for element in elements:
        if not _named(element):
            continue
        made = Outlined(element, ends.get(element.begin, element.end))
        around = (shown[e.begin] for e in element.around if e is not element and e.begin in shown)
        next(around, Outlined(element, 0, roots)).inside.append(made)
        shown[element.begin] = made
    return roots


def _named(element: ScannedElement) -> bool:
    tag = language().get(element.tag)
    return (
        bool(element.texts.get("name")) and tag is not None and issubclass(tag.forms[0], (Element, Described))
    )


def _ends(text: str, elements: list[ScannedElement]) -> dict[int, int]:
    """By where an element begins, behind its end tag; what is never closed ends with the text."""
    found, stack = dict[int, int](), list[ScannedElement]()
    known = {element.begin: element for element in elements}
    for token in TOKEN.finditer(text):
        if token["inside"] is None:
            continue
        if token["close"]:
            while stack:
                last = stack.pop()
                found[last.begin] = token.end() if last.tag == token["tag"] else token.start()
                if last.tag == token["tag"]:
                    break
        elif (element := known.get(token.start())) is not None and element.holds:
            stack.append(element)
    return found | {element.begin: len(text) for element in stack}
