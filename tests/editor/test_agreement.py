"""What check says of a text and what the server says are the same; a rename changes names alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from lxml import etree

from mcpn.answers.requirements import asked_of
from mcpn.answers.vocabulary import NamedWord, vocabulary
from mcpn.drawing.compose import compose
from mcpn.errors import InputError, Problem
from mcpn.mission.core.flattening import flatten
from mcpn.mission.language import references
from mcpn.mission.model import Mission
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.static.warnings import static_warnings
from mcpn.mission.xml import read_mission
from mcpn.spaces.formula_names import WORDS
from mcpn.testing import missions
from mcpn.testing.awkward_names import renamed
from mcpn.testing.broken import BrokenMission, broken_missions
from mcpn.testing.printing import as_xml
from mcpn.testing.shape import Shape

pytest.importorskip("pygls", reason="needs mcpn[editor]")

from lsprotocol import types as lsp
from pygls.workspace import TextDocument

from mcpn.editor.answers import Answers
from mcpn.editor.project import Memory, Project

FILE = Path("/nowhere/mission.xml")
SHAPE = Shape(
    sections=8,
    activities=3,
    events=2,
    facts=2,
    recovers=3,
    pauses=3,
    timeouts=2,
    timed_blocks=4,
    aborts=2,
    crashes=True,
    late=True,
)
LEFT = replace(SHAPE, pauses=0, becoming=2)
"""What an event pauses is not left by facts."""


def answers(text: str, memory: Memory | None = None) -> Answers:
    return Answers(Project({FILE: text}, memory), lambda file: TextDocument(file.as_uri(), text))


def checked(text: str) -> tuple[list[Problem], list[Problem]]:
    """What check refuses, and what it warns of: it reads the mission, warns, and reads the formulas."""
    warnings = list[Problem]()
    try:
        mission = read_mission(FILE, unsaved={FILE: text})
        warnings = static_warnings(Usage(mission, flatten(mission)))
        asked_of(compose(mission))
    except InputError as error:
        return list(error.problems), warnings
    return [], warnings


def words(known: tuple[NamedWord, ...]) -> Iterator[str]:
    """Names of some kind, those of single copies among them."""
    for word in known:
        yield from (word.name, *word.copies)


@st.composite
def asking(draw: st.DrawFn) -> tuple[str, list[str]]:
    """The text of a mission with requirements, and the words that these say."""
    mission = draw(st.sampled_from([SHAPE, LEFT]).flatmap(missions))
    known = vocabulary(compose(mission))
    says = [f"{word}({name})" for word in ("objective", "pending") for name in words(known.objectives)]
    says += [f"block({name})" for name in words(known.blocks)]
    says += [f"{word}({name})" for word in ("oos", "available") for name in words(known.hardware)]
    says += [f"available({name})" for name in words(known.software)]
    says += [f"{word}({each.name})" for word in ("activity", "refused") for each in known.activities]
    says += [f"alternative({each.name})={way}" for each in known.activities for way in each.alternatives]
    says += [f"waiting({each.name})={way}" for each in known.activities for way in each.alternatives]
    says += [
        f"fact({each.name})={value}" for each in known.facts for value in each.values if "(" not in each.name
    ]
    says += [f"{word}({name})" for word in ("event", "happens") for name in words(known.events)]
    said = draw(st.lists(st.sampled_from(says), min_size=1, max_size=4))
    root = etree.fromstring(as_xml(mission))
    first = next(
        i for i, e in enumerate(root) if etree.QName(e).localname not in ("import", "robot", "protocols")
    )
    for number, word in enumerate(said):
        asked = etree.Element(f"{{{etree.QName(root).namespace}}}requirement", name=f"asked{number}")
        if word.startswith("objective(") and draw(st.booleans()):
            etree.SubElement(asked, f"{{{etree.QName(root).namespace}}}avoidance", of=word[10:-1])
        elif draw(st.booleans()):
            on_paths = word.startswith("happens(")
            asked.set("formula", f"G ({word} -> F success)" if on_paths else f"AG EF ({word} | success)")
        else:
            inside = f"{{{etree.QName(root).namespace}}}response"
            etree.SubElement(asked, inside, to=word, gives=f"!{word} | failure")
        root.insert(first + number, asked)
    etree.indent(root)
    return etree.tostring(root, encoding="unicode"), said


def test_words_of_formulas_are_known_to_references() -> None:
    assert set(references.WORDS) == set(WORDS)


@given(broken_missions(max_objectives=4))
def test_a_seeded_error_is_told_as_by_check(broken: BrokenMission) -> None:
    errors, _ = Project({FILE: broken.text}).problems(FILE)
    assert errors == checked(broken.text)[0]
    assert errors


@given(asking(), st.data())
def test_a_formula_is_told_as_by_check(drawn: tuple[str, list[str]], data: st.DataObject) -> None:
    """Right, with a letter too many in one of its names, and right again: the memory hides nothing."""
    text, said = drawn
    memory = Memory()
    told, said_by_check = answers(text, memory).project.problems(FILE), checked(text)
    assert told == said_by_check
    word = data.draw(st.sampled_from(said))
    name = word.partition("(")[2].partition(")")[0]
    wrong = (
        text.replace(word, word.replace(name, f"{name}q"))
        if word in text
        else text.replace(f'of="{name}"', f'of="{name}q"')  # where it is asked of, not where it is declared
    )
    expected, _ = checked(wrong)
    typed = answers(wrong, memory)
    assert typed.project.problems(FILE, at_once=True)[0] == expected
    assert expected, "the name is unknown"
    squiggles = [d for d in typed.diagnostics(FILE)[FILE] if "formula, column" in d.message]
    for squiggle in squiggles:
        document = TextDocument(FILE.as_uri(), wrong)
        begin, end = map(document.offset_at_position, (squiggle.range.start, squiggle.range.end))
        assert name.rpartition(".")[2].split("_EV")[0] in wrong[begin:end]
    told, said_by_check = answers(text, memory).project.problems(FILE), checked(text)
    assert told == said_by_check


@given(asking(), st.data())
def test_a_rename_changes_names_and_nothing_else(drawn: tuple[str, list[str]], data: st.DataObject) -> None:
    """The mission is that of the model's own renaming; each formula speaks of the same places of the net."""
    text, _ = drawn
    asked = answers(text)
    declared = [s for s in asked.symbols(FILE) if s.declares and s.kind != "alternative"]
    symbol = data.draw(st.sampled_from(declared))
    assume(sum((s.kind, s.name) == (symbol.kind, symbol.name) for s in declared) == 1)
    before = read_mission(FILE, unsaved={FILE: text})
    if symbol.kind == "activity":  # which the model renames with its alternative, the editor does not
        (of,) = (a for a in before.activities if a.name == symbol.name)
        assume(len(of.alternatives) == 1 or symbol.name not in [w.name for w in of.alternatives])
        assume("alternatives" in text or f'<alternative name="{symbol.name}"' not in text)
    new = f"{symbol.name}z"
    edit = asked.renamed(FILE, asked.range(FILE, symbol.begin, symbol.end).start, new)
    assert edit.changes is not None
    after_text = applied(text, edit.changes[FILE.as_uri()])
    after = read_mission(FILE, unsaved={FILE: after_text})

    def other(kind: str, name: str) -> str:
        return new if (kind, name) == (symbol.kind, symbol.name) else name

    assert unasked(after) == renamed(before, other)
    formulas = [[each.formula for each in asked_of(compose(m))] for m in (before, after)]
    assert formulas[0] == formulas[1]


