"""Which attributes refer to names; missions under other names are the same but for these."""

from __future__ import annotations

import re

from hypothesis import given
from lxml import etree

from mcpn.mission.language.forms import NAMESPACE
from mcpn.mission.model import FAIL, SUCCEED, Mission
from mcpn.mission.writer import written
from mcpn.testing import missions
from mcpn.testing.awkward_names import renamed
from tests.mission.test_declaration import ATTRIBUTES, DRAWN, tag_of

REFERS = {
    "affects": "resource",
    "detects": "resource",
    "consumes": "resource",
    "produces": "resource",
    "activities": "activity",
    "success": "block",
    "failure": "block",
    "abort": "block",
    "timeout_goto": "block",
    "recover": "block",
    "pause": "block",
    "goto": "block",
    "else": "block",
    "fact": "fact",
    "requires": "condition",
    "when": "condition",
    "event": "event",
    "protocol": "protocol",
    "failures": "reason",
    "reason": "reason",
}
"""What each attribute that refers to something names."""


REQUIRED = {
    **dict.fromkeys(("of", "in"), "objective"),
    **dict.fromkeys(("formula", "after", "before", "until", "without"), "formula"),
    **dict.fromkeys(("by", "followed_by", "then", "to", "gives"), "formula"),
}
"""The same of requirements, whose formulas name elements in words."""


NAMED = {
    "fault": "resource",
    "hardware": "resource",
    "software": "resource",
    "activity": "activity",
    "alternative": "alternative",
    "event": "event",
    "fact": "fact",
    "protocol": "protocol",
    **dict.fromkeys(("objective", "parallel", "use", "each"), "block"),
}
"""What each element is of the kind of."""


def test_every_attribute_that_refers_is_known() -> None:
    assert {a.tag: a.datatype.refers for _, a in ATTRIBUTES if a.datatype.refers} == REFERS | REQUIRED


def renaming(begun: re.Match[str]) -> str:
    """What stands before the name in a word of a condition, with that of its kind."""
    return f"{begun[0]}{'block' if begun[2] else 'fact'}__"


@given(DRAWN | missions(awkward_names=True, max_events=1, facts=2))
def test_renaming_reaches_every_name_and_nothing_else(drawn: Mission) -> None:
    there = renamed(drawn, lambda kind, name: f"{kind}__{name}")
    roots = (etree.fromstring(written(mission)) for mission in (drawn, there))
    for was, element in zip(*(root.iter() for root in roots), strict=True):
        tag = tag_of(element)
        for attribute, value in was.attrib.items():
            kind = NAMED.get(tag, "") if attribute == "name" else REFERS.get(str(attribute), "")
            if tag == "alternative" and attribute == "name":
                (around,) = {str(e.get("name")) for e in was.iterancestors(f"{{{NAMESPACE}}}activity")}
                kind = "activity" if value == around else "alternative"
            names = str(value).split() if kind else [str(value)]
            exits = (SUCCEED, FAIL) if kind == "block" else ()
            expected = [f"{kind}__{n}" if kind and n not in exits else n for n in names]
            if kind == "condition":
                expected = [re.sub(r"^(!?)(done\()?", renaming, word) for word in names]
            assert str(element.get(attribute)) == (" ".join(expected) if kind else str(value))
    assert renamed(there, lambda kind, name: name.removeprefix(f"{kind}__")) == drawn
