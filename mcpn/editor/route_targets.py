"""Where a route may lead: the names that ``check`` accepts for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mcpn.editor.scan import ScannedElement
from mcpn.mission.language.forms import language
from mcpn.mission.language.references import EXITS
from mcpn.mission.model import (
    BlockElement,
    Each,
    EntryGuard,
    FactRoute,
    Handler,
    Mission,
    Objective,
    Parallel,
    Protocol,
)

_INSIDE = (Handler.TAG, FactRoute.TAG, EntryGuard.TAG)
_SERIES = (Mission.TAG, Protocol.TAG, Objective.TAG, Each.TAG)
_HELPERS = ("recover", "pause")
"""Attributes that name a sibling which is run for a block."""


def targets(element: ScannedElement, attribute: str, elements: Iterable[ScannedElement]) -> Iterator[str]:
    """The names that an attribute may say: siblings of what is routed, in the order of the text, then exits.

    Args:
        element: What has the attribute: a block, a handler or a route.
        attribute: Its name.
        elements: All of the file.
    """
    owner = element.parent if element.tag in _INSIDE else element
    if owner is None:
        return
    whole = owner.tag == Mission.TAG
    around = owner if whole else owner.parent
    if around is None:
        return
    helps, branch = attribute in _HELPERS, around.tag == Parallel.TAG
    every = list(elements)
    if not branch and around.tag in _SERIES and not (whole and helps):
        for each in every:
            sibling = each.parent is not None and each.parent.begin == around.begin and _block(each)
            if sibling and (not helps or (each.begin != owner.begin and not _needs_help(each, every))):
                yield sibling
    if not helps and (not branch or attribute in ("abort", "timeout_goto") or element.tag == Handler.TAG):
        yield from EXITS


def _block(element: ScannedElement) -> str:
    tag = language().get(element.tag)
    is_block = tag is not None and issubclass(tag.forms[0], BlockElement)
    return element.texts.get("name", "") if is_block else ""


def _needs_help(element: ScannedElement, elements: Iterable[ScannedElement]) -> bool:
    """Whether it recovers, or pauses, by a sibling itself: then it is run for no other."""
    inside = (e for e in elements if e.parent is not None and e.parent.begin == element.begin)
    pauses = any(e.tag == Handler.TAG and "pause" in e.texts for e in inside)
    return pauses or "recover" in element.texts