@given(st.sampled_from([SHAPE, LEFT]).flatmap(missions), st.data())
def test_a_taken_name_is_refused(mission: Mission, data: st.DataObject) -> None:
    text = as_xml(mission)
    asked = answers(text)
    declared = [s for s in asked.symbols(FILE) if s.declares]
    pairs = [
        (a, b)
        for a in declared
        for b in declared
        if (a.kind, a.scope) == (b.kind, b.scope) and a.name != b.name
    ]
    assume(pairs)
    one, two = data.draw(st.sampled_from(pairs))
    with pytest.raises(ValueError, match=f"{two.name} is taken"):
        asked.renamed(FILE, asked.range(FILE, one.begin, one.end).start, two.name)


@given(st.sampled_from([SHAPE, LEFT]).flatmap(missions), st.data())
def test_offered_routes_are_those_that_check_accepts(mission: Mission, data: st.DataObject) -> None:
    """Each name of a block or an exit, in the place of a route: offered, or refused by check as a route."""
    text = as_xml(mission)
    asked = answers(text)
    routes = [s for s in asked.symbols(FILE) if s.kind == "block" and not s.declares]
    assume(routes)
    route = data.draw(st.sampled_from(routes))
    (attribute,) = (a for a in route.element.attributes if a.begin <= route.begin <= a.end)
    assume(attribute.value == route.name)
    offered = {i.label for i in asked.completion(FILE, asked.range(FILE, route.begin, route.begin).start)}
    every = {s.name for s in asked.symbols(FILE) if s.declares and s.kind == "block"}
    for name in sorted({*every, "succeed", "fail", "abort"}):
        errors, _ = checked(text[: route.begin] + name + text[route.end :])
        wrong = [
            e for e in errors if any(said in e.message for said in (f"leads to {name};", f"names {name};"))
        ]
        wrong += [e for e in errors if "itself" in e.message or "has a route" in e.message]
        assert (name in offered) == (not wrong), (name, attribute.name, wrong, sorted(offered))


def applied(text: str, edits: Sequence[lsp.TextEdit]) -> str:
    document = TextDocument(FILE.as_uri(), text)
    places = [tuple(map(document.offset_at_position, (e.range.start, e.range.end))) for e in edits]
    for (begin, end), edit in sorted(zip(places, edits, strict=True), key=lambda pair: -pair[0][0]):
        text = text[:begin] + edit.new_text + text[end:]
    return text


def unasked(mission: Mission) -> Mission:
    return renamed(mission, lambda kind, name: name)


REASONS = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><activity name="go" failures="stuck"/></robot>
<requirement name="one" formula="G !happens(OBJ_x_EV_FAIL_stuck)"/>
<objective name="x" activities="go" failures="stuck=2e-4 lost" failure_probability="0.1">
<route on="failure" reason="stuck" goto="fail"/></objective>
</mission>
"""


def test_a_reason_is_renamed_wherever_it_stands() -> None:
    asked = answers(REASONS)
    reasons = [s for s in asked.symbols(FILE) if s.kind == "reason"]
    assert [(s.name, s.declares) for s in reasons] == [
        ("stuck", True),
        ("stuck", False),
        ("stuck", True),
        ("lost", True),
        ("stuck", False),
    ]
    for symbol in (s for s in reasons if s.name == "stuck"):
        edit = asked.renamed(FILE, asked.range(FILE, symbol.begin, symbol.end).start, "caught")
        assert edit.changes is not None
        assert applied(REASONS, edit.changes[FILE.as_uri()]) == REASONS.replace("stuck", "caught")
    with pytest.raises(ValueError, match="lost is taken"):
        asked.renamed(FILE, asked.range(FILE, reasons[0].begin, reasons[0].end).start, "lost")
    with pytest.raises(ValueError, match="with the name EV the mission is wrong"):
        asked.renamed(FILE, asked.range(FILE, reasons[0].begin, reasons[0].end).start, "EV")


@pytest.mark.parametrize(
    ("before", "has"),
    [
        ('reason="', {"stuck", "lost"}),
        ("happens(", {"OBJ_x_EV_FAIL", "OBJ_x_EV_FAIL_stuck", "OBJ_x_EV_FAIL_lost"}),
    ],
)
def test_reasons_are_offered(before: str, has: set[str]) -> None:
    asked, at = answers(REASONS), REASONS.index(before) + len(before)
    found = asked.completion(FILE, asked.range(FILE, at, at).start)
    assert has <= {item.label for item in found}
